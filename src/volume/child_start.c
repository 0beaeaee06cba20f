/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "volume/child_start.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "base/sandbox.h"

/* Runs the program itself, by system calls alone: it may write only its output, which this process reads. Other
 * prints of it and its libraries are discarded. */
static void run_program(const char *const words[], const iso_sandbox *box, int output, pid_t parent)
{
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    signal(SIGTERM, SIG_DFL); /* the signal that ends it, even if ignored in this process */
    if (getppid() != parent)  /* the parent ended before the death signal was set */
        _exit(ISO_CHILD_NOT_STARTED);
    const int nothing = open("/dev/null", O_RDWR);
    dup2(nothing, STDIN_FILENO);
    dup2(nothing, STDERR_FILENO);
    dup2(output, STDOUT_FILENO);
    close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);
    if (nothing >= 0 && iso_sandbox_enter(box))
        execv(words[0], (char *const *)words);
    _exit(ISO_CHILD_NOT_STARTED);
}

static iso_status failure(int cause)
{
    return cause == ENOMEM ? ISO_E_MEMORY : ISO_E_PROGRAM;
}

iso_status iso_child_start(iso_child_process *process, const char *const words[], iso_error *err)
{
    int ends[2];
    iso_sandbox box;
    if (access(words[0], X_OK) != 0)
        return iso_fail(err, ISO_E_MISSING, "%s: cannot be started: %s", words[0], strerror(errno));
    iso_status status = iso_sandbox_prepare(&(iso_sandbox_wish){.kind = ISO_SANDBOX_CLOSED}, NULL, &box, err);
    if (status != ISO_OK)
        return status;
    if (pipe2(ends, O_CLOEXEC) != 0) {
        status = iso_fail(err, failure(errno), "%s: no pipe: %s", words[1], strerror(errno));
        iso_sandbox_release(&box);
        return status;
    }
    const pid_t parent = getpid();
    process->pid = fork();
    if (process->pid == 0)
        run_program(words, &box, ends[1], parent);
    const int failed = process->pid < 0 ? errno : 0;
    iso_sandbox_release(&box);
    close(ends[1]);
    process->output = ends[0];
    return failed ? iso_fail(err, failure(failed), "%s: cannot be started: %s", words[0], strerror(failed)) : ISO_OK;
}
