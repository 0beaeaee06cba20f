/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "scene/subject.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/machine.h"
#include "base/path.h"
#include "base/temporary.h"
#include "pyramid/narrow.h"
#include "pyramid/pyramid_stream.h"
#include "scene/viewpoint.h"
#include "tf/presets.h"

iso_status iso_subject_open(void *file, iso_volume_source **source, iso_error *err)
{
    const iso_subject_file *f = file;
    return iso_volume_input_open(f->path, f->input, source, err);
}

/* Builds the pyramid of a volume, which it destroys. */
static iso_status build_whole(iso_volume *v, const char *path, const iso_pyramid_options *opt,
                              const iso_progress *progress, iso_pyramid *p, iso_error *err)
{
    iso_pyramid_options own = *opt;
    if (v->notes.label_count)
        own.scalar_filter = ISO_SCALAR_MAJORITY;
    const iso_status status = iso_pyramid_build(v, path, &own, p, progress, err);
    iso_volume_destroy(v);
    return status;
}

/* True if a pyramid can use the samples as they are. */
static bool keeps_samples(const iso_volume *v)
{
    return !v->notes.label_count && iso_type_bytes(v->type) <= sizeof(float);
}

/* Loads the volume of an open source, which it closes, and builds its pyramid. */
static iso_status build(iso_volume_source *source, const char *path, const iso_volume_input *input,
                        const iso_pyramid_options *opt, bool begin_only, const iso_progress *progress, iso_pyramid *p,
                        iso_error *err)
{
    iso_volume v;
    NEED(iso_volume_input_load_source(source, path, input, &v, err));
    return begin_only && keeps_samples(&v) ? iso_pyramid_begin(&v, path, opt, p, err)
                                           : build_whole(&v, path, opt, progress, p, err);
}

static iso_status load(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt, bool begin_only,
                       const iso_progress *progress, iso_pyramid *p, iso_error *err)
{
    iso_volume_source *source;
    *p = (iso_pyramid){0};
    if (iso_pyramid_is_one(path))
        return (begin_only ? iso_pyramid_load_begun : iso_pyramid_load)(path, p, err);
    NEED(iso_volume_input_open(path, input, &source, err));
    return build(source, path, input, opt, begin_only, progress, p, err);
}

void iso_subject_coarse_destroy(iso_subject_coarse *coarse)
{
    iso_end_temp_dir(&coarse->temporary);
    free(coarse->folder);
    *coarse = (iso_subject_coarse){0};
}

/* Builds the levels from 1 on in a temporary folder. */
static iso_status build_coarse(const iso_subject_file *file, const iso_pyramid_options *opt,
                               const iso_progress *progress, iso_subject_coarse *coarse, iso_error *err)
{
    iso_stream_report report;
    iso_pyramid_options own = *opt;
    size_t labels = 0;
    const iso_stream_input in = {iso_subject_open, (void *)file, file->path};
    const iso_stream_options how = {.first_level = 1,
                                    .memory_bytes = (size_t)fmin(iso_machine_free_bytes("") / 2, 1e15)};
    coarse->temporary = iso_make_temp_dir();
    coarse->folder = coarse->temporary ? iso_path_join(coarse->temporary, "coarse.iso") : NULL;
    if (!coarse->folder)
        return iso_temp_dir_fail(err);
    NEED(iso_volume_input_labels(file->path, file->input, &labels, err));
    if (labels)
        own.scalar_filter = ISO_SCALAR_MAJORITY;
    return iso_pyramid_stream(&in, &own, &how, coarse->folder, &report, progress, err);
}

/* Does iso_subject_load_coarse() for a volume. */
static iso_status load_volume(const iso_subject_file *file, const iso_pyramid_options *opt, double most,
                              const iso_progress *progress, iso_pyramid *p, iso_subject_coarse *coarse, iso_error *err)
{
    iso_volume_source *source;
    NEED(iso_volume_input_open(file->path, file->input, &source, err));
    if ((double)iso_geometry_voxel_count(&iso_source_volume(source)->geometry) <= most)
        return build(source, file->path, file->input, opt, false, progress, p, err);
    iso_source_close(source);
    return build_coarse(file, opt, progress, coarse, err);
}

/* Does iso_subject_load_coarse() for a pyramid on disk. */
static iso_status load_folder(const char *path, double most, iso_pyramid *p, iso_subject_coarse *coarse, iso_error *err)
{
    NEED(iso_pyramid_load_outline(path, p, err));
    const bool is_large = (double)iso_geometry_voxel_count(&p->levels[0].geometry) > most;
    iso_pyramid_destroy(p);
    if (!is_large)
        return iso_pyramid_load(path, p, err);
    coarse->folder = strdup(path);
    return coarse->folder ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
}

