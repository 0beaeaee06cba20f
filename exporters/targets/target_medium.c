/* SPDX-License-Identifier: MIT */
#include "targets/target_medium.h"

#include "base/file.h"

static void tell_json(json_t *results, const iso_medium *m, const iso_target_medium *t, const iso_bake_error *e)
{
    const size_t *n = m->geometry.size;
    json_t *medium = json_pack("{s[III] sI sI sI sf sb sb}", "size", (json_int_t)n[0], (json_int_t)n[1],
                               (json_int_t)n[2], "points_per_voxel", (json_int_t)m->baked->options.points,
                               "samples_per_point", (json_int_t)m->baked->options.samples, "visible_points",
                               (json_int_t)m->baked->visible_count, "max_extinction_per_mm", m->baked->extinction_max,
                               "emits", t->emits, "camera_is_inside", m->camera_is_inside);
    if (t->emits)
        json_object_update_new(medium, json_pack("{s[ii] s{sf sf}}", "picture", (int)e->width, (int)e->height,
                                                 "error_shaded", "rmse", e->lit.rmse, "max_abs", e->lit.max_abs));
    json_object_set_new(results, "medium", medium);
}

static void tell_person(FILE *f, const iso_medium *m, const iso_target_medium *t, const iso_bake_error *e)
{
    const size_t *n = m->geometry.size;
    fprintf(f, "baked: %zu of %zu x %zu x %zu points are visible; the extinction is at most %.4g per mm\n",
            m->baked->visible_count, n[0], n[1], n[2], m->baked->extinction_max);
    if (t->emits)
        fprintf(
            f,
            "interpolating shaded colors instead of values: RMSE %.2g, at most %.2g from the exact picture (%zu x %zu)\n",
            e->lit.rmse, e->lit.max_abs, e->width, e->height);
    else
        fprintf(
            f,
            "absorption only: media of Mitsuba 3 do not emit yet, so the picture lacks the transfer function's colors\n");
}

static iso_status write_folder(const iso_export_job *job, const iso_medium *m, const iso_target_medium *t,
                               iso_error *err)
{
    iso_output out = {0};
    iso_status status = iso_output_begin_dir(&out, job->output, t->scene, err);
    iso_progress_report(job->progress, t->name, 0);
    TRY(status, t->write(m, out.temp_path, err));
    TRY(status, iso_output_commit(&out, err));
    iso_progress_report(job->progress, t->name, 1);
    iso_output_abandon(&out);
    return status;
}

iso_status iso_target_medium_write(const iso_export_job *job, const iso_target_medium *t, iso_error *err)
{
    iso_bake_options o = job->lattice.points > 0 ? job->lattice : iso_bake_defaults();
    iso_bake_error error = {0};
    OWNED(iso_baked) baked = {0};
    iso_medium medium = {0};
    OWNED(iso_view) view = {0};
    o.shaded = t->emits;
    o.threads = job->threads;
    NEED(job->view_of_level(job, job->level, &view, err));
    NEED(
        iso_bake(&job->pyramid->levels[job->level], job->pyramid->options.code, &view, &o, &baked, job->progress, err));
    if (t->emits && (job->results || job->notes))
        NEED(iso_bake_measure_shaded(&baked, ISO_BAKE_ERROR_PIXELS, &error, job->progress, err));
    const char *source = job->pyramid->source ? iso_path_base(job->pyramid->source) : NULL;
    NEED(iso_medium_create(&baked, source, &medium, err));
    NEED(write_folder(job, &medium, t, err));
    if (job->results)
        tell_json(job->results, &medium, t, &error);
    if (job->notes)
        tell_person(job->notes, &medium, t, &error);
    return ISO_OK;
}
