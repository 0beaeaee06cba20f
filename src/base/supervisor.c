/* SPDX-License-Identifier: MIT */
/* Between fork() and exec or _exit() only system calls are made, since other threads may hold any lock. */
#define _GNU_SOURCE
#include "base/supervisor.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

/* Ends this process and reports why the program could not be started. */
static void give_up(int told)
{
    const int cause = errno;
    while (write(told, &cause, sizeof cause) < 0 && errno == EINTR)
        ;
    _exit(127);
}

/* Reads errno from the pipe; the end of the file means that the program started. 0, or the cause. */
static int listen_for_cause(int told)
{
    int cause = 0;
    size_t had = 0;
    while (had < sizeof cause) {
        const ssize_t n = read(told, (char *)&cause + had, sizeof cause - had);
        if (n < 0 && errno != EINTR)
            return errno;
        if (n == 0)
            return 0;
        had += n > 0 ? (size_t)n : 0;
    }
    return cause;
}

/* A program to start, and its settings. */
typedef struct order {
    const char *const *argv;
    const char *directory;
    const iso_sandbox *box;
    int in, out;
    int told;      /* closes when the program begins */
    sigset_t mask; /* the caller's */
} order;

/* Becomes the program. */
static void run_program(const order *o)
{
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    sigprocmask(SIG_SETMASK, &o->mask, NULL);
    if (o->directory && chdir(o->directory) != 0)
        give_up(o->told);
    const int in = o->in >= 0 ? o->in : open("/dev/null", O_RDONLY);
    if (in < 0)
        give_up(o->told);
    dup2(in, STDIN_FILENO);
    dup2(o->out, STDOUT_FILENO);
    dup2(o->out, STDERR_FILENO);
    close(o->out);
    close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);
    if (!iso_sandbox_enter(o->box))
        give_up(o->told);
    execve(o->argv[0], (char *const *)o->argv, o->box->environment ? o->box->environment : environ);
    give_up(o->told);
}

/* Sends SIGKILL to each child that the kernel lists, in decimal numbers with spaces between them. False: it does not
 * list all. */
static bool kill_children(void)
{
    const int list = open("/proc/thread-self/children", O_RDONLY);
    char digits[256];
    pid_t pid = 0;
    ssize_t n = list >= 0 ? 1 : -1;
    while (list >= 0 && ((n = read(list, digits, sizeof digits)) > 0 || (n < 0 && errno == EINTR)))
        for (ssize_t i = 0; i < n; ++i) {
            if (digits[i] >= '0' && digits[i] <= '9') {
                pid = 10 * pid + (digits[i] - '0');
            } else {
                if (pid > 1)
                    kill(pid, SIGKILL);
                pid = 0;
            }
        }
    if (list >= 0)
        close(list);
    return n == 0;
}

/* Ends all processes until none is left: one that loses its parent becomes our child, and may have started others in
 * the meantime. */
static void end_all(pid_t program, int *result)
{
    for (;;) {
        int how;
        kill(-program, SIGKILL);
        /* Where children are not listed, those that left the program's group are not waited for: they may stay for
         * ever. */
        const bool all_are_killed = kill_children();
        const pid_t pid = waitpid(all_are_killed ? -1 : -program, &how, 0);
        if (pid < 0 && errno != EINTR)
            return;
        if (pid == program)
            *result = how;
    }
}

static void end_like(int result)
{
    const struct rlimit none = {0, 0};
    if (WIFEXITED(result))
        _exit(WEXITSTATUS(result));
    sigset_t all;
    sigemptyset(&all);
    setrlimit(RLIMIT_CORE, &none);
    signal(WTERMSIG(result), SIG_DFL);
    sigprocmask(SIG_SETMASK, &all, NULL);
    kill(getpid(), WTERMSIG(result));
    _exit(127);
}

/* Waits for the program's end, or for the order to end it. */
static void wait_for_end(pid_t program, const sigset_t *wanted)
{
    int result = 0;
    for (bool stop = false, ended = false; !stop && !ended;) {
        /* the timeout covers a signal that came before this process started */
        const struct timespec patience = {.tv_sec = 1};
        stop = sigtimedwait(wanted, NULL, &patience) == SIGTERM;
        int how; /* status of the program, or of a process that it left running */
        for (pid_t pid; !ended && (pid = waitpid(-1, &how, WNOHANG)) > 0;)
            ended = pid == program;
        if (ended)
            result = how;
    }
    end_all(program, &result);
    end_like(result);
}

/* Runs the supervisor itself, from the fork on. */
static void be_supervisor(const order *o, pid_t caller, const sigset_t *wanted)
{
    setpgid(0, 0);
    prctl(PR_SET_CHILD_SUBREAPER, 1);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    signal(SIGCHLD, SIG_DFL);
    if (getppid() != caller)
        _exit(127);
    const pid_t program = fork();
    if (program < 0)
        give_up(o->told);
    if (program == 0)
        run_program(o);
    /* Pipes of other programs that are run at the same time may be open here: they would not see their end. */
    close_range(0, ~0U, 0);
    wait_for_end(program, wanted);
}

/* Waits until the program has been started. -1 with errno if it could not be; the supervisor has ended then. */
static pid_t started(pid_t supervisor, int told)
{
    const int cause = listen_for_cause(told);
    close(told);
    if (cause == 0)
        return supervisor;
    iso_supervisor_stop(supervisor);
    while (waitpid(supervisor, NULL, 0) < 0 && errno == EINTR)
        ;
    errno = cause;
    return -1;
}

pid_t iso_supervisor_start(const char *const argv[], const char *directory, const iso_sandbox *box, int in, int out)
{
    order o = {.argv = argv, .directory = directory, .box = box, .in = in, .out = out};
    sigset_t wanted;
    int told[2];
    if (pipe2(told, O_CLOEXEC) != 0)
        return -1;
    o.told = told[1];
    sigemptyset(&wanted);
    sigaddset(&wanted, SIGCHLD);
    sigaddset(&wanted, SIGTERM);
    const pid_t caller = getpid();
    /* Blocked before the fork: no signal may come before the supervisor can take it. */
    pthread_sigmask(SIG_BLOCK, &wanted, &o.mask);
    const pid_t supervisor = fork();
    if (supervisor == 0)
        be_supervisor(&o, caller, &wanted);
    const int cause = errno;
    pthread_sigmask(SIG_SETMASK, &o.mask, NULL);
    close(told[1]);
    if (supervisor > 0)
        return started(supervisor, told[0]);
    close(told[0]);
    errno = cause;
    return -1;
}

void iso_supervisor_stop(pid_t supervisor)
{
    kill(supervisor, SIGTERM);
}
