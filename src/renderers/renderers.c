/* SPDX-License-Identifier: MIT */
/* renderers.c - one call for all renderers. */
#include "renderers/renderers.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"
#include "base/parallel.h"
#include "base/warnings.h"
#include "base/work.h"
#include "renderers/picture_store.h"
#include "renderers/request.h"

void iso_renderers_end(iso_renderers *r)
{
    for (size_t i = 0; i < iso_renderer_count(); ++i)
        if (r->kept[i])
            iso_renderer_at(i)->end(r->kept[i]);
    *r = (iso_renderers){0};
}

iso_status iso_renderer_identify(const iso_renderer_info *r, const char *version, char hash[ISO_KEY_DIGEST_BYTES],
                                 iso_error *err)
{
    iso_key *key = iso_key_create();
    iso_status status = key ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "out of memory");
    hash[0] = 0;
    if (key) {
        iso_key_add_text(key, "its name", r->name);
        iso_key_add_text(key, "its version", version);
    }
    for (const char *const *name = r->programs; status == ISO_OK && name && *name; ++name)
        status = iso_key_add_dependency(key, *name, err);
    if (status == ISO_OK && !iso_renderer_has(r, ISO_IS_OF_A_USER) && !iso_key_digest(key, hash))
        status = iso_fail(err, ISO_E_MEMORY, "out of memory");
    iso_key_destroy(key);
    return status;
}

iso_render_options iso_render_defaults(const iso_renderer_info *r)
{
    iso_render_options opt = r->defaults;
    opt.renderer = r;
    return opt;
}

iso_status iso_renderers_find_missing(const char *list, bool wanted[ISO_MAX_RENDERERS], iso_error *err)
{
    iso_renderers r = {0};
    iso_status status = ISO_OK;
    for (size_t i = 0; i < iso_renderer_count() && status == ISO_OK; ++i) {
        char version[320], text[600];
        iso_error why = {""};
        const iso_renderer_info *which = iso_renderer_at(i);
        if (!wanted[i] || which->version(which, &r, version, sizeof version, &why) != ISO_E_MISSING)
            continue;
        wanted[i] = false;
        snprintf(text, sizeof text, "%s is left out: %.500s", which->name, why.text);
        if (list)
            status = iso_fail(err, ISO_E_MISSING, "%s", why.text);
        else
            iso_warn(text);
    }
    iso_renderers_end(&r);
    return status;
}

double iso_half_rounding(double most)
{
    return ldexp(1, (int)ceil(log2(fmax(most, 0x1p-14))) - 12) * (1 + 1e-6); /* for programs that round in float */
}

/* ---- steps ---- */

double iso_level_chord_voxels(const iso_level *level)
{
    return 2 * iso_geometry_box_radius_mm(&level->geometry) / iso_geometry_min_spacing_mm(&level->geometry);
}

void iso_render_ask_steps(const iso_renderer_info *r, const iso_level *level, double finest_voxels, size_t count,
                          double spare, iso_render_options *frames)
{
    for (size_t i = 0; i < count; ++i)
        frames[i].step_voxels = ldexp(finest_voxels, (int)(count - 1 - i));
    if (r->ask_steps)
        r->ask_steps(level, finest_voxels, count, spare, frames);
}

double iso_render_step_voxels(const iso_level *level, const iso_render_options *frame)
{
    return frame->intervals ? iso_level_chord_voxels(level) / (double)(frame->intervals * (frame->planes + 1))
                            : frame->step_voxels;
}

double iso_render_taken_step_voxels(const iso_render_request *q, const iso_render_options *frame)
{
    const iso_level *level = &q->pyramid->levels[q->level];
    const iso_renderer_info *r = frame->renderer;
    return frame->step_voxels > 0 || frame->intervals ? iso_render_step_voxels(level, frame)
           : frame->quadrature == ISO_QUADRATURE_CONVERGED && r == iso_renderers_reference() ? INFINITY
           : r->own_step                                                                     ? r->own_step(level)
                                                                                             : q->view->step_voxels;
}

/* Adds an image to the sums of the whole job. */
static void count_picture(const iso_render_request *q, const iso_render_options *frame)
{
    const double pixels = (double)(q->view->width * q->view->height), step = iso_render_taken_step_voxels(q, frame);
    iso_work_add_picture(frame->renderer->name, pixels,
                         pixels * iso_level_chord_voxels(&q->pyramid->levels[q->level]) / step);
}

