/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "blender/blender.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "base/file.h"
#include "base/json.h"
#include "base/parallel.h"
#include "base/process.h"
#include "encode/decode_double.h"
#include "scene/roi.h"
#include "vdb/vdb.h"

ISO_EMBED(iso_blender_build_scene_py, "exporters/blender/build_scene.py");

#define CALIBRATION_SIZE 4 /* voxels along an axis of the volume that shows where Blender puts grids */
#define MAX_STEPS 65536    /* the most that Cycles takes along a ray */

iso_blender_options iso_blender_defaults(void)
{
    return (iso_blender_options){.step_voxels = 0.0625, .samples = 1, .seed = 0, .threads = 0};
}

static void keep_version(void *user, const char *line)
{
    char *version = user;
    if (!version[0])
        sscanf(line, "Blender %31s", version);
}

iso_status iso_blender_version(char *version, size_t size, iso_error *err)
{
    char *blender = NULL, found[32] = "";
    iso_status status = iso_process_find("blender", "blender", &blender, err);
    if (status != ISO_OK)
        return status;
    const char *argv[] = {blender, "--version", NULL};
    iso_process_options options = {.line = keep_version, .user = found, .timeout_seconds = 60};
    status = iso_process_run(argv, &options, err);
    if (status == ISO_OK && !found[0])
        status = iso_fail(err, ISO_E_PROGRAM, "%s: --version names no version", blender);
    if (status == ISO_OK)
        snprintf(version, size, "%s", found);
    free(blender);
    return status;
}

/* ---- Blender's units ---- */

/* A unit is a millimetre, but for volumes that are so small or so large that
 * single precision and Cycles' fixed offsets do not suit them. */
static double units_per_mm(const iso_geometry *g)
{
    const double least = 1, most = 1e4, radius = iso_geometry_box_radius_mm(g);
    return radius >= least && radius <= most ? 1 : pow(10, 2 - ceil(log10(radius)));
}

/* A copy that shares the voxels, its geometry in units. Free its levels. */
static iso_status in_units(const iso_pyramid *p, double units, iso_pyramid *copy, iso_error *err)
{
    *copy = *p;
    copy->levels = malloc(p->level_count * sizeof *copy->levels);
    if (!copy->levels)
        return iso_fail(err, ISO_E_MEMORY, "blender: out of memory");
    memcpy(copy->levels, p->levels, p->level_count * sizeof *copy->levels);
    for (size_t k = 0; k < p->level_count; ++k) {
        iso_geometry *g = &copy->levels[k].geometry;
        g->index_to_world = iso_mat3_scale(g->index_to_world, units);
        g->origin_mm = iso_scale(g->origin_mm, units);
    }
    return ISO_OK;
}

/* ---- the description: all lengths in units, g the geometry in units ---- */

/* At most `limit` bytes, whole characters; what is not UTF-8 becomes '_'. */
static json_t *text_json(const char *text, size_t limit)
{
    char *copy = strdup(text);
    size_t n = copy ? strlen(copy) : 0;
    if (n > limit)
        for (n = limit; n > 0 && ((unsigned char)text[n] & 0xC0) == 0x80;)
            --n;
    json_t *json = copy ? json_stringn(copy, n) : NULL;
    for (size_t i = 0; !json && i < n; ++i)
        if ((unsigned char)copy[i] >= 0x80)
            copy[i] = '_';
    if (copy && !json)
        json = json_stringn(copy, n);
    free(copy);
    return json;
}

static json_t *vec_json(iso_vec3 v) { return iso_json_numbers((double[]){v.x, v.y, v.z}, 3); }

static json_t *rows_json(const double rows[][4], size_t count)
{
    json_t *array = json_array();
    for (size_t r = 0; r < count; ++r)
        json_array_append_new(array, iso_json_numbers(rows[r], 4));
    return array;
}

/* The box as an affine image of [0, 1]^3, and the way back. */
static void describe_box(json_t *about, const iso_geometry *g)
{
    iso_mat3 to_world = g->index_to_world;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
            to_world.m[r][c] *= g->box_index[c];
    iso_mat3 to_box = iso_mat3_inverse(to_world);
    iso_vec3 back = iso_mul(to_box, g->origin_mm);
    const double origin[3] = {g->origin_mm.x, g->origin_mm.y, g->origin_mm.z};
    const double shift[3] = {-back.x, -back.y, -back.z};
    double world[4][4] = {{0}}, box[3][4];
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
            world[r][c] = to_world.m[r][c];
            box[r][c] = to_box.m[r][c];
        }
        world[r][3] = origin[r];
        box[r][3] = shift[r];
    }
    world[3][3] = 1;
    json_object_set_new(about, "box_to_world", rows_json((const double(*)[4])world, 4));
    json_object_set_new(about, "world_to_box", rows_json((const double(*)[4])box, 3));
}

