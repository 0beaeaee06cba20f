/* SPDX-License-Identifier: MIT */
/* progress_line.h - one line on stderr that shows a command's progress:
 *
 *     validate: level 1: cycles-limit   43 %, 1 min 20 s
 *
 * It holds the command, the current step, the percent of all steps, which never falls, and the elapsed time. A
 * terminal's line is redrawn in place and wiped at the end. Other outputs get one line per half minute, so that
 * short commands are silent. Functions accept NULL, which is silent. Any thread may report. */
#pragma once

#include <stddef.h>

#include "base/progress.h"

typedef struct iso_progress_line iso_progress_line;

iso_progress_line *iso_progress_line_create(const char *command); /* the name is copied; NULL: no memory */
void iso_progress_line_destroy(iso_progress_line *line);

/* Adds a step. Call it in the order of the steps, before any is reported. The name is not copied. Only the ratios of
 * costs matter. A report with the step's name begins the step and sets its fraction; a report with another name is only
 * shown. Without steps the percent is that of the latest report. */
void iso_progress_line_expect(iso_progress_line *line, const char *step, double cost);
/* Adds a part, from 0 to 1, to the fraction of the current step. */
void iso_progress_line_add(iso_progress_line *line, double part);
iso_progress iso_progress_of_line(iso_progress_line *line);
/* Erases the line before other output; the next report draws it again. */
void iso_progress_line_hide(iso_progress_line *line);

/* Returns the fraction of all steps, from 0 to 1. */
double iso_progress_line_fraction(iso_progress_line *line);
/* Writes the text of the line, `columns` wide at most (0: any width): the step's name is cut first. */
void iso_progress_text(char *text, size_t size, const char *command, const char *name, double fraction, double seconds,
                       size_t columns);
