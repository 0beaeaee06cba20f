/* SPDX-License-Identifier: MIT */
/* gl_directions.h - bytes and directions of a level's voxels as textures. Private to src/render. */
#ifndef ISO_GL_DIRECTIONS_H
#define ISO_GL_DIRECTIONS_H

#include "render/gl/gl_context.h"
#include "scene/field.h"

/* A texture, and how its texels become lattice vectors and, from one channel, log2 of the extinction's scale
 * (fit/extinction_scale.h): texel * factor + offset. */
typedef struct iso_gl_directions {
    GLuint texture;
    double scale, offset;
    double octaves, octaves_offset;
} iso_gl_directions;

/* Bytes a voxel, of which texture units filter no fewer bits than of floats: in 8 bits, or in 16 where 8 are filtered
 * in 8. Their red channel is byte / 255. */
iso_status iso_gl_upload_bytes(const iso_gl *gl, const iso_level *level, const uint8_t *bytes, const char *what,
                               GLuint *texture, iso_error *err);

/* The same from the level's codes. extinction_scale: one byte per voxel that goes into alpha, which the texture has
 * anyway; or NULL. */
iso_status iso_gl_upload_codes(const iso_gl *gl, const iso_level *level, iso_code code, const uint8_t *extinction_scale,
                               iso_gl_directions *d, iso_error *err);
/* Codes in 16 bits with the scalar in alpha: (value - min) * multiple, which has to be a whole number of at most
 * 65535. */
iso_status iso_gl_upload_codes_with_scalar(const iso_gl *gl, const iso_level *level, iso_code code, double multiple,
                                           iso_gl_directions *d, iso_error *err);
/* Floats: the level's own, or decoded ones. In alpha, log2 of the scale itself. */
iso_status iso_gl_upload_vectors(const iso_gl *gl, const iso_level *level, iso_code code, iso_direction_source source,
                                 const uint8_t *extinction_scale, iso_gl_directions *d, iso_error *err);

#endif