static json_t *describe_camera(const iso_camera *c, double units, const iso_geometry *g)
{
    iso_vec3 position = iso_scale(c->position, units);
    double far = iso_norm(iso_sub(position, iso_geometry_box_center_mm(g))) + 4 * iso_geometry_box_radius_mm(g);
    return json_pack("{sb sf so so so so sf sf}", "orthographic", c->orthographic, "half_height",
                     c->half_height * (c->orthographic ? units : 1), "position", vec_json(position), "forward",
                     vec_json(c->forward), "right", vec_json(c->right), "up", vec_json(c->up), "clip_start",
                     1e-3 * iso_geometry_min_spacing_mm(g), "clip_end", far);
}

static json_t *describe_ramp(const iso_tf_table *t, double units)
{
    iso_color_ramp ramp;
    iso_color_ramp_fit(t, &ramp);
    json_t *stops = json_array();
    for (size_t i = 0; i < ramp.count; ++i)
        json_array_append_new(stops, iso_json_numbers((double[]){ramp.position[i], ramp.rgba[i][0], ramp.rgba[i][1],
                                                                 ramp.rgba[i][2], ramp.rgba[i][3]}, 5));
    return json_pack("{so sf sf sf sf sf}", "stops", stops, "lo", t->lo, "hi", t->hi, "max_extinction",
                     ramp.max_extinction / units, "color_loss", ramp.color_loss, "alpha_loss", ramp.alpha_loss);
}

static void append_entries(json_t *to, const iso_tf_table *t, double units)
{
    for (size_t i = 0; i < 4 * t->count; ++i)
        json_array_append_new(to, json_real((double)t->entries[i] / (i % 4 == 3 ? units : 1)));
}

static void append_table(json_t *to, const iso_tf_table *t, int rows, double units)
{
    json_t *entries = json_array();
    for (int r = 0; r < rows; ++r)
        append_entries(entries, &t[r], units);
    json_array_append_new(to, json_pack("{sf sf si so}", "lo", t->lo, "hi", t->hi, "rows", rows, "entries", entries));
}

/* A table a view, its entries row by row where it has classes; then one a region of interest. */
static json_t *describe_tf(const iso_view *views, size_t count, double units)
{
    json_t *all = json_array();
    for (size_t k = 0; k < count; ++k)
        append_table(all, views[k].tf_2d ? views[k].tf_2d->tables : &views[k].tf, views[k].tf_2d ? ISO_TF_2D_ROWS : 1, units);
    for (size_t k = 0; k < count; ++k)
        if (views[k].roi)
            append_table(all, &views[k].roi->tf, 1, units);
    return json_pack("{so so}", "tables", all, "ramp", describe_ramp(&views[0].tf, units));
}

static json_t *describe_lights(const iso_view *view)
{
    json_t *lights = json_array();
    for (size_t i = 0; i < view->light_count; ++i)
        json_array_append_new(lights, json_pack("{so sf}", "direction", vec_json(view->lights[i].direction), "intensity",
                                                view->lights[i].intensity));
    return lights;
}

/* Overlapping volumes are walked together by the shortest step of them, so they get the same: of the finest level. */
static double step_mm(const iso_view *view, const iso_level *level, const iso_blender_options *opt)
{
    return opt->step_voxels * iso_geometry_min_spacing_mm(iso_view_step_geometry(view, &level->geometry));
}

/* The box and the band of a region of interest in fractions of the volume's box; side: what its weight adds to the
 * volume, constant and factor. */
static json_t *describe_roi(const iso_roi *f, const iso_geometry *around, bool inside)
{
    double lo[3], hi[3], band[3];
    for (int a = 0; a < 3; ++a) {
        lo[a] = f->lo[a] / around->box_index[a];
        hi[a] = f->hi[a] / around->box_index[a];
        band[a] = fmax(f->band, 1e-6) / around->box_index[a];
    }
    return json_pack("{so so so s[fff]}", "lo", iso_json_numbers(lo, 3), "hi", iso_json_numbers(hi, 3), "band",
                     iso_json_numbers(band, 3), "side", inside ? 0.0 : 1.0, inside ? 1.0 : -1.0, 0.0);
}

