/* SPDX-License-Identifier: MIT */
/* gl.c - the OpenGL ray caster, on a GPU or in software. */
#include "renderers/gl.h"

#include <stdio.h>

iso_status iso_renderers_need_gl(iso_renderers *r, iso_gl **gl, iso_error *err)
{
    void **kept = iso_renderers_kept(r, &iso_renderer_gl);
    iso_gl *made = *kept;
    const iso_status status = made ? ISO_OK : iso_gl_create(&made, r->shader_dir, err);
    *kept = *gl = made;
    return status;
}

static void end(void *kept)
{
    iso_gl_destroy(kept);
}

_Static_assert(ISO_GL_MAX_DRAWS <= ISO_RENDER_MAX_FRAMES, "the stats hold all draws");

void iso_render_stats_of_gl(const iso_gl_stats *inside, iso_render_stats *stats)
{
    iso_render_stats_sum_up(stats, inside->draw_seconds, inside->draw_count);
    stats->setup_seconds = inside->upload_seconds;
    stats->bytes = inside->texture_bytes;
}

static iso_status version(const iso_renderer_info *self, iso_renderers *r, char *text, size_t size, iso_error *err)
{
    (void)self;
    iso_gl *gl;
    NEED(iso_renderers_need_gl(r, &gl, err));
    const iso_gl_info info = iso_gl_describe(gl);
    const int written = snprintf(text, size, "%s, OpenGL %s", info.renderer, info.version);
    /* Precision of the linear filter, if it is less than a float's 24 bits. */
    if (info.filter_bits_float < ISO_GL_FINE_FILTER_BITS && written > 0 && (size_t)written < size)
        snprintf(text + written, size - (size_t)written, ", linear filter of %d bits", info.filter_bits_float);
    return ISO_OK;
}

static iso_status render(const iso_render_request *q, iso_image *image, iso_render_stats *stats, iso_error *err)
{
    const iso_render_options *opt = q->options;
    const iso_surface surface = {.iso = opt->iso};
    iso_gl_stats inside = {0};
    iso_gl_options o = iso_gl_defaults();
    iso_gl *gl;
    o.source = opt->source;
    o.step_voxels = opt->step_voxels;
    o.shade_table = opt->shade_table;
    o.preintegrated = opt->quadrature == ISO_QUADRATURE_PREINTEGRATED;
    o.surface = opt->isosurface ? &surface : NULL;
    o.repeats = opt->repeats;
    o.repeat_seconds = opt->repeat_seconds;
    o.exact_lookups = opt->exact_lookups;
    o.fast_filter = opt->repeats > 1 || opt->repeat_seconds > 0; /* timed frames use the filter of a viewer */
    o.stats = &inside;
    NEED(iso_renderers_need_gl(q->renderers, &gl, err));
    if (opt->processor_time)
        iso_gl_time_processor(gl, true);
    NEED(iso_gl_render(gl, &q->pyramid->levels[q->level], q->pyramid->options.code, q->view, &o, image, err));
    iso_render_stats_of_gl(&inside, stats);
    return ISO_OK;
}

/* A texture coordinate in float is off by up to 3e-8 of the volume. A steep value at a table whose neighboring entries
 * differ by most of an opacity turns that into about 1e-5. With exact lookups, only texels, colors and the sums of a
 * ray are floats: at most 2e-7 and 5e-6 were observed, at a step of opacity 0.9999 (doc/results/deviations.md).
 *
 * Values can be steep where the TF is not (the padding of a CT), and a direction near zero can flip. A gradient on
 * the fly is a difference of two filtered values, each off by up to two last bits, over ISO_ON_THE_FLY_EPS of the
 * range: at most 2.4e-7 / 1e-4 = 2.4e-3 of the diffuse light. Exact lookups tell the rounding of texture units from
 * a fault. If exact lookups are within their limits, single pixels may differ by half a step of 8 bits, and the
 * whole image by the limit of steep TFs. Observed: 1.3e-6 and 3.4e-4. */
static const iso_lock_step lock_step = {
    .quadrature = ISO_QUADRATURE_MIDPOINT,
    .smooth = {.rmse = 1e-6, .max_abs = 2e-5},
    .sharp = {.rmse = 5e-6, .max_abs = 2e-4},
    .why = "the same samples, at texture coordinates in float, which are off by 3e-8 of the volume",
    .exact = {.rmse = 5e-7, .max_abs = 1e-5},
    .exact_why = "the same samples, filtered and classified in double; texels, colors and sums are floats",
    .rounded = {.rmse = 5e-6, .max_abs = 1.0 / 510},
    .rounded_why = "the same samples are within their limits if filtered and classified in double; rounding of texture "
                   "coordinates and filters in float adds at most half a step of 8 bits to single pixels",
};

const iso_renderer_info iso_renderer_gl = {
    .name = "gl",
    .title = "OpenGL ray caster",
    .color = "#0072b2",
    .traits = ISO_HAS_ALL_SCENES | ISO_HAS_LABELS | ISO_HAS_LIMIT | ISO_HAS_ISOSURFACES | ISO_HAS_BRICKS |
              ISO_HAS_PROCESSOR_TIME | ISO_READS_SOURCE | ISO_READS_QUADRATURE | ISO_READS_SHADE_TABLE |
              ISO_READS_EXACT_LOOKUPS | ISO_READS_SHADERS,
    .quadratures = 1u << ISO_QUADRATURE_MIDPOINT | 1u << ISO_QUADRATURE_PREINTEGRATED,
    .defaults = {.source = ISO_FROM_CODES, .quadrature = ISO_QUADRATURE_MIDPOINT},
    .sample_seconds = 4e-9,
    .first_step_voxels = 1.0 / 16, /* costs nothing */
    .lock_step = &lock_step,
    .version = version,
    .render = render,
    .end = end,
};