/* ---- stats ---- */

void iso_render_stats_sum_up(iso_render_stats *stats, const double *seconds, size_t count)
{
    memcpy(stats->frame_seconds, seconds, count * sizeof *seconds);
    qsort(stats->frame_seconds, count, sizeof *seconds, iso_order_doubles);
    stats->count = count;
    stats->seconds = stats->frame_seconds[0];
    stats->median_seconds = 0.5 * (stats->frame_seconds[(count - 1) / 2] + stats->frame_seconds[count / 2]);
    stats->most_seconds = stats->frame_seconds[count - 1];
}

void iso_render_stats_add(iso_render_stats *stats, const iso_render_stats *more)
{
    double seconds[2 * ISO_RENDER_MAX_FRAMES];
    memcpy(seconds, stats->frame_seconds, stats->count * sizeof *seconds);
    memcpy(seconds + stats->count, more->frame_seconds, more->count * sizeof *seconds);
    const size_t count = stats->count + more->count;
    qsort(seconds, count, sizeof *seconds, iso_order_doubles);
    if (count > 0)
        iso_render_stats_sum_up(stats, seconds, count < ISO_RENDER_MAX_FRAMES ? count : ISO_RENDER_MAX_FRAMES);
}

/* ---- one image ---- */

/* A feature that a view may need. */
typedef struct feature {
    unsigned trait;
    const char *name;
} feature;

static const feature features[] = {{ISO_HAS_ISOSURFACES, "isosurfaces"},
                                   {ISO_HAS_CLIP_PLANES, "clip planes"},
                                   {ISO_HAS_2D_TFS, "2D transfer functions"},
                                   {ISO_HAS_EXTINCTION_SCALES, "extinction scales"},
                                   {ISO_HAS_ROI, "regions of interest"},
                                   {ISO_HAS_LABELS, "label maps"},
                                   {ISO_HAS_LIGHTS, "lights"},
                                   {ISO_HAS_ORTHOGRAPHIC, "orthographic views"}};
enum { FEATURE_COUNT = sizeof features / sizeof *features };

static unsigned traits_of(const iso_pyramid *p, const iso_view *view, bool isosurface)
{
    return (isosurface ? ISO_HAS_ISOSURFACES : 0u) | (view->clip_count > 0 ? ISO_HAS_CLIP_PLANES : 0u) |
           (view->tf_2d ? ISO_HAS_2D_TFS : 0u) | (view->extinction_scale ? ISO_HAS_EXTINCTION_SCALES : 0u) |
           (view->roi ? ISO_HAS_ROI : 0u) | (p->levels[0].labels ? ISO_HAS_LABELS : 0u) |
           (iso_view_is_lit(view) ? ISO_HAS_LIGHTS : 0u) | (view->camera.orthographic ? ISO_HAS_ORTHOGRAPHIC : 0u);
}

/* Returns the first of these features that the renderer lacks, or NULL. */
static const feature *find_lacking(const iso_renderer_info *r, unsigned traits)
{
    for (size_t i = 0; i < FEATURE_COUNT; ++i)
        if (traits & features[i].trait && !iso_renderer_has(r, features[i].trait))
            return &features[i];
    return NULL;
}

const char *iso_renderer_lacks(const iso_renderer_info *r, const iso_pyramid *p, const iso_view *view, bool isosurface)
{
    const feature *lacking = find_lacking(r, traits_of(p, view, isosurface));
    return lacking ? lacking->name : NULL;
}

json_t *iso_renderer_features(const iso_renderer_info *r, bool lacking)
{
    json_t *list = json_array();
    for (size_t i = 0; i < FEATURE_COUNT; ++i)
        if (iso_renderer_has(r, features[i].trait) != lacking)
            json_array_append_new(list, json_string(features[i].name));
    return list;
}

