/* SPDX-License-Identifier: MIT */
/* bricks_gl.h - the ray caster on bricks of mixed resolution (brick/bricks.h).
 *
 * One cache texture for the scalar, one for the directions, more of them (pages) where GL allows none so large, one
 * layout texel a brick; the same loop, shading and quadrature as raycaster.h. Baked faces and bricks on their own run
 * the same shader: smoothness costs nothing there. */
#pragma once

#include "brick/bricks.h"
#include "render/gl/raycaster.h"

typedef struct iso_gl_brick_options {
    bool shaded;                /* else directions are not uploaded and the light is ambient alone */
    int cache_bits;             /* 16 (unorm scalar, snorm directions) or 32 (floats) */
    size_t max_slots;           /* capacity of the cache; 0: as much as its pages */
    size_t page_side;           /* texels along an axis of a page at most; 0: as many as GL takes */
    bool keep_hidden;           /* also bricks that the TF does not show */
    const uint8_t *wanted;      /* one byte per brick, 0 leaves it out; NULL: all */
    double step_voxels;         /* 0: the view's */
    iso_gl_skip skip;           /* of hidden bricks */
    const iso_surface *surface; /* its first hit instead of the integral, or NULL */
    bool fast_filter;           /* as in iso_gl_options */
    size_t repeats;             /* draws; the time is that of the fastest */
    double repeat_seconds;      /* as in iso_gl_options */
} iso_gl_brick_options;
iso_gl_brick_options iso_gl_brick_defaults(void);

typedef struct iso_gl_brick_stats {
    double seconds;      /* the drawing alone */
    double bake_seconds; /* culling, baking, packing and uploading */
    size_t brick_count, shown_count, slot_count, slot_side;
    size_t texel_count; /* of the cache, all pages */
    size_t page_count;
    size_t node_count; /* that the shown bricks hold */
    iso_gl_stats gl;   /* bytes of the textures, and the draws */
} iso_gl_brick_stats;

/* Bakes, packs, uploads and renders. With 16 bits the nodes must have been rounded (iso_node_levels_round), or faces
 * differ by up to a step of the cache. ISO_E_RANGE with the needed size if the cache is too small. */
iso_status iso_gl_render_bricks(iso_gl *gl, const iso_brick_field *field, const iso_view *view,
                                const iso_gl_brick_options *opt, iso_image *image, iso_gl_brick_stats *stats,
                                iso_error *err);
