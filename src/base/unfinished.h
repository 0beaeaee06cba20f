/* SPDX-License-Identifier: MIT */
/* unfinished.h - outputs that are not finished, and private folders: what has to go when the process is ended in the
 * middle. What a process that is killed leaves is removed by a later run (temporary.h). */
#ifndef ISO_UNFINISHED_H
#define ISO_UNFINISHED_H

#include <signal.h>
#include <stdbool.h>

/* A file or folder begins to be there; it is gone, or finished. resumable: a later run can go on with it, so a signal
 * leaves it. Those that find no room in the list are left as if the process was killed. */
void iso_unfinished_add(const char *path, bool resumable);
void iso_unfinished_drop(const char *path);

/* Removes all that is listed, by system calls alone: for handlers of signals, and where memory has ended. */
void iso_unfinished_remove(bool resumable_too);

/* What is said on stderr when Ctrl-C, SIGTERM or SIGHUP ends the process, such as how to go on; the text has to stay.
 * NULL: nothing, as at the start. */
void iso_unfinished_say(const char *line);

/* From now on signals that end the process (SIGINT, SIGTERM, ... SIGPIPE, and faults such as SIGSEGV) remove what is listed
 * before they do. Signals that are ignored or handled stay so. For programs; main() calls it. */
void iso_unfinished_catch_signals(void);

/* Does the signal end the process, be it after removing what is listed? */
bool iso_unfinished_ends(const struct sigaction *action);

#endif
