/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "blender/blender.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inputs.h"
#include "base/provenance.h"
#include "base/stamp.h"
#include "blender/blender_scene.h"
#include "scene/roi.h"
#include "vdb/vdb.h"

static const struct {
    const char *name, *summary;
} materials[] = {
    {"exact", "emission and absorption only, for the same picture in all renderers"},
    {"physical", "scattering with shadows, lit by lamps and world"},
};
const iso_names iso_blender_material_names = ISO_NAMES_OF_ROWS("material", materials);

iso_blender_options iso_blender_defaults(void)
{
    return (iso_blender_options){.step_voxels = 0.0625, .samples = 1, .seed = 0, .threads = 0};
}

iso_status iso_blender_check(const iso_pyramid *p, size_t level, size_t count, const iso_blender_options *opt,
                             iso_error *err)
{
    if (count == 0 || level >= p->level_count || count > p->level_count - level)
        return iso_fail(err, ISO_E_RANGE, "blender: levels %zu to %zu, the pyramid has levels 0 to %zu", level,
                        level + count - 1, p->level_count - 1);
    const iso_geometry *g = &p->levels[level].geometry;
    double steps = 2.5 * iso_geometry_box_radius_mm(g) / (opt->step_voxels * iso_geometry_min_spacing_mm(g));
    if (!(opt->step_voxels > 0) || !(steps <= ISO_BLENDER_MAX_STEPS))
        return iso_fail(err, ISO_E_RANGE,
                        "blender: a step of %g voxels takes %.0f steps through the volume, Cycles at most %d",
                        opt->step_voxels, steps, ISO_BLENDER_MAX_STEPS);
    if (opt->samples < 1 || opt->samples > 65536)
        return iso_fail(err, ISO_E_RANGE, "blender: %d samples, must be 1 to 65536", opt->samples);
    return ISO_OK;
}

iso_status iso_blender_pyramid_in_space(const iso_pyramid *p, const iso_blender_space *space, iso_pyramid *copy,
                                        iso_error *err)
{
    *copy = *p;
    copy->levels = malloc(p->level_count * sizeof *copy->levels);
    NEED_MEMORY(copy->levels, err, "blender: out of memory");
    memcpy(copy->levels, p->levels, p->level_count * sizeof *copy->levels);
    for (size_t k = 0; k < p->level_count; ++k)
        copy->levels[k].geometry = iso_blender_in_space(&p->levels[k].geometry, space);
    return ISO_OK;
}

/* Saves the grids of a region of interest with the given options. */
static iso_status save_roi(const iso_pyramid *p, const iso_roi *f, const iso_blender_space *space, const char *path,
                           iso_vdb_options options, iso_error *err)
{
    iso_level level = f->level;
    options.pad_voxels = 1;
    iso_blender_note_space(space, &options);
    level.geometry = iso_blender_in_space(&f->level.geometry, space);
    const iso_pyramid one = {.options = p->options, .source = p->source, .level_count = 1, .levels = &level};
    return iso_vdb_save(&one, 0, 1, path, &options, NULL, err);
}

/* Describes labels if the pyramid has any. */
static iso_status describe_labels(json_t *about, const iso_pyramid *p, const iso_blender_levels *levels, double units,
                                  const char *folder, iso_error *err)
{
    return p->levels[levels->first].labels ? iso_blender_describe_labels(about, p, levels, units, folder, err) : ISO_OK;
}

/* Runs the description if status is ISO_OK. Takes `about`. */
static iso_status run_described(iso_status status, json_t *about, const char *folder, const iso_blender_options *opt,
                                const iso_progress *progress, iso_error *err)
{
    if (status == ISO_OK)
        return iso_blender_run(about, folder, opt, progress, err);
    json_decref(about);
    return status;
}

/* ---- pictures ---- */

