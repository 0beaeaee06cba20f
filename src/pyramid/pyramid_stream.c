/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "pyramid/pyramid_stream.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/json.h"
#include "base/parallel.h"
#include "pyramid/cascade.h"
#include "pyramid/pyramid_layout.h"
#include "pyramid/stream_input.h"
#include "pyramid/stream_output.h"

#define PROGRESS_NAME "progress.json"
#define PROGRESS_SCHEMA "isoshade.progress/1"
#define CARRY_NAME "carry.raw"

/* Buffers are touched for the first time, which costs, and hold their slabs between the threads. */
#define FAST_BYTES ((size_t)160 << 20)

/* Input between two notes of progress; and from which on files bypass the page cache. */
#define PROGRESS_BYTES ((size_t)128 << 20)
#define DIRECT_BYTES ((size_t)256 << 20)

/* What goes from rank to rank with the turn: this, the files' tails, and the last planes of the cascade's carry. */
typedef struct baton {
    iso_status status;
    iso_error error;
    double lo[STREAM_MAX_LEVELS], hi[STREAM_MAX_LEVELS];
    size_t carry_first, carry_count;
} __attribute__((aligned(64))) baton;

/* What rank 0 decides. */
typedef struct plan {
    char folder[4096];
    size_t start, slab; /* first plane; planes of a slab */
} plan;

typedef struct stream {
    const iso_stream_input *in;
    const iso_pyramid_options *opt;
    const iso_stream_options *how;
    iso_stream_report *report;
    iso_output output; /* rank 0's */
    iso_volume_source *source;
    iso_volume header;
    iso_cascade *cascade;
    stream_input input;
    stream_output out;
    plan plan;
    size_t overlap; /* planes that a slab may have to be fed from before its own */
    size_t progress_at;
    iso_bigfile *carry; /* rank 0's */
    size_t carry_planes; /* written */
    baton *baton; /* only with other ranks */
} stream;

static bool is_alone(const stream *s)
{
    return iso_ranks_count(s->how->ranks) == 1;
}

static bool is_first(const stream *s)
{
    return iso_ranks_index(s->how->ranks) == 0;
}

static size_t input_plane_bytes(const stream *s)
{
    return s->header.geometry.size[0] * s->header.geometry.size[1] * iso_type_bytes(s->header.type);
}

/* ---- the range of the input ---- */

static iso_status measure_planes(const iso_volume *plane, const char *path, double *lo, double *hi, iso_error *err)
{
    iso_volume_stats stats = iso_volume_measure(plane);
    if (stats.nonfinite_count > 0)
        return iso_fail(err, ISO_E_RANGE, "%s: %zu voxels of a plane are NaN or infinite, none may be", path,
                        stats.nonfinite_count);
    *lo = fmin(*lo, stats.min);
    *hi = fmax(*hi, stats.max);
    return ISO_OK;
}

/* Of narrow integers by their type; of others by reading them all, each rank its share. */
static iso_status input_range(stream *s, double *range, iso_error *err)
{
    const size_t bytes = iso_type_bytes(s->header.type), nz = s->header.geometry.size[2];
    *range = bytes == 1 ? 255 : 65535;
    if (bytes <= 2)
        return ISO_OK;
    const size_t ranks = (size_t)iso_ranks_count(s->how->ranks), rank = (size_t)iso_ranks_index(s->how->ranks);
    const size_t first = nz * rank / ranks, end = nz * (rank + 1) / ranks;
    double lo = INFINITY, hi = -INFINITY;
    iso_volume plane = s->header;
    iso_volume_source *source = NULL;
    plane.geometry.size[2] = 1;
    plane.data = malloc(input_plane_bytes(s));
    iso_status status = plane.data ? s->in->open(s->in->user, &source, err)
                                   : iso_fail(err, ISO_E_MEMORY, "%s: no memory for a plane", s->in->path);
    if (status == ISO_OK)
        status = iso_source_skip(source, first, err);
    for (size_t z = first; z < end && status == ISO_OK; ++z) {
        status = iso_source_read(source, 1, plane.data, err);
        if (status == ISO_OK)
            status = measure_planes(&plane, s->in->path, &lo, &hi, err);
        if (status != ISO_OK && status == ISO_E_RANGE)
            status = iso_fail_in(err, status, "plane %zu", z);
    }
    iso_source_close(source);
    free(plane.data);
    double extremes[2] = {-lo, hi};
    status = iso_ranks_agree(s->how->ranks, status, err);
    iso_ranks_largest(s->how->ranks, extremes, 2);
    lo = -extremes[0], hi = extremes[1];
    *range = hi - lo;
    if (status == ISO_OK && !(*range <= FLT_MAX && fabs(lo) <= FLT_MAX && fabs(hi) <= FLT_MAX))
        status = iso_fail(err, ISO_E_RANGE, "%s: values from %g to %g, differences up to %g can be taken", s->in->path, lo,
                          hi, (double)FLT_MAX);
    return status;
}

