/* SPDX-License-Identifier: MIT */
/* process.h - running Blender, POV-Ray and gnuplot. */
#ifndef ISO_PROCESS_H
#define ISO_PROCESS_H

#include <stdbool.h>

#include "base/sandbox.h"
#include "base/status.h"

/* The path of a program: the environment variable ISOSHADE_<NAME> when it is
 * set (it must then point to an executable file), else the first hit on PATH.
 * To be freed. ISO_E_MISSING with the Debian package that has it. */
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

/* The same of a program that a person names: a path (a name with a slash), or a name that PATH has. what: what it should
 * be, for the message. */
iso_status iso_process_find_named(const char *what, const char *name, char **path, iso_error *err);

typedef struct iso_process_options {
    const char *directory;                      /* working directory, which is the sandbox's folder; NULL: unchanged */
    iso_sandbox_wish sandbox;                   /* its folder is a fresh one, and removed, where there is no directory */
    void (*line)(void *user, const char *line); /* each line of stdout and stderr; may be NULL */
    void *user;
    double timeout_seconds; /* that of iso_process_set_limit(), where it is less or this is 0 */
    iso_process_outcome *outcome; /* filled where the program ended; may be NULL */
} iso_process_options;

/* How long a program may take at most, or stay silent after an order: one that hangs would hold its caller for ever.
 * Options may say less, not more. 0: without end. At the start it is: */
#define ISO_PROCESS_LIMIT_SECONDS 7200
void iso_process_set_limit(double seconds);
/* The less of this and a limit of one's own, where 0 is none. Infinite where there is neither. */
double iso_process_limit(double own_seconds);
/* No program goes on longer than that, by iso_clock_seconds(); 0: without end, as at the start. */
void iso_process_set_deadline(double clock_seconds);

/* Runs argv (argv[0] is a path, the list ends with NULL) and waits. Output is
 * captured; on a non-zero exit, a signal or a timeout the status is
 * ISO_E_PROGRAM and the message names the program, the cause and the last
 * lines of the output that look like an error. Output that cannot be read ends
 * the program, and is ISO_E_IO. SIGINT, SIGTERM and SIGHUP end
 * the program and are such a failure, so that callers clean up. Neither the program nor
 * anything that it started outlives the call, or this process (keeper.h). Threads may each run one; a signal ends all. */
iso_status iso_process_run(const char *const argv[], const iso_process_options *options, iso_error *err);

/* Did a signal end programs of this process, such as Ctrl-C? Then a program that failed is not to blame, and nothing more is
 * to be begun. */
bool iso_process_was_stopped(void);

/* ---- a program that stays and takes one order after the other ---- */

/* It reads lines from its stdin. Belongs to the thread that starts it, and ends with it at the latest. */
typedef struct iso_process iso_process;
iso_status iso_process_start(const char *const argv[], const char *directory, const iso_sandbox_wish *sandbox,
                             iso_process **process, iso_error *err);

/* Sends a line. A program that has ended says so when it is listened to. */
void iso_process_say(iso_process *process, const char *line);

/* Takes output until a line is `until`: then the program waits for its next line. *ended: it came to its end instead, which
 * is told as iso_process_run() does; nothing more can be said to it. options->directory and sandbox are not looked at. */
iso_status iso_process_listen(iso_process *process, const char *until, const iso_process_options *options, bool *ended,
                              iso_error *err);

/* Closes its input, and gives it ten seconds at most to end by itself. NULL: nothing to do. */
void iso_process_end(iso_process *process);

#endif
