/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/unfinished.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

enum { SLOTS = 32, DEEPEST = 16 };
enum { FREE, TAKEN, LISTED }; /* TAKEN: its path is being written */

/* Handlers of signals read it, so nothing here is allocated or locked. */
static struct {
    atomic_int state;
    bool resumable;
    char path[PATH_MAX];
} slots[SLOTS];
static _Atomic pid_t owner; /* a process that was forked from it has nothing unfinished */

void iso_unfinished_add(const char *path, bool resumable)
{
    const size_t length = strlen(path);
    owner = getpid();
    for (int i = 0; i < SLOTS && length < sizeof slots[i].path; ++i) {
        int state = FREE;
        if (atomic_compare_exchange_strong(&slots[i].state, &state, TAKEN)) {
            memcpy(slots[i].path, path, length + 1);
            slots[i].resumable = resumable;
            slots[i].state = LISTED;
            return;
        }
    }
}

void iso_unfinished_drop(const char *path)
{
    for (int i = 0; i < SLOTS; ++i)
        if (slots[i].state == LISTED && strcmp(slots[i].path, path) == 0)
            slots[i].state = FREE;
}

static void remove_at(int dir, const char *name, int depth);

static void remove_all_in(int folder, int depth)
{
    /* As the kernel writes them: readdir() would need memory. */
    struct {
        uint64_t inode;
        int64_t next;
        unsigned short bytes;
        unsigned char type;
        char name[];
    } * e;
    _Alignas(8) char entries[2048];
    lseek(folder, 0, SEEK_SET);
    for (long n; (n = syscall(SYS_getdents64, folder, entries, sizeof entries)) > 0;)
        for (long at = 0; at < n; at += e->bytes) {
            e = (void *)(entries + at);
            if (strcmp(e->name, ".") != 0 && strcmp(e->name, "..") != 0)
                remove_at(folder, e->name, depth + 1);
        }
}

/* Folders again where other threads still put files into them. */
static void remove_at(int dir, const char *name, int depth)
{
    if (unlinkat(dir, name, 0) == 0 || errno == ENOENT || depth > DEEPEST)
        return;
    const int folder = openat(dir, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    for (int tries = 0; tries < 4 && folder >= 0; ++tries) {
        remove_all_in(folder, depth);
        if (unlinkat(dir, name, AT_REMOVEDIR) == 0)
            break;
    }
    if (folder >= 0)
        close(folder);
}

void iso_unfinished_remove(bool resumable_too)
{
    if (owner != getpid())
        return;
    for (int i = 0; i < SLOTS; ++i)
        if (slots[i].state == LISTED && (resumable_too || !slots[i].resumable))
            remove_at(AT_FDCWD, slots[i].path, 0);
}

static const char *_Atomic last_words;
static _Atomic pid_t speaker; /* a process that was forked from it prints nothing */

void iso_unfinished_say(const char *line)
{
    speaker = getpid();
    last_words = line;
}

static void say_last_words(int number)
{
    const char *const line = last_words;
    if (!line || speaker != getpid() || (number != SIGINT && number != SIGTERM && number != SIGHUP))
        return;
    for (size_t left = strlen(line), all = left; left > 0;) {
        const ssize_t n = write(STDERR_FILENO, line + (all - left), left);
        if (n < 0 && errno != EINTR)
            return;
        left -= n > 0 ? (size_t)n : 0;
    }
}

/* Removes unfinished files and raises the signal again, which ends the process when the handler returns. */
static void end_by(int number)
{
    const int cause = errno;
    iso_unfinished_remove(false);
    say_last_words(number);
    raise(number);
    errno = cause;
}

void iso_unfinished_catch_signals(void)
{
    static const int ends[] = {SIGINT,  SIGTERM, SIGHUP,  SIGQUIT, SIGPIPE, SIGALRM, SIGXCPU,
                               SIGUSR1, SIGUSR2, SIGSEGV, SIGBUS,  SIGFPE,  SIGILL,  SIGABRT};
    const struct sigaction catch = {.sa_handler = end_by, .sa_flags = (int)SA_RESETHAND};
    for (size_t i = 0; i < sizeof ends / sizeof *ends; ++i) {
        struct sigaction before;
        if (sigaction(ends[i], NULL, &before) == 0 && before.sa_handler == SIG_DFL)
            sigaction(ends[i], &catch, NULL);
    }
}

bool iso_unfinished_ends(const struct sigaction *action)
{
    return action->sa_handler == SIG_DFL || action->sa_handler == end_by;
}
