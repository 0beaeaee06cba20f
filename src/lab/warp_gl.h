/* SPDX-License-Identifier: MIT */
/* warp_gl.h - the ray caster on bricks with the transitions of [beyer-2008]
 * (lab/warp.h): on their own, as written, corrected. For comparison with bricks_gl.h.
 *
 * Cache as the paper has it: slots of (n + 2)^3 texels, one fine brick with its
 * border or eight coarse ones of (n / 2 + 1)^3; a layout texel and the 26
 * neighbors' bits a brick. As written the border is fixed up on upload and the
 * warped place fetched once; corrected, places in transition are fetched twice. */
#ifndef ISO_LAB_WARP_GL_H
#define ISO_LAB_WARP_GL_H

#include "lab/warp.h"
#include "render/gl/bricks_gl.h"

/* A field, and the level whose field it is: for its geometry, range and culling. */
typedef struct iso_gl_warp {
    const iso_warp_field *field;
    const iso_level *level;
} iso_gl_warp;

/* Ignores the options max_slots, keep_hidden and wanted. Fields of one channel are drawn unshaded. ISO_E_RANGE,
 * ISO_E_MEMORY. */
iso_status iso_gl_render_warp(iso_gl *gl, const iso_gl_warp *warp, const iso_view *view,
                              const iso_gl_brick_options *opt, iso_image *image, iso_gl_brick_stats *stats,
                              iso_error *err);

/* Samples single bricks with the shader, at places in their closed boxes. places: x, y, z (index coordinates) and the
 * brick's index, x fastest, count times. out: scalar and direction. Caches have 32 bits. */
iso_status iso_gl_sample_warp(iso_gl *gl, const iso_gl_warp *warp, const double *places, size_t count, float *out,
                              iso_error *err);

#endif
