/* SPDX-License-Identifier: MIT */
/* work.h - what this process has had done: programs that were started, pictures that were drawn, samples that were taken.
 *
 * Counted from the start of the process, by any thread; iso_work_reset() begins anew. Names are copied, 63 characters of
 * them at most; there is room for ISO_WORK_MOST of each kind, and what comes later is counted by the last one. */
#ifndef ISO_BASE_WORK_H
#define ISO_BASE_WORK_H

#include <jansson.h>
#include <stddef.h>

enum { ISO_WORK_MOST = 32 };

void iso_work_reset(void);

/* A program was started; it ended, after so much processor time of its own and of what it had started. */
void iso_work_add_start(const char *program);
void iso_work_add_end(const char *program, double processor_seconds);

/* A renderer drew a picture. samples: pixels times the steps of a ray through the whole box; 0 where it has no steps. */
void iso_work_add_picture(const char *renderer, double pixels, double samples);

typedef struct iso_work_total {
    size_t starts, pictures;
    double pixels, samples, processor_seconds; /* of this process and of the programs that ended */
} iso_work_total;
iso_work_total iso_work_sum(void);

/* A new object, "work" of doc/reference/files-report.md. */
json_t *iso_work_to_json(void);

#endif
