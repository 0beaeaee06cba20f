/* SPDX-License-Identifier: MIT */
/* Programs that are run: their exit codes, time limits, and what a signal leaves. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/process.h"
#include "base/progress.h"
#include "base/sandbox.h"
#include "base/unfinished.h"
#include "folder.h"
#include "test.h"

static bool go_on_twice(void *user, const char *stage, double fraction)
{
    (void)stage;
    (void)fraction;
    return ++*(int *)user < 3;
}

/* Without the request the program would run for an hour. */
TEST(a_canceled_call_ends_its_program)
{
    const char *argv[] = {"/bin/sleep", "3600", NULL};
    int calls = 0;
    iso_error err = {""};
    iso_call call;
    iso_call_begin(&call, go_on_twice, &calls);
    const iso_status status = iso_process_run(argv, NULL, &err);
    assert_int_equal(iso_call_end(&call, status, &err), ISO_E_CANCELED);
    assert_int_equal(calls, 3);
}

TEST(output_is_whole_also_of_lines_that_are_longer_than_a_message)
{
    FREED char *bytes = NULL;
    size_t size = 0;
    FILE *output = open_memstream(&bytes, &size);
    const iso_process_options options = {.output = output, .sandbox = {.kind = ISO_SANDBOX_NONE}};
    const char *const argv[] = {"/bin/sh", "-c", "printf '%5000d\\n' 7; echo end", NULL};
    assert_ok(iso_process_run(argv, &options, &err));
    assert_int_equal(fclose(output), 0);
    assert_int_equal(size, 5000 + 1 + 4);
    assert_string_equal(bytes + 4999, "7\nend\n");
}

TEST(an_exit_code_is_reported_with_the_line_that_speaks_of_an_error)
{
    const char *argv[] = {"/bin/sh", "-c", "echo one; echo an error here; echo three; exit 3", NULL};
    iso_error err = {""};
    assert_int_equal(iso_process_run(argv, NULL, &err), ISO_E_PROGRAM);
    assert_non_null(strstr(err.text, "exit code 3: an error here"));
}

TEST(a_program_that_takes_too_long_is_ended)
{
    const char *argv[] = {"/bin/sh", "-c", "sleep 3600 & sleep 3600", NULL};
    const iso_process_options options = {.timeout_seconds = 0.1};
    assert_status(iso_process_run(argv, &options, &err), ISO_E_PROGRAM);
}

/* It closes its output, so that there is nothing to wait for but its end. */
TEST(one_that_hangs_in_silence_is_ended_too)
{
    const char *argv[] = {"/bin/sh", "-c", "exec >&- 2>&-; sleep 3600", NULL};
    const iso_process_options options = {.timeout_seconds = 0.2};
    iso_error err = {""};
    assert_int_equal(iso_process_run(argv, &options, &err), ISO_E_PROGRAM);
    assert_non_null(strstr(err.text, "the time limit"));
    iso_process_set_limit(0.2);
    assert_int_equal(iso_process_run(argv, NULL, &err), ISO_E_PROGRAM);
    iso_process_set_limit(ISO_PROCESS_LIMIT_SECONDS);
}

/* Who asks for a run may allow less than the usual limit, never more; 0 is no limit. */
TEST(the_less_of_two_limits_holds)
{
    static const struct {
        double own, usual, said;
    } cases[] = {{30, 0.2, 0.2}, {0.3, 30, 0.3}, {0, 0.2, 0.2}, {0.3, 0, 0.3}};
    const char *argv[] = {"/bin/sh", "-c", "exec sleep 3600", NULL};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const iso_process_options options = {.timeout_seconds = cases[i].own};
        char wanted[64];
        iso_error err = {""};
        iso_process_set_limit(cases[i].usual);
        assert_int_equal(iso_process_run(argv, &options, &err), ISO_E_PROGRAM);
        snprintf(wanted, sizeof wanted, "stopped after %g s, the time limit", cases[i].said);
        assert_non_null(strstr(err.text, wanted));
    }
    iso_process_set_limit(ISO_PROCESS_LIMIT_SECONDS);
}

static void keep_pid(void *user, const char *line)
{
    *(long *)user = strtol(line, NULL, 10);
}

static void send_interrupt(void *user, const char *line)
{
    (void)user;
    (void)line;
    raise(SIGTERM);
}

TEST(a_signal_ends_the_program_and_is_a_failure)
{
    const char *argv[] = {"/bin/sh", "-c", "echo ready; exec sleep 3600", NULL};
    const iso_process_options options = {.line = send_interrupt};
    iso_error err = {""};
    assert_int_equal(iso_process_run(argv, &options, &err), ISO_E_PROGRAM);
    assert_non_null(strstr(err.text, "stopped by signal 15"));
    /* Afterwards signals do what they did before. */
    struct sigaction now;
    sigaction(SIGTERM, NULL, &now);
    assert_true(now.sa_handler == SIG_DFL);
}

