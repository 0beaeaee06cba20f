/* SPDX-License-Identifier: MIT */
/* progress.h - reports of the progress of long work.
 *
 * The library calls report(user, stage, fraction) with fraction in [0, 1]; the command line draws a bar from it. A
 * NULL progress, or a NULL report, is silent. Calls come from one thread at a time. */
#ifndef ISO_PROGRESS_H
#define ISO_PROGRESS_H

typedef struct iso_progress {
    void (*report)(void *user, const char *stage, double fraction);
    void *user;
} iso_progress;

static inline void iso_progress_report(const iso_progress *progress, const char *stage, double fraction)
{
    if (progress && progress->report)
        progress->report(progress->user, stage, fraction);
}

#endif
