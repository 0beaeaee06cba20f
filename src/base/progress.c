/* SPDX-License-Identifier: MIT */
#include "base/progress.h"

#include <stdio.h>

#include "base/parallel.h"

static const double POLL_SECONDS = 0.05;
static _Thread_local const iso_progress *current;

void iso_call_begin(iso_call *call, bool (*report)(void *user, const char *stage, double fraction), void *user)
{
    const bool is_part = !report && current; /* of a call that reports */
    *call = (iso_call){.progress = is_part ? *current : (iso_progress){.report = report, .user = user, .call = call},
                       .lock = PTHREAD_MUTEX_INITIALIZER,
                       .stage = "start",
                       .outer = current};
    current = &call->progress;
}

iso_status iso_call_end(iso_call *call, iso_status status, iso_error *err)
{
    current = call->outer;
    pthread_mutex_destroy(&call->lock);
    return status == ISO_OK || !call->canceled ? status : iso_fail(err, ISO_E_CANCELED, "canceled by its caller");
}

static bool is_canceled(const iso_call *call)
{
    return __atomic_load_n(&call->canceled, __ATOMIC_RELAXED);
}

/* Reports, unless it is canceled already. The caller holds the lock. */
static void report_locked(iso_call *call)
{
    const iso_progress *p = &call->progress;
    if (!is_canceled(call) && !p->report(p->user, call->stage, call->fraction))
        __atomic_store_n(&call->canceled, true, __ATOMIC_RELAXED);
    const double next = iso_clock_seconds() + POLL_SECONDS;
    __atomic_store(&call->next_poll, &next, __ATOMIC_RELAXED);
}

void iso_progress_report(const iso_progress *progress, const char *stage, double fraction)
{
    if (!progress || !progress->report)
        return;
    iso_call *call = progress->call;
    if (!call) {
        progress->report(progress->user, stage, fraction);
        return;
    }
    pthread_mutex_lock(&call->lock);
    snprintf(call->stage, sizeof call->stage, "%s", stage);
    call->fraction = fraction;
    report_locked(call);
    pthread_mutex_unlock(&call->lock);
}

const iso_progress *iso_progress_current(void)
{
    return current;
}

bool iso_progress_poll(const iso_progress *progress)
{
    iso_call *call = progress ? progress->call : NULL;
    if (!call || !progress->report)
        return false;
    double next;
    __atomic_load(&call->next_poll, &next, __ATOMIC_RELAXED);
    if (!is_canceled(call) && iso_clock_seconds() >= next && pthread_mutex_trylock(&call->lock) == 0) {
        report_locked(call);
        pthread_mutex_unlock(&call->lock);
    }
    return is_canceled(call);
}

iso_status iso_progress_check(const iso_progress *progress, iso_error *err)
{
    return iso_progress_poll(progress) ? iso_fail(err, ISO_E_CANCELED, "canceled by its caller") : ISO_OK;
}
