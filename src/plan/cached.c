/* SPDX-License-Identifier: MIT */
#include "plan/cached.h"

#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "brick/pack.h"
#include "render/cpu/mixed.h"

/* 16 bits of the scalar and, in four channels, of the direction. */
enum { BYTES_A_TEXEL = 10, LARGEST_PAGE = 2048 };

typedef struct cache {
    iso_gl *gl; /* NULL: the CPU ray caster */
    const iso_node_levels *nodes;
    const iso_view *view;
    const iso_cached_options *opt;
    iso_plan_errors *plan;
    uint8_t *visible; /* by TF and view */
} cache;

static size_t page_side(const iso_cached_options *o)
{
    return o->page_side > 0 && o->page_side < LARGEST_PAGE ? o->page_side : LARGEST_PAGE;
}

/* Returns the nodes of the visible bricks at the plan's levels. */
static size_t count_nodes(const cache *c)
{
    size_t nodes = 0;
    for (size_t i = 0; i < c->plan->brick_count; ++i) {
        const size_t side = iso_brick_side(c->nodes, c->plan->levels[i]);
        nodes += c->visible[i] ? side * side * side : 0;
    }
    return nodes;
}

/* Returns the bytes of the textures, or of the CPU ray caster's nodes, at the plan's levels. Marks the visible
 * bricks. */
static double bytes_of(cache *c)
{
    const iso_brick_field field = {.nodes = c->nodes, .levels = c->plan->levels, .faces = ISO_FACES_BAKED};
    iso_brick_cull(&field, &c->view->tf, NULL, c->opt->threads, c->visible);
    for (size_t i = 0; i < c->plan->brick_count; ++i)
        c->visible[i] = c->visible[i] && c->plan->footprints[i] > 0;
    if (!c->gl)
        return (iso_view_is_lit(c->view) ? 8.0 : 2.0) * (double)count_nodes(c);
    return BYTES_A_TEXEL * (double)iso_brick_pack_texels(c->nodes, c->plan->levels, c->visible, page_side(c->opt));
}

/* Chooses the wanted predicted error or, if none is given, the least one whose bricks fit, within a hundredth of a
 * decade. */
static iso_status fit(cache *c, double *predicted, iso_error *err)
{
    double low = -9, high = 1; /* decades of the prediction: at 1 all is coarsest */
    if (c->opt->plan_error > 0) {
        *predicted = iso_plan_choose(c->plan, c->nodes, c->opt->plan_error);
        bytes_of(c);
        return ISO_OK;
    }
    *predicted = iso_plan_choose(c->plan, c->nodes, 0);
    if (bytes_of(c) <= c->opt->cache_bytes)
        return ISO_OK;
    iso_plan_choose(c->plan, c->nodes, pow(10, high));
    double least = bytes_of(c);
    if (least > c->opt->cache_bytes)
        return iso_fail(err, ISO_E_RANGE, "--cache-bytes is %g; the coarsest bricks take %g: allow more levels",
                        c->opt->cache_bytes, least);
    while (high - low > 1e-2) {
        double middle = 0.5 * (low + high);
        iso_plan_choose(c->plan, c->nodes, pow(10, middle));
        *(bytes_of(c) <= c->opt->cache_bytes ? &high : &low) = middle;
    }
    *predicted = iso_plan_choose(c->plan, c->nodes, pow(10, high));
    bytes_of(c);
    return ISO_OK;
}

static iso_status draw_by_gl(cache *c, const iso_brick_field *field, iso_image *image, iso_cached_report *r,
                             iso_error *err)
{
    iso_gl_brick_options o = iso_gl_brick_defaults();
    iso_gl_brick_stats stats;
    o.wanted = c->visible;
    o.page_side = page_side(c->opt);
    o.step_voxels = c->opt->step_voxels;
    o.repeats = c->opt->repeats;
    o.repeat_seconds = c->opt->repeat_seconds;
    o.fast_filter = o.repeats > 1 || o.repeat_seconds > 0;
    NEED(iso_gl_render_bricks(c->gl, field, c->view, &o, image, &stats, err));
    r->cache_bytes = BYTES_A_TEXEL * (double)stats.texel_count;
    r->page_count = stats.page_count;
    r->brick_count = stats.shown_count;
    r->node_count = stats.node_count;
    r->seconds = stats.seconds;
    r->draws = stats.gl;
    return ISO_OK;
}