/* A program in a thread of its own, however few OpenMP may have. */
typedef struct run {
    const char *argv[5];
    iso_process_options options;
    iso_status status;
    iso_error error;
} run;

static void *run_in_a_thread(void *user)
{
    run *r = user;
    r->status = iso_process_run(r->argv, &r->options, &r->error);
    return NULL;
}

/* The second says "ready" when the first runs: each waits at the fifo for the other. */
TEST(programs_of_two_threads_run_at_once_and_one_signal_ends_both)
{
    FREED char *fifo = iso_path_join(folder, "fifo");
    assert_int_equal(mkfifo(fifo, 0600), 0);
    const iso_sandbox_wish all_rights = {.kind = ISO_SANDBOX_NONE}; /* the fifo is in no folder of theirs */
    run runs[2] = {{.argv = {"/bin/sh", "-c", "echo up >\"$0\"; exec sleep 3600", fifo, NULL},
                    .options = {.sandbox = all_rights}},
                   {.argv = {"/bin/sh", "-c", "read up <\"$0\"; echo ready; exec sleep 3600", fifo, NULL},
                    .options = {.line = send_interrupt, .sandbox = all_rights}}};
    pthread_t threads[2];
    for (int i = 0; i < 2; ++i)
        assert_int_equal(pthread_create(&threads[i], NULL, run_in_a_thread, &runs[i]), 0);
    for (int i = 0; i < 2; ++i)
        pthread_join(threads[i], NULL);
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(runs[i].status, ISO_E_PROGRAM);
        assert_non_null(strstr(runs[i].error.text, "stopped by signal 15"));
    }
    struct sigaction now;
    sigaction(SIGTERM, NULL, &now);
    assert_true(now.sa_handler == SIG_DFL);
}

/* Also what moved to a session of its own, and would go on when the program has ended well. */
TEST(nothing_that_it_started_outlives_it)
{
    long pid = 0;
    const char *argv[] = {"/bin/sh", "-c", "setsid sleep 3600 >&- 2>&- & echo $!; exit 5", NULL};
    const iso_process_options options = {.line = keep_pid, .user = &pid};
    iso_error err = {""};
    assert_int_equal(iso_process_run(argv, &options, &err), ISO_E_PROGRAM);
    assert_non_null(strstr(err.text, "exit code 5"));
    assert_true(pid > 1);
    assert_int_equal(kill((pid_t)pid, 0), -1);
    /* Children that ended before it, and that it did not wait for, come to the supervisor with it: their codes are not
     * its. */
    const char *careless[] = {"/bin/sh", "-c", "for i in 1 2 3 4 5 6 7 8; do (exit 9) & done; exec timeout 0.1 sleep 60", NULL};
    for (int i = 0; i < 5; ++i) {
        assert_int_equal(iso_process_run(careless, NULL, &err), ISO_E_PROGRAM);
        assert_non_null(strstr(err.text, "exit code 124")); /* of timeout */
    }
    const char *killed[] = {"/bin/sh", "-c", "kill -SEGV $$", NULL};
    assert_int_equal(iso_process_run(killed, NULL, &err), ISO_E_PROGRAM);
    assert_non_null(strstr(err.text, "ended by signal 11"));
}

/* A program that cannot be started is reported with the system's reason, not as an exit code of the program. */
TEST(one_that_cannot_be_started_says_why)
{
    const char *echo[] = {"/bin/sh", "-c", "exit 127", NULL};
    iso_error err = {""};
    assert_int_equal(iso_process_run(echo, NULL, &err), ISO_E_PROGRAM);
    assert_non_null(strstr(err.text, "exit code 127"));
    /* A script whose interpreter is not there. */
    FREED char *script = iso_path_join(folder, "script");
    const int fd = open(script, O_WRONLY | O_CREAT, 0700);
    assert_true(fd >= 0 && write(fd, "#!/no/such/program\n", 19) == 19);
    close(fd);
    const char *argv[] = {script, NULL};
    iso_process_outcome outcome = {.exit_code = -1};
    const iso_process_options options = {.outcome = &outcome};
    assert_int_equal(iso_process_run(argv, &options, &err), ISO_E_MISSING);
    assert_non_null(strstr(err.text, "cannot be started: No such file"));
    assert_int_equal(outcome.exit_code, -1);
}

/* As a user whose processes are as many as may be: root may have any number. A process of its own, since rights do not
 * come back. The supervisor may be there and the program not, or neither. */