/* vdb is the path that Blender sees: absolute, or relative to the .blend by a leading "//"; step in millimetres. */
static json_t *describe_level(const iso_geometry *in_units_g, size_t k, size_t table, const char *vdb, double step)
{
    const double x = iso_vdb_reverses_x(in_units_g) ? -1 : 1; /* along the axes of the file's grids */
    return json_pack("{sI sI ss sf so}", "level", (json_int_t)k, "table", (json_int_t)table, "vdb", vdb, "step", step,
                     "voxel_diagonal", vec_json(iso_mul(in_units_g->index_to_world, iso_v3(x, 1, 1))));
}

static iso_geometry scaled_geometry(const iso_geometry *from, double units)
{
    iso_geometry g = *from;
    g.index_to_world = iso_mat3_scale(g.index_to_world, units);
    g.origin_mm = iso_scale(g.origin_mm, units);
    return g;
}

/* The volume objects of level k: itself, and its region of interest. p in units. tables: the numbers of their tables. */
static void append_level(json_t *levels, const iso_pyramid *p, size_t k, const iso_view *view, double units, const size_t tables[2],
                         const char *vdb, const char *roi_vdb, const iso_blender_options *opt)
{
    const double step = units * step_mm(view, &(iso_level){.geometry = scaled_geometry(&p->levels[k].geometry, 1 / units)}, opt);
    json_t *around = describe_level(&p->levels[k].geometry, k, tables[0], vdb, step);
    if (view->roi) {
        const iso_geometry g = scaled_geometry(&view->roi->level.geometry, units);
        json_t *inside = describe_level(&g, k, tables[1], roi_vdb, step);
        json_object_set_new(around, "roi", describe_roi(view->roi, &p->levels[k].geometry, false));
        json_object_set_new(inside, "roi", describe_roi(view->roi, &p->levels[k].geometry, true));
        json_array_append_new(levels, around);
        json_array_append_new(levels, inside);
        return;
    }
    json_array_append_new(levels, around);
}

static iso_status save_roi(const iso_pyramid *p, const iso_roi *f, double units, const char *path, const iso_progress *progress,
                             iso_error *err)
{
    iso_level level = f->level;
    iso_vdb_options options = iso_vdb_defaults();
    options.pad_voxels = 1;
    level.geometry = scaled_geometry(&f->level.geometry, units);
    const iso_pyramid one = {.options = p->options, .source = p->source, .level_count = 1, .levels = &level};
    return iso_vdb_save(&one, 0, 1, path, &options, progress, err);
}

static iso_status check_options(const iso_pyramid *p, size_t level, size_t count, const iso_blender_options *opt,
                                iso_error *err)
{
    if (count == 0 || level >= p->level_count || count > p->level_count - level)
        return iso_fail(err, ISO_E_RANGE, "blender: levels %zu to %zu, the pyramid has levels 0 to %zu", level,
                        level + count - 1, p->level_count - 1);
    const iso_geometry *g = &p->levels[level].geometry;
    double steps = 2.5 * iso_geometry_box_radius_mm(g) / (opt->step_voxels * iso_geometry_min_spacing_mm(g));
    if (!(opt->step_voxels > 0) || !(steps <= MAX_STEPS))
        return iso_fail(err, ISO_E_RANGE, "blender: a step of %g voxels takes %.0f steps through the volume, Cycles at most %d",
                        opt->step_voxels, steps, MAX_STEPS);
    if (opt->samples < 1 || opt->samples > 65536)
        return iso_fail(err, ISO_E_RANGE, "blender: %d samples, must be 1 to 65536", opt->samples);
    return ISO_OK;
}

/* Planes over fractions of the box, counted from its centre: [x, y, z, w], x fx + y fy + z fz >= w stays. */
static json_t *describe_clips(const iso_view *view, const iso_geometry *g)
{
    json_t *clips = json_array();
    for (size_t i = 0; i < view->clip_count; ++i) {
        double plane[4];
        iso_clip_in_index(&view->clips[i], g, plane);
        for (int a = 0; a < 3; ++a) {
            plane[a] *= g->box_index[a];
            plane[3] -= 0.5 * plane[a];
        }
        json_array_append_new(clips, iso_json_numbers(plane, 4));
    }
    return clips;
}

