/* SPDX-License-Identifier: MIT */
/* temporary.h - names of what is not finished yet.
 *
 * A temporary is called [.]isoshade-HOST-PID-START-RANDOM[-NAME]: HOST stands for this boot of this machine and for the
 * namespace that process numbers count in, START is when the process began. So two processes never write to one
 * temporary, even in containers that share a folder and have equal process numbers, and what a killed process left can be
 * told from the work of one that lives. */
#ifndef ISO_TEMPORARY_H
#define ISO_TEMPORARY_H

#include <stdbool.h>

#include "base/status.h"

/* "DIR/.isoshade-...-NAME", to be freed; nothing has that name yet. The end of a long NAME is kept, since libraries choose
 * a format by it. NULL only when memory ends. */
char *iso_temporary_path(const char *dir, const char *name);

/* Removes what dead processes of this machine and user left in dir, temporaries of outputs or of $TMPDIR alike. Once for
 * each folder in a process. */
void iso_temporary_sweep(const char *dir);

/* A fresh private directory under $TMPDIR or /tmp, by its whole path, since programs run elsewhere; the caller frees
 * the path and removes the tree. NULL when none can be made. */
char *iso_make_temp_dir(void);

/* What to fail with then: where none can be made, and why, by errno. */
iso_status iso_temp_dir_fail(iso_error *err);

/* Is the path in, or itself, a temporary of this process? */
bool iso_temporary_holds(const char *path);

/* Takes the marks of this process's temporaries out of a message, so that it names what the user named. */
void iso_temporary_rename_in(char *text);

#endif
