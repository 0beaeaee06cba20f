/* SPDX-License-Identifier: MIT */
#include "pyramid/stream_build.h"

#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"

/* Buffers are touched for the first time, which costs, and hold their slabs between the threads. */
#define FAST_BYTES ((size_t)160 << 20)

/* ---- the range of the input ---- */

static iso_status measure_planes(const iso_volume *plane, const char *path, double *lo, double *hi, bool *has_no_data,
                                 iso_error *err)
{
    iso_volume_stats stats = iso_volume_measure(plane);
    if (stats.nonfinite_count > 0)
        return iso_fail(err, ISO_E_RANGE,
                        "%s: %zu voxels of a plane are NaN or infinite, none may be; --no-data inf leaves infinite "
                        "ones out",
                        path, stats.nonfinite_count);
    *lo = fmin(*lo, stats.min);
    *hi = fmax(*hi, stats.max);
    *has_no_data = *has_no_data || stats.no_data_count > 0;
    return ISO_OK;
}

/* Gets the range of narrow integers from their type; of others by reading them all, each rank its share. */
iso_status iso_stream_input_range(pyramid_build *s, double *range, iso_error *err)
{
    const size_t bytes = iso_type_bytes(s->header.type), nz = s->header.geometry.size[2];
    *range = bytes == 1 ? 255 : 65535;
    if (bytes <= 2)
        return ISO_OK;
    const size_t ranks = (size_t)iso_ranks_count(s->how->ranks), rank = (size_t)iso_ranks_index(s->how->ranks);
    const size_t first = nz * rank / ranks, end = nz * (rank + 1) / ranks;
    double lo = INFINITY, hi = -INFINITY;
    bool has_no_data = false;
    iso_volume plane = s->header;
    iso_volume_source *source = NULL;
    plane.geometry.size[2] = 1;
    plane.data = malloc(stream_plane_bytes(s));
    iso_status status = plane.data ? s->in->open(s->in->user, &source, err)
                                   : iso_fail(err, ISO_E_MEMORY, "%s: no memory for a plane", s->in->path);
    TRY(status, iso_source_skip(source, first, err));
    for (size_t z = first; z < end && status == ISO_OK; ++z) {
        status = iso_source_read(source, 1, plane.data, err);
        TRY(status, measure_planes(&plane, s->in->path, &lo, &hi, &has_no_data, err));
        if (status != ISO_OK && status == ISO_E_RANGE)
            status = iso_fail_in(err, status, "plane %zu", z);
    }
    iso_source_close(source);
    free(plane.data);
    double extremes[3] = {-lo, hi, has_no_data};
    status = iso_ranks_agree(s->how->ranks, status, err);
    iso_ranks_largest(s->how->ranks, extremes, 3);
    lo = -extremes[0], hi = extremes[1];
    s->header.geometry.has_no_data = extremes[2] > 0;
    if (status == ISO_OK && !(lo <= hi))
        status = iso_fail(err, ISO_E_RANGE, "%s: no voxel has data", s->in->path);
    *range = hi - lo;
    return status == ISO_OK ? iso_pyramid_check_values(lo, hi, s->in->path, err) : status;
}

/* ---- buffers ---- */

size_t iso_stream_planes_capacity(const pyramid_build *s, size_t slab)
{
    return slab + s->overlap + 2 * iso_cascade_reach(s->cascade);
}

size_t iso_stream_buffer_bytes(const pyramid_build *s, size_t slab)
{
    size_t bytes = STREAM_INPUT_SETS * iso_stream_planes_capacity(s, slab) * stream_plane_bytes(s) +
                   iso_cascade_bytes(s->cascade);
    for (size_t k = 0; k < s->out.level_count; ++k) {
        const stream_level *l = &s->out.levels[k];
        bytes += 2 * iso_cascade_capacity(s->cascade, k, slab) * iso_stream_level_plane_bytes(l, s->opt);
        for (int i = 0; i < FILE_COUNT; ++i)
            bytes += l->files[i].stored ? ISO_BIGFILE_BYTES : 0;
    }
    return bytes;
}

/* Returns the most planes that are fed twice if slabs do not follow each other. */
size_t iso_stream_longest_warm_up(const pyramid_build *s)
{
    size_t longest = 0;
    for (size_t z = 0; !stream_is_alone(s) && z < s->header.geometry.size[2]; z += iso_cascade_step(s->cascade)) {
        const size_t from = iso_cascade_warm_up(s->cascade, z);
        longest = z - from > longest ? z - from : longest;
    }
    return longest;
}

/* Limits a slab so that each of several ranks has several slabs, so that none waits long for the last ones. */
static size_t longest_slab(const pyramid_build *s)
{
    const size_t nz = s->header.geometry.size[2], step = iso_cascade_step(s->cascade);
    const size_t longest = s->how->max_slab > 0 && s->how->max_slab < nz ? s->how->max_slab : nz;
    const size_t share = stream_is_alone(s) ? nz : nz / (4 * (size_t)iso_ranks_count(s->how->ranks)) / step * step;
    return share < longest ? share : longest;
}

iso_status iso_stream_choose_slab(pyramid_build *s, iso_error *err)
{
    const size_t step = iso_cascade_step(s->cascade), limit = s->how->memory_bytes, longest = longest_slab(s);
    size_t slab = step;
    if (limit > 0 && iso_stream_buffer_bytes(s, step) > limit)
        return iso_fail(err, ISO_E_MEMORY, "%s: slabs of %zu planes need %zu MB of memory, %zu MB are allowed",
                        s->in->path, step, iso_stream_buffer_bytes(s, step) >> 20, limit >> 20);
    const size_t enough = iso_stream_buffer_bytes(s, step) > FAST_BYTES ? iso_stream_buffer_bytes(s, step) : FAST_BYTES;
    while (slab < longest && (limit == 0 || iso_stream_buffer_bytes(s, slab + step) <= limit) &&
           (iso_stream_buffer_bytes(s, slab + step) <= enough || slab < 4 * s->overlap))
        slab += step;
    s->plan.slab = slab;
    return ISO_OK;
}