static json_t *describe_scene(const iso_view *view, double units, const iso_geometry *g, const char *name,
                              const iso_blender_options *opt)
{
    json_t *about = json_pack("{ss so si si si s[II] so so so s{sf sf sf sf} sf sf sf}", "schema", "isoshade.blender/1",
                              "name", text_json(name, 50), "samples", opt->samples, "seed", opt->seed, "max_steps", MAX_STEPS, "image",
                              (json_int_t)view->width, (json_int_t)view->height, "background",
                              iso_json_numbers(view->background, 3), "camera", describe_camera(&view->camera, units, g),
                              "lights", describe_lights(view), "shading", "ambient", view->shading.ambient, "diffuse",
                              view->shading.diffuse, "specular", view->shading.specular, "power", view->shading.power,
                              "eps", ISO_DIRECTION_EPS, "step_voxels", opt->step_voxels, "units_per_mm",
                              units);
    if (about) {
        describe_box(about, g);
        json_object_set_new(about, "clip_planes", describe_clips(view, g));
    }
    return about;
}

/* ---- running Blender ---- */

static iso_status save_calibration_volume(const char *path, iso_error *err)
{
    enum { voxels = CALIBRATION_SIZE * CALIBRATION_SIZE * CALIBRATION_SIZE };
    float scalar[voxels];
    uint8_t codes[3 * voxels] = {0};
    for (int i = 0; i < voxels; ++i)
        scalar[i] = 1;
    iso_level level = {.geometry = iso_geometry_axis_aligned((size_t[]){CALIBRATION_SIZE, CALIBRATION_SIZE, CALIBRATION_SIZE},
                                                             (double[]){1, 1, 1}),
                       .scalar = scalar, .codes = codes, .min = 1, .max = 1};
    iso_pyramid p = {.level_count = 1, .levels = &level};
    iso_vdb_options vdb = iso_vdb_defaults();
    vdb.gradient = false;
    return iso_vdb_save(&p, 0, 1, path, &vdb, NULL, err);
}

typedef struct listener {
    const iso_progress *progress;
    char refusal[256]; /* why calibration failed */
    char failure[256]; /* why the script did */
    iso_cycles_stats *stats;
} listener;

/* "Fra:1 Mem:91.94M (Peak 92.20M) | Time:00:01.34 | Mem:82.00M, Peak:82.00M | scene, ViewLayer | Sample 0/1": of the first
 * picture, when its pixels begin and when it is finished. */
static void take_stats(iso_cycles_stats *stats, const char *line)
{
    int minutes;
    double seconds, megabytes;
    const char *time = strstr(line, "| Time:");
    sscanf(line, "isoshade: peak %lf", &stats->peak_rss_bytes);
    if (strcmp(line, "isoshade: pictures begin") == 0) /* after those of the calibration */
        stats->load_seconds = stats->render_seconds = 0;
    if (!time || stats->render_seconds > 0 || sscanf(time, "| Time:%d:%lf | Mem:%lfM", &minutes, &seconds, &megabytes) != 3)
        return;
    seconds += 60 * minutes;
    if (strstr(line, "| Sample 0/")) {
        stats->load_seconds = seconds;
        stats->device_bytes = 1048576 * megabytes;
    } else if (strstr(line, "| Finished")) {
        stats->render_seconds = seconds;
    }
}

static void take_line(void *user, const char *line)
{
    listener *l = user;
    double fraction;
    char stage[64];
    if (sscanf(line, "isoshade: progress %lf %63[^\n]", &fraction, stage) == 2)
        iso_progress_report(l->progress, stage, fraction);
    if (l->stats)
        take_stats(l->stats, line);
    sscanf(line, "isoshade: calibration failed: %255[^\n]", l->refusal);
    sscanf(line, "isoshade: failed: %255[^\n]", l->failure);
}

/* Writes script, description and calibration volume into the folder and runs them. Takes `about`. */
static iso_status run_blender(json_t *about, const char *folder, const iso_blender_options *opt,
                              const iso_progress *progress, iso_error *err)
{
    char *blender = NULL, threads[16];
    char *script = iso_path_join(folder, "build_scene.py");
    char *description = iso_path_join(folder, "description.json");
    char *calibration = iso_path_join(folder, "calibration.vdb");
    json_object_set_new(about, "calibration",
                        json_pack("{ss ss si}", "vdb", calibration, "folder", folder, "size", CALIBRATION_SIZE));
    iso_status status = iso_process_find("blender", "blender", &blender, err);
    if (status == ISO_OK)
        status = iso_file_write(script, iso_blender_build_scene_py, strlen(iso_blender_build_scene_py), err);
    if (status == ISO_OK)
        status = save_calibration_volume(calibration, err);
    if (status == ISO_OK)
        status = iso_json_save(description, about, err);
    if (status == ISO_OK) {
        snprintf(threads, sizeof threads, "%d", iso_threads(opt->threads));
        const char *argv[] = {blender, "-b", "--factory-startup", "-noaudio", "--python-exit-code", "9", "-t", threads,
                              "-P", script, "--", description, NULL};
        listener l = {.progress = progress, .stats = opt->stats};
        iso_process_options options = {.directory = folder, .line = take_line, .user = &l};
        status = iso_process_run(argv, &options, err);
        if (status != ISO_OK && l.refusal[0])
            status = iso_fail(err, ISO_E_UNTRUSTED, "%s: calibration failed: %s", blender, l.refusal);
        else if (status != ISO_OK && l.failure[0])
            status = iso_fail(err, ISO_E_PROGRAM, "%s: %s", blender, l.failure);
    }
    json_decref(about);
    free(calibration);
    free(description);
    free(script);
    free(blender);
    return status;
}

