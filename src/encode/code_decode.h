/* SPDX-License-Identifier: MIT */
/* code_decode.h - conversion of a (filtered) lattice vector to the shading normal,
 * defined once for C and GLSL.
 *
 * GLSL: put this text after the #version line; it needs no definitions.
 * C: define before the inclusion
 *     ISO_REAL             float or double
 *     ISO_VEC3             a struct with ISO_REAL x, y, z
 *     ISO_MAKE_VEC3(x, y, z), ISO_SQRT(x), ISO_ABS(x)
 *
 *     e  lattice vector: a texture fetch, bytes read as SNORM8, or as UNORM8
 *        and then 2 t - 1
 *     d  iso_decode(decoder, e): shading direction, |d| at most slightly above 1;
 *        its length is its reliability, 0: undefined
 *     n  iso_shading_normal(d) = d / sqrt(|d|^2 + eps^2), |n| < 1
 *
 * eps is one step of the signed lattice (1/127): n fades only if d is as short as
 * one code step, that is, if there is no direction. */
#ifndef __STDC__ /* GLSL */
#define ISO_REAL float
#define ISO_VEC3 vec3
#define ISO_MAKE_VEC3(x, y, z) vec3(x, y, z)
#define ISO_SQRT(x) sqrt(x)
#define ISO_ABS(x) abs(x)
#define ISO_FUNCTION
#else
#define ISO_FUNCTION static inline
#endif

#define ISO_DIRECTION_EPS (1.0 / 127.0)

/* Decoders; several codes may share one (iso_code_info.decoder). */
#define ISO_DECODER_LINEAR 0
#define ISO_DECODER_REGION48 1
#define ISO_DECODER_UNIT 2
#define ISO_DECODER_OCT 3

/* [diaz-garcia-2017] section 4.1, Figure 10: the optimal lambda of Eq. 2. */
#define ISO_REGION48_LAMBDA 0.61

/* Codes without length have |d| = 1 at every defined voxel. |d| falls to 0 only if
 * filtering meets undefined voxels or opposite directions:
 * |d| = slope (|e| - zero), at most 1. "zero" is the length of the eight codes around
 * the center of the unsigned lattice, one of which, (128,128,128), stands for
 * "undefined" (0,0,0 does on the signed one). Encoders write no other vector shorter
 * than 1/3, since its multiples, odd ones on the unsigned lattice, have the same
 * direction. */
#define ISO_TRUST_ZERO 0.006793 /* sqrt(3) / 255, rounded up */
#define ISO_TRUST_SLOPE 4.0

#define ISO_MIN(a, b) ((a) < (b) ? (a) : (b))
#define ISO_MAX(a, b) ((a) < (b) ? (b) : (a))

ISO_FUNCTION ISO_REAL iso_decode_length(ISO_VEC3 v)
{
    return ISO_SQRT(v.x * v.x + v.y * v.y + v.z * v.z);
}

/* Returns |d| for |e| of a code without length. */
ISO_FUNCTION ISO_REAL iso_decode_trust(ISO_REAL r)
{
    ISO_REAL t = ISO_TRUST_SLOPE * (r - ISO_TRUST_ZERO);
    return ISO_MAX(0.0, ISO_MIN(1.0, t));
}

ISO_FUNCTION ISO_VEC3 iso_decode_unit(ISO_VEC3 e)
{
    ISO_REAL length = iso_decode_length(e);
    ISO_REAL scale = iso_decode_trust(length) / ISO_MAX(length, 1.0e-9);
    return ISO_MAKE_VEC3(e.x * scale, e.y * scale, e.z * scale);
}

/* Returns the new magnitude for a component of e by its rank among |components|
 * (high >= middle >= low), with its own sign. Equal components get equal
 * magnitudes from every decoder, so the order among them is free. */
ISO_FUNCTION ISO_REAL iso_decode_pick(ISO_REAL component, ISO_REAL high, ISO_REAL low, ISO_VEC3 ranked)
{
    ISO_REAL size = ISO_ABS(component);
    ISO_REAL value = size >= high ? ranked.x : size <= low ? ranked.z : ranked.y;
    return component < 0.0 ? -value : value;
}

/* Decodes after [diaz-garcia-2017] section 4.2. The order and the signs of the
 * components select the region. The cube-dot (a, b, c) / a of the sorted ones is
 * u (1,0,0) + v (1,1,0) + w (1,1,1); Eq. 2 moves (u, v, w). Its normalization only
 * scales the vector, so it is left out: the last step sets the length. */
