/* SPDX-License-Identifier: MIT */
/* child_start.h - starts a program that reads volumes (child_stream.h); private to src/volume. */
#pragma once

#include <sys/types.h>

#include "base/status.h"

/* A running program: its output is read from `output`, below 0 if there is none. pid 0: no process to wait for. It
 * ends at the latest with the thread that started it, also if that is killed. */
typedef struct iso_child_process {
    pid_t pid;
    int output;
} iso_child_process;

/* No exit code of these programs, as with shells: the program could not be started. */
enum { ISO_CHILD_NOT_STARTED = 127 };

/* Starts a program. words: its path and its arguments (child_stream.h), ended by NULL. After a failure, too, a pid
 * above 0 has to be waited for. tests/fuzz/in_process.cc has a second one, which calls the program's reader within
 * this process. */
iso_status iso_child_start(iso_child_process *process, const char *const words[], iso_error *err);
