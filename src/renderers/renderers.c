/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "renderers/renderers.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/version.h"
#include "blender/blender.h"
#include "povray/povray.h"

static const struct {
    const char *name, *title;
} renderers[ISO_RENDERER_COUNT] = {
#define ISO_RENDERER_ROW(value, text, title) [value] = {text, title},
    ISO_RENDERER_LIST(ISO_RENDERER_ROW)
#undef ISO_RENDERER_ROW
};

const char *iso_renderer_name(iso_renderer r) { return renderers[r].name; }
const char *iso_renderer_title(iso_renderer r) { return renderers[r].title; }

bool iso_renderer_has_isosurfaces(iso_renderer r) { return r != ISO_WITH_CYCLES; }

iso_status iso_renderer_from_name(const char *name, iso_renderer *r, iso_error *err)
{
    for (int i = 0; i < ISO_RENDERER_COUNT; ++i)
        if (strcmp(renderers[i].name, name) == 0) {
            *r = (iso_renderer)i;
            return ISO_OK;
        }
    return iso_fail(err, ISO_E_USAGE, "no renderer is called \"%s\"; wanted reference, gl, cycles or povray", name);
}

iso_status iso_renderers_from_list(const char *list, bool wanted[ISO_RENDERER_COUNT], iso_error *err)
{
    for (int i = 0; i < ISO_RENDERER_COUNT; ++i)
        wanted[i] = !list;
    wanted[ISO_WITH_REFERENCE] = true;
    if (!list)
        return ISO_OK;
    char *copy = strdup(list), *rest = copy;
    iso_status status = copy ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "out of memory");
    for (char *name; status == ISO_OK && (name = strsep(&rest, ","));) {
        iso_renderer r = ISO_WITH_REFERENCE;
        status = iso_renderer_from_name(name, &r, err);
        if (status == ISO_OK)
            wanted[r] = true;
    }
    free(copy);
    return status;
}

iso_render_options iso_render_defaults(iso_renderer r)
{
    /* Exports carry decoded directions; the arbiter compares like with like. For linear codes it is the same. */
    return (iso_render_options){.renderer = r, .source = ISO_FROM_CODES, .quadrature = ISO_QUADRATURE_CONVERGED};
}

void iso_renderers_end(iso_renderers *r)
{
    iso_gl_destroy(r->gl);
    *r = (iso_renderers){0};
}