/* One entry a picture: what may change without building the scene again. */
static json_t *describe_frames(double voxel, const char *folder, const iso_blender_options *frames, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; ++i) {
        char path[PATH_MAX];
        snprintf(path, sizeof path, "%s/picture-%zu.exr", folder, i);
        json_array_append_new(list, json_pack("{sf si si ss}", "step",
                                              frames[i].step_voxels * voxel, "samples",
                                              frames[i].samples, "seed", frames[i].seed, "path", path));
    }
    return list;
}

static iso_status load_pictures(const char *folder, const iso_view *view, size_t count, iso_image *pictures, iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t i = 0; i < count && status == ISO_OK; ++i) {
        char path[PATH_MAX];
        iso_image *picture = &pictures[i];
        snprintf(path, sizeof path, "%s/picture-%zu.exr", folder, i);
        status = iso_image_load_exr(path, picture, err);
        if (status == ISO_OK && (picture->width != view->width || picture->height != view->height))
            status = iso_fail(err, ISO_E_PROGRAM, "blender: the picture is %zu x %zu, wanted %zu x %zu", picture->width,
                              picture->height, view->width, view->height);
        if (status == ISO_OK)
            iso_image_add_background(picture, view->background);
    }
    for (size_t i = 0; i < count && status != ISO_OK; ++i)
        iso_image_destroy(&pictures[i]);
    return status;
}

iso_status iso_cycles_render_frames(const iso_pyramid *p, size_t level, const iso_view *view,
                                    const iso_blender_options *frames, size_t count, iso_image *pictures,
                                    const iso_progress *progress, iso_error *err)
{
    iso_pyramid scaled = {0};
    iso_status status = count > 0 ? ISO_OK : iso_fail(err, ISO_E_RANGE, "blender: no picture is asked for");
    memset(pictures, 0, count * sizeof *pictures);
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        status = check_options(p, level, 1, &frames[i], err);
    if (status != ISO_OK)
        return status;
    char *folder = iso_make_temp_dir();
    if (!folder)
        return iso_fail(err, ISO_E_IO, "blender: no temporary folder can be made");
    double units = units_per_mm(&p->levels[0].geometry);
    char *vdb = iso_path_join(folder, "volume.vdb"), *roi_vdb = iso_path_join(folder, "roi.vdb");
    iso_vdb_options vdb_options = iso_vdb_defaults();
    vdb_options.pad_voxels = 1; /* Cycles fades to 0 behind the last voxels */
    vdb_options.tf_2d = view->tf_2d ? view->tf_2d->bytes : NULL;
    status = in_units(p, units, &scaled, err);
    if (status == ISO_OK)
        status = iso_vdb_save(&scaled, level, 1, vdb, &vdb_options, progress, err);
    if (status == ISO_OK && view->roi)
        status = save_roi(p, view->roi, units, roi_vdb, progress, err);
    if (status == ISO_OK) {
        const iso_level *l = &scaled.levels[level];
        const double voxel = units * iso_geometry_min_spacing_mm(iso_view_step_geometry(view, &p->levels[level].geometry));
        json_t *levels = json_array();
        append_level(levels, &scaled, level, view, units, (const size_t[2]){0, 1}, vdb, roi_vdb, &frames[0]);
        json_t *about = describe_scene(view, units, &l->geometry, "isoshade", &frames[0]);
        json_object_set_new(about, "levels", levels);
        json_object_set_new(about, "tf", describe_tf(view, 1, units));
        json_object_set_new(about, "film_transparent", json_true());
        json_object_set_new(about, "frames", describe_frames(voxel, folder, frames, count));
        status = run_blender(about, folder, &frames[0], progress, err);
    }
    if (status == ISO_OK)
        status = load_pictures(folder, view, count, pictures, err);
    iso_remove_tree(folder);
    free(scaled.levels);
    free(roi_vdb);
    free(vdb);
    free(folder);
    return status;
}

