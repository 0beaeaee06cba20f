/* SPDX-License-Identifier: MIT */
/* child_start.h - starts a program that reads volumes (child_stream.h); private to src/volume. */
#ifndef ISO_VOLUME_CHILD_START_H
#define ISO_VOLUME_CHILD_START_H

#include <sys/types.h>

#include "base/status.h"

/* One that runs: what it writes is read from `output`, which is below 0 where there is none. pid 0: nothing that has to
 * be waited for. It ends with the thread that started it at the latest, also where that is killed. */
typedef struct iso_child_process {
    pid_t pid;
    int output;
} iso_child_process;

/* No exit code of these programs, as with shells: the program could not be started. */
enum { ISO_CHILD_NOT_STARTED = 127 };

/* words: the program's path and what it is told (child_stream.h), NULL behind the last. After a failure, too, a pid above 0
 * has to be waited for. tests/fuzz/in_process.cc has a second one, which calls the program's reader within this process. */
iso_status iso_child_start(iso_child_process *process, const char *const words[], iso_error *err);

#endif