/* ---- buffers ---- */

static size_t planes_capacity(const stream *s, size_t slab)
{
    return slab + s->overlap + 2 * iso_cascade_reach(s->cascade);
}

static size_t buffer_bytes(const stream *s, size_t slab)
{
    size_t bytes = STREAM_INPUT_SETS * planes_capacity(s, slab) * input_plane_bytes(s) + iso_cascade_bytes(s->cascade);
    for (size_t k = 0; k < s->out.level_count; ++k) {
        const stream_level *l = &s->out.levels[k];
        bytes += 2 * iso_cascade_capacity(s->cascade, k, slab) * iso_stream_level_plane_bytes(l, s->opt);
        for (int i = 0; i < FILE_COUNT; ++i)
            bytes += l->files[i].stored ? ISO_BIGFILE_BYTES : 0;
    }
    return bytes;
}

/* What is fed twice when slabs do not follow each other. */
static size_t longest_warm_up(const stream *s)
{
    size_t longest = 0;
    for (size_t z = 0; !is_alone(s) && z < s->header.geometry.size[2]; z += iso_cascade_step(s->cascade)) {
        const size_t from = iso_cascade_warm_up(s->cascade, z);
        longest = z - from > longest ? z - from : longest;
    }
    return longest;
}

/* Of several ranks each has several slabs, so that none waits long for the last ones. */
static size_t longest_slab(const stream *s)
{
    const size_t nz = s->header.geometry.size[2], step = iso_cascade_step(s->cascade);
    const size_t longest = s->how->max_slab > 0 && s->how->max_slab < nz ? s->how->max_slab : nz;
    const size_t share = is_alone(s) ? nz : nz / (4 * (size_t)iso_ranks_count(s->how->ranks)) / step * step;
    return share < longest ? share : longest;
}

static iso_status choose_slab(stream *s, iso_error *err)
{
    const size_t step = iso_cascade_step(s->cascade), limit = s->how->memory_bytes, longest = longest_slab(s);
    size_t slab = step;
    if (limit > 0 && buffer_bytes(s, step) > limit)
        return iso_fail(err, ISO_E_MEMORY, "%s: slabs of %zu planes need %zu MB of memory, %zu MB are allowed", s->in->path,
                        step, buffer_bytes(s, step) >> 20, limit >> 20);
    const size_t enough = buffer_bytes(s, step) > FAST_BYTES ? buffer_bytes(s, step) : FAST_BYTES;
    while (slab < longest && (limit == 0 || buffer_bytes(s, slab + step) <= limit) &&
           (buffer_bytes(s, slab + step) <= enough || slab < 4 * s->overlap))
        slab += step;
    s->plan.slab = slab;
    return ISO_OK;
}

static size_t baton_bytes(const stream *s)
{
    size_t plane_floats;
    size_t bytes = sizeof(baton) + iso_stream_tails_bytes(&s->out);
    if (iso_cascade_carry(s->cascade, &plane_floats))
        bytes += (size_t)iso_ranks_count(s->how->ranks) * ((s->plan.slab >> iso_cascade_carry_level(s->cascade)) + 1) *
                 plane_floats * sizeof(float);
    return (bytes + 63) / 64 * 64;
}