iso_status iso_cycles_render(const iso_pyramid *p, size_t level, const iso_view *view, const iso_blender_options *opt,
                             iso_image *image, const iso_progress *progress, iso_error *err)
{
    return iso_cycles_render_frames(p, level, view, opt, 1, image, progress, err);
}

/* ---- export ---- */

/* One file a level, and one a region of interest, all with the same grid names, so that one material reads them. */
static char *vdb_path(const char *blend_path, size_t k, size_t count, bool roi)
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

static iso_status write_grid(const iso_pyramid *p, size_t k, size_t count, const iso_view *view, const char *blend_path, iso_output *out,
                             const iso_progress *progress, iso_error *err)
{
    char *path = vdb_path(blend_path, k, count, false);
    iso_status status = path ? iso_output_begin(out, path, err) : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", blend_path);
    iso_vdb_options options = iso_vdb_defaults();
    options.pad_voxels = 1;
    options.tf_2d = view->tf_2d ? view->tf_2d->bytes : NULL;
    if (status == ISO_OK)
        status = iso_vdb_save(p, k, 1, out->temp_path, &options, progress, err);
    free(path);
    return status;
}

static iso_status write_roi_grid(const iso_pyramid *p, size_t k, size_t count, const iso_view *view, double units,
                                   const char *blend_path, iso_output *out, const iso_progress *progress, iso_error *err)
{
    char *path = vdb_path(blend_path, k, count, true);
    iso_status status = path ? iso_output_begin(out, path, err) : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", blend_path);
    if (status == ISO_OK)
        status = save_roi(p, view->roi, units, out->temp_path, progress, err);
    free(path);
    return status;
}

static json_t *describe_export(const iso_pyramid *p, double units, size_t first, size_t count, const iso_view *views,
                               const char *blend_path, const iso_blender_options *opt)
{
    const char *base = iso_path_base(blend_path);
    char name[NAME_MAX + 1];
    snprintf(name, sizeof name, "%.*s", (int)(strlen(base) - strlen(".blend")), base);
    json_t *about = describe_scene(&views[0], units, &p->levels[first].geometry, name, opt);
    json_t *levels = json_array();
    size_t tables[2] = {0, count}; /* the regions' tables stand behind the levels' */
    for (; tables[0] < count; ++tables[0]) {
        const size_t k = first + tables[0];
        char *path = vdb_path(blend_path, k, count, false), relative[NAME_MAX + 48];
        char *roi_path = vdb_path(blend_path, k, count, true), roi_relative[NAME_MAX + 48];
        snprintf(relative, sizeof relative, "//%s", iso_path_base(path));
        snprintf(roi_relative, sizeof roi_relative, "//%s", iso_path_base(roi_path));
        append_level(levels, p, k, &views[tables[0]], units, tables, relative, roi_relative, opt);
        tables[1] += views[tables[0]].roi != NULL;
        free(path);
        free(roi_path);
    }
    json_object_set_new(about, "levels", levels);
    json_object_set_new(about, "tf", describe_tf(views, count, units));
    json_object_set_new(about, "film_transparent", json_false());
    json_object_set_new(about, "source", text_json(p->source ? p->source : "", 1000));
    return about;
}

