/* SPDX-License-Identifier: MIT */
/* gl_palette.h - a palette and its indices as textures. Private to src/render. */
#pragma once

#include "render/gl/gl_context.h"

/* Uploads one index per voxel: 8 bits for at most 256 entries, otherwise 16. Integers are never filtered. */
iso_status iso_gl_upload_indices(const iso_gl *gl, const iso_level *level, GLuint *texture, iso_error *err);

/* Uploads a texture of one row: each entry's direction, and its shade as fourth component. The shade is for the view's
 * lights, seen along the camera's axis (palette/palette.h: iso_palette_shade). */
iso_status iso_gl_upload_palette(const iso_gl *gl, const iso_palette *palette, const iso_view *view, GLuint *texture,
                                 iso_error *err);
