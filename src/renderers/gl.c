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
    const iso_status status = iso_renderers_need_gl(r, &gl, err);
    if (status != ISO_OK)
        return status;
    const iso_gl_info info = iso_gl_describe(gl);
    const int written = snprintf(text, size, "%s, OpenGL %s", info.renderer, info.version);
    /* What limits its pictures, where that is not the float's own 24 bits. */
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
    o.fast_filter = opt->repeats > 1 || opt->repeat_seconds > 0; /* what is timed is drawn as a viewer would draw it */
    o.stats = &inside;
    iso_status status = iso_renderers_need_gl(q->renderers, &gl, err);
    if (status == ISO_OK && opt->processor_time)
        iso_gl_time_processor(gl, true);
    TRY(status, iso_gl_render(gl, &q->pyramid->levels[q->level], q->pyramid->options.code, q->view, &o, image, err));
    if (status == ISO_OK)
        iso_render_stats_of_gl(&inside, stats);
    return status;
}

/* A texture coordinate in float is up to 3e-8 of the volume off; where a steep value meets a table whose neighboring
 * entries differ by most of an opacity, that becomes some 1e-5. With exact lookups floats of texels, colors and a ray's sums
 * are left: 2e-7 and 5e-6 at most were seen, at a step of opacity 0.9999 (doc/results/deviations.md).
 *
 * Values can be steep where the TF is not (the padding of a CT), and where a direction is nearly zero it turns at once. A
 * gradient on the fly is a difference of two filtered values, each rounded by up to two last bits, over
 * ISO_ON_THE_FLY_EPS of the range: 2.4e-7 / 1e-4 = 2.4e-3 of the diffuse light at most. So what texture units round is told
 * from a fault by exact lookups: where those hold, half a step of 8 bits is left to single pixels, and to the image as a
 * whole what steep TFs have. 1.3e-6 and 3.4e-4 were seen. */
static const iso_lock_step lock_step = {
    .quadrature = ISO_QUADRATURE_MIDPOINT,
    .smooth = {.rmse = 1e-6, .max_abs = 2e-5},
    .sharp = {.rmse = 5e-6, .max_abs = 2e-4},
    .why = "the same samples at texture coordinates in float, 3e-8 of the volume off",
    .exact = {.rmse = 5e-7, .max_abs = 1e-5},
    .exact_why = "the same samples, filtered and classified in double: floats of texels, colors and sums are left",
    .rounded = {.rmse = 5e-6, .max_abs = 1.0 / 510},
    .rounded_why =
        "filtered and classified in double the same samples are within their limits, so that what is more is "
        "what texture coordinates and filters in float round: half a step of 8 bits is left to single pixels",
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
