/* SPDX-License-Identifier: MIT */
/* gl_palette.h - a palette and its indices as textures. Private to src/render. */
#ifndef ISO_GL_PALETTE_H
#define ISO_GL_PALETTE_H

#include "render/gl/gl_context.h"

/* One index per voxel, in 8 bits if the palette has at most 256 entries, otherwise in 16. Integers are never
 * filtered. */
iso_status iso_gl_upload_indices(const iso_gl *gl, const iso_level *level, GLuint *texture, iso_error *err);

/* One row: the entry's direction, and as fourth component its shade under the view's lights, seen along the camera's
 * axis (palette/palette.h: iso_palette_shade). */
iso_status iso_gl_upload_palette(const iso_gl *gl, const iso_palette *palette, const iso_view *view, GLuint *texture,
                                 iso_error *err);

#endif