iso_status iso_cycles_render_frames(const iso_pyramid *p, size_t level, const iso_view *view,
                                    const iso_blender_frames *wanted, const iso_progress *progress, iso_error *err)
{
    const iso_blender_options *frames = wanted->options;
    const size_t count = wanted->count;
    iso_image *pictures = wanted->pictures;
    iso_pyramid scaled = {0};
    iso_status status = count > 0 ? ISO_OK : iso_fail(err, ISO_E_RANGE, "blender: no picture requested");
    memset(pictures, 0, count * sizeof *pictures);
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        status = iso_blender_check(p, level, 1, &frames[i], err);
    if (status != ISO_OK)
        return status;
    FREED char *folder = iso_blender_folder(&frames[0]);
    if (!folder)
        return iso_temp_dir_fail(err);
    const iso_blender_space space = iso_blender_space_of(&p->levels[0].geometry);
    FREED char *vdb = iso_path_join(folder, "volume.vdb"), *roi_vdb = iso_path_join(folder, "roi.vdb");
    iso_vdb_options vdb_options = iso_vdb_defaults();
    vdb_options.pad_voxels = 1; /* Cycles fades to 0 beyond the last voxels */
    vdb_options.tf_2d = view->tf_2d ? view->tf_2d->bytes : NULL;
    vdb_options.extinction_scale = view->extinction_scale;
    iso_vdb_shown visible, roi_visible;
    iso_vdb_options roi_options = iso_vdb_defaults();
    iso_blender_grid_options(&frames[0], &view->tf, view->tf_2d, &visible, &vdb_options);
    iso_blender_grid_options(&frames[0], view->roi ? &view->roi->tf : &view->tf, NULL, &roi_visible, &roi_options);
    iso_blender_note_space(&space, &vdb_options);
    status = iso_blender_pyramid_in_space(p, &space, &scaled, err);
    TRY(status, iso_vdb_save(&scaled, level, 1, vdb, &vdb_options, progress, err));
    if (status == ISO_OK && view->roi)
        status = save_roi(p, view->roi, &space, roi_vdb, roi_options, err);
    if (status == ISO_OK) {
        const iso_geometry *g = &p->levels[level].geometry;
        const double voxel = space.units * iso_geometry_min_spacing_mm(iso_view_step_geometry(view, g));
        json_t *levels = json_array();
        const blender_level shown = {g, level, {0, 1}, vdb, roi_vdb, p->levels[level].is_optimized};
        iso_blender_append_level(levels, &shown, view, &space, &frames[0]);
        json_t *about = iso_blender_describe_scene(view, &space, g, "isoshade", &frames[0]);
        json_object_set_new(about, "levels", levels);
        json_object_set_new(about, "tf", iso_blender_describe_tf(view, level, 1, space.units));
        json_object_set_new(about, "extinction_scale", json_boolean(view->extinction_scale));
        json_object_set_new(about, "film_transparent", json_true());
        iso_blender_scale_directions(about, &frames[0], iso_vdb_direction_scale(p->options.code));
        json_object_set_new(about, "frames", iso_blender_describe_frames(voxel, folder, frames, count));
        status = describe_labels(about, p, &(iso_blender_levels){level, 1, view}, space.units, folder, err);
        status = run_described(status, about, folder, &frames[0], progress, err);
    }
    TRY(status, iso_blender_load_pictures(folder, view, count, pictures, err));
    iso_remove_tree(folder);
    free(scaled.levels);
    return status;
}

iso_status iso_cycles_render(const iso_pyramid *p, size_t level, const iso_view *view, const iso_blender_options *opt,
                             iso_image *image, const iso_progress *progress, iso_error *err)
{
    return iso_cycles_render_frames(p, level, view, &(iso_blender_frames){opt, 1, image}, progress, err);
}

/* ---- export ---- */

char *iso_blender_vdb_path(const char *blend_path, size_t k, size_t count, bool roi)
{
    size_t stem = strlen(blend_path) - strlen(".blend"), size = stem + 48;
    const char *which = roi ? "_roi" : "";
    char *path = malloc(size);
    if (path && count == 1)
        snprintf(path, size, "%.*s%s.vdb", (int)stem, blend_path, which);
    else if (path)
        snprintf(path, size, "%.*s_level_%zu%s.vdb", (int)stem, blend_path, k, which);
    return path;
}

