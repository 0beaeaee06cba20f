/* SPDX-License-Identifier: MIT */
/* target_vdb.c - levels, or the bricks of a plan, as grids of one OpenVDB or NanoVDB file. */
#include <stdlib.h>

#include "targets/targets.h"
#include "vdb/vdb.h"

/* ---- baked grids, of --bake or --for ---- */

static json_t *difference(const iso_bake_difference *d)
{
    return json_pack("{sf sf}", "rmse", d->rmse, "max_abs", d->max_abs);
}

static const char *up_of(const iso_bake_request *r)
{
    return r->convention.y_up ? "y" : "z";
}

/* Returns the unit's name, or its length if it has none. */
static const char *unit_of(const iso_bake_request *r, char text[24])
{
    snprintf(text, 24, *r->convention.unit ? "%s" : "%.0s%.9g mm", r->convention.unit, r->convention.unit_mm);
    return text;
}

static void tell_json(json_t *results, const iso_baked *b, const iso_bake_request *r, const iso_bake_error *e)
{
    json_t *grids = json_object(), *bake;
    const char *const up = up_of(r);
    char unit[24];
    for (int i = 0; i < ISO_BAKE_GRIDS; ++i)
        if (r->has[i])
            json_object_set_new(grids, iso_names_name(&iso_bake_grid_names, (size_t)i), json_string(r->name[i]));
    bake = json_pack("{so ss sf ss sI sI sI sI sf s[ii] so so}", "grids", grids, "scene_unit", unit_of(r, unit),
                     "scene_unit_mm", r->convention.unit_mm, "up", up, "points_per_voxel",
                     (json_int_t)r->lattice.points, "samples_per_point", (json_int_t)r->lattice.samples,
                     "visible_points", (json_int_t)b->visible_count, "colored_points", (json_int_t)b->color_count,
                     "max_extinction", b->extinction_max * r->convention.unit_mm, "picture", (int)e->width,
                     (int)e->height, "error_lit", difference(&e->lit), "error_unlit", difference(&e->unlit));
    if (e->has_emission)
        json_object_set_new(bake, "error_emission", difference(&e->emission));
    if (r->program)
        json_object_update_new(bake, json_pack("{ss ss}", "for", r->program->name, "tested", r->program->tested));
    json_object_set_new(results, "bake", bake);
}

static void tell_person(FILE *f, const iso_baked *b, const iso_bake_request *r, const iso_bake_error *e)
{
    char unit[24];
    fprintf(
        f,
        "baked: %zu of %zu points are visible; 1 scene unit is %s%s, %s up; the extinction is at most %.4g per unit\n",
        b->visible_count, iso_geometry_voxel_count(&b->geometry), *r->convention.unit ? "1 " : "", unit_of(r, unit),
        up_of(r), b->extinction_max * r->convention.unit_mm);
    fprintf(f, "interpolating colors instead of values: RMSE %.2g, at most %.2g from the exact picture (%zu x %zu)\n",
            e->lit.rmse, e->lit.max_abs, e->width, e->height);
    fprintf(f, "unlit, in programs that show colors as light: RMSE %.2g, at most %.2g\n", e->unlit.rmse,
            e->unlit.max_abs);
    if (e->has_emission)
        fprintf(f, "unlit, with the emission grid: RMSE %.2g, at most %.2g\n", e->emission.rmse, e->emission.max_abs);
    if (r->program)
        fprintf(f, "for %s (%s): %s\n", r->program->name, r->program->tested, r->program->setting);
}

static iso_status target_vdb_baked(const iso_export_job *job, iso_error *err)
{
    iso_bake_request request = *job->bake, *r = &request;
    iso_bake_options o = r->lattice;
    iso_bake_error error = {0};
    OWNED(iso_baked) baked = {0};
    OWNED(iso_view) view = {0};
    o.threads = job->threads;
    r->nanovdb = job->nanovdb;
    NEED(job->view_of_level(job, job->level, &view, err));
    NEED(
        iso_bake(&job->pyramid->levels[job->level], job->pyramid->options.code, &view, &o, &baked, job->progress, err));
    if (!r->unit_is_asked && !iso_vdb_fits(&r->convention, &baked.geometry))
        r->convention.unit = iso_vdb_choose_unit(iso_geometry_mean_spacing_mm(&baked.geometry), NULL,
                                                 &r->convention.unit_mm);
    NEED(iso_bake_measure(&baked, r->has[ISO_BAKE_EMISSION], r->error_pixels, &error, job->progress, err));
    NEED(iso_bake_save(&baked, r, (int)job->level, job->pyramid->source, job->output, job->progress, err));
    if (job->results)
        tell_json(job->results, &baked, r, &error);
    if (job->notes)
        tell_person(job->notes, &baked, r, &error);
    return ISO_OK;
}