static iso_status create_buffers(stream *s, iso_error *err)
{
    bool good = iso_stream_input_create(&s->input, s->source, planes_capacity(s, s->plan.slab)) &&
                iso_stream_output_create(&s->out, s->cascade, s->plan.slab, s->opt);
    s->out.in_turns = !is_alone(s);
    if (good && s->out.in_turns)
        good = (s->baton = aligned_alloc(64, baton_bytes(s))) != NULL;
    return good ? ISO_OK
                : iso_fail(err, ISO_E_MEMORY, "%s: no memory for slabs of %zu planes", s->in->path, s->plan.slab);
}

/* ---- progress.json ---- */

static json_t *describe_job(const stream *s, double scale)
{
    struct stat st = {0};
    stat(s->in->path, &st);
    return json_pack("{s:s, s:s, s:I, s:I, s:o, s:s, s:f, s:o}", "schema", PROGRESS_SCHEMA, "source", s->in->path,
                     "source_bytes", (json_int_t)st.st_size, "source_time", (json_int_t)st.st_mtime, "geometry",
                     iso_layout_geometry(&s->header.geometry), "type", iso_type_name(s->header.type), "scale", scale,
                     "options", iso_layout_options(s->opt));
}

static iso_status save_progress(const stream *s, json_t *job, size_t planes, iso_error *err)
{
    json_t *ranges = json_array();
    for (size_t k = 0; k < s->out.level_count; ++k) {
        double range[2] = {0, 0};
        iso_cascade_range(s->cascade, k, &range[0], &range[1]);
        json_array_append_new(ranges, iso_json_numbers(range, 2)); /* null where there is none yet */
    }
    json_object_set_new(job, "planes", json_integer((json_int_t)planes));
    json_object_set_new(job, "ranges", ranges);
    return iso_layout_save_json(s->output.temp_path, PROGRESS_NAME, job, err);
}

static iso_status take_up_carry(stream *s, const char *folder, size_t z, iso_error *err)
{
    size_t plane_floats;
    float *carry = iso_cascade_carry(s->cascade, &plane_floats);
    const size_t level = iso_cascade_carry_level(s->cascade), planes = z >> level;
    if (!carry || planes == 0)
        return ISO_OK;
    char *path = iso_path_join(folder, CARRY_NAME), *data = NULL;
    size_t size = 0;
    iso_status status = path ? iso_file_read(path, &data, &size, err) : iso_fail(err, ISO_E_MEMORY, "out of memory");
    if (status == ISO_OK && size < planes * plane_floats * sizeof *carry)
        status = iso_fail(err, ISO_E_FORMAT, "%s: holds less than progress.json says", path);
    if (status == ISO_OK) {
        memcpy(carry, data, planes * plane_floats * sizeof *carry);
        s->carry_planes = planes;
    }
    free(data);
    free(path);
    return status;
}

/* Whether an earlier build's progress is of this very job, and how far it came. */
static bool read_progress(stream *s, const json_t *job, size_t *planes)
{
    char *path = iso_path_join(s->output.temp_path, PROGRESS_NAME);
    json_t *found = NULL;
    bool same = path && iso_json_load(path, &found, NULL) == ISO_OK;
    const char *key;
    json_t *value;
    if (same)
        json_object_foreach((json_t *)job, key, value)
            same = same && json_equal(value, json_object_get(found, key));
    json_t *ranges = same ? json_object_get(found, "ranges") : NULL;
    *planes = same ? (size_t)json_integer_value(json_object_get(found, "planes")) : 0;
    same = same && *planes > 0 && *planes <= s->header.geometry.size[2] && json_array_size(ranges) == s->out.level_count;
    for (size_t k = 0; same && k < s->out.level_count; ++k) {
        json_t *range = json_array_get(ranges, k);
        if (json_is_number(json_array_get(range, 0)))
            iso_cascade_set_range(s->cascade, k, json_number_value(json_array_get(range, 0)),
                                  json_number_value(json_array_get(range, 1)));
    }
    json_decref(found);
    free(path);
    return same;
}

