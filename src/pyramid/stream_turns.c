/* SPDX-License-Identifier: MIT */
#include "pyramid/stream_build.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"

/* ---- what goes from rank to rank ---- */

static size_t turn_bytes(const pyramid_build *s)
{
    size_t plane_floats;
    size_t bytes = sizeof(stream_turn) + iso_stream_tails_bytes(&s->out);
    if (iso_cascade_carry(s->cascade, &plane_floats))
        bytes += (size_t)iso_ranks_count(s->how->ranks) * ((s->plan.slab >> iso_cascade_carry_level(s->cascade)) + 1) *
                 plane_floats * sizeof(float);
    return (bytes + 63) / 64 * 64;
}

bool iso_stream_turn_create(pyramid_build *s)
{
    s->turn = aligned_alloc(64, turn_bytes(s));
    return s->turn != NULL;
}

static char *turn_tails(const pyramid_build *s)
{
    return (char *)(s->turn + 1);
}

static float *turn_carry(const pyramid_build *s)
{
    return (float *)(void *)(turn_tails(s) + iso_stream_tails_bytes(&s->out));
}

/* Copies the ranges so far, and the carry's planes from slab `oldest` on, into the turn. */
static void fill_turn(pyramid_build *s, size_t oldest, size_t z)
{
    size_t plane_floats;
    const float *carry = iso_cascade_carry(s->cascade, &plane_floats);
    const size_t level = iso_cascade_carry_level(s->cascade);
    for (size_t k = 0; k < s->out.level_count; ++k)
        iso_cascade_range(s->cascade, k, &s->turn->lo[k], &s->turn->hi[k]);
    s->turn->carry_first = iso_stream_slab_at(s, oldest).z0 >> level;
    s->turn->carry_count = carry ? (z >> level) - s->turn->carry_first : 0;
    if (carry)
        memcpy(turn_carry(s), carry + s->turn->carry_first * plane_floats,
               s->turn->carry_count * plane_floats * sizeof *carry);
}

static void take_over(pyramid_build *s)
{
    size_t plane_floats;
    float *carry = iso_cascade_carry(s->cascade, &plane_floats);
    for (size_t k = 0; k < s->out.level_count; ++k) {
        double lo, hi;
        iso_cascade_range(s->cascade, k, &lo, &hi);
        iso_cascade_set_range(s->cascade, k, fmin(lo, s->turn->lo[k]), fmax(hi, s->turn->hi[k]));
    }
    if (carry)
        memcpy(carry + s->turn->carry_first * plane_floats, turn_carry(s),
               s->turn->carry_count * plane_floats * sizeof *carry);
}

/* Waits for the turn of slab i; an error of an earlier slab goes before one of this rank. */
static iso_status take_turn(pyramid_build *s, size_t i, iso_status status, iso_error *err)
{
    const int count = iso_ranks_count(s->how->ranks);
    const double start = iso_clock_seconds();
    iso_status written = iso_stream_output_wait(&s->out, status == ISO_OK ? err : NULL);
    status = status == ISO_OK ? written : status;
    if (i > 0)
        iso_ranks_receive(s->how->ranks, (int)((i - 1) % (size_t)count), s->turn, turn_bytes(s));
    s->report->seconds_write += iso_clock_seconds() - start;
    if (i > 0 && s->turn->status != ISO_OK) {
        *err = s->turn->error;
        return s->turn->status;
    }
    if (i > 0 && status == ISO_OK)
        take_over(s);
    return status;
}

static void pass_turn(pyramid_build *s, size_t i, iso_status status, const iso_error *err)
{
    const size_t count = (size_t)iso_ranks_count(s->how->ranks);
    s->turn->status = status;
    if (status != ISO_OK)
        s->turn->error = *err;
    else
        fill_turn(s, i + 2 > count ? i + 2 - count : 0, iso_stream_slab_at(s, i).z1);
    if (i + 1 < iso_stream_slab_count(s))
        iso_ranks_send(s->how->ranks, (int)((i + 1) % count), s->turn,
                       status == ISO_OK ? turn_bytes(s) : sizeof *s->turn);
}

/* True for the last slab if there is a carry: the top levels are then made from it, and need all of it before. */
static bool needs_turn_first(const pyramid_build *s, const stream_slab *b)
{
    size_t plane_floats;
    return b->z1 == s->header.geometry.size[2] && iso_cascade_carry(s->cascade, &plane_floats);
}

