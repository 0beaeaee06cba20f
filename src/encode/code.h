/* SPDX-License-Identifier: MIT */
/* code.h - directions in 3 bytes: one table of codes, one interface.
 *
 * A texture holds the three bytes of each voxel and filters them linearly. What
 * a fetch returns is a *lattice vector* e: bytes read as SNORM8 (signed,
 * c / 127) or as UNORM8 (2 c / 255 - 1). Decoding turns the filtered e into the
 * shading direction d; its length says how far the direction can be trusted
 * (coherence; 0: undefined), and the shading normal is
 *     n = d / sqrt(|d|^2 + ISO_DIRECTION_EPS^2).
 * The decoders and the normal are written once, in code_decode.h, which C (in
 * double) and GLSL both include.
 *
 *   fit       signed; the code near d whose direction is best, at almost its
 *             length. Linear as snorm is, at half its error.
 *   snorm     signed; d rounded to 1/127. Decode: d = e.
 *   shell     signed; the nearest direction among lengths in [0.95, 1].
 *   free      signed; the nearest direction at any length.
 *   cube      unsigned; the cube-dot, rounded.
 *   region48  unsigned; [diaz-garcia-2017] section 4: cube-dots of 48 triangular
 *             regions, Eq. 2 with lambda = 0.61.
 *   oct24     12 + 12 bits of the octahedral map; for nearest fetches.
 *   half      three half floats, 6 bytes.
 *
 * Linear codes (decode(e) = e) agree in every renderer that filters vectors;
 * those that keep the length carry coherence. The others hold directions alone.
 * doc/results/direction-codes.md has the errors of each at voxels and between them. */
#ifndef ISO_CODE_H
#define ISO_CODE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/names.h"
#include "base/status.h"
#include "encode/hole.h"

/* The one list of codes: ISO_CODE_FIT is the number of iso_code_fit, the row that stands beside the encoder. */
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
    size_t bytes;      /* a direction */
    bool is_textured;  /* 3 bytes that a texture may filter: what pyramids store */
    bool is_signed;    /* SNORM8 lattice, else UNORM8 read as 2t - 1 */
    bool keeps_length; /* d's length survives */
    bool is_linear;    /* decode(e) = e, so that filtering decoded vectors is the same */
    int decoder;       /* ISO_DECODER_* of code_decode.h, for shaders */
    /* count directions of 3 floats to `bytes` each. Cannot fail. */
    void (*encode)(const float *restrict directions, uint8_t *restrict bytes, size_t count);
    /* The bytes to the lattice vector, where they are not three bytes that is_signed says how to read; else NULL. */
    void (*lattice)(const uint8_t *bytes, double e[3]);
    /* encode() of rows of components, to the low three bytes of a word each: what builds use. NULL: there is none. */
    void (*encode_rows)(const float *restrict x, const float *restrict y, const float *restrict z, size_t count,
                        uint32_t *restrict words);
    /* The biggest hole, as iso_code_hole() of code_hole.h. */
    iso_status (*hole)(const struct iso_code_info *code, double tolerance_deg, iso_hole *hole, const char **how,
                       iso_error *err);
} iso_code_info;

extern const iso_names iso_code_names;

const iso_code_info *iso_code_describe(iso_code code);
iso_status iso_code_from_name(const char *name, iso_code *code, iso_error *err);

/* Encodes `count` finite directions of 3 floats, |d| <= 1, into info.bytes each. (0, 0, 0) means undefined. */
void iso_code_encode(iso_code code, const float *restrict directions, uint8_t *restrict bytes, size_t count);

/* The lattice vector that the bytes stand for: what a nearest fetch returns.
 * oct24: (x, y, 0) of the octahedral map. */
void iso_code_lattice(iso_code code, const uint8_t *bytes, double e[3]);

/* Decodes a lattice vector, which may be filtered, to the direction d; |d| <= 1 or a little above. */
void iso_code_decode(iso_code code, const double e[3], double d[3]);

/* Decodes the bytes of each voxel, in single precision. */
void iso_code_decode_all(iso_code code, const uint8_t *restrict bytes, float *restrict directions, size_t count);

/* n = d / sqrt(|d|^2 + eps^2) */
void iso_code_normal(const double d[3], double n[3]);

#endif
