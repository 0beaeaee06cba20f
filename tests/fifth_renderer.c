/* SPDX-License-Identifier: MIT */
/* shifted.c - the reference, of a volume that stands shift_voxels off: an example. */
#include <stdio.h>

#include "renderers/renderers.h"

static double shift_voxels = 0; /* anything else is a fault, which validation finds */

static iso_status version(const iso_renderer_info *self, iso_renderers *r, char *text, size_t size, iso_error *err)
{
    (void)self;
    (void)r, (void)err; /* what is not there: return iso_fail(err, ISO_E_MISSING, "...") */
    snprintf(text, size, "shifted by %g voxels", shift_voxels);
    return ISO_OK;
}

static iso_status render(const iso_render_request *q, iso_image *image, iso_render_stats *stats, iso_error *err)
{
    (void)stats;                                    /* the time of the call will do */
    iso_level level = q->pyramid->levels[q->level]; /* borrowed, but for where it stands */
    iso_reference_options o = iso_reference_defaults();
    level.geometry.origin_mm = iso_geometry_to_world(&level.geometry, iso_v3(shift_voxels, shift_voxels, shift_voxels));
    o.quadrature = ISO_QUADRATURE_MIDPOINT;
    o.source = q->options->source;
    o.step_voxels = q->options->step_voxels;
    o.threads = q->options->threads;
    return iso_reference_render(&level, q->pyramid->options.code, q->view, &o, image, q->progress, err);
}

/* The reference's own midpoints, in its arithmetic: only the rounding of where the volume stands may tell them
 * apart. */
static const iso_lock_step lock_step = {
    .quadrature = ISO_QUADRATURE_MIDPOINT,
    .why = "the same samples in the same arithmetic",
    .smooth = {.rmse = 1e-6, .max_abs = 1e-5},
    .sharp = {.rmse = 1e-6, .max_abs = 1e-5},
};

const iso_renderer_info iso_renderer_shifted = {
    .name = "shifted",
    .title = "Shifted reference",
    .color = "#cc79a7",
    .sample_seconds = 4e-8,
    .traits = ISO_HAS_LIMIT | ISO_HAS_ALL_SCENES | ISO_READS_SOURCE,
    .lock_step = &lock_step,
    .version = version,
    .render = render,
};