static iso_status do_slab_in_turn(pyramid_build *s, size_t i, iso_status status, iso_error *err)
{
    const stream_slab b = iso_stream_slab_at(s, i);
    const stream_planes *planes = NULL;
    const bool turn_first = needs_turn_first(s, &b);
    TRY(status, iso_stream_wait_for_planes(s, &planes, err));
    if (status == ISO_OK)
        iso_stream_request_slab(s, i + (size_t)iso_ranks_count(s->how->ranks));
    if (turn_first)
        status = take_turn(s, i, status, err);
    TRY(status, iso_stream_feed_slab(s, &b, planes, err));
    if (!turn_first)
        status = take_turn(s, i, status, err);
    if (status == ISO_OK) {
        iso_stream_list_slab(s, &b, planes);
        iso_stream_tails_set(&s->out, turn_tails(s));
        iso_stream_tails_advance(&s->out, turn_tails(s));
    }
    pass_turn(s, i, status, err);
    if (status == ISO_OK)
        iso_stream_output_start(&s->out);
    return status;
}

/* Builds slab i on rank i mod count. When rank 0 has the turn of slab i, slabs up to i - count are written: each rank
 * waits for its own writers in its turn. The end of a slab stands in the first block of the next one, so one slab less
 * is safe. */
iso_status iso_stream_run_in_turns(pyramid_build *s, json_t *job, const iso_progress *progress, iso_error *err)
{
    const size_t count = (size_t)iso_ranks_count(s->how->ranks), rank = (size_t)iso_ranks_index(s->how->ranks);
    iso_status status = ISO_OK;
    if (rank == 0)
        iso_stream_tails_get(&s->out, turn_tails(s));
    iso_stream_request_slab(s, rank);
    for (size_t i = rank; i < iso_stream_slab_count(s); i += count) {
        const size_t safe = i >= count ? iso_stream_slab_at(s, i - count).z0 : 0;
        iso_progress_report(progress, "build", (double)i / (double)iso_stream_slab_count(s));
        status = do_slab_in_turn(s, i, status, err);
        if (status == ISO_OK && rank == 0 && safe > s->plan.start && iso_stream_progress_is_due(s))
            status = iso_stream_note_progress(s, job, safe, err);
    }
    iso_status written = iso_stream_output_wait(&s->out, status == ISO_OK ? err : NULL);
    iso_progress_report(progress, "build", 1);
    return status == ISO_OK ? written : status;
}

/* ---- the end ---- */

/* Sizes and checksums of the files, sent by the rank of the last slab to rank 0. */
typedef struct summary {
    level_file files[STREAM_MAX_LEVELS][FILE_COUNT];
    double lo[STREAM_MAX_LEVELS], hi[STREAM_MAX_LEVELS];
} summary;

iso_status iso_stream_close_in_turns(pyramid_build *s, iso_error *err)
{
    const int last = (int)((iso_stream_slab_count(s) - 1) % (size_t)iso_ranks_count(s->how->ranks));
    const int rank = iso_ranks_index(s->how->ranks);
    iso_status status = ISO_OK;
    if (rank == last) {
        iso_stream_tails_set(&s->out, turn_tails(s));
        status = iso_stream_output_close(&s->out, err);
    }
    status = iso_ranks_agree(s->how->ranks, status, err);
    if (status != ISO_OK || last == 0)
        return status;
    summary all = {0};
    for (size_t k = 0; k < s->out.level_count && rank == last; ++k) {
        memcpy(all.files[k], s->out.levels[k].files, sizeof all.files[k]);
        iso_cascade_range(s->cascade, k, &all.lo[k], &all.hi[k]);
    }
    if (rank == last)
        iso_ranks_send(s->how->ranks, 0, &all, sizeof all);
    if (rank != 0)
        return ISO_OK;
    iso_ranks_receive(s->how->ranks, last, &all, sizeof all);
    for (size_t k = 0; k < s->out.level_count; ++k) {
        iso_cascade_set_range(s->cascade, k, all.lo[k], all.hi[k]);
        for (int i = 0; i < FILE_COUNT; ++i) {
            s->out.levels[k].files[i].bytes = all.files[k][i].bytes;
            s->out.levels[k].files[i].hash = all.files[k][i].hash;
        }
    }
    return ISO_OK;
}
