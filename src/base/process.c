/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/process.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/file.h"
#include "base/supervisor.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/temporary.h"
#include "base/unfinished.h"
#include "base/words.h"
#include "base/work.h"

static char *search_path(const char *program)
{
    const char *path = getenv("PATH"), *dir = path ? path : "/usr/bin:/bin";
    for (const char *end; dir; dir = *end ? end + 1 : NULL) {
        end = strchrnul(dir, ':');
        FREED char *folder = end > dir ? strndup(dir, (size_t)(end - dir)) : strdup(".");
        FREED char *candidate = folder ? iso_path_join(folder, program) : NULL;
        if (candidate && access(candidate, X_OK) == 0 && !iso_path_is_dir(candidate))
            return strdup(candidate);
    }
    return NULL;
}

iso_status iso_process_find(const char *program, const char *debian_package, char **path, iso_error *err)
{
    char variable[64];
    int n = snprintf(variable, sizeof variable, "ISOSHADE_%s", program);
    for (int i = 0; i < n && i < (int)sizeof variable - 1; ++i)
        if (variable[i] >= 'a' && variable[i] <= 'z')
            variable[i] = (char)(variable[i] - 'a' + 'A');
    const char *chosen = getenv(variable);
    if (chosen && *chosen) {
        *path = NULL;
        if (access(chosen, X_OK) != 0 || iso_path_is_dir(chosen))
            return iso_fail(err, ISO_E_MISSING,
                            "%s: $%s names no executable file: %s; correct it, or install the Debian package %s",
                            program, variable, chosen, debian_package);
        *path = strdup(chosen);
    } else {
        *path = search_path(program);
    }
    if (!*path)
        return iso_fail(err, ISO_E_MISSING, "%s: not found on PATH; install the Debian package %s, or set $%s", program,
                        debian_package, variable);
    return ISO_OK;
}

iso_status iso_process_find_named(const char *what, const char *name, char **path, iso_error *err)
{
    const bool is_path = strchr(name, '/') != NULL;
    *path = !is_path                                            ? search_path(name)
            : access(name, X_OK) == 0 && !iso_path_is_dir(name) ? realpath(name, NULL)
                                                                : NULL;
    if (*path)
        return ISO_OK;
    return iso_fail(err, ISO_E_MISSING, is_path ? "%s: %s is no executable file" : "%s: %s is not found on PATH", what,
                    name);
}

/* The kept part of the output: enough to report why a program failed. */
typedef struct line_log {
    char line[1024];
    size_t used;
    char last[512];  /* the last line that was not empty */
    char error[512]; /* the last line that speaks of an error */
    const iso_process_options *options;
    const char *until; /* the line that is waited for; NULL: none */
    bool is_there;     /* it came */
} line_log;

static void end_line(line_log *log)
{
    log->line[log->used] = 0;
    if (log->used > 0) {
        snprintf(log->last, sizeof log->last, "%.*s", (int)sizeof log->last - 1, log->line);
        iso_words_make_printable(log->last);
        /* Blender says at last that a script failed; why, a line before it does. */
        const bool says_why = !log->error[0] || !strstr(log->line, "Error: script failed");
        if (says_why && (strcasestr(log->line, "error") || strcasestr(log->line, "fatal")))
            memcpy(log->error, log->last, sizeof log->error);
        if (log->options->line)
            log->options->line(log->options->user, log->line);
        log->is_there = log->is_there || (log->until && strcmp(log->line, log->until) == 0);
    }
    log->used = 0;
}

static void take_output(line_log *log, const char *bytes, size_t count)
{
    if (log->options->output)
        fwrite(bytes, 1, count, log->options->output);
    for (size_t i = 0; i < count; ++i) {
        if (bytes[i] == '\n' || bytes[i] == '\r')
            end_line(log);
        else if (log->used + 1 < sizeof log->line)
            log->line[log->used++] = bytes[i];
    }
}

/* Ctrl-C and similar signals, while programs run: the programs are ended and the calls fail, so that callers remove
 * unfinished outputs. A handler can reach only a global; the first of several calls watches, the last restores. */
