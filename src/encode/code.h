/* SPDX-License-Identifier: MIT */
/* code.h - directions in 3 bytes: one table of codes, one interface.
 *
 * A texture stores the three bytes of each voxel and filters them linearly. A fetch
 * returns a *lattice vector* e: the bytes read as SNORM8 (signed, c / 127) or as
 * UNORM8 (2 c / 255 - 1). Decoding converts the filtered e to the shading direction
 * d. Its length is its reliability (coherence; 0: undefined), and the shading normal is
 *     n = d / sqrt(|d|^2 + ISO_DIRECTION_EPS^2).
 * The decoders and the normal are defined once, in code_decode.h, for C (in double)
 * and GLSL.
 *
 *   fit       signed; the code near d with the best direction, at almost its
 *             length. Linear like snorm, with half its error.
 *   snorm     signed; d rounded to 1/127. Decode: d = e.
 *   shell     signed; the nearest direction among lengths in [0.95, 1].
 *   free      signed; the nearest direction at any length.
 *   cube      unsigned; the cube-dot, rounded.
 *   region48  unsigned; [diaz-garcia-2017] section 4: cube-dots of 48 triangular
 *             regions, Eq. 2 with lambda = 0.61.
 *   oct24     12 + 12 bits of the octahedral map; for nearest fetches.
 *   half      three half floats, 6 bytes.
 *
 * Linear codes (decode(e) = e) look the same in every renderer that filters vectors;
 * codes that keep the length also store coherence. The others store directions alone.
 * doc/results/direction-codes.md has the errors of each at voxels and between them. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/names.h"
#include "base/status.h"

/* The list of codes: row NAME is iso_code_NAME, defined next to its encoder; ISO_CODE_* are row numbers. */
/* clang-format off */
#define ISO_CODE_LIST(X)  \
    X(SNORM, snorm)       \
    X(FIT, fit)           \
    X(SHELL, shell)       \
    X(FREE, free)         \
    X(CUBE, cube)         \
    X(REGION48, region48) \
    X(OCT24, oct24)       \
    X(HALF, half)
/* clang-format on */

typedef enum iso_code {
#define ISO_CODE_ENUM(code, row) ISO_CODE_##code,
    ISO_CODE_LIST(ISO_CODE_ENUM)
#undef ISO_CODE_ENUM
        ISO_CODE_COUNT
} iso_code;

typedef struct iso_code_info {
    const char *name;
    const char *summary;
    size_t bytes;      /* per direction */
    bool is_textured;  /* True for 3 bytes that textures may filter; pyramids store these codes */
    bool is_signed;    /* True for an SNORM8 lattice; otherwise UNORM8 read as 2t - 1 */
    bool keeps_length; /* True if the length of d is stored */
    bool is_linear;    /* True if decode(e) = e: decoded vectors may be filtered instead */
    int decoder;       /* ISO_DECODER_* of code_decode.h, for shaders */
    /* Encodes count directions of 3 floats into `bytes` each. Cannot fail. */
    void (*encode)(const float *restrict directions, uint8_t *restrict bytes, size_t count);
    /* Converts the bytes to the lattice vector; NULL: three bytes read according to is_signed. */
    void (*lattice)(const uint8_t *bytes, double e[3]);
    /* Encodes rows of components into the low three bytes of a word each, for builds; NULL: not available. */
    void (*encode_rows)(const float *restrict x, const float *restrict y, const float *restrict z, size_t count,
                        uint32_t *restrict words);
} iso_code_info;

extern const iso_names iso_code_names;

const iso_code_info *iso_code_describe(iso_code code);
iso_status iso_code_from_name(const char *name, iso_code *code, iso_error *err);

/* Encodes `count` finite directions of 3 floats, |d| <= 1, into info.bytes each. (0, 0, 0) means undefined. */
void iso_code_encode(iso_code code, const float *restrict directions, uint8_t *restrict bytes, size_t count);

/* Returns the lattice vector for the bytes, as a nearest fetch does. oct24: (x, y, 0) of the octahedral map. */
void iso_code_lattice(iso_code code, const uint8_t *bytes, double e[3]);

/* Decodes a lattice vector, which may be filtered, to the direction d; |d| is at most slightly above 1. */
void iso_code_decode(iso_code code, const double e[3], double d[3]);

/* Decodes the bytes of each voxel, in single precision. */
void iso_code_decode_all(iso_code code, const uint8_t *restrict bytes, float *restrict directions, size_t count);

/* Computes n = d / sqrt(|d|^2 + eps^2). */
void iso_code_normal(const double d[3], double n[3]);
