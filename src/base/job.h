/* SPDX-License-Identifier: MIT */
/* job.h - how far a whole job is, and how long the rest will take.
 *
 * A job is laid out before it begins:
 *
 *   phases   one after the other:              calibration | agreement | consistency
 *   lanes    of a phase, side by side:         level 0, level 1, level 2
 *   parts    of a lane, one after the other:   reference, gl, Cycles
 *
 * Each part has a cost, in seconds that it would take on a usual machine with nothing beside it, and a kind: parts of one
 * kind are wrong by the same factor. What a kind is wrong by is learned as its parts end or tell how far they are, and
 * until then it is what all parts are wrong by. What is left is then played forward: so many lanes at a time, each slowed
 * down by those beside it, the next phase when the last lane is over.
 *
 *   fraction   time passed / (time passed + time left); it never falls, and is 1 at the end alone
 *   left       follows the played rest smoothly: it falls with the clock and leans towards what is played
 *
 * Bounds (tests/test_job.c, by a clock of its own): see there.
 *
 * The clock is given with each call, in seconds from any moment. One thread at a time. */
#ifndef ISO_BASE_JOB_H
#define ISO_BASE_JOB_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

typedef struct iso_job iso_job;

/* cores: how many lanes may compute before one slows another down. NULL: no memory. */
iso_job *iso_job_create(int cores);
void iso_job_destroy(iso_job *job); /* accepts NULL */

/* ---- the layout ---------------------------------------------------------------------------- */

/* Each of the three is added to the last of what holds it; names are copied. A part without a phase or lane gets one. What
 * a kind is wrong by is taken to be what kinds with the same word before a slash ("limit/cycles") are, until it is known. */
void iso_job_add_phase(iso_job *job, const char *name, size_t workers);
void iso_job_add_lane(iso_job *job);
void iso_job_add_part(iso_job *job, const char *name, const char *kind, double cost_seconds);
/* What became known of parts that are not over: of those that have this name, or, where `of_variants`, of those whose names
 * end with it after something else. */
void iso_job_foresee(iso_job *job, const char *name, bool of_variants, double cost_seconds);
/* The job is over then, whatever its parts say: the end of a budget. */
void iso_job_set_deadline(iso_job *job, double now, double seconds);
/* Without a part the job has no estimate. */
bool iso_job_has_parts(const iso_job *job);
/* No part waits, and those that run told a fraction of 1. */
bool iso_job_is_done(const iso_job *job);

/* ---- as it runs ---------------------------------------------------------------------------- */

/* The phase of that name, or of none where the layout lacks it: those before it are over. */
void iso_job_begin_phase(iso_job *job, const char *name, double now);
/* Lane number `lane` of the phase reports: the part of that name, and those before it are over. A name that the rest of
 * the lane lacks is a detail of the part that runs. NAN: the fraction is not known. */
void iso_job_report(iso_job *job, size_t lane, const char *name, double fraction, double now);
/* Some of what the part that runs in the lane has to do was done before, so that its time says nothing of its kind. */
void iso_job_is_shortened(iso_job *job, size_t lane);
void iso_job_end_lane(iso_job *job, size_t lane, double now);
void iso_job_end(iso_job *job, double now);

/* ---- what it says -------------------------------------------------------------------------- */

typedef struct iso_job_state {
    const char *part;      /* the one that began last of those that run; "" for none. Valid until the job goes on. */
    double fraction;       /* 0 to 1 */
    double left_seconds;   /* NAN while too little is known */
    double passed_seconds; /* since the first report */
} iso_job_state;

/* Also lets the clock go on, so that it may be asked between two reports. */
iso_job_state iso_job_look(iso_job *job, double now);

/* How far off the time was that was shown: of all looks from a third of the job on, passed and left together beside what it
 * took until `now`. worst: the largest part by which it was too long or too short; NAN where nothing was shown. */
typedef struct iso_job_estimate {
    double seconds, first, worst; /* first: what the first look that had one told of the whole, in seconds */
    size_t looks;
} iso_job_estimate;
iso_job_estimate iso_job_judge(const iso_job *job, double now);

/* A part as it was laid out and as it went; names are valid until the job is destroyed. */
typedef struct iso_job_part {
    const char *phase, *name, *kind;
    double cost_seconds, seconds; /* foreseen, and taken so far had it been alone: 0 of what did not run */
} iso_job_part;
size_t iso_job_part_count(const iso_job *job);
iso_job_part iso_job_part_at(const iso_job *job, size_t i);

#endif
