/* SPDX-License-Identifier: MIT */
/* supervisor.h - a supervisor process between this one and a program. It ends with the program and lets no process
 * outlive them.
 *
 * The supervisor adopts every process that the program leaves running, including those in a session of their own. It
 * ends them all when the program has ended, on request, and when the process or thread that started it has ended for
 * any reason. It ends with the program's exit code or signal. */
#pragma once

#include <sys/types.h>

#include "base/sandbox.h"

/* Starts a program and returns its supervisor's number, which is its process group's. -1 with errno if it cannot start:
 * a fork fails, its folder, stdin or the sandbox is not available, or the kernel refuses the file. box: the program's
 * rights; the supervisor stays outside. in: the program's stdin, below 0: none. out: its stdout and stderr. */
pid_t iso_supervisor_start(const char *const argv[], const char *directory, const iso_sandbox *box, int in, int out);

/* Requests to end everything now. It must still be waited for. */
void iso_supervisor_stop(pid_t supervisor);
