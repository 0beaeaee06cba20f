/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/process.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/file.h"
#include "base/parallel.h"

static char *search_path(const char *program)
{
    const char *path = getenv("PATH");
    char *copy = strdup(path ? path : "/usr/bin:/bin");
    char *found = NULL, *rest = copy;
    for (char *dir; copy && !found && (dir = strsep(&rest, ":"));) {
        char *candidate = iso_path_join(*dir ? dir : ".", program);
        if (candidate && access(candidate, X_OK) == 0 && !iso_path_is_dir(candidate))
            found = candidate;
        else
            free(candidate);
    }
    free(copy);
    return found;
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
            return iso_fail(err, ISO_E_MISSING, "%s: $%s names no executable file: %s", program, variable, chosen);
        *path = strdup(chosen);
    } else {
        *path = search_path(program);
    }
    if (!*path)
        return iso_fail(err, ISO_E_MISSING, "%s: not found on PATH; install the Debian package %s, or set $%s", program,
                        debian_package, variable);
    return ISO_OK;
}

/* What is kept of the output: enough to say why a program failed. */
typedef struct line_log {
    char line[1024];
    size_t used;
    char last[512];  /* the last line that was not empty */
    char error[512]; /* the last line that speaks of an error */
    const iso_process_options *options;
} line_log;

static void end_line(line_log *log)
{
    log->line[log->used] = 0;
    if (log->used > 0) {
        snprintf(log->last, sizeof log->last, "%.*s", (int)sizeof log->last - 1, log->line);
        if (strcasestr(log->line, "error") || strcasestr(log->line, "fatal"))
            memcpy(log->error, log->last, sizeof log->error);
        if (log->options->line)
            log->options->line(log->options->user, log->line);
    }
    log->used = 0;
}

static void take_output(line_log *log, const char *bytes, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        if (bytes[i] == '\n' || bytes[i] == '\r')
            end_line(log);
        else if (log->used + 1 < sizeof log->line)
            log->line[log->used++] = bytes[i];
    }
}

/* Ctrl-C and the like, while programs run: they are ended and the calls fail, so that the callers remove what is half
 * made. A handler can speak through nothing but a global; the first of several calls watches, the last restores. */
static volatile sig_atomic_t stop_signal;
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
}

/* Signals that are ignored (nohup) or handled by others stay so. */
static void watch_signals(void)
{
    const struct sigaction watch = {.sa_handler = note_signal};
    pthread_mutex_lock(&watched.lock);
    if (watched.running++ == 0) {
        stop_signal = 0;
        for (int i = 0; i < stop_count; ++i)
            if (sigaction(stop_signals[i], NULL, &watched.before[i]) == 0 && watched.before[i].sa_handler == SIG_DFL)
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

typedef enum drain_end { DRAIN_CLOSED, DRAIN_TIMED_OUT, DRAIN_STOPPED } drain_end;

/* Reads until the child closes its output. */
static drain_end drain(int fd, line_log *log, double timeout_seconds)
{
    double start = iso_clock_seconds();
    for (char buffer[4096];;) {
        struct pollfd p = {.fd = fd, .events = POLLIN};
        int ready = poll(&p, 1, 500);
        if (stop_signal)
            return DRAIN_STOPPED;
        if (timeout_seconds > 0 && iso_clock_seconds() - start > timeout_seconds)
            return DRAIN_TIMED_OUT;
        if (ready < 0 && errno != EINTR)
            return DRAIN_CLOSED;
        if (ready <= 0)
            continue;
        ssize_t n = read(fd, buffer, sizeof buffer);
        if (n == 0 || (n < 0 && errno != EINTR))
            break;
        if (n > 0)
            take_output(log, buffer, (size_t)n);
    }
    end_line(log);
    return DRAIN_CLOSED;
}

static void run_child(const char *const argv[], const char *directory, int out)
{
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGKILL); /* a killed isoshade leaves nothing running */
    if (directory && chdir(directory) != 0)
        _exit(126);
    int nothing = open("/dev/null", O_RDONLY); /* no stdio: other threads may have held its locks at the fork */
    if (nothing < 0)
        _exit(126);
    dup2(nothing, STDIN_FILENO);
    dup2(out, STDOUT_FILENO);
    dup2(out, STDERR_FILENO);
    close(out);
    execv(argv[0], (char *const *)argv);
    _exit(127);
}

iso_status iso_process_run(const char *const argv[], const iso_process_options *options, iso_error *err)
{
    static const iso_process_options none = {0};
    options = options ? options : &none;
    const char *name = iso_path_base(argv[0]);
    int fds[2];
    if (pipe2(fds, O_CLOEXEC) != 0)
        return iso_fail(err, ISO_E_IO, "%s: no pipe: %s", name, strerror(errno));
    watch_signals();
    pid_t pid = fork();
    if (pid < 0) {
        restore_signals();
        close(fds[0]);
        close(fds[1]);
        return iso_fail(err, ISO_E_IO, "%s: cannot be started: %s", name, strerror(errno));
    }
    if (pid == 0)
        run_child(argv, options->directory, fds[1]);
    close(fds[1]);
    line_log log = {.options = options};
    drain_end end = drain(fds[0], &log, options->timeout_seconds);
    close(fds[0]);
    if (end != DRAIN_CLOSED)
        kill(-pid, SIGKILL);
    int result = 0;
    while (waitpid(pid, &result, 0) < 0 && errno == EINTR) {
    }
    restore_signals();
    if (end == DRAIN_STOPPED)
        return iso_fail(err, ISO_E_PROGRAM, "%s: stopped by signal %d", name, (int)stop_signal);
    if (end == DRAIN_TIMED_OUT)
        return iso_fail(err, ISO_E_PROGRAM, "%s: stopped after %g s, the time limit", name, options->timeout_seconds);
    if (WIFSIGNALED(result))
        return iso_fail(err, ISO_E_PROGRAM, "%s: ended by signal %d; last output: %s", name, WTERMSIG(result),
                        log.last);
    if (WEXITSTATUS(result) != 0)
        return iso_fail(err, ISO_E_PROGRAM, "%s: exit code %d: %s", name, WEXITSTATUS(result),
                        log.error[0] ? log.error : log.last);
    return ISO_OK;
}