/* Up to plane z of the input. */
static iso_status write_carry(stream *s, size_t z, iso_error *err)
{
    size_t plane_floats;
    const float *carry = iso_cascade_carry(s->cascade, &plane_floats);
    const size_t planes = z >> iso_cascade_carry_level(s->cascade);
    if (!carry || planes <= s->carry_planes)
        return ISO_OK;
    iso_status status = iso_bigfile_write(s->carry, carry + s->carry_planes * plane_floats,
                                          (planes - s->carry_planes) * plane_floats * sizeof *carry, err);
    s->carry_planes = planes;
    return status == ISO_OK ? iso_bigfile_sync(s->carry, err) : status;
}

/* Not after every small slab: the last blocks of the files are written each time. */
static bool progress_is_due(stream *s, size_t z)
{
    const size_t bytes = (z - s->progress_at) * input_plane_bytes(s);
    if (bytes < PROGRESS_BYTES && s->how->stop_after == 0)
        return false;
    s->progress_at = z;
    return true;
}

/* What is on the disk up to plane z may be taken up. */
static iso_status note_progress(stream *s, json_t *job, size_t z, iso_error *err)
{
    iso_status status = write_carry(s, z, err);
    return status == ISO_OK ? save_progress(s, job, z, err) : status;
}

/* ---- slabs ---- */

typedef struct slab {
    size_t from, z0, z1;   /* fed from; its planes */
    size_t read_from, read_to;
} slab;

static size_t slab_count(const stream *s)
{
    return (s->header.geometry.size[2] - s->plan.start + s->plan.slab - 1) / s->plan.slab;
}

static slab slab_at(const stream *s, size_t i)
{
    const size_t nz = s->header.geometry.size[2], reach = iso_cascade_reach(s->cascade);
    slab b = {.z0 = s->plan.start + i * s->plan.slab};
    b.z1 = b.z0 + s->plan.slab < nz ? b.z0 + s->plan.slab : nz;
    b.from = is_alone(s) ? b.z0 : iso_cascade_warm_up(s->cascade, b.z0);
    b.read_from = b.from > reach ? b.from - reach : 0;
    b.read_to = b.z1 + reach < nz ? b.z1 + reach : nz;
    return b;
}

static void request_slab(stream *s, size_t i)
{
    if (i >= slab_count(s))
        return;
    const slab b = slab_at(s, i);
    iso_stream_input_request(&s->input, b.read_from, b.read_to);
}

static iso_status feed_slab(stream *s, const slab *b, const stream_planes *planes, iso_error *err)
{
    const size_t *n = s->header.geometry.size;
    const iso_planes in = {planes->data, s->header.type, {n[0], n[1], n[2]}, planes->first, planes->count};
    iso_cascade_out out[STREAM_MAX_LEVELS];
    const double start = iso_clock_seconds();
    if (is_alone(s))
        iso_stream_output_copy_begun(&s->out);
    else
        for (size_t k = 0; k < s->out.level_count; ++k)
            s->out.levels[k].first = iso_cascade_complete(s->cascade, k, b->z0);
    iso_stream_output_targets(&s->out, out);
    iso_status status = iso_cascade_feed(s->cascade, &in, b->from, b->z1, out, err);
    s->report->seconds_build += iso_clock_seconds() - start;
    return status;
}

static void list_slab(stream *s, const slab *b, const stream_planes *planes)
{
    size_t complete[STREAM_MAX_LEVELS];
    for (size_t k = 0; k < s->out.level_count; ++k)
        complete[k] = iso_cascade_complete(s->cascade, k, b->z1);
    iso_stream_output_list(&s->out, complete, planes->data, planes->first);
}

static iso_status wait_for_writers(stream *s, iso_error *err)
{
    const double start = iso_clock_seconds();
    iso_status status = iso_stream_output_wait(&s->out, err);
    s->report->seconds_write += iso_clock_seconds() - start;
    return status;
}