iso_status iso_subject_load_coarse(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt,
                                   double most, const iso_progress *progress, iso_pyramid *p,
                                   iso_subject_coarse *coarse, iso_error *err)
{
    *p = (iso_pyramid){0};
    *coarse = (iso_subject_coarse){0};
    iso_status status = iso_pyramid_is_one(path)
                            ? load_folder(path, most, p, coarse, err)
                            : load_volume(&(iso_subject_file){path, input}, opt, most, progress, p, coarse, err);
    if (status == ISO_OK && coarse->folder)
        status = iso_pyramid_load_from(coarse->folder, SIZE_MAX, p, err);
    return status;
}

iso_status iso_subject_load_pyramid(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt,
                                    const iso_progress *progress, iso_pyramid *p, iso_error *err)
{
    return load(path, input, opt, false, progress, p, err);
}

iso_status iso_subject_begin_pyramid(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt,
                                     const iso_progress *progress, iso_pyramid *p, iso_error *err)
{
    return load(path, input, opt, true, progress, p, err);
}

iso_status iso_subject_refuse_labels(const iso_pyramid *p, const char *path, const char *what, iso_error *err)
{
    return p->levels[0].labels
               ? iso_fail(err, ISO_E_USAGE, "%s: is a label map, which %s would interpolate; --no-labels allows it",
                          path, what)
               : ISO_OK;
}

iso_status iso_subject_parse_image_size(const char *text, size_t *width, size_t *height, iso_error *err)
{
    char *end;
    unsigned long w = strtoul(text, &end, 10), h = w;
    bool good = end != text && text[0] != '-';
    if (good && *end == 'x') {
        const char *second = end + 1;
        h = strtoul(second, &end, 10);
        good = end != second && *second != '-';
    }
    if (!good || *end || w < 1 || h < 1 || w > 16384 || h > 16384)
        return iso_fail(err, ISO_E_USAGE, "--size is \"%s\", must be WxH such as 320x200, each 1 to 16384", text);
    *width = w;
    *height = h;
    return ISO_OK;
}

iso_status iso_subject_check_look(const iso_subject_look *look, iso_error *err)
{
    OWNED(iso_scene) scene = {0};
    iso_viewpoint viewpoint;
    size_t width, height;
    if (look->scene)
        NEED(iso_scene_load(look->scene, &scene, err));
    NEED(iso_tf_check_name(look->tf, &look->request, err));
    if (look->view)
        NEED(iso_viewpoint_parse(look->view, &viewpoint, err));
    if (!(look->zoom == 0 || (look->zoom >= 0.01 && look->zoom <= 1000)))
        return iso_fail(err, ISO_E_USAGE, "--zoom is %g, must be .01 to 1000", look->zoom);
    return look->size ? iso_subject_parse_image_size(look->size, &width, &height, err) : ISO_OK;
}

bool iso_subject_look_needs_values(const iso_subject_look *look)
{
    size_t row;
    return look->tf ? iso_tf_preset_find(look->tf, &row) : !look->scene;
}

static iso_status first_scene(const iso_subject_look *look, const iso_geometry *g, iso_scene *scene, iso_error *err)
{
    size_t width = ISO_SUBJECT_PIXELS, height = ISO_SUBJECT_PIXELS;
    iso_viewpoint viewpoint;
    NEED(iso_viewpoint_parse(look->view ? look->view : iso_viewpoint_usual(g), &viewpoint, err));
    if (look->size)
        NEED(iso_subject_parse_image_size(look->size, &width, &height, err));
    *scene = iso_scene_first(g, &viewpoint, width, height);
    return ISO_OK;
}

/* Replaces parts of the scene; the size first, since the camera frames the box in it. */
static iso_status change_scene(const iso_subject_look *look, const iso_geometry *g, iso_scene *scene, iso_error *err)
{
    iso_viewpoint viewpoint;
    iso_status status = ISO_OK;
    if (look->size)
        status = iso_subject_parse_image_size(look->size, &scene->width, &scene->height, err);
    if (status == ISO_OK && look->view && (status = iso_viewpoint_parse(look->view, &viewpoint, err)) == ISO_OK)
        iso_scene_look_from(scene, g, &viewpoint);
    return status;
}

