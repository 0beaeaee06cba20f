/* SPDX-License-Identifier: MIT */
/* target_pbrt.c - a level as a folder with a scene of pbrt-v4: a medium of a baked level. */
#include "base/file.h"
#include "pbrt/pbrt.h"
#include "targets/targets.h"

static void tell_json(json_t *results, const iso_medium *m, const iso_bake_error *e)
{
    const size_t *n = m->geometry.size;
    json_object_set_new(results, "medium",
                        json_pack("{s[III] sI sI sI sf sb s[ii] s{sf sf}}", "size", (json_int_t)n[0], (json_int_t)n[1],
                                  (json_int_t)n[2], "points_per_voxel", (json_int_t)m->baked->options.points,
                                  "samples_per_point", (json_int_t)m->baked->options.samples, "visible_points",
                                  (json_int_t)m->baked->visible_count, "max_extinction_per_mm",
                                  m->baked->extinction_max, "camera_is_inside", m->camera_is_inside, "picture",
                                  (int)e->width, (int)e->height, "error_shaded", "rmse", e->lit.rmse, "max_abs",
                                  e->lit.max_abs));
}

static void tell_person(FILE *f, const iso_medium *m, const iso_bake_error *e)
{
    const size_t *n = m->geometry.size;
    fprintf(f,
            "baked: %zu of %zu x %zu x %zu points are visible; the extinction is at most %.4g per mm\n"
            "interpolating shaded colors instead of values: RMSE %.2g, at most %.2g from the exact picture "
            "(%zu x %zu)\n",
            m->baked->visible_count, n[0], n[1], n[2], m->baked->extinction_max, e->lit.rmse, e->lit.max_abs, e->width,
            e->height);
}

static iso_status write_folder(const iso_export_job *job, const iso_medium *m, iso_error *err)
{
    ENDED_BY(iso_output_abandon) iso_output out = {0};
    NEED(iso_output_begin_dir(&out, job->output, "scene.pbrt", err));
    iso_progress_report(job->progress, "pbrt", 0);
    NEED(iso_medium_write(m, out.temp_path, err));
    NEED(iso_output_commit(&out, err));
    iso_progress_report(job->progress, "pbrt", 1);
    return ISO_OK;
}

static iso_status write_pbrt(const iso_export_job *job, iso_error *err)
{
    iso_bake_options o = job->lattice.points > 0 ? job->lattice : iso_bake_defaults();
    iso_bake_error error = {0};
    OWNED(iso_baked) baked = {0};
    iso_medium medium = {0};
    OWNED(iso_view) view = {0};
    o.shaded = true;
    o.threads = job->threads;
    NEED(job->view_of_level(job, job->level, &view, err));
    NEED(
        iso_bake(&job->pyramid->levels[job->level], job->pyramid->options.code, &view, &o, &baked, job->progress, err));
    if (job->results || job->notes)
        NEED(iso_bake_measure_shaded(&baked, ISO_BAKE_ERROR_PIXELS, &error, job->progress, err));
    const char *source = job->pyramid->source ? iso_path_base(job->pyramid->source) : NULL;
    NEED(iso_medium_create(&baked, source, &medium, err));
    NEED(write_folder(job, &medium, err));
    if (job->results)
        tell_json(job->results, &medium, &error);
    if (job->notes)
        tell_person(job->notes, &medium, &error);
    return ISO_OK;
}

const iso_export_target iso_export_target_pbrt = {
    .name = "pbrt",
    .title = "pbrt-v4",
    .stages = {"baking", "pbrt"},
    .summary = "a folder for pbrt-v4: a medium of baked grids that emits and absorbs, shaded for the scene's camera",
    .output = "a folder",
    .options = ISO_EXPORT_TAKES(ISO_EXPORT_SCENE) | ISO_EXPORT_TAKES(ISO_EXPORT_SIZE) |
               ISO_EXPORT_TAKES(ISO_EXPORT_ADAPT) | ISO_EXPORT_TAKES(ISO_EXPORT_EXTINCTION_SCALE) |
               ISO_EXPORT_TAKES(ISO_EXPORT_LATTICE),
    .write = write_pbrt,
    .suffix = "",
};