static iso_status wait_for_planes(stream *s, const stream_planes **planes, iso_error *err)
{
    const double start = iso_clock_seconds();
    iso_status status = iso_stream_input_wait(&s->input, planes, err);
    s->report->seconds_read += iso_clock_seconds() - start;
    return status;
}

/* ---- alone ---- */

/* All planes before z are written; the last blocks of the files may not be. */
static iso_status note_if_due(stream *s, json_t *job, size_t z, size_t done, iso_error *err)
{
    if (z <= done || !progress_is_due(s, z))
        return ISO_OK;
    iso_status status = iso_stream_output_sync(&s->out, err);
    return status == ISO_OK ? note_progress(s, job, z, err) : status;
}

static iso_status do_slab(stream *s, size_t i, json_t *job, size_t done, iso_error *err)
{
    const slab b = slab_at(s, i);
    const stream_planes *planes;
    iso_status status = wait_for_planes(s, &planes, err);
    if (status != ISO_OK)
        return status;
    request_slab(s, i + 1);
    status = feed_slab(s, &b, planes, err);
    if (status == ISO_OK)
        status = wait_for_writers(s, err);
    if (status == ISO_OK)
        status = note_if_due(s, job, b.z0, done, err);
    if (status != ISO_OK)
        return status;
    list_slab(s, &b, planes);
    iso_stream_output_start(&s->out);
    return ISO_OK;
}

static iso_status run_alone(stream *s, json_t *job, size_t done, const iso_progress *progress, iso_error *err)
{
    const size_t nz = s->header.geometry.size[2];
    iso_status status = ISO_OK;
    request_slab(s, 0);
    for (size_t i = 0; i < slab_count(s) && status == ISO_OK; ++i) {
        const slab b = slab_at(s, i);
        iso_progress_report(progress, "build", (double)b.z0 / (double)nz);
        status = do_slab(s, i, job, done, err);
        if (status != ISO_OK || s->how->stop_after == 0 || b.z1 < s->how->stop_after || b.z1 == nz)
            continue;
        status = wait_for_writers(s, err);
        status = status == ISO_OK ? note_if_due(s, job, b.z1, done, err) : status;
        return status == ISO_OK ? iso_fail(err, ISO_E_PROGRAM, "stopped after %zu planes", b.z1) : status;
    }
    if (status == ISO_OK)
        status = wait_for_writers(s, err);
    iso_progress_report(progress, "build", 1);
    return status;
}

/* ---- in turns ---- */

static char *baton_tails(const stream *s)
{
    return (char *)(s->baton + 1);
}

static float *baton_carry(const stream *s)
{
    return (float *)(void *)(baton_tails(s) + iso_stream_tails_bytes(&s->out));
}

/* The ranges so far, and the carry's planes from slab `oldest` on, into the baton. */
static void fill_baton(stream *s, size_t oldest, size_t z)
{
    size_t plane_floats;
    const float *carry = iso_cascade_carry(s->cascade, &plane_floats);
    const size_t level = iso_cascade_carry_level(s->cascade);
    for (size_t k = 0; k < s->out.level_count; ++k)
        iso_cascade_range(s->cascade, k, &s->baton->lo[k], &s->baton->hi[k]);
    s->baton->carry_first = slab_at(s, oldest).z0 >> level;
    s->baton->carry_count = carry ? (z >> level) - s->baton->carry_first : 0;
    if (carry)
        memcpy(baton_carry(s), carry + s->baton->carry_first * plane_floats,
               s->baton->carry_count * plane_floats * sizeof *carry);
}

static void take_over_baton(stream *s)
{
    size_t plane_floats;
    float *carry = iso_cascade_carry(s->cascade, &plane_floats);
    for (size_t k = 0; k < s->out.level_count; ++k) {
        double lo, hi;
        iso_cascade_range(s->cascade, k, &lo, &hi);
        iso_cascade_set_range(s->cascade, k, fmin(lo, s->baton->lo[k]), fmax(hi, s->baton->hi[k]));
    }
    if (carry)
        memcpy(carry + s->baton->carry_first * plane_floats, baton_carry(s),
               s->baton->carry_count * plane_floats * sizeof *carry);
}