TEST(where_no_process_can_be_had_it_is_told_so)
{
    enum { NOBODY = 54321 };
    if (getuid() != 0)
        skip();
    for (rlim_t most = 1; most <= 2; ++most) {
        const pid_t user = fork();
        if (user == 0) {
            const struct rlimit limit = {most, most};
            const char *argv[] = {"/bin/sh", "-c", ":", NULL};
            const iso_process_options options = {.sandbox = {.kind = ISO_SANDBOX_NONE}};
            iso_error err = {""};
            if (setuid(NOBODY) != 0 || setrlimit(RLIMIT_NPROC, &limit) != 0)
                _exit(1);
            const iso_status status = iso_process_run(argv, &options, &err);
            _exit(status == ISO_E_PROGRAM && strstr(err.text, "sh: cannot be started: Resource") ? 0 : 2);
        }
        int how = 1;
        assert_int_equal(waitpid(user, &how, 0), user);
        assert_int_equal(how, 0);
    }
}

/* The ends of pipes that this process has open become a folder, of which no bytes can be read. */
static void spoil_pipes(void *user, const char *line)
{
    const int unreadable = open("/", O_RDONLY | O_DIRECTORY);
    int *spoiled = user;
    (void)line;
    assert_true(unreadable >= 0);
    for (int fd = 3; fd < 256; ++fd) {
        struct stat st;
        if (fstat(fd, &st) == 0 && S_ISFIFO(st.st_mode) && (fcntl(fd, F_GETFL) & O_ACCMODE) == O_RDONLY)
            *spoiled += dup2(unreadable, fd) == fd;
    }
    close(unreadable);
}

/* It would go on for as long as it likes, since nothing is written that could not be. */
TEST(one_whose_output_cannot_be_read_is_ended_and_not_to_blame)
{
    const char *argv[] = {"/bin/sh", "-c", "echo ready; exec sleep 3600", NULL};
    int spoiled = 0;
    iso_process_outcome outcome = {.exit_code = 0};
    const iso_process_options options = {
        .line = spoil_pipes, .user = &spoiled, .timeout_seconds = 20, .outcome = &outcome};
    iso_error err = {""};
    assert_int_equal(iso_process_run(argv, &options, &err), ISO_E_IO);
    assert_true(spoiled >= 1); /* those of a caller that runs tests by pipes, too */
    assert_non_null(strstr(err.text, "its output cannot be read"));
    assert_int_equal(outcome.exit_code, -1);
    assert_false(outcome.timed_out);
}

#ifdef __x86_64__
/* io_uring_setup(), socket() and socketpair() as programs of 32 bits call them, which a process of 64 bits may do as
 * well. Returns the errors that are not those of the sandbox, as bits. */
static int call_as_32_bits(void)
{
    static const long calls[][2] = {{425, -ENOSYS}, {359, -EACCES}, {360, -EACCES}}; /* number, wanted */
    int wrong = 0;
    for (int i = 0; i < 3; ++i) {
        int result;
        __asm__ volatile("int $0x80"
                         : "=a"(result)
                         : "a"(calls[i][0]), "b"(1), "c"(1), "d"(0), "S"(0)
                         : "memory", "r8", "r9", "r10", "r11");
        wrong |= (result != calls[i][1]) << i;
    }
    return wrong;
}

/* In a process of its own, since a sandbox is for ever. A kernel without such calls ends it by a signal. */
TEST(the_sandbox_refuses_sockets_of_32_bits_too)
{
    static const iso_sandbox_kind kinds[] = {ISO_SANDBOX_CLOSED, ISO_SANDBOX_DEVICE};
    char text[200];
    iso_sandbox_describe(text, sizeof text);
    if (!strstr(text, "use no network"))
        skip();
    for (int k = 0; k < 2; ++k) {
        const pid_t child = fork();
        if (child == 0) {
            const iso_sandbox_wish wish = {.kind = kinds[k]};
            iso_sandbox box;
            signal(SIGSEGV, SIG_DFL); /* cmocka's handler would go on with the other tests, in the sandbox */
            if (iso_sandbox_prepare(&wish, NULL, &box, NULL) != ISO_OK || !iso_sandbox_enter(&box))
                _exit(8);
            _exit(call_as_32_bits());
        }
        int how = 1;
        assert_int_equal(waitpid(child, &how, 0), child);
        assert_true(WIFSIGNALED(how) || how == 0);
    }
}
#endif

static void tell_pid(void *user, const char *line)
{
    const int *pipe_end = user;
    long pid = strtol(line, NULL, 10);
    if (write(*pipe_end, &pid, sizeof pid) != sizeof pid)
        _exit(2);
}