iso_status iso_blender_export_levels(const iso_pyramid *p, size_t first, size_t count, const iso_view *views,
                                     const char *blend_path, const iso_blender_options *opt,
                                     const iso_progress *progress, iso_error *err)
{
    iso_status status = check_options(p, first, count, opt, err);
    if (status == ISO_OK && !iso_path_ends_with(blend_path, ".blend"))
        status = iso_fail(err, ISO_E_USAGE, "%s: the name of a Blender file ends in .blend", blend_path);
    json_t *probe = json_string(blend_path);
    if (status == ISO_OK && !probe)
        status = iso_fail(err, ISO_E_USAGE, "%s: Blender wants a path in UTF-8", blend_path);
    json_decref(probe);
    if (status != ISO_OK)
        return status;
    char *folder = iso_make_temp_dir();
    iso_output *outs = calloc(2 * count + 1, sizeof *outs); /* the grids, those of regions of interest, the .blend */
    iso_pyramid scaled = {0};
    double units = units_per_mm(&p->levels[0].geometry);
    if (!folder || !outs)
        status = iso_fail(err, ISO_E_IO, "blender: no temporary folder can be made");
    if (status == ISO_OK)
        status = in_units(p, units, &scaled, err);
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        status = write_grid(&scaled, first + i, count, &views[i], blend_path, &outs[i], progress, err);
    size_t files = count;
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        if (views[i].roi)
            status = write_roi_grid(p, first + i, count, &views[i], units, blend_path, &outs[files++], progress, err);
    if (status == ISO_OK)
        status = iso_output_begin(&outs[files], blend_path, err);
    char *target = status == ISO_OK ? realpath(outs[files].temp_path, NULL) : NULL;
    if (status == ISO_OK && !target)
        status = iso_fail(err, ISO_E_IO, "%s: cannot be written", blend_path);
    if (status == ISO_OK) {
        json_t *about = describe_export(&scaled, units, first, count, views, blend_path, opt);
        json_object_set_new(about, "save", json_string(target));
        status = run_blender(about, folder, opt, progress, err);
    }
    for (size_t i = 0; i <= files && status == ISO_OK; ++i)
        status = iso_output_commit(&outs[i], err);
    for (size_t i = 0; outs && i <= files; ++i)
        iso_output_abandon(&outs[i]);
    if (folder)
        iso_remove_tree(folder);
    free(scaled.levels);
    free(target);
    free(outs);
    free(folder);
    return status;
}

iso_status iso_blender_export(const iso_pyramid *p, size_t level, const iso_view *view, const char *blend_path,
                              const iso_blender_options *opt, const iso_progress *progress, iso_error *err)
{
    return iso_blender_export_levels(p, level, 1, view, blend_path, opt, progress, err);
}

/* ---- what a plan leaves ---- */

static iso_status check_plan(const iso_blender_plan *plan, const iso_view *view, const iso_blender_options *opt, iso_error *err)
{
    iso_level box = {.geometry = *plan->geometry};
    const iso_pyramid p = {.level_count = 1, .levels = &box};
    if (view->tf_2d || view->roi)
        return iso_fail(err, ISO_E_RANGE, "blender: a plan goes with neither a table over two values nor a region of interest");
    return check_options(&p, 0, 1, opt, err);
}

static char *plan_vdb_path(const iso_blender_plan *plan, size_t i, const char *blend_path)
{
    return vdb_path(blend_path, plan->lattices[i].level, plan->count, false);
}

static iso_status save_lattice(const iso_blender_plan *plan, size_t i, double units, const char *path,
                               const iso_progress *progress, iso_error *err)
{
    iso_lattice lattice = plan->lattices[i];
    iso_vdb_options options = iso_vdb_defaults();
    lattice.geometry = scaled_geometry(&lattice.geometry, units);
    return iso_vdb_save_lattices(&lattice, 1, plan->source, path, &options, progress, err);
}

static json_t *describe_bricks(const iso_blender_plan *p)
{
    const size_t *size = p->geometry->size;
    json_t *pieces = json_array();
    for (size_t i = 0; i < p->bricks[0] * p->bricks[1] * p->bricks[2]; ++i)
        json_array_append_new(pieces, json_integer(p->piece[i]));
    return json_pack("{s[III] sI s[III] so}", "count", (json_int_t)p->bricks[0], (json_int_t)p->bricks[1], (json_int_t)p->bricks[2],
                     "voxels", (json_int_t)p->brick_voxels, "size", (json_int_t)size[0], (json_int_t)size[1], (json_int_t)size[2],
                     "piece", pieces);
}

/* Volumes that overlap are walked together by the shortest step of them, so all have the same. relative: to the .blend. */
static json_t *describe_plan(const iso_blender_plan *plan, double units, const iso_view *view, const char *name,
                             const char *blend_path, bool relative, const iso_blender_options *opt)
{
    const iso_geometry box = scaled_geometry(plan->geometry, units);
    const double step = opt->step_voxels * iso_geometry_min_spacing_mm(&box);
    json_t *about = describe_scene(view, units, &box, name, opt), *levels = json_array();
    for (size_t i = 0; i < plan->count; ++i) {
        const iso_geometry g = scaled_geometry(&plan->lattices[i].geometry, units);
        char *path = plan_vdb_path(plan, i, blend_path), text[PATH_MAX];
        snprintf(text, sizeof text, "%s%s", relative ? "//" : "", relative ? iso_path_base(path) : path);
        json_t *level = describe_level(&g, plan->lattices[i].level, 0, text, step);
        json_object_set_new(level, "piece", json_integer((json_int_t)i + 1));
        json_array_append_new(levels, level);
        free(path);
    }
    json_object_set_new(about, "levels", levels);
    json_object_set_new(about, "bricks", describe_bricks(plan));
    json_object_set_new(about, "tf", describe_tf(view, 1, units));
    json_object_set_new(about, "film_transparent", json_boolean(!relative));
    json_object_set_new(about, "source", text_json(plan->source ? plan->source : "", 1000));
    return about;
}

