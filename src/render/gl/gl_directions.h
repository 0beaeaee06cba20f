/* SPDX-License-Identifier: MIT */
/* gl_directions.h - bytes and directions of a level's voxels as textures. Private to src/render. */
#pragma once

#include "render/gl/gl_context.h"
#include "scene/field.h"

/* A texture, and how its texels become lattice vectors and, from one channel, log2 of the extinction's scale
 * (fit/extinction_scale.h): texel * factor + offset. */
typedef struct iso_gl_directions {
    GLuint texture;
    double scale, offset;
    double octaves, octaves_offset;
} iso_gl_directions;

/* Uploads one byte per voxel: in 16 bits if the device filters 8-bit textures in 8 bits, otherwise in 8. Texture units
 * then filter them in as many bits as floats. The red channel is byte / 255. */
iso_status iso_gl_upload_bytes(const iso_gl *gl, const iso_level *level, const uint8_t *bytes, const char *what,
                               GLuint *texture, iso_error *err);

/* Uploads the level's codes, filtered as bytes are. extinction_scale: one byte per voxel for alpha, which the texture
 * has anyway; or NULL. */
iso_status iso_gl_upload_codes(const iso_gl *gl, const iso_level *level, iso_code code, const uint8_t *extinction_scale,
                               iso_gl_directions *d, iso_error *err);
/* Uploads codes in 16 bits with the scalar in alpha: (value - min) * multiple, which must be a whole number up to
 * 65535. */
iso_status iso_gl_upload_codes_with_scalar(const iso_gl *gl, const iso_level *level, iso_code code, double multiple,
                                           iso_gl_directions *d, iso_error *err);
/* Uploads floats: the level's own, or decoded ones. With extinction_scale, alpha is log2 of the scale. */
iso_status iso_gl_upload_vectors(const iso_gl *gl, const iso_level *level, iso_code code, iso_direction_source source,
                                 const uint8_t *extinction_scale, iso_gl_directions *d, iso_error *err);
