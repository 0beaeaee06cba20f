/* SPDX-License-Identifier: MIT */
/* progress_line.h - one line on stderr that says how far a command is:
 *
 *     validate: level 1: cycles-limit   43 %, 1 min 20 s
 *
 * The command, what runs, the percent of all steps, which never falls, and the time that has passed. A terminal's line is
 * redrawn in place and wiped off in the end. Elsewhere it is a line each half a minute, so that short commands are silent.
 * Functions accept NULL, which is silence. Any thread may report. */
#ifndef ISO_BASE_PROGRESS_LINE_H
#define ISO_BASE_PROGRESS_LINE_H

#include <stddef.h>

#include "base/progress.h"

typedef struct iso_progress_line iso_progress_line;

iso_progress_line *iso_progress_line_create(const char *command); /* the name is copied; NULL: no memory */
void iso_progress_line_destroy(iso_progress_line *line);

/* Adds a step, in their order and before any is reported; its name stays the caller's. Costs only matter beside those of other steps. A report of its
 * name begins it and has its fraction; another name is only shown. Without steps the percent is that of the name shown. */
void iso_progress_line_expect(iso_progress_line *line, const char *step, double cost);
/* Adds a part, from 0 to 1, to what is done of the step that runs. */
void iso_progress_line_add(iso_progress_line *line, double part);
iso_progress iso_progress_of_line(iso_progress_line *line);
/* Wipes the line off before something else is printed; the next report brings it back. */
void iso_progress_line_hide(iso_progress_line *line);

/* From 0 to 1, of all steps. */
double iso_progress_line_fraction(iso_progress_line *line);
/* Writes the text of the line, `columns` wide at most (0: any width): the name of what runs is cut first. */
void iso_progress_text(char *text, size_t size, const char *command, const char *name, double fraction, double seconds,
                       size_t columns);

#endif