/* Waits for the turn of slab i; an error of an earlier slab goes before one of this rank. */
static iso_status take_baton(stream *s, size_t i, iso_status status, iso_error *err)
{
    const int count = iso_ranks_count(s->how->ranks);
    const double start = iso_clock_seconds();
    iso_status written = iso_stream_output_wait(&s->out, status == ISO_OK ? err : NULL);
    status = status == ISO_OK ? written : status;
    if (i > 0)
        iso_ranks_receive(s->how->ranks, (int)((i - 1) % (size_t)count), s->baton, baton_bytes(s));
    s->report->seconds_write += iso_clock_seconds() - start;
    if (i > 0 && s->baton->status != ISO_OK) {
        *err = s->baton->error;
        return s->baton->status;
    }
    if (i > 0 && status == ISO_OK)
        take_over_baton(s);
    return status;
}

static void pass_baton(stream *s, size_t i, iso_status status, const iso_error *err)
{
    const size_t count = (size_t)iso_ranks_count(s->how->ranks);
    s->baton->status = status;
    if (status != ISO_OK)
        s->baton->error = *err;
    else
        fill_baton(s, i + 2 > count ? i + 2 - count : 0, slab_at(s, i).z1);
    if (i + 1 < slab_count(s))
        iso_ranks_send(s->how->ranks, (int)((i + 1) % count), s->baton, status == ISO_OK ? baton_bytes(s) : sizeof *s->baton);
}

/* The top levels are made from the carry with the last slab, which then needs all of it before. */
static bool needs_baton_first(const stream *s, const slab *b)
{
    size_t plane_floats;
    return b->z1 == s->header.geometry.size[2] && iso_cascade_carry(s->cascade, &plane_floats);
}

static iso_status do_slab_in_turn(stream *s, size_t i, iso_status status, iso_error *err)
{
    const slab b = slab_at(s, i);
    const stream_planes *planes = NULL;
    const bool baton_first = needs_baton_first(s, &b);
    if (status == ISO_OK)
        status = wait_for_planes(s, &planes, err);
    if (status == ISO_OK)
        request_slab(s, i + (size_t)iso_ranks_count(s->how->ranks));
    if (baton_first)
        status = take_baton(s, i, status, err);
    if (status == ISO_OK)
        status = feed_slab(s, &b, planes, err);
    if (!baton_first)
        status = take_baton(s, i, status, err);
    if (status == ISO_OK) {
        list_slab(s, &b, planes);
        iso_stream_tails_set(&s->out, baton_tails(s));
        iso_stream_tails_advance(&s->out, baton_tails(s));
    }
    pass_baton(s, i, status, err);
    if (status == ISO_OK)
        iso_stream_output_start(&s->out);
    return status;
}

/* Slab i is rank i mod count's. When rank 0 has the turn of slab i, slabs up to i - count are written: whoever had the
 * turn has waited for its own writers. Their end stands in the first block of the next slab, so one slab less is safe. */
static iso_status run_in_turns(stream *s, json_t *job, const iso_progress *progress, iso_error *err)
{
    const size_t count = (size_t)iso_ranks_count(s->how->ranks), rank = (size_t)iso_ranks_index(s->how->ranks);
    iso_status status = ISO_OK;
    if (rank == 0)
        iso_stream_tails_get(&s->out, baton_tails(s));
    request_slab(s, rank);
    for (size_t i = rank; i < slab_count(s); i += count) {
        const size_t safe = i >= count ? slab_at(s, i - count).z0 : 0;
        iso_progress_report(progress, "build", (double)i / (double)slab_count(s));
        status = do_slab_in_turn(s, i, status, err);
        if (status == ISO_OK && rank == 0 && safe > s->plan.start && progress_is_due(s, safe))
            status = note_progress(s, job, safe, err);
    }
    iso_status written = iso_stream_output_wait(&s->out, status == ISO_OK ? err : NULL);
    iso_progress_report(progress, "build", 1);
    return status == ISO_OK ? written : status;
}