ISO_FUNCTION ISO_VEC3 iso_decode_region48(ISO_VEC3 e)
{
    ISO_REAL trust = iso_decode_trust(iso_decode_length(e));
    ISO_REAL x = ISO_ABS(e.x), y = ISO_ABS(e.y), z = ISO_ABS(e.z);
    ISO_REAL high = ISO_MAX(1.0e-9, ISO_MAX(x, ISO_MAX(y, z)));
    ISO_REAL low = ISO_MIN(x, ISO_MIN(y, z));
    ISO_REAL middle = ISO_MAX(ISO_MIN(x, y), ISO_MIN(ISO_MAX(x, y), z));
    ISO_REAL u = 1.0 - middle / high, v = (middle - low) / high, w = low / high;
    u = u * (1.0 - ISO_REGION48_LAMBDA + ISO_REGION48_LAMBDA * u);
    v = v * (1.0 - ISO_REGION48_LAMBDA + ISO_REGION48_LAMBDA * v);
    w = w * (1.0 - ISO_REGION48_LAMBDA + ISO_REGION48_LAMBDA * w);
    ISO_VEC3 ranked = ISO_MAKE_VEC3(u + v + w, v + w, w);
    ISO_REAL scale = trust / iso_decode_length(ranked);
    ranked = ISO_MAKE_VEC3(ranked.x * scale, ranked.y * scale, ranked.z * scale);
    return ISO_MAKE_VEC3(iso_decode_pick(e.x, high, low, ranked), iso_decode_pick(e.y, high, low, ranked),
                         iso_decode_pick(e.z, high, low, ranked));
}

/* Decodes the octahedral map: (x, y) of e; the lower half of the octahedron
 * |x| + |y| + |z| = 1 is folded outwards. For nearest fetches only: filtering across a
 * fold is wrong. The corner (-1,-1) stands for "undefined" (the other three corners
 * decode to the same -z). */
ISO_FUNCTION ISO_VEC3 iso_decode_oct(ISO_VEC3 e)
{
    ISO_REAL ax = ISO_ABS(e.x), ay = ISO_ABS(e.y), z = 1.0 - ax - ay;
    ISO_REAL fold = ISO_MAX(-z, 0.0);
    ISO_REAL x = (e.x < 0.0 ? -1.0 : 1.0) * (ax - fold), y = (e.y < 0.0 ? -1.0 : 1.0) * (ay - fold);
    ISO_REAL scale = (e.x + e.y > -1.9999 ? 1.0 : 0.0) / ISO_SQRT(x * x + y * y + z * z);
    return ISO_MAKE_VEC3(x * scale, y * scale, z * scale);
}

ISO_FUNCTION ISO_VEC3 iso_decode(int decoder, ISO_VEC3 e)
{
    return decoder == ISO_DECODER_REGION48 ? iso_decode_region48(e)
           : decoder == ISO_DECODER_UNIT   ? iso_decode_unit(e)
           : decoder == ISO_DECODER_OCT    ? iso_decode_oct(e)
                                           : e;
}

/* The flipped fetch. Light is two-sided, so d and -d give the same shade, but a filter
 * that mixes them, as between the faces of a thin plate, cancels them. So the most
 * important of the eight voxels around a point (largest weight times |d|, the first of
 * equals) is the pivot, and voxels that oppose it by more than this cosine count as -d.
 * -0.5 includes opposite faces; 0 would include the sides of a vessel, -0.8 would miss
 * noisy faces. */
#define ISO_FLIP_COSINE (-0.5)

ISO_FUNCTION ISO_REAL iso_flip_sign(ISO_VEC3 d, ISO_VEC3 pivot)
{
    ISO_REAL cosine = d.x * pivot.x + d.y * pivot.y + d.z * pivot.z;
    return cosine < ISO_FLIP_COSINE * iso_decode_length(d) * iso_decode_length(pivot) ? -1.0 : 1.0;
}

ISO_FUNCTION ISO_VEC3 iso_shading_normal(ISO_VEC3 d)
{
    ISO_REAL length = ISO_SQRT(d.x * d.x + d.y * d.y + d.z * d.z + ISO_DIRECTION_EPS * ISO_DIRECTION_EPS);
    return ISO_MAKE_VEC3(d.x / length, d.y / length, d.z / length);
}
