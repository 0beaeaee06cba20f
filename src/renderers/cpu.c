/* SPDX-License-Identifier: MIT */
/* cpu.c - the ray caster on the CPU, with the samples of the OpenGL ray caster. It needs no GPU. */
#include <stdio.h>

#include "base/parallel.h"
#include "base/version.h"
#include "render/cpu/caster.h"
#include "renderers/renderers.h"

static iso_status version(const iso_renderer_info *self, iso_renderers *r, char *text, size_t size, iso_error *err)
{
    (void)self;
    (void)r, (void)err;
    snprintf(text, size, "isoshade %s, %s", ISO_VERSION, iso_cpu_width_name(iso_cpu_widest()));
    return ISO_OK;
}

static void draw_repeatedly(const iso_cpu_scene *scene, const iso_render_options *opt, iso_image *image,
                            iso_render_stats *stats)
{
    double seconds[ISO_RENDER_MAX_FRAMES];
    const size_t most = opt->repeats < ISO_RENDER_MAX_FRAMES ? opt->repeats : ISO_RENDER_MAX_FRAMES;
    iso_render_stats_sum_up(stats, seconds,
                            iso_cpu_draw_repeatedly(scene, image, most, opt->repeat_seconds, opt->processor_time,
                                                    seconds));
}

ISO_ENDING(end_scene, iso_cpu_scene, iso_cpu_release)

static iso_status render(const iso_render_request *q, iso_image *image, iso_render_stats *stats, iso_error *err)
{
    const iso_render_options *opt = q->options;
    const double start = iso_clock_seconds();
    iso_cpu_options o = iso_cpu_defaults();
    ENDED_BY(end_scene) iso_cpu_scene *scene = NULL;
    o.source = opt->source;
    o.step_voxels = opt->step_voxels;
    o.threads = opt->threads;
    o.once = opt->once;
    NEED(iso_cpu_prepare(&scene, &q->pyramid->levels[q->level], q->pyramid->options.code, q->view, &o, err));
    NEED(iso_image_create(image, q->view->width, q->view->height, err));
    stats->setup_seconds = iso_clock_seconds() - start;
    draw_repeatedly(scene, opt, image, stats);
    stats->bytes = iso_cpu_bytes(scene);
    return ISO_OK;
}

/* Samples have the reference's positions to 2^-24 of a voxel. A filtered value is off by a float's rounding, 6e-8 of
 * the largest value in its cell. This error times the slope of the table is the error of the color, so that steep
 * tables differ most. Opacities, colors, highlights (a float's power) and normals are floats; the sums along a ray
 * are compensated. Observed: 5e-8 and 4e-7 for scenes of the suite, 3e-7 and 5e-6 for steep ones
 * (doc/guide/renderers.md). */
static const iso_lock_step lock_step = {
    .quadrature = ISO_QUADRATURE_MIDPOINT,
    .smooth = {.rmse = 5e-7, .max_abs = 1e-5},
    .sharp = {.rmse = 2e-6, .max_abs = 5e-5},
    .why = "the same samples at the same positions; values, table entries, colors and normals are floats",
};

const iso_renderer_info iso_renderer_cpu = {
    .name = "cpu",
    .title = "CPU ray caster",
    .color = "#e69f00",
    .traits = ISO_HAS_CLIP_PLANES | ISO_HAS_2D_TFS | ISO_HAS_EXTINCTION_SCALES | ISO_HAS_LIGHTS | ISO_HAS_ORTHOGRAPHIC |
              ISO_HAS_LABELS | ISO_HAS_LIMIT | ISO_HAS_BRICKS | ISO_HAS_PROCESSOR_TIME | ISO_READS_SOURCE |
              ISO_TAKES_A_PART | ISO_IS_NAMED,
    .defaults = {.source = ISO_FROM_CODES, .quadrature = ISO_QUADRATURE_MIDPOINT},
    .sample_seconds = 4e-9,
    .first_step_voxels = 1.0 / 16,
    .lock_step = &lock_step,
    .version = version,
    .render = render,
};