iso_status iso_renderers_need_gl(iso_renderers *r, iso_error *err)
{
    return r->gl ? ISO_OK : iso_gl_create(&r->gl, r->shader_dir, err);
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The fastest, the middle and the slowest of at least one frame. */
static void sum_up(iso_render_stats *stats, const double *seconds, size_t count)
{
    memcpy(stats->frame_seconds, seconds, count * sizeof *seconds);
    qsort(stats->frame_seconds, count, sizeof *seconds, by_value);
    stats->count = count;
    stats->seconds = stats->frame_seconds[0];
    stats->median_seconds = 0.5 * (stats->frame_seconds[(count - 1) / 2] + stats->frame_seconds[count / 2]);
    stats->most_seconds = stats->frame_seconds[count - 1];
}

void iso_render_stats_add(iso_render_stats *stats, const iso_render_stats *more)
{
    double seconds[2 * ISO_GL_MAX_DRAWS];
    memcpy(seconds, stats->frame_seconds, stats->count * sizeof *seconds);
    memcpy(seconds + stats->count, more->frame_seconds, more->count * sizeof *seconds);
    const size_t count = stats->count + more->count;
    qsort(seconds, count, sizeof *seconds, by_value);
    if (count > 0)
        sum_up(stats, seconds, count < ISO_GL_MAX_DRAWS ? count : ISO_GL_MAX_DRAWS);
}

static iso_status render_gl(iso_renderers *r, const iso_level *level, iso_code code, const iso_view *view,
                            const iso_render_options *opt, iso_image *image, iso_render_stats *stats, iso_error *err)
{
    iso_gl_stats inside = {0};
    iso_gl_options o = iso_gl_defaults();
    const iso_surface surface = {.iso = opt->iso};
    o.source = opt->source;
    o.step_voxels = opt->step_voxels;
    o.shade_table = opt->shade_table;
    o.exact_lookups = opt->exact_lookups;
    o.preintegrated = opt->quadrature == ISO_QUADRATURE_PREINTEGRATED;
    o.surface = opt->isosurface ? &surface : NULL;
    o.repeats = opt->repeats;
    o.repeat_seconds = opt->repeat_seconds;
    o.stats = &inside;
    iso_status status = iso_renderers_need_gl(r, err);
    if (status == ISO_OK && opt->processor_time)
        iso_gl_time_processor(r->gl, true);
    if (status == ISO_OK)
        status = iso_gl_render(r->gl, level, code, view, &o, image, NULL, err);
    if (status == ISO_OK)
        iso_render_stats_of_gl(&inside, stats);
    return status;
}

void iso_render_stats_of_gl(const iso_gl_stats *inside, iso_render_stats *stats)
{
    sum_up(stats, inside->draw_seconds, inside->draw_count);
    stats->setup_seconds = inside->upload_seconds;
    stats->bytes = inside->texture_bytes;
}

/* What the reference reads of a level: floats of the scalar, and codes or floats of the directions. */
static double reference_bytes(const iso_level *level, iso_direction_source source)
{
    const double direction = source == ISO_FROM_ON_THE_FLY                                       ? 0
                             : source == ISO_FROM_FLOAT                                          ? 3 * sizeof(float)
                             : source == ISO_FROM_PALETTE || source == ISO_FROM_PALETTE_NEAREST ? sizeof(uint16_t)
                                                                                                 : 3;
    return (double)iso_geometry_voxel_count(&level->geometry) * (sizeof(float) + direction);
}

static iso_status render_reference(const iso_level *level, iso_code code, const iso_view *view, const iso_render_options *opt,
                                   iso_image *image, iso_render_stats *stats, const iso_progress *progress, iso_error *err)
{
    double seconds[ISO_GL_MAX_DRAWS], sum = 0, (*clock)(void) = opt->processor_time ? iso_cpu_seconds : iso_clock_seconds;
    size_t count = 0;
    iso_reference_options o = iso_reference_defaults();
    o.quadrature = opt->isosurface ? ISO_QUADRATURE_FIRST_HIT : opt->quadrature;
    o.iso = opt->iso;
    o.source = opt->source;
    o.step_voxels = opt->step_voxels;
    o.threads = opt->threads;
    if (opt->intervals)
        o.intervals = opt->intervals;
    iso_status status = ISO_OK;
    do {
        iso_image_destroy(image);
        const double start = clock();
        status = iso_reference_render(level, code, view, &o, image, progress, err);
        sum += seconds[count++] = clock() - start;
    } while (status == ISO_OK && count < opt->repeats && count < ISO_GL_MAX_DRAWS && sum < opt->repeat_seconds);
    sum_up(stats, seconds, count);
    stats->bytes = reference_bytes(level, opt->source);
    return status;
}

static iso_blender_options blender_options(const iso_render_options *opt)
{
    iso_blender_options o = iso_blender_defaults();
    if (opt->step_voxels > 0)
        o.step_voxels = opt->step_voxels;
    if (opt->samples)
        o.samples = opt->samples;
    o.seed = opt->seed;
    o.threads = opt->threads;
    return o;
}

static iso_status render_cycles(const iso_pyramid *p, size_t level, const iso_view *view, const iso_render_options *opt,
                                iso_image *image, iso_render_stats *stats, const iso_progress *progress, iso_error *err)
{
    iso_blender_options o = blender_options(opt);
    iso_cycles_stats inside = {0};
    o.stats = &inside;
    iso_status status = iso_cycles_render(p, level, view, &o, image, progress, err);
    inside.render_seconds -= inside.load_seconds;
    sum_up(stats, &inside.render_seconds, 1);
    stats->bytes = inside.device_bytes;
    return status;
}

/* As few pieces of equally many intervals, at most 255, as make the longest chord's step at most step_voxels. */
static void set_povray_step(const iso_geometry *g, const iso_view *view, double step_voxels, iso_povray_options *o)
{
    double chord_voxels = 2 * iso_geometry_box_radius_mm(g) / iso_geometry_min_spacing_mm(iso_view_step_geometry(view, g));
    double intervals = chord_voxels / step_voxels, most = ISO_POVRAY_MAX_INTERVALS;
    double pieces = fmin(fmax(ceil(intervals / most), 1), ISO_POVRAY_MAX_PLANES + 1);
    o->intervals = (size_t)fmin(fmax(ceil(intervals / pieces), 1), most);
    o->planes = (size_t)pieces - 1;
    o->extrapolate = false;
}

static iso_status render_povray(const iso_pyramid *p, size_t level, const iso_view *view, const iso_render_options *opt,
                                iso_image *image, iso_render_stats *stats, const iso_progress *progress, iso_error *err)
{
    iso_povray_options o = iso_povray_defaults();
    iso_povray_stats inside = {0};
    o.stats = &inside;
    if (opt->intervals) {
        o.intervals = opt->intervals;
        o.planes = opt->planes;
        o.extrapolate = opt->extrapolate;
    } else if (opt->step_voxels > 0) {
        set_povray_step(&p->levels[level].geometry, view, opt->step_voxels, &o);
    }
    o.float_directions = opt->source == ISO_FROM_FLOAT;
    o.isosurface = opt->isosurface;
    o.iso = opt->iso;
    o.threads = opt->threads;
    iso_status status = iso_povray_render(p, level, view, &o, image, progress, err);
    sum_up(stats, opt->processor_time ? &inside.processor_seconds : &inside.trace_seconds, 1);
    stats->bytes = inside.df3_bytes;
    return status;
}

iso_status iso_render_with(iso_renderers *r, const iso_pyramid *p, size_t level, const iso_view *view,
                           const iso_render_options *opt, iso_image *image, double *seconds,
                           const iso_progress *progress, iso_error *err)
{
    *image = (iso_image){0};
    if (level >= p->level_count)
        return iso_fail(err, ISO_E_RANGE, "level %zu: the pyramid has levels 0 to %zu", level, p->level_count - 1);
    if (opt->isosurface && !iso_renderer_has_isosurfaces(opt->renderer))
        return iso_fail(err, ISO_E_USAGE, "isosurfaces are rendered by reference, gl and povray, not by %s",
                        iso_renderer_name(opt->renderer));
    const iso_level *l = &p->levels[level];
    const double start = iso_clock_seconds();
    iso_render_stats stats = {0};
    iso_status status = ISO_OK;
    switch (opt->renderer) {
    case ISO_WITH_GL: status = render_gl(r, l, p->options.code, view, opt, image, &stats, err); break;
    case ISO_WITH_CYCLES: status = render_cycles(p, level, view, opt, image, &stats, progress, err); break;
    case ISO_WITH_POVRAY: status = render_povray(p, level, view, opt, image, &stats, progress, err); break;
    default: status = render_reference(l, p->options.code, view, opt, image, &stats, progress, err); break;
    }
    const double all = iso_clock_seconds() - start;
    const bool is_other_program = opt->renderer == ISO_WITH_CYCLES || opt->renderer == ISO_WITH_POVRAY;
    if (is_other_program)
        stats.setup_seconds = fmax(all - stats.seconds, 0);
    if (status == ISO_OK)
        iso_planted_spoil(r->planted, image);
    if (seconds)
        *seconds = opt->renderer == ISO_WITH_GL ? stats.seconds : all;
    if (opt->stats)
        *opt->stats = stats;
    return status;
}

static iso_status render_cycles_frames(const iso_pyramid *p, size_t level, const iso_view *view, const iso_render_options *frames,
                                       size_t count, iso_image *images, const iso_progress *progress, iso_error *err)
{
    iso_blender_options *o = malloc(count * sizeof *o);
    if (!o)
        return iso_fail(err, ISO_E_MEMORY, "no memory for %zu images", count);
    for (size_t i = 0; i < count; ++i)
        o[i] = blender_options(&frames[i]);
    iso_status status = iso_cycles_render_frames(p, level, view, o, count, images, progress, err);
    free(o);
    return status;
}

static iso_status render_several(iso_renderers *r, const iso_pyramid *p, size_t level, const iso_view *view,
                                 const iso_render_options *frames, size_t count, iso_image *images,
                                 const iso_progress *progress, iso_error *err)
{
    iso_status status = ISO_OK;
    memset(images, 0, count * sizeof *images);
    if (count > 0 && level < p->level_count && frames[0].renderer == ISO_WITH_CYCLES) {
        status = render_cycles_frames(p, level, view, frames, count, images, progress, err);
        for (size_t i = 0; i < count && status == ISO_OK; ++i)
            iso_planted_spoil(r->planted, &images[i]);
        return status;
    }
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        status = iso_render_with(r, p, level, view, &frames[i], &images[i], NULL, progress, err);
    for (size_t i = 0; i < count && status != ISO_OK; ++i)
        iso_image_destroy(&images[i]);
    return status;
}

/* ---- images that are there ---- */

void iso_frame_cache_clear(iso_frame_cache *cache)
{
    for (size_t i = 0; i < cache->count; ++i)
        iso_image_destroy(&cache->images[i]);
    free(cache->frames);
    free(cache->images);
    *cache = (iso_frame_cache){0};
}

static bool is_same_frame(const iso_render_options *a, const iso_render_options *b)
{
    return a->renderer == b->renderer && a->source == b->source && a->quadrature == b->quadrature &&
           !(a->step_voxels < b->step_voxels || a->step_voxels > b->step_voxels) && a->intervals == b->intervals &&
           a->planes == b->planes && a->extrapolate == b->extrapolate && a->samples == b->samples && a->seed == b->seed &&
           a->isosurface == b->isosurface && !(a->iso < b->iso || a->iso > b->iso) && a->shade_table == b->shade_table;
}

static const iso_image *find_frame(const iso_frame_cache *cache, const iso_render_options *frame)
{
    for (size_t i = 0; i < cache->count; ++i)
        if (is_same_frame(&cache->frames[i], frame))
            return &cache->images[i];
    return NULL;
}

/* Room for so many more. */
static iso_status grow_cache(iso_frame_cache *cache, size_t more, iso_error *err)
{
    iso_render_options *frames = realloc(cache->frames, (cache->count + more) * sizeof *frames);
    cache->frames = frames ? frames : cache->frames;
    iso_image *images = realloc(cache->images, (cache->count + more) * sizeof *images);
    cache->images = images ? images : cache->images;
    return frames && images ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for %zu images", more);
}

/* Renders what the cache lacks, and copies all. */
static iso_status render_cached(iso_renderers *r, const iso_pyramid *p, size_t level, const iso_view *view,
                                const iso_render_options *frames, size_t count, iso_image *images,
                                const iso_progress *progress, iso_error *err)
{
    iso_frame_cache *cache = r->cache;
    size_t lacking = 0;
    iso_status status = grow_cache(cache, count, err);
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        if (!find_frame(cache, &frames[i]))
            cache->frames[cache->count + lacking++] = frames[i];
    if (status == ISO_OK && lacking > 0)
        status = render_several(r, p, level, view, cache->frames + cache->count, lacking, cache->images + cache->count, progress, err);
    cache->count += status == ISO_OK ? lacking : 0;
    for (size_t i = 0; i < count && status == ISO_OK; ++i) {
        const iso_image *there = find_frame(cache, &frames[i]);
        status = iso_image_create(&images[i], there->width, there->height, err);
        if (status == ISO_OK)
            memcpy(images[i].rgba, there->rgba, 4 * there->width * there->height * sizeof(float));
    }
    for (size_t i = 0; i < count && status != ISO_OK; ++i)
        iso_image_destroy(&images[i]);
    return status;
}

iso_status iso_render_several(iso_renderers *r, const iso_pyramid *p, size_t level, const iso_view *view,
                              const iso_render_options *frames, size_t count, iso_image *images,
                              const iso_progress *progress, iso_error *err)
{
    memset(images, 0, count * sizeof *images);
    return r->cache ? render_cached(r, p, level, view, frames, count, images, progress, err)
                    : render_several(r, p, level, view, frames, count, images, progress, err);
}

iso_status iso_renderer_version(iso_renderers *r, iso_renderer which, char *text, size_t size, iso_error *err)
{
    char version[128] = "";
    iso_status status = ISO_OK;
    text[0] = 0;
    switch (which) {
    case ISO_WITH_GL:
        status = iso_renderers_need_gl(r, err);
        if (status == ISO_OK) {
            iso_gl_info info = iso_gl_describe(r->gl);
            snprintf(text, size, "%s, OpenGL %s", info.renderer, info.version);
        }
        break;
    case ISO_WITH_CYCLES:
        status = iso_blender_version(version, sizeof version, err);
        if (status == ISO_OK)
            snprintf(text, size, "Blender %s", version);
        break;
    case ISO_WITH_POVRAY:
        status = iso_povray_version(version, sizeof version, err);
        if (status == ISO_OK)
            snprintf(text, size, "POV-Ray %s", version);
        break;
    default: snprintf(text, size, "isoshade %s, double precision", ISO_VERSION); break;
    }
    return status;
}
