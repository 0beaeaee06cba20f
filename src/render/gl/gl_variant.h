/* SPDX-License-Identifier: MIT */
/* gl_variant.h - the ray caster's variants: raycast.glsl compiled with the features of a view, by names that the
 * shaders share (shaders/variants.h). */
#pragma once

#include "render/gl/gl_context.h"
#include "render/gl/shaders/variants.h"

/* The fields are the shader's switches of the same names; raycast.glsl documents each. */
typedef struct iso_gl_variant {
    int direction_source; /* SOURCE_... */
    int decoder;          /* ISO_DECODER_... of code_decode.h, for SOURCE_CODES */
    int output;           /* OUTPUT_... */
    size_t light_count;
    bool scalar_with_directions, specular, shade_table, skip_empty, preintegrated, exact, filtered_by_hand, roi, bricks;
    int screen_tile;        /* pixels along the edge of the tiles that have a visible range; 0: there are none */
    int tf_2d_rows;         /* of a 2D transfer function; 0: it is 1D */
    int extinction_scale;   /* SCALE_... */
    size_t pages;           /* of the brick cache; 0: one */
    const char *transition; /* value of TRANSITION for iso_gl.transition; NULL: bricks share the nodes of their faces */
} iso_gl_variant;

/* Returns OUTPUT_HIT_... of a surface, or OUTPUT_INTEGRAL for NULL. */
int iso_gl_output(const iso_surface *surface);

/* Returns the variant's program. The context compiles it once and keeps it. */
iso_status iso_gl_get_variant(iso_gl *gl, const iso_gl_variant *v, GLuint *program, iso_error *err);