/* Refuses a request with a feature that the renderer lacks, since it would draw another scene. */
static iso_status check(const iso_render_request *q, iso_error *err)
{
    char names[256];
    const iso_renderer_info *r = q->options->renderer;
    const feature *lacking = find_lacking(r, traits_of(q->pyramid, q->view, q->options->isosurface));
    NEED(iso_pyramid_check_level(q->pyramid, NULL, q->level, err));
    if (lacking)
        return iso_fail(err, ISO_E_USAGE, "%s are rendered by %s, not by %s", lacking->name,
                        iso_renderers_with(lacking->trait, ", ", " and ", names, sizeof names), r->name);
    /* Values between two labels are neither a third label nor a surface. */
    if (q->pyramid->levels[0].labels && (q->options->isosurface || q->view->roi || q->view->tf_2d ||
                                         q->options->quadrature == ISO_QUADRATURE_PREINTEGRATED))
        return iso_fail(
            err, ISO_E_USAGE,
            "label maps are rendered only by samples of a one-dimensional transfer function: no isosurface, "
            "pre-integration or region of interest; --no-labels interpolates");
    return ISO_OK;
}

static iso_status apply_hook(const iso_render_request *q, iso_image *image, iso_error *err)
{
    const iso_image_hook *after = &q->renderers->after;
    const iso_status status = after->change ? after->change(after->user, q, image, err) : ISO_OK;
    if (status != ISO_OK)
        iso_image_destroy(image);
    return status;
}

static iso_status find_or_draw(const iso_render_request *frame, iso_image *image, double *seconds, iso_error *err)
{
    const iso_render_options *opt = frame->options;
    const bool is_program = iso_renderer_has(opt->renderer, ISO_IS_PROGRAM);
    iso_render_stats stats = {0};
    if (iso_picture_store_find(frame->renderers->store, frame, opt, image))
        return ISO_OK;
    const double start = iso_clock_seconds();
    iso_status status = opt->renderer->render(frame, image, &stats, err);
    count_picture(frame, opt);
    const double all = iso_clock_seconds() - start;
    if (stats.count == 0)
        iso_render_stats_sum_up(&stats, &all, 1);
    if (is_program)
        stats.setup_seconds = fmax(all - stats.seconds, 0);
    TRY(status, apply_hook(frame, image, err));
    if (status == ISO_OK)
        iso_picture_store_put(frame->renderers->store, frame, opt, image);
    if (seconds) /* without the textures if they are measured apart: frames are drawn repeatedly */
        *seconds = !is_program && stats.setup_seconds > 0 ? stats.seconds : all;
    if (opt->stats)
        *opt->stats = stats;
    return status;
}

iso_status iso_render_with(const iso_render_request *frame, iso_image *image, double *seconds, iso_error *err)
{
    struct iso_picture_store *store = frame->renderers->store;
    *image = (iso_image){0};
    NEED(check(frame, err));
    const uint64_t claim = iso_picture_store_claim(store, frame, frame->options);
    iso_status status = find_or_draw(frame, image, seconds, err);
    iso_picture_store_release(store, claim);
    return status;
}

/* ---- several images ---- */

/* Renders all frames in one start of a program. */
static iso_status render_in_one_start(const iso_render_request *q, size_t count, iso_image *images, iso_error *err)
{
    iso_render_request one = *q;
    NEED(check(q, err));
    NEED(q->options->renderer->render_several(q, count, images, err));
    for (size_t i = 0; i < count; ++i) {
        one.options = &q->options[i];
        count_picture(q, one.options);
        NEED(apply_hook(&one, &images[i], err));
    }
    return ISO_OK;
}

static iso_status render_each(const iso_render_request *q, size_t count, iso_image *images, iso_error *err)
{
    iso_render_request one = *q;
    for (size_t i = 0; i < count; ++i) {
        one.options = &q->options[i];
        NEED(iso_render_with(&one, &images[i], NULL, err));
    }
    return ISO_OK;
}

static iso_status render_several(const iso_render_request *q, size_t count, iso_image *images, iso_error *err)
{
    const bool is_one_start = count > 0 && q->options->renderer->render_several && !getenv(ISO_RENDERERS_APART);
    memset(images, 0, count * sizeof *images);
    const iso_status status = (is_one_start ? render_in_one_start : render_each)(q, count, images, err);
    for (size_t i = 0; i < count && status != ISO_OK; ++i)
        iso_image_destroy(&images[i]);
    return status;
}