/* ---- from beginning to end ---- */

static iso_status open_input(stream *s, iso_error *err)
{
    iso_status status = iso_pyramid_check_options(s->opt, err);
    if (status == ISO_OK)
        status = s->in->open(s->in->user, &s->source, err);
    if (status == ISO_OK)
        s->header = *iso_source_volume(s->source);
    return iso_ranks_agree(s->how->ranks, status, err);
}

static iso_status set_up(stream *s, double *scale, iso_error *err)
{
    double range = 0;
    iso_status status = input_range(s, &range, err);
    *scale = iso_cascade_scale(&s->header.geometry, range);
    if (status == ISO_OK)
        status = iso_cascade_create(&s->header.geometry, s->header.type, s->opt, *scale, &s->cascade, err);
    if (status != ISO_OK)
        return status;
    iso_stream_output_describe(&s->out, &s->header.geometry, s->header.type, s->opt);
    s->out.direct = s->how->direct || iso_geometry_voxel_count(&s->header.geometry) * iso_type_bytes(s->header.type) >= DIRECT_BYTES;
    s->overlap = longest_warm_up(s);
    return choose_slab(s, err);
}

/* Where the build begins: 0, or where a killed one stood. */
static iso_status begin(stream *s, const json_t *job, bool resumed, size_t *done, iso_error *err)
{
    const bool same = resumed && read_progress(s, job, done);
    if (!same) {
        *done = 0;
        iso_output_clear(&s->output);
    }
    for (size_t k = 0; k < s->out.level_count; ++k)
        s->out.levels[k].first = iso_cascade_complete(s->cascade, k, *done);
    s->report->resumed_at_plane = *done;
    s->plan.start = is_alone(s) ? iso_cascade_warm_up(s->cascade, *done) : *done;
    iso_status status = iso_stream_output_open(&s->out, s->output.temp_path, err);
    if (status == ISO_OK)
        status = take_up_carry(s, s->output.temp_path, *done, err);
    size_t plane_floats;
    if (status == ISO_OK && iso_cascade_carry(s->cascade, &plane_floats)) {
        char *path = iso_path_join(s->output.temp_path, CARRY_NAME);
        status = path ? iso_bigfile_open(path, s->out.direct, s->carry_planes * plane_floats * sizeof(float), &s->carry, err)
                      : iso_fail(err, ISO_E_MEMORY, "out of memory");
        free(path);
    }
    return status;
}

/* Rank 0 makes the folder, then the others open what is in it. */
static iso_status begin_all(stream *s, const char *dir, double scale, json_t **job, size_t *done, iso_error *err)
{
    iso_status status = ISO_OK;
    bool resumed = false;
    if (is_first(s)) {
        status = iso_output_resume_dir(&s->output, dir, ISO_PYRAMID_MARKER, s->how->resume, &resumed, err);
        *job = describe_job(s, scale);
        if (status == ISO_OK && snprintf(s->plan.folder, sizeof s->plan.folder, "%s", s->output.temp_path) >= (int)sizeof s->plan.folder)
            status = iso_fail(err, ISO_E_IO, "%s: the path is too long", dir);
        if (status == ISO_OK)
            status = begin(s, *job, resumed, done, err);
    }
    status = iso_ranks_agree(s->how->ranks, status, err);
    if (status != ISO_OK)
        return status;
    iso_ranks_broadcast(s->how->ranks, &s->plan, sizeof s->plan);
    status = create_buffers(s, err);
    if (status == ISO_OK && !is_first(s)) {
        status = iso_stream_output_join(&s->out, s->plan.folder, err);
        status = status == ISO_OK ? take_up_carry(s, s->plan.folder, s->plan.start, err) : status;
    }
    return iso_ranks_agree(s->how->ranks, status, err);
}

