/* SPDX-License-Identifier: MIT */
/* process.h - running Blender, POV-Ray and gnuplot. */
#pragma once

#include <stdbool.h>
#include <stdio.h>

#include "base/sandbox.h"
#include "base/status.h"

/* Finds a program: the environment variable ISOSHADE_<NAME> if it is set (it must then point to an executable file),
 * or the first hit on PATH. The path is to be freed. ISO_E_MISSING with the Debian package that has it. */
iso_status iso_process_find(const char *program, const char *debian_package, char **path, iso_error *err);

/* How a program ended. */
typedef struct iso_process_outcome {
    int exit_code;  /* -1: it has none, since a signal, the time limit or output that could not be read ended it */
    int signal;     /* 0: none */
    bool timed_out; /* it was ended at its time limit */
    double seconds;
    double processor_seconds; /* of the program and all that it started, over all cores */
    double peak_bytes;        /* the most memory that one of these processes had at once */
} iso_process_outcome;

/* Finds a program that a person names: a path (a name with a slash), or a name on PATH. what: a description of the
 * program, for the message. */
iso_status iso_process_find_named(const char *what, const char *name, char **path, iso_error *err);

typedef struct iso_process_options {
    const char *directory;                      /* working directory, which is the sandbox's folder; NULL: unchanged */
    iso_sandbox_wish sandbox;                   /* with a fresh folder, removed afterwards, if directory is NULL */
    void (*line)(void *user, const char *line); /* 1023 bytes of each line of stdout and stderr; may be NULL */
    void *user;
    FILE *output; /* gets all that line() gets, whole; may be NULL */
    double timeout_seconds; /* the limit of iso_process_set_limit(), if that is less or this is 0 */
    iso_process_outcome *outcome; /* filled if the program ended; may be NULL */
} iso_process_options;

/* Longest time that a program may take, or stay silent after a line: one that hangs would hold its caller forever.
 * Options may lower it, not raise it. 0: no limit. The initial limit: */
#define ISO_PROCESS_LIMIT_SECONDS 7200
void iso_process_set_limit(double seconds);
/* Returns the smaller of this limit and the caller's own, 0 being none. Infinite if there is neither. */
double iso_process_limit(double own_seconds);
/* Sets the time, by iso_clock_seconds(), at which every program is ended; 0, as at the start: never. */
void iso_process_set_deadline(double clock_seconds);

/* Runs argv (argv[0] is a path, the list ends with NULL) and waits. Output is captured. On a non-zero exit, a signal or
 * a timeout the status is ISO_E_PROGRAM. The message names the program, the cause and the last lines of the output that
 * look like an error. Unreadable output ends the program, and is ISO_E_IO.
 * A canceled call (progress.h) ends the program, too: ISO_E_CANCELED.
 * SIGINT, SIGTERM and SIGHUP end the program and are such a failure, so that callers clean up. Neither the program
 * nor a process that it started outlives the call, or this process (supervisor.h). Each thread may run one; a signal
 * ends all. */
iso_status iso_process_run(const char *const argv[], const iso_process_options *options, iso_error *err);

/* True if a signal, such as Ctrl-C, ended programs of this process. A program that failed is not to blame then, and
 * no further work may begin. */
bool iso_process_was_stopped(void);

/* ---- a program that stays and takes one order after the other ---- */

/* It reads lines from its stdin. Belongs to the thread that starts it, and ends with it at the latest. */
typedef struct iso_process iso_process;
iso_status iso_process_start(const char *const argv[], const char *directory, const iso_sandbox_wish *sandbox,
                             iso_process **process, iso_error *err);

/* Sends a line. If the program has ended, iso_process_listen() reports it. */
void iso_process_say(iso_process *process, const char *line);

/* Reads output until a line is `until`: the program waits for its next line then. *ended: the program ended instead,
 * which is reported as by iso_process_run(); it accepts no more lines. options->directory and sandbox are ignored. */
iso_status iso_process_listen(iso_process *process, const char *until, const iso_process_options *options, bool *ended,
                              iso_error *err);

/* Closes its input, and gives it ten seconds at most to end by itself. NULL: nothing to do. */
void iso_process_end(iso_process *process);
