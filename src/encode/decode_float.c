/* SPDX-License-Identifier: MIT */
/* decode_float.c - the decoders in single precision over whole arrays, like those of a
 * GPU. Compiled with -fsingle-precision-constant (Makefile). */
#include <math.h>

#include "base/simd.h"
#include "encode/encode_kernel.h"

typedef struct vec3f {
    float x, y, z;
} vec3f;

#define ISO_REAL float
#define ISO_VEC3 vec3f
#define ISO_MAKE_VEC3(vx, vy, vz) ((vec3f){vx, vy, vz})
#define ISO_SQRT(x) sqrtf(x)
#define ISO_ABS(x) fabsf(x)
#include "encode/code_decode.h"

#define SIMD static inline __attribute__((always_inline)) void

/* One loop per decoder, so that each vectorizes. */
SIMD decode_loop(int decoder, const float *restrict lattice, float *restrict directions, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        vec3f d = iso_decode(decoder, ISO_MAKE_VEC3(lattice[3 * i], lattice[3 * i + 1], lattice[3 * i + 2]));
        directions[3 * i] = d.x;
        directions[3 * i + 1] = d.y;
        directions[3 * i + 2] = d.z;
    }
}

SIMD decode_any(int decoder, const float *restrict lattice, float *restrict directions, size_t count)
{
    switch (decoder) {
    case ISO_DECODER_REGION48: decode_loop(ISO_DECODER_REGION48, lattice, directions, count); break;
    case ISO_DECODER_UNIT: decode_loop(ISO_DECODER_UNIT, lattice, directions, count); break;
    case ISO_DECODER_OCT: decode_loop(ISO_DECODER_OCT, lattice, directions, count); break;
    default: decode_loop(ISO_DECODER_LINEAR, lattice, directions, count); break;
    }
}

ISO_FOR("avx2") static void decode_avx2(int decoder, const float *restrict lattice, float *restrict directions,
                                        size_t count)
{
    decode_any(decoder, lattice, directions, count);
}

static void decode_baseline(int decoder, const float *restrict lattice, float *restrict directions, size_t count)
{
    decode_any(decoder, lattice, directions, count);
}

void iso_decode_floats(int decoder, const float *restrict lattice, float *restrict directions, size_t count)
{
    if (ISO_HAS("avx2"))
        decode_avx2(decoder, lattice, directions, count);
    else
        decode_baseline(decoder, lattice, directions, count);
}