/* What the rank of the last slab knows of the files comes to rank 0. */
typedef struct summary {
    level_file files[STREAM_MAX_LEVELS][FILE_COUNT];
    double lo[STREAM_MAX_LEVELS], hi[STREAM_MAX_LEVELS];
} summary;

static iso_status close_in_turns(stream *s, iso_error *err)
{
    const int last = (int)((slab_count(s) - 1) % (size_t)iso_ranks_count(s->how->ranks));
    const int rank = iso_ranks_index(s->how->ranks);
    iso_status status = ISO_OK;
    if (rank == last) {
        iso_stream_tails_set(&s->out, baton_tails(s));
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

static void remove_in(const char *dir, const char *name)
{
    char *path = iso_path_join(dir, name);
    if (path)
        unlink(path);
    free(path);
}

/* The description, last of all; then the folder gets its name. */
static iso_status describe_and_commit(stream *s, iso_error *err)
{
    json_t *levels = json_array();
    s->report->level_count = s->out.level_count;
    s->report->slab_planes = s->plan.slab;
    s->report->buffer_bytes = buffer_bytes(s, s->plan.slab);
    for (size_t k = 0; k < s->out.level_count; ++k) {
        const stream_level *l = &s->out.levels[k];
        double lo, hi;
        iso_cascade_range(s->cascade, k, &lo, &hi);
        s->report->levels[k].geometry = l->geometry;
        s->report->levels[k].type = l->type;
        s->report->levels[k].min = lo;
        s->report->levels[k].max = hi;
        json_array_append_new(levels, iso_layout_level(&l->geometry, l->type, lo, hi, l->files, k));
    }
    remove_in(s->output.temp_path, PROGRESS_NAME);
    remove_in(s->output.temp_path, CARRY_NAME);
    iso_status status = iso_layout_save(s->output.temp_path, s->in->path, s->opt, levels, err);
    return status == ISO_OK ? iso_output_commit(&s->output, err) : status;
}

static iso_status finish(stream *s, iso_error *err)
{
    iso_status status = is_alone(s) ? iso_stream_output_close(&s->out, err) : close_in_turns(s, err);
    if (status == ISO_OK && is_first(s))
        status = describe_and_commit(s, err);
    return iso_ranks_agree(s->how->ranks, status, err);
}

static void clean_up(stream *s, bool keep)
{
    s->report->seconds_reading = s->input.seconds_busy;
    s->report->seconds_writing = s->out.seconds_busy;
    iso_stream_input_destroy(&s->input);
    iso_stream_output_destroy(&s->out);
    iso_bigfile_abandon(s->carry);
    free(s->baton);
    iso_cascade_destroy(s->cascade);
    iso_source_close(s->source);
    if (keep)
        iso_output_keep(&s->output);
    else
        iso_output_abandon(&s->output);
}

iso_status iso_pyramid_stream(const iso_stream_input *in, const iso_pyramid_options *opt, const iso_stream_options *how,
                              const char *dir, iso_stream_report *report, const iso_progress *progress, iso_error *err)
{
    stream *s = calloc(1, sizeof *s);
    *report = (iso_stream_report){0};
    if (!s)
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    *s = (stream){.in = in, .opt = opt, .how = how, .report = report};
    const double start = iso_clock_seconds();
    double scale = 1;
    size_t done = 0;
    json_t *job = NULL;
    iso_status status = open_input(s, err);
    if (status == ISO_OK)
        status = iso_ranks_agree(how->ranks, set_up(s, &scale, err), err);
    if (status == ISO_OK)
        status = begin_all(s, dir, scale, &job, &done, err);
    if (status == ISO_OK) {
        status = is_alone(s) ? run_alone(s, job, done, progress, err) : run_in_turns(s, job, progress, err);
        status = iso_ranks_agree(how->ranks, status, err);
    }
    if (status == ISO_OK)
        status = finish(s, err);
    if (status != ISO_OK)
        iso_output_rename_in(s->plan.folder, dir, err);
    json_decref(job);
    clean_up(s, status == ISO_E_PROGRAM);
    free(s);
    report->seconds_total = iso_clock_seconds() - start;
    return status;
}