iso_status iso_blender_guard_grid(const char *path, bool force, iso_error *err)
{
    const iso_status status = iso_inputs_announce(path, err);
    return status == ISO_OK ? iso_stamp_guard_other(path, iso_vdb_is_ours(path), force, err) : status;
}

static iso_status guard_level(const char *blend_path, size_t k, size_t count, bool roi, bool force, iso_error *err)
{
    FREED char *path = iso_blender_vdb_path(blend_path, k, count, roi);
    return path ? iso_blender_guard_grid(path, force, err) : iso_fail(err, ISO_E_MEMORY, "blender: out of memory");
}

iso_status iso_blender_guard_grids(const char *blend_path, size_t level, size_t level_count, bool roi, bool force,
                                   iso_error *err)
{
    iso_status status = iso_blender_check_path(blend_path, err);
    for (size_t k = level; k < level + level_count && status == ISO_OK; ++k) {
        status = guard_level(blend_path, k, level_count, false, force, err);
        if (status == ISO_OK && roi)
            status = guard_level(blend_path, k, level_count, true, force, err);
    }
    return status;
}

/* An export of levels [first, first + count) of a pyramid to one file. */
typedef struct export_job {
    const iso_pyramid *p, *scaled; /* in millimeters; in Blender's space */
    const iso_blender_space *space;
    size_t first, count;
    const iso_view *views;
    const char *blend_path;
    const iso_blender_options *opt;
} export_job;

static iso_status begin_grid(const export_job *e, size_t i, bool roi, iso_output *out, iso_error *err)
{
    FREED char *path = iso_blender_vdb_path(e->blend_path, e->first + i, e->count, roi);
    return path ? iso_output_begin(out, path, err) : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", e->blend_path);
}

static iso_status write_grid(const export_job *e, size_t i, iso_output *out, const iso_progress *progress,
                             iso_error *err)
{
    const iso_view *view = &e->views[i];
    iso_vdb_options options = iso_vdb_defaults();
    options.pad_voxels = 1;
    options.tf_2d = view->tf_2d ? view->tf_2d->bytes : NULL;
    options.extinction_scale = view->extinction_scale;
    iso_vdb_shown shown;
    iso_blender_grid_options(e->opt, &view->tf, view->tf_2d, &shown, &options);
    iso_blender_note_space(e->space, &options);
    NEED(begin_grid(e, i, false, out, err));
    return iso_vdb_save(e->scaled, e->first + i, 1, out->temp_path, &options, progress, err);
}

static iso_status write_roi_grid(const export_job *e, size_t i, iso_output *out, iso_error *err)
{
    iso_vdb_options options = iso_vdb_defaults();
    iso_vdb_shown shown;
    iso_blender_grid_options(e->opt, &e->views[i].roi->tf, NULL, &shown, &options);
    NEED(begin_grid(e, i, true, out, err));
    return save_roi(e->p, e->views[i].roi, e->space, out->temp_path, options, err);
}

/* True if a level has an extinction scale. Others, like the finest, have no such grid: Cycles reads 0, a scale of 1. */
static bool have_scale(const iso_view *views, size_t count)
{
    bool any = false;
    for (size_t i = 0; i < count; ++i)
        any = any || views[i].extinction_scale;
    return any;
}