static iso_status frame_visible(const iso_subject_look *look, const iso_pyramid *p, iso_scene *scene, iso_error *err)
{
    OWNED(iso_tf_table) table = {0};
    NEED(iso_tf_tabulate(&scene->tf, iso_pyramid_lo(p), iso_pyramid_hi(p), &p->levels[0].geometry, &table, err));
    return iso_scene_frame_visible(scene, iso_pyramid_finest(p), &table, look->threads, look->visible, err);
}

/* Chooses the transfer function by the finest level that is loaded; its lengths are those of level 0. */
static iso_status choose_tf(const iso_subject_look *look, const iso_pyramid *p, iso_tf *tf, iso_error *err)
{
    const iso_level *level0 = &p->levels[0], *seen = iso_pyramid_finest(p);
    FREED iso_survey *survey = NULL;
    if (!look->survey && seen != level0 && iso_subject_look_needs_values(look))
        NEED(iso_survey_make(seen, look->threads, &survey, err));
    return iso_tf_of_level(look->tf, &look->request, survey ? survey : look->survey, level0, look->threads, tf, err);
}

iso_status iso_subject_make_scene(const iso_subject_look *look, const iso_pyramid *p, iso_scene *scene, iso_error *err)
{
    const iso_level *level0 = &p->levels[0], *seen = iso_pyramid_finest(p);
    *scene = (iso_scene){0};
    iso_status status = look->scene ? iso_scene_load(look->scene, scene, err)
                                    : first_scene(look, &level0->geometry, scene, err);
    if (status == ISO_OK && look->scene)
        status = change_scene(look, &level0->geometry, scene, err);
    if (look->zoom > 0)
        scene->zoom = look->zoom;
    if (status == ISO_OK && (look->tf || !look->scene)) {
        iso_tf_destroy(&scene->tf);
        status = choose_tf(look, p, &scene->tf, err);
    }
    if (status == ISO_OK && !look->scene && !look->frames_box && (seen->scalar || seen->samples))
        status = frame_visible(look, p, scene, err);
    if (status != ISO_OK)
        iso_scene_destroy(scene);
    return status;
}

iso_status iso_subject_make_view(const iso_subject_look *look, const iso_pyramid *p, iso_view *view, iso_error *err)
{
    OWNED(iso_scene) scene = {0};
    *view = (iso_view){0};
    NEED(iso_subject_make_scene(look, p, &scene, err));
    return iso_scene_resolve(&scene, &p->levels[0].geometry, iso_pyramid_lo(p), iso_pyramid_hi(p), view, err);
}

/* ---- with a narrow pyramid ---- */

static iso_status see(const iso_subject_look *look, const iso_pyramid *p, iso_subject_sight *sight, iso_error *err)
{
    if (!look)
        return ISO_OK;
    NEED(iso_subject_make_view(look, p, &sight->view, err));
    sight->visible = iso_visible_measure(&p->levels[0], &sight->view, NULL, look->threads);
    return ISO_OK;
}

/* Makes the view with a pyramid of one level whose scalars are the volume's samples. */
static iso_status see_volume(const iso_subject_look *look, const iso_volume *v, const char *path,
                             const iso_pyramid_options *opt, iso_subject_sight *sight, iso_error *err)
{
    if (!look)
        return ISO_OK;
    const iso_volume_stats stats = iso_volume_measure(v);
    iso_level level = {
        .geometry = v->geometry, .stored_type = v->type, .samples = v, .min = stats.min, .max = stats.max};
    const iso_pyramid p = {.options = *opt,
                           .source = (char *)path,
                           .unit = iso_pyramid_unit_of(&v->notes),
                           .level_count = 1,
                           .levels = &level};
    return see(look, &p, sight, err);
}

iso_status iso_subject_load_narrow(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt,
                                   const iso_subject_look *look, const iso_progress *progress, iso_pyramid *p,
                                   iso_volume *v, iso_subject_sight *sight, iso_error *err)
{
    *p = (iso_pyramid){0};
    *v = (iso_volume){0};
    *sight = (iso_subject_sight){0};
    if (iso_pyramid_is_one(path)) {
        NEED(iso_pyramid_load(path, p, err));
        return see(look, p, sight, err);
    }
    NEED(iso_volume_input_load(path, input, v, err));
    if (!keeps_samples(v)) {
        NEED(build_whole(v, path, opt, progress, p, err));
        return see(look, p, sight, err);
    }
    NEED(see_volume(look, v, path, opt, sight, err));
    return iso_pyramid_build_narrow(v, path, opt, p, progress, err);
}
