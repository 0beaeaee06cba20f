/* SPDX-License-Identifier: MIT */
/* progress_line.h - one line on stderr that says how far a command is:
 *
 *     validate: level 1: cycles-limit   43 %, about 1 min 20 s left
 *
 * On a terminal it is redrawn in place, once a second and when something happens, cut to the terminal's width, and wiped
 * off in the end. Elsewhere (a file, a pipe, a terminal that cannot go back on its line) it is a line at each tenth of the
 * job, five seconds apart at least, or after thirty seconds: nothing for what is done in five. No colors.
 *
 * Functions accept NULL, which is silence, but for create. Any thread may report. */
#ifndef ISO_BASE_PROGRESS_LINE_H
#define ISO_BASE_PROGRESS_LINE_H

#include <stddef.h>

#include "base/job.h"
#include "base/progress.h"

typedef struct iso_progress_line iso_progress_line;

/* name: of the command; copied. NULL: no memory, which is silence as well. */
iso_progress_line *iso_progress_line_create(const char *name);
void iso_progress_line_destroy(iso_progress_line *line);

/* The job for its layout, while nothing is drawn; NULL of NULL. */
iso_job *iso_progress_line_lock(iso_progress_line *line);
void iso_progress_line_unlock(iso_progress_line *line);

void iso_progress_line_begin_phase(iso_progress_line *line, const char *name);

/* What one lane of the phase reports to; the struct has to outlive the progress. */
typedef struct iso_progress_lane {
    iso_progress_line *line;
    size_t number;
    size_t taken; /* counted up by the lane's thread: pieces of work that were done before (iso_job_is_shortened()) */
    size_t told;  /* of these */
} iso_progress_lane;
iso_progress iso_progress_of_lane(iso_progress_lane *lane);
/* The first lane, which is all that most commands have. */
iso_progress iso_progress_of_line(iso_progress_line *line);
void iso_progress_lane_end(iso_progress_lane *lane);

/* Wipes the line off before something else is printed; the next report brings it back. */
void iso_progress_line_hide(iso_progress_line *line);

/* ---- its parts, for tests ------------------------------------------------------------------ */

/* The text, columns wide at most (0: any width): the name of the part is shortened first. */
void iso_progress_text(char *text, size_t size, const char *name, const iso_job_state *state, size_t columns);

/* Whether a log gets a line now. Begin with {0}; told_seconds and told_tenth are set when it does. */
typedef struct iso_progress_log {
    double told_seconds;
    int told_tenth, count;
} iso_progress_log;
int iso_progress_log_is_due(iso_progress_log *log, const iso_job_state *state);

#endif