/* ---- levels and bricks ---- */

static iso_status write_planned(const iso_export_job *job, iso_vdb_options *o, iso_error *err)
{
    o->half_directions = !job->nanovdb;
    OWNED(iso_planned_lattices) lattices = {0};
    NEED(iso_planned_lattices_create(job->planned, job->merged, false, job->threads, &lattices, err));
    return iso_vdb_save_lattices(lattices.items, lattices.count, job->pyramid->source, job->output, o, job->progress,
                                 err);
}

/* One view per level of the file, and the voxels that they show. */
typedef struct shown_levels {
    iso_view views[64];
    iso_vdb_shown shown[64];
} shown_levels;

static iso_status find_shown(const iso_export_job *job, shown_levels *l, iso_error *err)
{
    for (size_t k = 0; k < job->level_count; ++k) {
        iso_view *view = &l->views[k];
        if (job->is_shown)
            NEED(job->view_of_level(job, job->level + k, view, err));
        if (view->tf_2d)
            l->shown[k] = (iso_vdb_shown){.tfs = view->tf_2d->rows, .tf_count = ISO_TF_2D_ROWS};
        else if (job->is_shown)
            l->shown[k] = (iso_vdb_shown){.tfs = &view->tf, .tf_count = 1};
        l->shown[k].has_background = job->background != NULL;
        l->shown[k].background = job->background ? *job->background : 0;
    }
    return ISO_OK;
}

static iso_status write_vdb(const iso_export_job *job, iso_error *err)
{
    if (job->bake)
        return target_vdb_baked(job, err);
    iso_vdb_options o = iso_vdb_defaults();
    o.half_float = job->half_float;
    o.nanovdb = job->nanovdb;
    o.unit = job->pyramid->unit.name;
    o.command = job->command;
    o.threads = job->threads;
    o.volume = job->volume;
    if (job->planned)
        return write_planned(job, &o, err);
    FREED shown_levels *l = calloc(1, sizeof *l);
    iso_status status = l ? find_shown(job, l, err) : iso_fail(err, ISO_E_MEMORY, "export: out of memory");
    if (status == ISO_OK) {
        const bool sparse = (job->is_shown || job->background) && !job->dense;
        o.shown = sparse ? l->shown : NULL;
        o.half_directions = sparse && !job->nanovdb;
        const bool has_shares = job->pyramid->levels[0].geometry.has_no_data; /* each level adds its own */
        for (size_t k = 0; k < job->level_count && !o.extinction_scale && !has_shares; ++k)
            o.extinction_scale = l->views[k].extinction_scale; /* refused if there are more levels */
        status = iso_vdb_save(job->pyramid, job->level, job->level_count, job->output, &o, job->progress, err);
    }
    for (size_t k = 0; l && k < job->level_count; ++k)
        iso_view_destroy(&l->views[k]);
    return status;
}

const iso_export_target iso_export_target_vdb = {
    .name = "vdb",
    .title = "OpenVDB",
    .stages = {"OpenVDB grids"},
    .summary = "an OpenVDB file: float grid density, vec3s grid gradient",
    .baked = "an OpenVDB file of baked grids",
    .output = "NAME.vdb",
    .options = ISO_EXPORT_TAKES(ISO_EXPORT_PLAN) | ISO_EXPORT_TAKES(ISO_EXPORT_LEVELS) |
               ISO_EXPORT_TAKES(ISO_EXPORT_HALF) | ISO_EXPORT_TAKES(ISO_EXPORT_GRIDS) |
               ISO_EXPORT_TAKES(ISO_EXPORT_EXTINCTION_SCALE) | ISO_EXPORT_TAKES(ISO_EXPORT_BAKE) |
               ISO_EXPORT_TAKES(ISO_EXPORT_DENSE) | ISO_EXPORT_TAKES(ISO_EXPORT_BACKGROUND) |
               ISO_EXPORT_TAKES(ISO_EXPORT_SHOWN),
    .narrow = true,
    .write = write_vdb,
    .suffix = ".vdb",
};