iso_status iso_cycles_render_plan(const iso_blender_plan *plan, const iso_view *view, const iso_blender_options *opt,
                                  iso_image *image, const iso_progress *progress, iso_error *err)
{
    *image = (iso_image){0};
    iso_status status = check_plan(plan, view, opt, err);
    if (status != ISO_OK)
        return status;
    char *folder = iso_make_temp_dir(), *stem = folder ? iso_path_join(folder, "volume.blend") : NULL;
    if (!stem)
        return iso_fail(err, ISO_E_IO, "blender: no temporary folder can be made");
    double units = units_per_mm(plan->geometry);
    for (size_t i = 0; i < plan->count && status == ISO_OK; ++i) {
        char *path = plan_vdb_path(plan, i, stem);
        status = save_lattice(plan, i, units, path, progress, err);
        free(path);
    }
    if (status == ISO_OK) {
        json_t *about = describe_plan(plan, units, view, "isoshade", stem, false, opt);
        json_object_set_new(about, "frames", describe_frames(units * iso_geometry_min_spacing_mm(plan->geometry), folder, opt, 1));
        status = run_blender(about, folder, opt, progress, err);
    }
    if (status == ISO_OK)
        status = load_pictures(folder, view, 1, image, err);
    iso_remove_tree(folder);
    free(stem);
    free(folder);
    return status;
}

/* The grids beside the .blend, then itself: outs holds count + 1. */
static iso_status write_plan(const iso_blender_plan *plan, const iso_view *view, const char *blend_path, const char *folder,
                             const iso_blender_options *opt, iso_output *outs, const iso_progress *progress, iso_error *err)
{
    iso_status status = ISO_OK;
    double units = units_per_mm(plan->geometry);
    const char *base = iso_path_base(blend_path);
    char name[NAME_MAX + 1], *target = NULL;
    for (size_t i = 0; i < plan->count && status == ISO_OK; ++i) {
        char *path = plan_vdb_path(plan, i, blend_path);
        status = iso_output_begin(&outs[i], path, err);
        if (status == ISO_OK)
            status = save_lattice(plan, i, units, outs[i].temp_path, progress, err);
        free(path);
    }
    if (status == ISO_OK)
        status = iso_output_begin(&outs[plan->count], blend_path, err);
    if (status == ISO_OK && !(target = realpath(outs[plan->count].temp_path, NULL)))
        status = iso_fail(err, ISO_E_IO, "%s: cannot be written", blend_path);
    if (status == ISO_OK) {
        snprintf(name, sizeof name, "%.*s", (int)(strlen(base) - strlen(".blend")), base);
        json_t *about = describe_plan(plan, units, view, name, blend_path, true, opt);
        json_object_set_new(about, "save", json_string(target));
        status = run_blender(about, folder, opt, progress, err);
    }
    free(target);
    return status;
}

iso_status iso_blender_export_plan(const iso_blender_plan *plan, const iso_view *view, const char *blend_path,
                                   const iso_blender_options *opt, const iso_progress *progress, iso_error *err)
{
    iso_status status = check_plan(plan, view, opt, err);
    if (status == ISO_OK && !iso_path_ends_with(blend_path, ".blend"))
        status = iso_fail(err, ISO_E_USAGE, "%s: the name of a Blender file ends in .blend", blend_path);
    if (status != ISO_OK)
        return status;
    char *folder = iso_make_temp_dir();
    iso_output *outs = calloc(plan->count + 1, sizeof *outs);
    status = folder && outs ? write_plan(plan, view, blend_path, folder, opt, outs, progress, err)
                            : iso_fail(err, ISO_E_IO, "blender: no temporary folder can be made");
    for (size_t i = 0; i <= plan->count && status == ISO_OK; ++i)
        status = iso_output_commit(&outs[i], err);
    for (size_t i = 0; outs && i <= plan->count; ++i)
        iso_output_abandon(&outs[i]);
    if (folder)
        iso_remove_tree(folder);
    free(outs);
    free(folder);
    return status;
}
