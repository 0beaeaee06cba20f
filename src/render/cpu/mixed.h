/* SPDX-License-Identifier: MIT */
/* mixed.h - the CPU ray caster on bricks of mixed resolution (brick/bricks.h): the samples of render/gl/bricks_gl.h.
 *
 * The shown bricks' nodes lie one after the other, each brick's at its own level: one number per brick holds their
 * start and their level. As in bricks_gl.h bricks with baked faces and bricks on their own run the same loop. */
#pragma once

#include "brick/bricks.h"
#include "render/cpu/caster.h"

typedef struct iso_cpu_brick_options {
    bool shaded;           /* else directions are not kept and the light is ambient alone */
    int node_bits;         /* of each of a node's numbers: 16 (as bricks_gl.h's cache_bits), or 32: floats */
    const uint8_t *wanted; /* one byte per brick, 0 leaves it out; NULL: all */
    double step_voxels;    /* 0: the view's */
    iso_cpu_skip skip;     /* skipping of parts of bricks that the transfer function hides */
    iso_cpu_width width;
    int threads;
} iso_cpu_brick_options;
iso_cpu_brick_options iso_cpu_brick_defaults(void);

/* Creates a scene; draw and release it as in caster.h. Field and view are not needed afterwards. For 16 bits, round
 * the nodes first (iso_node_levels_round). ISO_E_RANGE: a 2D transfer function, an extinction scale, a region of
 * interest, a step that is not above 0, bits other than 16 and 32, more than 2^28 nodes, or an unsupported width.
 * ISO_E_MEMORY. */
iso_status iso_cpu_prepare_bricks(iso_cpu_scene **scene, const iso_brick_field *field, const iso_view *view,
                                  const iso_cpu_brick_options *opt, iso_error *err);

/* Prepares, draws and releases a scene. */
iso_status iso_cpu_render_bricks(const iso_brick_field *field, const iso_view *view, const iso_cpu_brick_options *opt,
                                 iso_image *image, iso_error *err);