static _Atomic int stop_signal, was_stopped; /* lock-free, for the handler; _Atomic, for threads that look */
_Static_assert(ATOMIC_INT_LOCK_FREE == 2, "a signal's handler may store to atomics without a lock alone");
static const int stop_signals[] = {SIGINT, SIGTERM, SIGHUP};
enum { stop_count = sizeof stop_signals / sizeof *stop_signals };
static struct {
    pthread_mutex_t lock;
    size_t running;
    struct sigaction before[stop_count];
} watched = {.lock = PTHREAD_MUTEX_INITIALIZER};

static void note_signal(int number)
{
    stop_signal = number;
    was_stopped = 1;
}

bool iso_process_was_stopped(void)
{
    return was_stopped != 0;
}

/* Watches stop_signals. Those that are ignored (nohup) or handled by other code stay so. */
static void watch_signals(void)
{
    const struct sigaction watch = {.sa_handler = note_signal};
    pthread_mutex_lock(&watched.lock);
    if (watched.running++ == 0) {
        stop_signal = 0;
        for (int i = 0; i < stop_count; ++i)
            if (sigaction(stop_signals[i], NULL, &watched.before[i]) == 0 && iso_unfinished_ends(&watched.before[i]))
                sigaction(stop_signals[i], &watch, NULL);
    }
    pthread_mutex_unlock(&watched.lock);
}

static void restore_signals(void)
{
    pthread_mutex_lock(&watched.lock);
    if (--watched.running == 0)
        for (int i = 0; i < stop_count; ++i)
            sigaction(stop_signals[i], &watched.before[i], NULL);
    pthread_mutex_unlock(&watched.lock);
}

static bool has_ended(pid_t pid)
{
    siginfo_t info = {0};
    return waitid(P_PID, (id_t)pid, &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == pid;
}

typedef enum drain_end {
    DRAIN_CLOSED,
    DRAIN_TIMED_OUT,
    DRAIN_STOPPED,
    DRAIN_CANCELED,
    DRAIN_WAITS,
    DRAIN_UNREADABLE
} drain_end;

/* Reads until the child closes its output, or prints the line that is waited for. talking: a child of its own may hold
 * the output while it waits for a line, so that its end counts too.
 * Unreadable output (errno has the cause) differs from closed output: the child would write on, and be ended by
 * that, or not at all. */
static drain_end drain(int fd, pid_t talking, line_log *log, double deadline)
{
    for (char buffer[4096];;) {
        struct pollfd p = {.fd = fd, .events = POLLIN};
        int ready = poll(&p, 1, iso_progress_current() ? 50 : 200);
        if (stop_signal)
            return DRAIN_STOPPED;
        if (iso_progress_poll(iso_progress_current()))
            return DRAIN_CANCELED;
        if (iso_clock_seconds() > deadline)
            return DRAIN_TIMED_OUT;
        if (ready < 0 && errno != EINTR)
            return DRAIN_UNREADABLE;
        if (ready == 0 && talking && has_ended(talking))
            break;
        if (ready <= 0)
            continue;
        ssize_t n = read(fd, buffer, sizeof buffer);
        if (n < 0 && errno != EINTR)
            return DRAIN_UNREADABLE;
        if (n == 0)
            break;
        if (n > 0)
            take_output(log, buffer, (size_t)n);
        if (log->is_there)
            return DRAIN_WAITS;
    }
    end_line(log);
    return DRAIN_CLOSED;
}

struct iso_process {
    pid_t pid;
    int in, out; /* its stdin, -1: nothing to be read from; its stdout and stderr */
    char name[64];
    char *folder; /* that was made for it; or NULL */
    line_log log;
};

static void close_both(const int fds[2])
{
    for (int i = 0; i < 2; ++i)
        if (fds[i] >= 0)
            close(fds[i]);
}

/* Returns the status for errno. ENOENT for an existing file: its interpreter, or another file that it names, is
 * missing. */
static iso_status failure(void)
{
    return errno == ENOMEM ? ISO_E_MEMORY : errno == ENOENT ? ISO_E_MISSING : errno == EIO ? ISO_E_IO : ISO_E_PROGRAM;
}

/* Starts a program. talks: it accepts lines, by a socket, since writing to a pipe without a reader would end this
 * process. */
static iso_status begin_in(const char *const argv[], const char *directory, const iso_sandbox *box, bool talks,
                           iso_process *p, iso_error *err)
{
    int in[2] = {-1, -1}, out[2];
    if (pipe2(out, O_CLOEXEC) != 0)
        return iso_fail(err, failure(), "%s: no pipe: %s", p->name, strerror(errno));
    if (talks && socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, in) != 0) {
        close_both(out);
        return iso_fail(err, failure(), "%s: no socket: %s", p->name, strerror(errno));
    }
    p->pid = iso_supervisor_start(argv, directory, box, in[0], out[1]);
    if (p->pid < 0) {
        const int cause = errno;
        close_both(in);
        close_both(out);
        errno = cause;
        return iso_fail(err, failure(), "%s: cannot be started: %s", p->name, strerror(errno));
    }
    iso_work_add_start(p->name);
    if (talks)
        close(in[0]);
    close(out[1]);
    p->in = in[1];
    p->out = out[0];
    return ISO_OK;
}