static iso_status draw_by_cpu(cache *c, const iso_brick_field *field, iso_image *image, iso_cached_report *r,
                              iso_error *err)
{
    const double start = iso_clock_seconds();
    const iso_cached_options *opt = c->opt;
    const size_t most = opt->repeats < ISO_GL_MAX_DRAWS ? opt->repeats : ISO_GL_MAX_DRAWS;
    iso_cpu_brick_options o = iso_cpu_brick_defaults();
    iso_cpu_scene *scene;
    o.wanted = c->visible;
    o.step_voxels = opt->step_voxels;
    o.threads = opt->threads;
    iso_status status = iso_cpu_prepare_bricks(&scene, field, c->view, &o, err);
    TRY(status, iso_image_create(image, c->view->width, c->view->height, err));
    if (status == ISO_OK) {
        iso_gl_stats *s = &r->draws;
        s->upload_seconds = iso_clock_seconds() - start;
        s->texture_bytes = iso_cpu_bytes(scene);
        s->draw_count = iso_cpu_draw_repeatedly(scene, image, most, opt->repeat_seconds, opt->processor_time,
                                                s->draw_seconds);
        r->seconds = INFINITY;
        for (size_t i = 0; i < s->draw_count; ++i)
            r->seconds = fmin(r->seconds, s->draw_seconds[i]);
        r->cache_bytes = bytes_of(c);
        r->page_count = 1;
        r->node_count = count_nodes(c);
        for (size_t i = 0; i < c->plan->brick_count; ++i)
            r->brick_count += c->visible[i];
    }
    iso_cpu_release(scene);
    return status;
}

static iso_status draw(cache *c, iso_image *image, iso_cached_report *r, iso_error *err)
{
    const iso_brick_field field = {.nodes = c->nodes, .levels = c->plan->levels, .faces = ISO_FACES_BAKED};
    NEED(c->gl ? draw_by_gl(c, &field, image, r, err) : draw_by_cpu(c, &field, image, r, err));
    for (size_t i = 0; i < c->plan->brick_count; ++i)
        r->bricks_by_level[c->plan->levels[i]] += c->visible[i];
    if (c->opt->cache_bytes > 0 && r->cache_bytes > c->opt->cache_bytes) {
        iso_image_destroy(image);
        return iso_fail(err, ISO_E_RANGE, "the cache takes %g bytes, at most %g are allowed", r->cache_bytes,
                        c->opt->cache_bytes);
    }
    return ISO_OK;
}

iso_status iso_cached_render_nodes(iso_gl *gl, const iso_node_levels *nodes, iso_plan_errors *plan,
                                   const iso_view *view, const iso_cached_options *opt, iso_image *image,
                                   iso_error *err)
{
    cache c = {.gl = gl, .nodes = nodes, .view = view, .opt = opt, .plan = plan, .visible = malloc(plan->brick_count)};
    iso_cached_report report = {0};
    *image = (iso_image){0};
    iso_status status = c.visible ? fit(&c, &report.predicted_rmse, err)
                                  : iso_fail(err, ISO_E_MEMORY, "no memory for %zu bricks", plan->brick_count);
    TRY(status, draw(&c, image, &report, err));
    if (opt->report)
        *opt->report = report;
    free(c.visible);
    return status;
}

iso_status iso_cached_render(iso_gl *gl, const iso_level *level0, const iso_view *view, const iso_cached_options *opt,
                             iso_image *image, const iso_progress *progress, iso_error *err)
{
    OWNED(iso_node_levels) nodes = {0};
    OWNED(iso_plan_errors) plan = {0};
    if (opt->report)
        *opt->report = (iso_cached_report){0};
    *image = (iso_image){0};
    NEED(iso_node_levels_begin(&nodes, level0, opt->brick_voxels, opt->level_count, opt->threads, err));
    NEED(iso_node_levels_complete(&nodes, opt->threads, err));
    NEED(iso_plan_errors_create(&plan, &nodes, view, 1, opt->threads, progress, err));
    return iso_cached_render_nodes(gl, &nodes, &plan, view, opt, image, err);
}
