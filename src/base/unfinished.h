/* SPDX-License-Identifier: MIT */
/* unfinished.h - unfinished outputs and private folders, which are removed when a signal ends the process. The
 * remains of a killed process are removed by a later run (temporary.h). */
#pragma once

#include <signal.h>
#include <stdbool.h>

/* Adds or removes a file or folder: it begins to exist; it is gone, or finished. resumable: a later run can continue
 * it, so a signal leaves it. Entries beyond the list's capacity are left as if the process was killed. */
void iso_unfinished_add(const char *path, bool resumable);
void iso_unfinished_drop(const char *path);

/* Removes all listed entries, by system calls alone: for signal handlers, and if memory has ended. */
void iso_unfinished_remove(bool resumable_too);

/* Sets the line printed on stderr when Ctrl-C, SIGTERM or SIGHUP ends the process, such as how to resume. The text
 * has to stay valid. NULL: nothing, as at the start. */
void iso_unfinished_say(const char *line);

/* Makes signals that end the process (SIGINT, SIGTERM, ... SIGPIPE, and faults such as SIGSEGV) first remove the
 * listed entries. Signals that are ignored or handled stay so. For programs; main() calls it. */
void iso_unfinished_catch_signals(void);

/* True if the signal ends the process, with or without cleanup. */
bool iso_unfinished_ends(const struct sigaction *action);
