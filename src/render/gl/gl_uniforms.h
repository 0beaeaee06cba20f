/* SPDX-License-Identifier: MIT */
/* gl_uniforms.h - the uniforms of all ray casting programs: camera, step, lights.
 *
 * raycast.glsl walks in its own coordinates p = scale * index + offset: texture
 * coordinates of one volume, or bricks. */
#pragma once

#include "render/gl/gl_context.h"

void iso_gl_set_float(GLuint program, const char *name, double value);
void iso_gl_set_int(GLuint program, const char *name, int value);
void iso_gl_set_vec3(GLuint program, const char *name, iso_vec3 v);
/* Writes the matrix by columns, as GL reads it. */
void iso_gl_matrix_columns(iso_mat3 m, double columns[9]);

void iso_gl_set_camera(GLuint program, const iso_geometry *g, const iso_view *view, double step_mm);
void iso_gl_set_coordinates(GLuint program, iso_vec3 scale, iso_vec3 offset);
void iso_gl_set_light(GLuint program, const iso_view *view);
/* Sets the transfer function. Texel t of the scalar has the value zero + t * per_texel. */
void iso_gl_set_tf(GLuint program, const iso_tf_table *tf, double zero, double per_texel);


/* Sets a first-hit surface. Samples of level 0 lie at whole samples_per_p * p - first_sample. zero and per_texel as
 * above. */
void iso_gl_set_surface(GLuint program, const iso_surface *surface, iso_vec3 samples_per_p, double first_sample,
                        double zero, double per_texel);
/* Returns a transfer function for culling that shows the values from iso on. The caller owns the entries. */
iso_tf_table iso_gl_surface_tf(const iso_surface *surface, double min, double max, float entries[12]);