static void remove_folder(iso_process *p)
{
    if (p->folder)
        iso_remove_tree(p->folder);
    free(p->folder);
    p->folder = NULL;
}

static iso_status begin(const char *const argv[], const char *directory, const iso_sandbox_wish *wish, bool talks,
                        iso_process *p, iso_error *err)
{
    iso_sandbox box;
    *p = (iso_process){.in = -1};
    snprintf(p->name, sizeof p->name, "%s", iso_path_base(argv[0]));
    const bool has_box = wish->kind != ISO_SANDBOX_NONE && iso_sandbox_is_on();
    if (has_box && !directory && !(p->folder = iso_make_temp_dir()))
        return iso_temp_dir_fail(err);
    iso_status status = iso_sandbox_prepare(wish, directory ? directory : p->folder, &box, err);
    TRY(status, begin_in(argv, directory, &box, talks, p, err));
    iso_sandbox_release(&box);
    if (status != ISO_OK)
        remove_folder(p);
    return status;
}

static double seconds_of(struct timeval t)
{
    return (double)t.tv_sec + 1e-6 * (double)t.tv_usec;
}

/* Waits for a program that has closed its output and may go on all the same, or ends it. *end: why it ended. */
static int reap(iso_process *p, double deadline, drain_end *end, struct rusage *used)
{
    int result = 0;
    if (p->in >= 0)
        close(p->in);
    close(p->out);
    p->in = p->out = -1;
    while (*end == DRAIN_CLOSED && !has_ended(p->pid)) {
        if (stop_signal)
            *end = DRAIN_STOPPED;
        else if (iso_progress_poll(iso_progress_current()))
            *end = DRAIN_CANCELED;
        else if (iso_clock_seconds() > deadline)
            *end = DRAIN_TIMED_OUT;
        else
            poll(NULL, 0, 5);
    }
    if (*end != DRAIN_CLOSED)
        iso_supervisor_stop(p->pid);
    while (wait4(p->pid, &result, 0, used) < 0 && errno == EINTR) {
    }
    iso_work_add_end(p->name, seconds_of(used->ru_utime) + seconds_of(used->ru_stime));
    remove_folder(p);
    return result;
}

static _Atomic double usual_limit_seconds = ISO_PROCESS_LIMIT_SECONDS;

void iso_process_set_limit(double seconds)
{
    usual_limit_seconds = seconds;
}

double iso_process_limit(double own_seconds)
{
    const double own = own_seconds > 0 ? own_seconds : INFINITY, usual = usual_limit_seconds;
    return usual > 0 ? fmin(own, usual) : own;
}

static _Atomic double last_moment; /* 0: none */

void iso_process_set_deadline(double clock_seconds)
{
    last_moment = clock_seconds;
}

static void note_outcome(const iso_process_options *options, drain_end end, int result, const struct rusage *used,
                         double start)
{
    const bool exited = end == DRAIN_CLOSED && WIFEXITED(result), signaled = end == DRAIN_CLOSED && WIFSIGNALED(result);
    if (options->outcome)
        *options->outcome = (iso_process_outcome){.exit_code = exited ? WEXITSTATUS(result) : -1,
                                                  .signal = signaled ? WTERMSIG(result) : 0,
                                                  .timed_out = end == DRAIN_TIMED_OUT,
                                                  .seconds = iso_clock_seconds() - start,
                                                  .processor_seconds = seconds_of(used->ru_utime) +
                                                                       seconds_of(used->ru_stime),
                                                  .peak_bytes = 1024.0 * (double)used->ru_maxrss};
}

