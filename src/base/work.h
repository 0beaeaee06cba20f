/* SPDX-License-Identifier: MIT */
/* work.h - counts of this process's work: programs started, pictures rendered, samples taken.
 *
 * Counted from the start of the process, by any thread. Names are copied, 63 characters at most. Each kind has
 * ISO_WORK_MOST entries; later names are counted in the last one. */
#pragma once

#include <jansson.h>
#include <stddef.h>

enum { ISO_WORK_MOST = 32 };

/* Counts the start of a program, and its end with its own and its children's processor time. */
void iso_work_add_start(const char *program);
void iso_work_add_end(const char *program, double processor_seconds);

/* Counts a rendered picture. samples: pixels times the steps of a ray through the whole box; 0 if it has no steps. */
void iso_work_add_picture(const char *renderer, double pixels, double samples);

typedef struct iso_work_total {
    size_t starts, pictures;
    double pixels, samples, processor_seconds; /* of this process and of the programs that ended */
} iso_work_total;
iso_work_total iso_work_sum(void);

/* Returns a new object, "work" of doc/reference/files-report.md. */
json_t *iso_work_to_json(void);