TEST(a_killed_caller_leaves_nothing_running)
{
    int fds[2];
    assert_int_equal(pipe(fds), 0);
    const pid_t caller = fork();
    if (caller == 0) {
        const char *argv[] = {"/bin/sh", "-c", "setsid sleep 3600 & echo $!; wait", NULL};
        const iso_process_options options = {.line = tell_pid, .user = &fds[1]};
        iso_process_run(argv, &options, NULL);
        _exit(0);
    }
    long program = 0;
    assert_int_equal(read(fds[0], &program, sizeof program), sizeof program);
    kill(caller, SIGKILL);
    waitpid(caller, NULL, 0);
    /* It dies with its parent; who adopts it may take a moment to notice, or leave it a zombie. */
    char path[64], text[256] = "";
    snprintf(path, sizeof path, "/proc/%ld/stat", program);
    bool gone = false;
    for (int i = 0; i < 12000 && !gone; ++i) { /* ten minutes, on a machine that has much else to do */
        FILE *f = fopen(path, "r");
        gone = !f || !fgets(text, sizeof text, f) || strstr(text, ") Z") || strstr(text, ") X");
        if (f)
            fclose(f);
        if (!gone)
            usleep(50000);
    }
    assert_true(gone);
    close(fds[0]);
    close(fds[1]);
}

static void count_lines(void *user, const char *line)
{
    (void)line;
    ++*(int *)user;
}

/* It answers each line with two, the second of them the sign, and ends at the line "end" by the exit code 3. */
static const char *const answering[] = {
    "/bin/sh", "-c",
    "echo hello; echo done; while read -r l; do [ \"$l\" = end ] && echo an error is here && exit 3; echo \"$l\"; echo done; done",
    NULL};

TEST(a_program_that_stays_answers_line_by_line)
{
    iso_process *p;
    int lines = 0;
    bool ended = true;
    const iso_process_options options = {.line = count_lines, .user = &lines};
    assert_ok(iso_process_start(answering, NULL, &(iso_sandbox_wish){0}, &p, &err));
    for (int i = 1; i <= 3; ++i) {
        assert_ok(iso_process_listen(p, "done", &options, &ended, &err));
        assert_false(ended);
        assert_int_equal(lines, 2 * i);
        iso_process_say(p, i < 3 ? "again" : "end");
    }
    iso_error why = {""};
    assert_int_equal(iso_process_listen(p, "done", &options, &ended, &why), ISO_E_PROGRAM);
    assert_true(ended);
    assert_non_null(strstr(why.text, "exit code 3: an error is here"));
    iso_process_end(p);

    /* Without more input it ends by itself; the next line finds that it has ended. */
    assert_ok(iso_process_start(answering, NULL, &(iso_sandbox_wish){0}, &p, &err));
    assert_ok(iso_process_listen(p, "done", NULL, &ended, &err));
    iso_process_end(p);
    const char *brief[] = {"/bin/sh", "-c", "echo done; exit 0", NULL};
    assert_ok(iso_process_start(brief, NULL, &(iso_sandbox_wish){0}, &p, &err));
    assert_ok(iso_process_listen(p, "done", NULL, &ended, &err));
    for (int i = 0; i < 100; ++i)
        iso_process_say(p, "is anybody there?");
    assert_ok(iso_process_listen(p, "done", NULL, &ended, &err));
    assert_true(ended);
    iso_process_end(p);

    /* Its end is seen although a child of its own, which waits for a line, holds its output. */
    const char *parent[] = {"/bin/sh", "-c", "exec 3<&0; cat <&3 & exit 4", NULL};
    assert_ok(iso_process_start(parent, NULL, &(iso_sandbox_wish){0}, &p, &err));
    assert_status(iso_process_listen(p, "done", NULL, &ended, &err), ISO_E_PROGRAM);
    assert_true(ended);
    iso_process_end(p);
    iso_process_end(NULL);
}

/* What stderr has when the signal ends a process that left such words. */
TEST(a_signal_that_ends_the_process_says_how_to_go_on)
{
    static const struct {
        int signal;
        const char *said;
    } cases[] = {{SIGTERM, "go on\n"}, {SIGHUP, "go on\n"}, {SIGUSR1, ""}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        int ends[2], result;
        char said[32] = "";
        assert_int_equal(pipe(ends), 0);
        const pid_t child = fork();
        if (child == 0) {
            dup2(ends[1], STDERR_FILENO);
            signal(cases[i].signal, SIG_DFL);
            iso_unfinished_catch_signals();
            iso_unfinished_say("go on\n");
            raise(cases[i].signal);
            _exit(0);
        }
        close(ends[1]);
        assert_int_equal(waitpid(child, &result, 0), child);
        assert_true(WIFSIGNALED(result) && WTERMSIG(result) == cases[i].signal);
        assert_true(read(ends[0], said, sizeof said - 1) >= 0);
        assert_string_equal(said, cases[i].said);
        close(ends[0]);
    }
}

TEST_MAIN(make_folder, remove_folder)