/* Takes stored images from the store, and renders the others by one call. */
static iso_status render_stored(const iso_render_request *q, size_t count, iso_image *images, iso_error *err)
{
    struct iso_picture_store *store = q->renderers->store;
    FREED iso_render_options *frames = malloc(count * sizeof *frames);
    FREED iso_image *drawn = calloc(count, sizeof *drawn);
    iso_render_request rest = *q;
    size_t lacking = 0;
    iso_status status = frames && drawn ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for %zu images", count);
    const uint64_t claim = count > 0 ? iso_picture_store_claim(store, q, q->options) : 0;
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        if (!iso_picture_store_find(q->renderers->store, q, &q->options[i], &images[i]))
            frames[lacking++] = q->options[i];
    rest.options = frames;
    if (status == ISO_OK && lacking > 0)
        status = render_several(&rest, lacking, drawn, err);
    for (size_t i = 0, next = 0; i < count && status == ISO_OK; ++i)
        if (!images[i].rgba) {
            images[i] = drawn[next++];
            iso_picture_store_put(store, q, &q->options[i], &images[i]);
        }
    iso_picture_store_release(store, claim);
    for (size_t i = 0; i < count && status != ISO_OK; ++i)
        iso_image_destroy(&images[i]);
    return status;
}

iso_status iso_render_check_finite(const iso_renderer_info *r, const iso_image *image, iso_error *err)
{
    return iso_image_is_finite(image)
               ? ISO_OK
               : iso_fail(err, ISO_E_PROGRAM, "%s: the picture has values that are not finite", r->title);
}

iso_status iso_render_several(const iso_render_request *frames, size_t count, iso_image *images, iso_error *err)
{
    memset(images, 0, count * sizeof *images);
    if (frames->renderers->several)
        return frames->renderers->several(frames, count, images, err);
    return frames->renderers->store && frames->options->renderer->render_several && !getenv(ISO_RENDERERS_APART)
               ? render_stored(frames, count, images, err)
               : render_several(frames, count, images, err);
}

/* ---- several scenes ---- */

/* Takes stored images from the store, and draws the others in one start. */
static iso_status render_together(const iso_render_request *scenes, size_t count, iso_image *images, iso_error *err)
{
    iso_render_request lacking[ISO_RENDER_MAX_SCENES];
    iso_image drawn[ISO_RENDER_MAX_SCENES] = {{0}};
    size_t n = 0, next = 0;
    iso_status status = ISO_OK;
    const uint64_t claim = iso_picture_store_claim(scenes->renderers->store, scenes, scenes->options);
    for (size_t i = 0; i < count && status == ISO_OK; ++i) {
        status = check(&scenes[i], err);
        if (status == ISO_OK &&
            !iso_picture_store_find(scenes[i].renderers->store, &scenes[i], scenes[i].options, &images[i]))
            lacking[n++] = scenes[i];
    }
    if (status == ISO_OK && n > 0)
        status = scenes->options->renderer->render_scenes(lacking, n, drawn, err);
    for (size_t i = 0; i < n && status == ISO_OK; ++i) {
        count_picture(&lacking[i], lacking[i].options);
        status = apply_hook(&lacking[i], &drawn[i], err);
        if (status == ISO_OK)
            iso_picture_store_put(scenes->renderers->store, &lacking[i], lacking[i].options, &drawn[i]);
    }
    iso_picture_store_release(scenes->renderers->store, claim);
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        if (!images[i].rgba)
            images[i] = drawn[next++];
    for (size_t i = 0; i < n && status != ISO_OK; ++i)
        iso_image_destroy(&drawn[i]);
    return status;
}

iso_status iso_render_scenes(const iso_render_request *scenes, size_t count, iso_image *images, iso_error *err)
{
    iso_status status = ISO_OK;
    memset(images, 0, count * sizeof *images);
    if (count > ISO_RENDER_MAX_SCENES)
        return iso_fail(err, ISO_E_RANGE, "%zu scenes at once, at most %d", count, ISO_RENDER_MAX_SCENES);
    if (count > 1 && scenes->options->renderer->render_scenes && !getenv(ISO_RENDERERS_APART))
        status = render_together(scenes, count, images, err);
    else
        for (size_t i = 0; i < count && status == ISO_OK; ++i)
            status = iso_render_with(&scenes[i], &images[i], NULL, err);
    for (size_t i = 0; i < count && status != ISO_OK; ++i)
        iso_image_destroy(&images[i]);
    return status;
}
