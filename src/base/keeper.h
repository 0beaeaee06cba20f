/* SPDX-License-Identifier: MIT */
/* keeper.h - a process between this one and a program, which ends with the program and lets nothing outlive either.
 *
 * The keeper adopts whatever the program leaves running, also what has moved to a session of its own, and ends all of it
 * when the program has ended, when it is told to, and when the process or thread that started it is no more, however that
 * came to its end. It ends as the program did: by the same exit code or signal. */
#ifndef ISO_KEEPER_H
#define ISO_KEEPER_H

#include <sys/types.h>

#include "base/sandbox.h"

/* The keeper's number, which is its process group's, once the program has begun; -1 with errno where it cannot: a fork
 * fails, its folder, stdin or the sandbox cannot be had, or the kernel refuses the file. box: what the program may do; the
 * keeper stays outside. in: what the program reads from, below 0: nothing. out: its stdout and stderr. */
pid_t iso_keeper_start(const char *const argv[], const char *directory, const iso_sandbox *box, int in, int out);

/* Tells it to end everything now. It has to be waited for all the same. */
void iso_keeper_stop(pid_t keeper);

#endif
