/* SPDX-License-Identifier: MIT */
/* Programs that are run: their exit codes, time limits, and what a signal leaves. */
#define _GNU_SOURCE
#include <errno.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/process.h"
#include "test.h"

static void an_exit_code_is_reported_with_the_line_that_speaks_of_an_error(void **state)
{
    (void)state;
    const char *argv[] = {"/bin/sh", "-c", "echo one; echo an error here; echo three; exit 3", NULL};
    iso_error err = {""};
    assert_int_equal(iso_process_run(argv, NULL, &err), ISO_E_PROGRAM);
    assert_non_null(strstr(err.text, "exit code 3: an error here"));
}

static void a_program_that_takes_too_long_is_ended(void **state)
{
    (void)state;
    const char *argv[] = {"/bin/sh", "-c", "sleep 60 & sleep 60", NULL};
    const iso_process_options options = {.timeout_seconds = 0.1};
    assert_status(iso_process_run(argv, &options, &err), ISO_E_PROGRAM);
}

static void send_interrupt(void *user, const char *line)
{
    (void)user;
    (void)line;
    raise(SIGTERM);
}

static void a_signal_ends_the_program_and_is_a_failure(void **state)
{
    (void)state;
    const char *argv[] = {"/bin/sh", "-c", "echo ready; sleep 60", NULL};
    const iso_process_options options = {.line = send_interrupt};
    iso_error err = {""};
    assert_int_equal(iso_process_run(argv, &options, &err), ISO_E_PROGRAM);
    assert_non_null(strstr(err.text, "stopped by signal 15"));
    /* Afterwards signals do what they did before. */
    struct sigaction now;
    sigaction(SIGTERM, NULL, &now);
    assert_true(now.sa_handler == SIG_DFL);
}

/* The one that begins last ends first: signals stay watched until both are over. */
static void programs_of_two_threads_run_at_once_and_one_signal_ends_both(void **state)
{
    (void)state;
    const char *const programs[2][4] = {{"/bin/sh", "-c", "sleep 60", NULL}, {"/bin/sh", "-c", "sleep 0.2; echo ready; sleep 60", NULL}};
    const iso_process_options options[2] = {{.line = NULL}, {.line = send_interrupt}};
    iso_error errors[2] = {{""}, {""}};
    iso_status results[2];
    #pragma omp parallel for num_threads(2) schedule(static, 1)
    for (int i = 0; i < 2; ++i)
        results[i] = iso_process_run(programs[i], &options[i], &errors[i]);
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(results[i], ISO_E_PROGRAM);
        assert_non_null(strstr(errors[i].text, "stopped by signal 15"));
    }
    struct sigaction now;
    sigaction(SIGTERM, NULL, &now);
    assert_true(now.sa_handler == SIG_DFL);
}

static void tell_pid(void *user, const char *line)
{
    const int *pipe_end = user;
    long pid = strtol(line, NULL, 10);
    if (write(*pipe_end, &pid, sizeof pid) != sizeof pid)
        _exit(2);
}

static void a_killed_caller_leaves_nothing_running(void **state)
{
    (void)state;
    int fds[2];
    assert_int_equal(pipe(fds), 0);
    const pid_t caller = fork();
    if (caller == 0) {
        const char *argv[] = {"/bin/sh", "-c", "echo $$; exec sleep 60", NULL};
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
    for (int i = 0; i < 100 && !gone; ++i) {
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_exit_code_is_reported_with_the_line_that_speaks_of_an_error),
        cmocka_unit_test(a_program_that_takes_too_long_is_ended),
        cmocka_unit_test(a_signal_ends_the_program_and_is_a_failure),
        cmocka_unit_test(programs_of_two_threads_run_at_once_and_one_signal_ends_both),
        cmocka_unit_test(a_killed_caller_leaves_nothing_running),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
