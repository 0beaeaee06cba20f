/* SPDX-License-Identifier: MIT */
/* stream_choose.c - a pass over the volume that only sums up how gradients agree (agreement.h): which filter a level
 * gets has to be known before its first row is written. */
#include <stdlib.h>
#include <string.h>

#include "pyramid/agreement.h"
#include "pyramid/stream_build.h"

/* Planes in memory at a time: no more than the levels need, or this much. */
#define WINDOW_BYTES ((size_t)64 << 20)

/* Planes [first, first + count) of the volume, read one after the other. */
typedef struct window {
    char *data;
    size_t plane_bytes, first, count;
} window;

/* Moves the window to the planes [from, to). */
static iso_status move_to(window *w, iso_volume_source *source, size_t from, size_t to, iso_error *err)
{
    const size_t end = w->first + w->count, kept = end > from ? end - from : 0;
    memmove(w->data, w->data + (w->count - kept) * w->plane_bytes, kept * w->plane_bytes);
    w->first = from;
    w->count = to - from;
    return to - from > kept ? iso_source_read(source, to - from - kept, w->data + kept * w->plane_bytes, err) : ISO_OK;
}

static size_t planes_at_a_time(const pyramid_build *s, const iso_cascade *c)
{
    const size_t step = iso_cascade_step(c), most = s->how->max_slab, fit = WINDOW_BYTES / stream_plane_bytes(s);
    const size_t planes = (most > 0 && most < fit ? most : fit) / step * step;
    return planes > step ? planes : step;
}

/* Sums up the agreement of the planes [z0, z1); z0 is a multiple of the cascade's step. */
static iso_status sum_up(pyramid_build *s, iso_cascade *c, size_t z0, size_t z1, const iso_progress *progress,
                         iso_error *err)
{
    const size_t *n = s->header.geometry.size;
    const size_t reach = iso_cascade_reach(c), slab = planes_at_a_time(s, c);
    const iso_cascade_out nothing[STREAM_MAX_LEVELS] = {{0}};
    window w = {.plane_bytes = stream_plane_bytes(s), .first = z0 > reach ? z0 - reach : 0};
    iso_volume_source *source = NULL;
    w.data = malloc((slab + 2 * reach) * w.plane_bytes);
    iso_status status = w.data ? s->in->open(s->in->user, &source, err)
                               : iso_fail(err, ISO_E_MEMORY, "%s: no memory for %zu planes", s->in->path, slab);
    TRY(status, iso_source_skip(source, w.first, err));
    for (size_t z = z0; z < z1 && status == ISO_OK; z += slab) {
        const size_t end = z + slab < z1 ? z + slab : z1;
        iso_progress_report(progress, "directions", (double)(z - z0) / (double)(z1 - z0));
        status = move_to(&w, source, z > reach ? z - reach : 0, end + reach < n[2] ? end + reach : n[2], err);
        const iso_planes in = {w.data, s->header.type, {n[0], n[1], n[2]}, w.first, w.count,
                               s->header.geometry.has_no_data};
        TRY(status, iso_cascade_feed(c, &in, z, end, nothing, err));
    }
    iso_source_close(source);
    free(w.data);
    return status;
}

/* Adds up all ranks' sums on rank 0 and sends its choice to the others. */
static void add_shares(pyramid_build *s, iso_cascade *c)
{
    iso_agreement sums[STREAM_MAX_LEVELS] = {0};
    for (int rank = 1; rank < iso_ranks_count(s->how->ranks); ++rank) {
        if (stream_is_first(s)) {
            iso_ranks_receive(s->how->ranks, rank, sums, sizeof sums);
            for (size_t k = 0; k < STREAM_MAX_LEVELS; ++k)
                iso_cascade_add_agreement(c, k, &sums[k]);
        } else if (iso_ranks_index(s->how->ranks) == rank) {
            for (size_t k = 0; k < STREAM_MAX_LEVELS; ++k)
                iso_cascade_get_agreement(c, k, &sums[k]);
            iso_ranks_send(s->how->ranks, 0, sums, sizeof sums);
        }
    }
    iso_cascade_choose(c, &s->own.choice);
    iso_ranks_broadcast(s->how->ranks, &s->own.choice, sizeof s->own.choice);
}

iso_status iso_stream_choose(pyramid_build *s, double scale, const iso_progress *progress, iso_error *err)
{
    if (s->opt->direction_filter != ISO_DIRECTION_AUTO)
        return ISO_OK;
    const iso_pyramid_options opt = iso_agreement_options(s->opt);
    iso_cascade *c = NULL;
    iso_status status = iso_cascade_create(&s->header.geometry, &opt, scale, &c, err);
    if (status == ISO_OK) {
        const size_t nz = s->header.geometry.size[2], step = iso_cascade_step(c), steps = (nz + step - 1) / step;
        const size_t ranks = (size_t)iso_ranks_count(s->how->ranks), rank = (size_t)iso_ranks_index(s->how->ranks);
        const size_t first = steps * rank / ranks * step, end = steps * (rank + 1) / ranks * step;
        status = sum_up(s, c, first, end < nz ? end : nz, progress, err);
    }
    status = iso_ranks_agree(s->how->ranks, status, err);
    if (status == ISO_OK)
        add_shares(s, c);
    iso_cascade_destroy(c);
    return status;
}