static iso_status listen_to(iso_process *p, const char *until, const iso_process_options *options, bool *ended,
                            iso_error *err)
{
    line_log *log = &p->log;
    log->options = options;
    log->until = until;
    log->is_there = false;
    log->last[0] = log->error[0] = 0;
    const double start = iso_clock_seconds(), last = last_moment > 0 ? fmax(last_moment, start) : INFINITY,
                 deadline = fmin(start + iso_process_limit(options->timeout_seconds), last);
    drain_end end = drain(p->out, p->in >= 0 ? p->pid : 0, log, deadline);
    const int cause = errno; /* errno of a failed read */
    *ended = end != DRAIN_WAITS;
    if (!*ended)
        return ISO_OK;
    struct rusage used = {0}; /* of the supervisor and of all processes that it has waited for */
    const int result = reap(p, deadline, &end, &used);
    note_outcome(options, end, result, &used, start);
    if (end == DRAIN_STOPPED)
        return iso_fail(err, ISO_E_PROGRAM, "%s: stopped by signal %d", p->name, stop_signal);
    if (end == DRAIN_CANCELED)
        return iso_fail(err, ISO_E_CANCELED, "%s: canceled", p->name);
    if (end == DRAIN_UNREADABLE)
        return iso_fail(err, ISO_E_IO, "%s: its output cannot be read: %s", p->name, strerror(cause));
    if (end == DRAIN_TIMED_OUT)
        return iso_fail(err, ISO_E_PROGRAM, "%s: stopped after %g s, the time limit", p->name, deadline - start);
    if (WIFSIGNALED(result))
        return iso_fail(err, ISO_E_PROGRAM, "%s: ended by signal %d; last output: %s", p->name, WTERMSIG(result),
                        log->last);
    if (WEXITSTATUS(result) != 0)
        return iso_fail(err, ISO_E_PROGRAM, "%s: exit code %d: %s", p->name, WEXITSTATUS(result),
                        log->error[0] ? log->error : log->last);
    return ISO_OK;
}

static const iso_process_options no_options = {0};

iso_status iso_process_run(const char *const argv[], const iso_process_options *options, iso_error *err)
{
    iso_process p;
    bool ended;
    options = options ? options : &no_options;
    watch_signals();
    iso_status status = begin(argv, options->directory, &options->sandbox, false, &p, err);
    TRY(status, listen_to(&p, NULL, options, &ended, err));
    restore_signals();
    return status;
}

/* ---- one that stays ---- */

iso_status iso_process_start(const char *const argv[], const char *directory, const iso_sandbox_wish *sandbox,
                             iso_process **process, iso_error *err)
{
    iso_process *p = malloc(sizeof *p);
    *process = NULL;
    NEED_MEMORY(p, err, "%s: no memory to start it", iso_path_base(argv[0]));
    const iso_status status = begin(argv, directory, sandbox, true, p, err);
    if (status == ISO_OK)
        *process = p;
    else
        free(p);
    return status;
}

void iso_process_say(iso_process *p, const char *line)
{
    const char *const parts[] = {line, "\n"};
    for (size_t i = 0; i < 2; ++i)
        for (size_t left = strlen(parts[i]), all = left; left > 0;) {
            const ssize_t n = send(p->in, parts[i] + (all - left), left, MSG_NOSIGNAL);
            if (n < 0 && errno != EINTR)
                return;
            left -= n > 0 ? (size_t)n : 0;
        }
}

/* Watches signals only while it waits. In between they end this process, and the program with it. */
iso_status iso_process_listen(iso_process *p, const char *until, const iso_process_options *options, bool *ended,
                              iso_error *err)
{
    watch_signals();
    const iso_status status = listen_to(p, until, options ? options : &no_options, ended, err);
    restore_signals();
    return status;
}

void iso_process_end(iso_process *p)
{
    const iso_process_options patience = {.timeout_seconds = 10};
    bool ended;
    if (p && p->in >= 0) {
        shutdown(p->in, SHUT_RDWR);
        iso_process_listen(p, NULL, &patience, &ended, NULL);
    }
    free(p);
}