static json_t *describe_export(const export_job *e)
{
    const iso_view *views = e->views;
    const char *base = iso_path_base(e->blend_path);
    char name[NAME_MAX + 1];
    snprintf(name, sizeof name, "%.*s", (int)(strlen(base) - strlen(".blend")), base);
    json_t *about = iso_blender_describe_scene(&views[0], e->space, &e->p->levels[e->first].geometry, name, e->opt);
    json_t *levels = json_array();
    size_t region = e->count; /* tables of regions follow those of levels */
    for (size_t i = 0; i < e->count; ++i) {
        const size_t k = e->first + i;
        char *path = iso_blender_vdb_path(e->blend_path, k, e->count, false), relative[NAME_MAX + 48];
        char *roi_path = iso_blender_vdb_path(e->blend_path, k, e->count, true), roi_relative[NAME_MAX + 48];
        snprintf(relative, sizeof relative, "//%s", iso_path_base(path));
        snprintf(roi_relative, sizeof roi_relative, "//%s", iso_path_base(roi_path));
        const iso_level *l = &e->p->levels[k];
        const blender_level level = {&l->geometry, k, {i, region}, relative, roi_relative, l->is_optimized};
        iso_blender_append_level(levels, &level, &views[i], e->space, e->opt);
        region += views[i].roi != NULL;
        free(path);
        free(roi_path);
    }
    json_object_set_new(about, "levels", levels);
    json_object_set_new(about, "tf", iso_blender_describe_tf(views, e->first, e->count, e->space->units));
    json_object_set_new(about, "extinction_scale", json_boolean(have_scale(views, e->count)));
    iso_blender_scale_directions(about, e->opt, iso_vdb_direction_scale(e->p->options.code));
    json_object_set_new(about, "film_transparent", json_false());
    json_object_set_new(about, "source", iso_blender_text(iso_provenance_name(e->p->source), 1000));
    json_object_set_new(about, "unit", json_string(e->p->unit.name));
    json_object_set_new(about, "value_range",
                        iso_json_numbers((double[]){iso_pyramid_lo(e->p), iso_pyramid_hi(e->p)}, 2));
    json_object_set_new(about, "voxel_mm", json_real(iso_geometry_mean_spacing_mm(&e->p->levels[0].geometry)));
    return about;
}

/* Writes the grids, those of regions of interest, then the .blend: outs has 2 count + 1 entries, *files of them
 * used. */
static iso_status write_files(const export_job *e, const char *folder, iso_output *outs, size_t *files,
                              const iso_progress *progress, iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t i = 0; i < e->count && status == ISO_OK; ++i)
        status = write_grid(e, i, &outs[i], progress, err);
    *files = e->count;
    for (size_t i = 0; i < e->count && status == ISO_OK; ++i)
        if (e->views[i].roi)
            status = write_roi_grid(e, i, &outs[(*files)++], err);
    if (status == ISO_OK) {
        json_t *about = describe_export(e);
        status = describe_labels(about, e->p, &(iso_blender_levels){e->first, e->count, e->views}, e->space->units,
                                 folder, err);
        if (status == ISO_OK)
            return iso_blender_save(about, e->blend_path, &outs[*files], folder, e->opt, progress, err);
        json_decref(about);
    }
    return status;
}

iso_status iso_blender_export_levels(const iso_pyramid *p, const iso_blender_levels *levels, const char *blend_path,
                                     const iso_blender_options *opt, const iso_progress *progress, iso_error *err)
{
    const size_t first = levels->first, count = levels->count;
    iso_status status = iso_blender_check(p, first, count, opt, err);
    TRY(status, iso_blender_check_path(blend_path, err));
    if (status != ISO_OK)
        return status;
    iso_blender_started blender;
    FREED iso_output *outs = calloc(2 * count + 1, sizeof *outs);
    iso_pyramid scaled = {0};
    const iso_blender_space space = iso_blender_space_of(&p->levels[0].geometry);
    status = outs ? iso_blender_begin(opt, &blender, err) : iso_fail(err, ISO_E_MEMORY, "blender: out of memory");
    TRY(status, iso_blender_pyramid_in_space(p, &space, &scaled, err));
    const export_job job = {p, &scaled, &space, first, count, levels->views, blend_path, &blender.options};
    size_t files = 0;
    TRY(status, write_files(&job, blender.folder, outs, &files, progress, err));
    TRY(status, iso_output_commit_all(outs, files + 1, err));
    for (size_t i = 0; outs && i <= files; ++i)
        iso_output_abandon(&outs[i]);
    if (outs)
        iso_blender_end(&blender);
    free(scaled.levels);
    return status;
}
