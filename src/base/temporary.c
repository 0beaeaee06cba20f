/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/temporary.h"

#include <dirent.h>
#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#include <xxhash.h>

#include "base/path.h"
#include "base/unfinished.h"

enum {
    RANDOM_LETTERS = 8,
    /* A folder entry has at most 255 bytes; Blender and the step aside of a folder append a few of their own. */
    NAME_KEPT = 160
};

/* ---- identity of this process ---- */

static struct {
    pthread_once_t once;
    char host[32]; /* "isoshade-HOST-" */
    char mine[80]; /* "isoshade-HOST-PID-START-" */
} identity = {.once = PTHREAD_ONCE_INIT};

/* Returns when a process began, in ticks since the boot: the 22nd word of /proc/PID/stat; 0: not known. The second word
 * is a program's name in parentheses, which may hold spaces and parentheses itself. */
static unsigned long long start_of(long pid)
{
    char path[64], text[1024];
    unsigned long long start = 0;
    snprintf(path, sizeof path, "/proc/%ld/stat", pid);
    FILE *file = fopen(path, "re");
    const size_t n = file ? fread(text, 1, sizeof text - 1, file) : 0;
    if (file)
        fclose(file);
    text[n] = 0;
    const char *at = strrchr(text, ')');
    for (int word = 2; at && word < 22; ++word)
        at = strchr(at + 1, ' ');
    return at && sscanf(at, "%llu", &start) == 1 ? start : 0;
}

static void find_identity(void)
{
    char text[256] = "";
    FILE *file = fopen("/proc/sys/kernel/random/boot_id", "re");
    size_t n = file ? fread(text, 1, 64, file) : 0;
    if (file)
        fclose(file);
    const ssize_t length = readlink("/proc/self/ns/pid", text + n, sizeof text - n);
    n += length > 0 ? (size_t)length : 0;
    snprintf(identity.host, sizeof identity.host, "isoshade-%08x-", (unsigned)XXH3_64bits(text, n));
    snprintf(identity.mine, sizeof identity.mine, "%s%ld-%llx-", identity.host, (long)getpid(), start_of(getpid()));
}

static const char *my_mark(void)
{
    pthread_once(&identity.once, find_identity);
    return identity.mine;
}

/* ---- names ---- */

static void draw_letters(char letters[RANDOM_LETTERS + 1])
{
    static const char alphabet[] = "0123456789abcdefghijklmnopqrstuv"; /* 32 */
    unsigned char bytes[RANDOM_LETTERS];
    if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes) {
        struct timespec now;
        clock_gettime(CLOCK_MONOTONIC, &now);
        const XXH64_hash_t hash = XXH3_64bits(&now, sizeof now);
        memcpy(bytes, &hash, sizeof bytes);
    }
    for (int i = 0; i < RANDOM_LETTERS; ++i)
        letters[i] = alphabet[bytes[i] % 32];
    letters[RANDOM_LETTERS] = 0;
}

/* Returns the last bytes of a name, from the start of a character of UTF-8 on. */
static const char *end_of_name(const char *name)
{
    const size_t length = strlen(name);
    const char *kept = length > NAME_KEPT ? name + length - NAME_KEPT : name;
    while (kept > name && ((unsigned char)*kept & 0xC0) == 0x80)
        ++kept;
    return kept;
}

char *iso_temporary_path(const char *dir, const char *name)
{
    for (;;) {
        char *path = NULL, letters[RANDOM_LETTERS + 1];
        struct stat st;
        draw_letters(letters);
        if (asprintf(&path, "%s/.%s%s-%s", dir, my_mark(), letters, end_of_name(name)) < 0)
            return NULL;
        if (lstat(path, &st) != 0)
            return path;
        free(path);
    }
}

bool iso_temporary_holds(const char *path)
{
    const char *at = strstr(path, my_mark());
    return at && (at == path || at[-1] == '/' || at[-1] == '.');
}

void iso_temporary_rename_in(char *text)
{
    char mark[sizeof identity.mine + 2];
    snprintf(mark, sizeof mark, "/.%s", my_mark());
    for (char *at = strstr(text, mark); at; at = strstr(at + 1, mark)) {
        const size_t rest = strlen(at), length = strlen(mark) + RANDOM_LETTERS + 1;
        if (rest > length)
            memmove(at + 1, at + length, rest - length + 1);
    }
}

static const char *temp_base(void)
{
    const char *base = getenv("TMPDIR");
    return base && *base ? base : "/tmp";
}

char *iso_make_temp_dir(void)
{
    char *path = NULL, *base = realpath(temp_base(), NULL);
    if (base)
        iso_temporary_sweep(base);
    if (!base || asprintf(&path, "%s/%sXXXXXX", base, my_mark()) < 0)
        path = NULL;
    free(base);
    if (path && !mkdtemp(path)) {
        free(path);
        return NULL;
    }
    if (path)
        iso_unfinished_add(path, false);
    return path;
}

void iso_end_temp_dir(char **path)
{
    if (*path)
        iso_remove_tree(*path);
    free(*path);
}

iso_status iso_temp_dir_fail(iso_error *err)
{
    return iso_fail(err, iso_errno_status(),
                    "%s: no temporary folder can be made there (TMPDIR names another place): %s", temp_base(),
                    strerror(errno));
}

/* ---- remains of dead processes ---- */

static bool is_dead(long pid, unsigned long long start)
{
    if (kill((pid_t)pid, 0) != 0 && errno == ESRCH)
        return true;
    const unsigned long long now = start_of(pid); /* the number may have gone to another process */
    return start != 0 && now != 0 && now != start;
}

/* Removes an entry of a dead process. Other users' entries in a shared folder stay: they may change while we remove
 * them. */
static void sweep_entry(const char *dir, const char *name)
{
    const char *mark = name + (name[0] == '.');
    const size_t host = strlen(identity.host);
    long pid;
    unsigned long long start;
    if (strncmp(mark, identity.host, host) != 0 || sscanf(mark + host, "%ld-%llx-", &pid, &start) != 2 || pid <= 0 ||
        !is_dead(pid, start))
        return;
    FREED char *path = iso_path_join(dir, name);
    struct stat st;
    if (path && lstat(path, &st) == 0 && st.st_uid == geteuid())
        iso_remove_tree(path);
}

/* True if the folder was swept. Folders beyond the list's capacity are swept again: slower, never wrong. */
static bool was_swept(const struct stat *st)
{
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    static struct {
        dev_t device;
        ino_t inode;
    } seen[16];
    static size_t next;
    bool found = false;
    pthread_mutex_lock(&lock);
    for (size_t i = 0; i < sizeof seen / sizeof *seen; ++i)
        found = found || (seen[i].inode == st->st_ino && seen[i].device == st->st_dev);
    if (!found) {
        seen[next].device = st->st_dev;
        seen[next].inode = st->st_ino;
        next = (next + 1) % (sizeof seen / sizeof *seen);
    }
    pthread_mutex_unlock(&lock);
    return found;
}

void iso_temporary_sweep(const char *dir)
{
    struct stat st;
    if (stat(dir, &st) != 0 || was_swept(&st))
        return;
    my_mark();
    DIR *entries = opendir(dir);
    if (!entries)
        return;
    for (struct dirent *e; (e = readdir(entries));)
        sweep_entry(dir, e->d_name);
    closedir(entries);
}
