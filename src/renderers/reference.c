/* SPDX-License-Identifier: MIT */
/* reference.c - the reference: double precision on the CPU. The other renderers are compared with it. */
#include <stdio.h>

#include "base/parallel.h"
#include "base/version.h"
#include "renderers/renderers.h"

static iso_status version(const iso_renderer_info *self, iso_renderers *r, char *text, size_t size, iso_error *err)
{
    (void)self;
    (void)r, (void)err;
    snprintf(text, size, "isoshade %s, double precision", ISO_VERSION);
    return ISO_OK;
}

/* Returns the bytes that it reads of a level: floats of the scalar, and codes or floats of the directions. */
static double bytes_of(const iso_level *level, iso_direction_source source)
{
    const double direction = source == ISO_FROM_ON_THE_FLY                                      ? 0
                             : source == ISO_FROM_FLOAT                                         ? 3 * sizeof(float)
                             : source == ISO_FROM_PALETTE || source == ISO_FROM_PALETTE_NEAREST ? sizeof(uint16_t)
                                                                                                : 3;
    return (double)iso_geometry_voxel_count(&level->geometry) * (sizeof(float) + direction);
}

static iso_status render(const iso_render_request *q, iso_image *image, iso_render_stats *stats, iso_error *err)
{
    const iso_render_options *opt = q->options;
    const iso_level *level = &q->pyramid->levels[q->level];
    double seconds[ISO_RENDER_MAX_FRAMES], sum = 0,
                                           (*clock)(void) = opt->processor_time ? iso_cpu_seconds : iso_clock_seconds;
    size_t count = 0;
    iso_reference_options o = iso_reference_defaults();
    o.quadrature = opt->isosurface ? ISO_QUADRATURE_FIRST_HIT : opt->quadrature;
    o.iso = opt->iso;
    o.source = opt->source;
    o.step_voxels = opt->step_voxels;
    o.threads = opt->threads;
    if (opt->intervals)
        o.intervals = opt->intervals;
    o.planes = opt->planes;
    iso_reference_result result = {NULL, NAN, false};
    o.result = &result;
    iso_status status = ISO_OK;
    do {
        iso_image_destroy(image);
        const double start = clock();
        status = iso_reference_render(level, q->pyramid->options.code, q->view, &o, image, q->progress, err);
        sum += seconds[count++] = clock() - start;
    } while (status == ISO_OK && count < opt->repeats && count < ISO_RENDER_MAX_FRAMES && sum < opt->repeat_seconds);
    iso_render_stats_sum_up(stats, seconds, count);
    stats->bytes = bytes_of(level, opt->source);
    if (o.quadrature == ISO_QUADRATURE_CONVERGED) {
        stats->error = result.error;
        stats->is_proved = result.is_proved;
    }
    return status;
}

const iso_renderer_info iso_renderer_reference = {
    .name = "reference",
    .title = "Reference",
    .stages = {"reference"},
    .color = "#222222",
    .traits = ISO_HAS_ALL_SCENES | ISO_HAS_LABELS | ISO_HAS_ISOSURFACES | ISO_HAS_PROCESSOR_TIME | ISO_READS_SOURCE |
              ISO_READS_QUADRATURE | ISO_READS_INTERVALS | ISO_READS_PLANES,
    .quadratures = 1u << ISO_QUADRATURE_CONVERGED | 1u << ISO_QUADRATURE_MIDPOINT | 1u << ISO_QUADRATURE_PREINTEGRATED |
                   1u << ISO_QUADRATURE_POVRAY,
    .defaults = {.source = ISO_FROM_CODES, .quadrature = ISO_QUADRATURE_CONVERGED},
    .sample_seconds = 4e-8,
    .version = version,
    .render = render,
};