/* ---- slabs ---- */

size_t iso_stream_slab_count(const pyramid_build *s)
{
    return (s->header.geometry.size[2] - s->plan.start + s->plan.slab - 1) / s->plan.slab;
}

stream_slab iso_stream_slab_at(const pyramid_build *s, size_t i)
{
    const size_t nz = s->header.geometry.size[2], reach = iso_cascade_reach(s->cascade);
    stream_slab b = {.z0 = s->plan.start + i * s->plan.slab};
    b.z1 = b.z0 + s->plan.slab < nz ? b.z0 + s->plan.slab : nz;
    b.from = stream_is_alone(s) ? b.z0 : iso_cascade_warm_up(s->cascade, b.z0);
    b.read_from = b.from > reach ? b.from - reach : 0;
    b.read_to = b.z1 + reach < nz ? b.z1 + reach : nz;
    return b;
}

void iso_stream_request_slab(pyramid_build *s, size_t i)
{
    if (i >= iso_stream_slab_count(s))
        return;
    const stream_slab b = iso_stream_slab_at(s, i);
    iso_stream_input_request(&s->input, b.read_from, b.read_to);
}

iso_status iso_stream_feed_slab(pyramid_build *s, const stream_slab *b, const stream_planes *planes, iso_error *err)
{
    const size_t *n = s->header.geometry.size;
    const iso_planes in = {planes->data,  s->header.type, {n[0], n[1], n[2]},
                           planes->first, planes->count,  s->header.geometry.has_no_data};
    iso_cascade_out out[STREAM_MAX_LEVELS];
    const double start = iso_clock_seconds();
    if (stream_is_alone(s))
        iso_stream_output_copy_begun(&s->out);
    else
        for (size_t k = 0; k < s->out.level_count; ++k)
            s->out.levels[k].first = iso_cascade_complete(s->cascade, k, b->z0);
    iso_stream_output_targets(&s->out, out);
    iso_status status = iso_cascade_feed(s->cascade, &in, b->from, b->z1, out, err);
    s->report->seconds_build += iso_clock_seconds() - start;
    return status;
}

void iso_stream_list_slab(pyramid_build *s, const stream_slab *b, const stream_planes *planes)
{
    size_t complete[STREAM_MAX_LEVELS];
    for (size_t k = 0; k < s->out.level_count; ++k)
        complete[k] = iso_cascade_complete(s->cascade, k, b->z1);
    iso_stream_output_list(&s->out, complete, planes->data, planes->first);
}

static iso_status stream_wait_for_writers(pyramid_build *s, iso_error *err)
{
    const double start = iso_clock_seconds();
    iso_status status = iso_stream_output_wait(&s->out, err);
    s->report->seconds_write += iso_clock_seconds() - start;
    return status;
}

iso_status iso_stream_wait_for_planes(pyramid_build *s, const stream_planes **planes, iso_error *err)
{
    const double start = iso_clock_seconds();
    iso_status status = iso_stream_input_wait(&s->input, planes, err);
    s->report->seconds_read += iso_clock_seconds() - start;
    return status;
}

/* ---- alone ---- */

/* Notes progress if it is due. All planes before z are written; the last blocks of the files may not be. */
static iso_status note_if_due(pyramid_build *s, json_t *job, size_t z, size_t done, iso_error *err)
{
    if (z <= done || !iso_stream_progress_is_due(s))
        return ISO_OK;
    NEED(iso_stream_output_sync(&s->out, err));
    return iso_stream_note_progress(s, job, z, err);
}

static iso_status do_slab(pyramid_build *s, size_t i, json_t *job, size_t done, iso_error *err)
{
    const stream_slab b = iso_stream_slab_at(s, i);
    const stream_planes *planes;
    NEED(iso_stream_wait_for_planes(s, &planes, err));
    iso_stream_request_slab(s, i + 1);
    NEED(iso_stream_feed_slab(s, &b, planes, err));
    NEED(stream_wait_for_writers(s, err));
    NEED(note_if_due(s, job, b.z0, done, err));
    iso_stream_list_slab(s, &b, planes);
    iso_stream_output_start(&s->out);
    return ISO_OK;
}

iso_status iso_stream_run_alone(pyramid_build *s, json_t *job, size_t done, const iso_progress *progress,
                                iso_error *err)
{
    const size_t nz = s->header.geometry.size[2];
    iso_status status = ISO_OK;
    iso_stream_request_slab(s, 0);
    for (size_t i = 0; i < iso_stream_slab_count(s) && status == ISO_OK; ++i) {
        const stream_slab b = iso_stream_slab_at(s, i);
        iso_progress_report(progress, "build", (double)b.z0 / (double)nz);
        status = do_slab(s, i, job, done, err);
        if (status != ISO_OK || s->how->stop_after == 0 || b.z1 < s->how->stop_after || b.z1 == nz)
            continue;
        status = stream_wait_for_writers(s, err);
        status = status == ISO_OK ? note_if_due(s, job, b.z1, done, err) : status;
        return status == ISO_OK ? iso_fail(err, ISO_E_PROGRAM, "stopped after %zu planes", b.z1) : status;
    }
    TRY(status, stream_wait_for_writers(s, err));
    iso_progress_report(progress, "build", 1);
    return status;
}
