/* SPDX-License-Identifier: MIT */
/* progress.h - reports of the progress of long work, and requests to cancel it.
 *
 * The library calls report(user, stage, fraction) with fraction in [0, 1]; the command line draws a bar from it. A
 * NULL progress, or a NULL report, is silent. Calls come from one thread at a time.
 *
 * report() returns whether to go on. Work that a call of the library does (iso_call_begin()) ends early if it returns
 * false: loops poll, skip what is left, and the call fails with ISO_E_CANCELED. Other work ignores the result. */
#pragma once

#include <pthread.h>
#include <stdbool.h>

#include "base/status.h"

typedef struct iso_progress {
    bool (*report)(void *user, const char *stage, double fraction);
    void *user;
    struct iso_call *call; /* that may be canceled; or NULL */
} iso_progress;

/* A call of the library, from its begin to its end. */
typedef struct iso_call {
    iso_progress progress;
    pthread_mutex_t lock; /* of the following */
    char stage[64];       /* of the last report */
    double fraction;
    double next_poll;         /* by iso_clock_seconds() */
    bool canceled;            /* read and written as an atomic */
    const iso_progress *outer; /* of this thread before the call */
} iso_call;

/* Makes call->progress the calling thread's current one. report NULL: that of a call that this one is a part of, or
 * none. */
void iso_call_begin(iso_call *call, bool (*report)(void *user, const char *stage, double fraction), void *user);
/* Restores the thread's progress. Returns the call's status: ISO_E_CANCELED if it failed after it was canceled. */
iso_status iso_call_end(iso_call *call, iso_status status, iso_error *err);

void iso_progress_report(const iso_progress *progress, const char *stage, double fraction);

/* Returns the progress of the call that this thread does; NULL: none. Ask before a parallel loop: its threads have no
 * progress of their own. */
const iso_progress *iso_progress_current(void);

/* True if the work was canceled. Repeats the last report if a twentieth of a second has passed. For any thread. */
bool iso_progress_poll(const iso_progress *progress);
/* Returns ISO_E_CANCELED if the work was canceled. */
iso_status iso_progress_check(const iso_progress *progress, iso_error *err);
