/* SPDX-License-Identifier: MIT */
#include "pyramid/pyramid_stream.h"

#include <stdio.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "pyramid/pyramid_layout.h"
#include "pyramid/stream_build.h"

/* Files of at least this size bypass the page cache. */
#define DIRECT_BYTES ((size_t)256 << 20)

static iso_status create_buffers(pyramid_build *s, iso_error *err)
{
    bool good = iso_stream_input_create(&s->input, s->source, iso_stream_planes_capacity(s, s->plan.slab)) &&
                iso_stream_output_create(&s->out, s->cascade, s->plan.slab, s->opt);
    s->out.in_turns = !stream_is_alone(s);
    if (good && s->out.in_turns)
        good = iso_stream_turn_create(s);
    return good ? ISO_OK
                : iso_fail(err, ISO_E_MEMORY, "%s: no memory for slabs of %zu planes", s->in->path, s->plan.slab);
}

static iso_status open_input(pyramid_build *s, iso_error *err)
{
    iso_status status = iso_pyramid_check_options(s->opt, err);
    TRY(status, s->in->open(s->in->user, &s->source, err));
    if (status == ISO_OK)
        s->header = *iso_source_volume(s->source);
    return iso_ranks_agree(s->how->ranks, status, err);
}

static iso_status set_up(pyramid_build *s, double *scale, const iso_progress *progress, iso_error *err)
{
    double range = 0;
    iso_status status = iso_stream_input_range(s, &range, err);
    *scale = iso_cascade_scale(&s->header.geometry, range);
    TRY(status, iso_stream_choose(s, *scale, progress, err));
    TRY(status, iso_cascade_create(&s->header.geometry, s->opt, *scale, &s->cascade, err));
    if (status != ISO_OK)
        return status;
    iso_stream_output_describe(&s->out, &s->header.geometry, s->header.type, s->opt);
    iso_stream_output_begin_at(&s->out, s->how->first_level);
    s->out.direct = s->how->direct ||
                    iso_geometry_voxel_count(&s->header.geometry) * iso_type_bytes(s->header.type) >= DIRECT_BYTES;
    s->overlap = iso_stream_longest_warm_up(s);
    return iso_stream_choose_slab(s, err);
}

