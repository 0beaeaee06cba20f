/* SPDX-License-Identifier: MIT */
/* temporary.h - names of unfinished outputs.
 *
 * A temporary is called [.]isoshade-HOST-PID-START-RANDOM[-NAME]. HOST stands for this boot of this machine and for
 * the namespace of process numbers. START is the start time of the process. So two processes never write to one
 * temporary, even in containers that share a folder and have equal process numbers. The remains of a killed process
 * differ from the work of a living one. */
#pragma once

#include <stdbool.h>

#include "base/status.h"

/* Returns "DIR/.isoshade-...-NAME", to be freed; nothing has that name yet. The end of a long NAME is kept, since
 * libraries choose a format by it. NULL only when memory ends. */
char *iso_temporary_path(const char *dir, const char *name);

/* Removes temporaries that dead processes of this machine and user left in dir, of outputs and of $TMPDIR. Once per
 * folder and process. */
void iso_temporary_sweep(const char *dir);

/* Makes a private directory under $TMPDIR or /tmp. Returns its whole path, since programs run elsewhere; the caller
 * frees the path and removes the tree. NULL when none can be made. */
char *iso_make_temp_dir(void);
/* Removes such a directory, and frees its path: for ENDED_BY() (base/owned.h). */
void iso_end_temp_dir(char **path);

/* Fails with the folders that were tried and the cause, by errno, if no temporary folder can be made. */
iso_status iso_temp_dir_fail(iso_error *err);

/* True if the path is a temporary of this process, or in one. */
bool iso_temporary_holds(const char *path);

/* Takes the marks of this process's temporaries out of a message, so that it names the user's files. */
void iso_temporary_rename_in(char *text);