/* Begins the build at plane *done: 0, or where a killed build stopped. */
static iso_status begin(pyramid_build *s, size_t *done, iso_error *err)
{
    bool same = false;
    NEED(s->resumed ? iso_stream_read_progress(s, &same, done, err) : ISO_OK);
    if (!same) {
        *done = 0;
        iso_output_clear(&s->output);
    }
    for (size_t k = 0; k < s->out.level_count; ++k)
        s->out.levels[k].first = iso_cascade_complete(s->cascade, k, *done);
    s->report->resumed_at_plane = *done;
    s->plan.start = stream_is_alone(s) ? iso_cascade_warm_up(s->cascade, *done) : *done;
    NEED(iso_stream_output_open(&s->out, s->output.temp_path, err));
    NEED(iso_stream_take_up_carry(s, s->output.temp_path, *done, err));
    size_t plane_floats;
    if (iso_cascade_carry(s->cascade, &plane_floats)) {
        FREED char *path = iso_path_join(s->output.temp_path, STREAM_CARRY_NAME);
        NEED(path
                 ? iso_bigfile_open(path, s->out.direct, s->carry_planes * plane_floats * sizeof(float), &s->carry, err)
                 : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    }
    return ISO_OK;
}

/* Files that a build writes into the folder. */
static const char *const own_names[] = {ISO_PYRAMID_MARKER, "level_*.nrrd", STREAM_PROGRESS_NAME, STREAM_CARRY_NAME,
                                        NULL};

/* Makes the folder on rank 0, then opens its files on the other ranks. */
static iso_status begin_all(pyramid_build *s, const char *dir, double scale, json_t **job, size_t *done, iso_error *err)
{
    iso_status status = ISO_OK;
    if (stream_is_first(s)) {
        status = iso_output_resume_dir(&s->output, dir, own_names, s->how->resume, &s->resumed, err);
        TRY(status, iso_stream_make_key(s, scale, err));
        if (status == ISO_OK && !(*job = iso_stream_describe_job(s)))
            status = iso_fail(err, ISO_E_MEMORY, "out of memory");
        if (status == ISO_OK &&
            snprintf(s->plan.folder, sizeof s->plan.folder, "%s", s->output.temp_path) >= (int)sizeof s->plan.folder)
            status = iso_fail(err, ISO_E_IO, "%s: the path is too long", dir);
        TRY(status, begin(s, done, err));
    }
    NEED(iso_ranks_agree(s->how->ranks, status, err));
    iso_ranks_broadcast(s->how->ranks, &s->plan, sizeof s->plan);
    status = create_buffers(s, err);
    if (status == ISO_OK && !stream_is_first(s)) {
        status = iso_stream_output_join(&s->out, s->plan.folder, err);
        status = status == ISO_OK ? iso_stream_take_up_carry(s, s->plan.folder, s->plan.start, err) : status;
    }
    return iso_ranks_agree(s->how->ranks, status, err);
}

/* Writes the description, last of all; then gives the folder its name. */
static iso_status describe_and_commit(pyramid_build *s, iso_error *err)
{
    json_t *levels = json_array();
    s->report->level_count = s->out.level_count;
    s->report->slab_planes = s->plan.slab;
    s->report->buffer_bytes = iso_stream_buffer_bytes(s, s->plan.slab);
    for (size_t k = 0; k < s->out.level_count; ++k) {
        const stream_level *l = &s->out.levels[k];
        double lo, hi;
        iso_cascade_range(s->cascade, k, &lo, &hi);
        s->report->levels[k].geometry = l->geometry;
        s->report->levels[k].type = l->type;
        s->report->levels[k].min = lo;
        s->report->levels[k].max = hi;
        json_t *level = iso_layout_level(&l->geometry, l->type, lo, hi, l->files, k);
        iso_layout_choice(s->opt, k, level);
        json_array_append_new(levels, level);
    }
    s->report->choice = s->opt->choice;
    iso_stream_remove_progress(s);
    const iso_pyramid_unit unit = iso_pyramid_unit_of(&s->header.notes);
    const iso_pyramid of = {.segments = s->opt->scalar_filter == ISO_SCALAR_MAJORITY ? s->header.segments : NULL};
    iso_status status = iso_layout_save(s->output.temp_path, s->in->path, &unit, s->opt, levels, &of, err);
    return status == ISO_OK ? iso_output_commit(&s->output, err) : status;
}

static iso_status finish(pyramid_build *s, iso_error *err)
{
    iso_status status = stream_is_alone(s) ? iso_stream_output_close(&s->out, err) : iso_stream_close_in_turns(s, err);
    if (status == ISO_OK && stream_is_first(s))
        status = describe_and_commit(s, err);
    return iso_ranks_agree(s->how->ranks, status, err);
}

static void clean_up(pyramid_build *s, bool keep)
{
    s->report->seconds_reading = s->input.seconds_busy;
    s->report->seconds_writing = s->out.seconds_busy;
    iso_stream_input_destroy(&s->input);
    iso_stream_output_destroy(&s->out);
    iso_bigfile_abandon(s->carry);
    free(s->turn);
    iso_cascade_destroy(s->cascade);
    iso_key_destroy(s->key);
    iso_source_close(s->source);
    if (keep)
        iso_output_keep(&s->output);
    else
        iso_output_abandon(&s->output);
}

iso_status iso_pyramid_stream(const iso_stream_input *in, const iso_pyramid_options *opt, const iso_stream_options *how,
                              const char *dir, iso_stream_report *report, const iso_progress *progress, iso_error *err)
{
    pyramid_build *s = calloc(1, sizeof *s);
    *report = (iso_stream_report){0};
    NEED_MEMORY(s, err, "out of memory");
    const double start = iso_clock_seconds();
    *s = (pyramid_build){.in = in, .own = *opt, .how = how, .report = report, .progress_at = start};
    s->opt = &s->own;
    double scale = 1;
    size_t done = 0;
    json_auto_t *job = NULL;
    iso_status status = open_input(s, err);
    TRY(status, iso_ranks_agree(how->ranks, set_up(s, &scale, progress, err), err));
    TRY(status, begin_all(s, dir, scale, &job, &done, err));
    if (status == ISO_OK) {
        status = stream_is_alone(s) ? iso_stream_run_alone(s, job, done, progress, err)
                                    : iso_stream_run_in_turns(s, job, progress, err);
        status = iso_ranks_agree(how->ranks, status, err);
    }
    TRY(status, finish(s, err));
    if (status != ISO_OK)
        iso_output_rename_in(s->plan.folder, dir, err);
    /* A later run resumes after a requested stop. It also keeps an earlier build's files that did not cause the
     * error. */
    const bool stays = s->resumed && (status == ISO_E_IO || status == ISO_E_MEMORY);
    clean_up(s, status == ISO_E_PROGRAM || stays);
    free(s);
    report->seconds_total = iso_clock_seconds() - start;
    return status;
}
