/* SPDX-License-Identifier: MIT */
/* code_decode.h - from a (filtered) lattice vector to the shading normal: the
 * one definition that C and GLSL share.
 *
 * GLSL: put this text behind the #version line; nothing has to be defined.
 * C: define before the inclusion
 *     ISO_REAL             float or double
 *     ISO_VEC3             a struct with ISO_REAL x, y, z
 *     ISO_MAKE_VEC3(x, y, z), ISO_SQRT(x), ISO_ABS(x)
 *
 *     e  lattice vector: a texture fetch, bytes read as SNORM8, or as UNORM8
 *        and then 2 t - 1
 *     d  iso_decode(decoder, e): shading direction, |d| <= 1 or a little above;
 *        its length is how far it can be trusted, 0: undefined
 *     n  iso_shading_normal(d) = d / sqrt(|d|^2 + eps^2), |n| < 1
 *
 * eps is one step of the signed lattice (1/127): n fades only where d is as
 * short as one code step, that is where there is no direction. */
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
#define ISO_DECODER_SQUEEZE 4

/* [diaz-garcia-2017] section 4.1, Figure 10: the best lambda of Eq. 2. */
#define ISO_REGION48_LAMBDA 0.61

/* Codes that keep the direction alone have |d| = 1 at every defined voxel, and
 * |d| falls to 0 only where filtering meets undefined voxels or opposite
 * directions: |d| = slope (|e| - zero), at most 1. "zero" is the length of the
 * eight codes round the center of the unsigned lattice, one of which,
 * (128,128,128), stands for "undefined" (0,0,0 does on the signed one).
 * Encoders emit no other vector shorter than 1/3: its multiples, odd ones on
 * the unsigned lattice, have the same direction. */
#define ISO_TRUST_ZERO 0.006793 /* sqrt(3) / 255, rounded up */
#define ISO_TRUST_SLOPE 4.0

#define ISO_MIN(a, b) ((a) < (b) ? (a) : (b))
#define ISO_MAX(a, b) ((a) < (b) ? (b) : (a))

ISO_FUNCTION ISO_REAL iso_decode_length(ISO_VEC3 v)
{
    return ISO_SQRT(v.x * v.x + v.y * v.y + v.z * v.z);
}

/* |d| for |e| of a code of directions alone. */
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

/* Gives each component of e, by its rank among |components| (high >= middle >=
 * low), the new magnitude of that rank, and its own sign. Equal components get
 * equal magnitudes from every decoder, so the order among them is free. */
ISO_FUNCTION ISO_REAL iso_decode_pick(ISO_REAL component, ISO_REAL high, ISO_REAL low, ISO_VEC3 ranked)
{
    ISO_REAL size = ISO_ABS(component);
    ISO_REAL value = size >= high ? ranked.x : size <= low ? ranked.z : ranked.y;
    return component < 0.0 ? -value : value;
}

/* [diaz-garcia-2017] section 4.2: the region is the order and the signs of the
 * components; the cube-dot (a, b, c) / a of the sorted ones is
 * u (1,0,0) + v (1,1,0) + w (1,1,1); Eq. 2 moves (u, v, w). Its normalization
 * is only a scale of the vector, which the last step undoes anyway. */
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

/* The 48 regions with a smaller hole. What is left of the hole of Eq. 2 lies along
 * lines m y + n z = c, m, n and c small whole numbers, of the cube-dot (y, z):
 * there the points of all lengths fall on the same parallels, 2 / (255 |(m,n)|)
 * apart. So each such line is squeezed by itself (slope 1 - strength |(m,n)|^2 /
 * width on the line, a shift far from it), then the edges of the triangle as in
 * Eq. 2 (slope k on the edge), and what density is left over is evened out by a
 * polynomial. All of it is monotone and independent of the length. */
/* k and t of u, v, w: slope k on the edge, from t on a shift; how near to an edge a
 * line still moves points; the polynomial; the lines: m, n, c, strength, width. Found
 * by descent on the largest few thousand holes at once. */
#define ISO_SQUEEZE_KU 3.4998e-06
#define ISO_SQUEEZE_KV 2.3671e-05
#define ISO_SQUEEZE_KW 1.3845e-05
#define ISO_SQUEEZE_TU 0.027111
#define ISO_SQUEEZE_TV 0.025472
#define ISO_SQUEEZE_TW 0.036693
#define ISO_SQUEEZE_RIM 0.024752
#define ISO_SQUEEZE_CUBIC -0.13567
#define ISO_SQUEEZE_QUINTIC 0.23911
/* clang-format off */
#define ISO_SQUEEZE_LINES(X)                 \
    X(1.0, 1.0, 1.0, 0.0038754, 0.013867)    \
    X(2.0, 0.0, 1.0, 0.00075629, 0.011858)   \
    X(0.0, 2.0, 1.0, 0.00048866, 0.0084009)  \
    X(1.0, -2.0, 0.0, 0.001347, 0.01216)     \
    X(2.0, -1.0, 1.0, 0.00042309, 0.005418)  \
    X(2.0, 1.0, 2.0, -0.00051774, 0.048061)  \
    X(2.0, 1.0, 1.0, 0.00031208, 0.004807)   \
    X(1.0, 2.0, 1.0, 0.0004769, 0.0058937)   \
    X(1.0, 2.0, 2.0, -0.00093351, 0.059507)  \
    X(2.0, -2.0, 1.0, 0.00023569, 0.014403)  \
    X(2.0, 2.0, 1.0, 0.00064891, 0.059026)   \
    X(2.0, 2.0, 3.0, -0.00076273, 0.011132)  \
    X(3.0, 0.0, 1.0, 0.00051052, 0.03772)    \
    X(3.0, 0.0, 2.0, -6.932e-05, 0.046974)   \
    X(1.0, -3.0, 0.0, 4.8635e-05, 0.0015818) \
    X(3.0, -1.0, 1.0, 0.00025583, 0.010914)  \
    X(3.0, -1.0, 2.0, 0.00026626, 0.0048916) \
    X(1.0, 3.0, 1.0, 0.0001316, 0.027755)    \
    X(1.0, 3.0, 2.0, 0.00030847, 0.14685)    \
    X(3.0, -2.0, 1.0, -0.00073491, 0.12274)
#define ISO_SQUEEZE_LINE(m, n, c, strength, width)   \
    t = m * y + n * z - c;                           \
    t = strength * t / (ISO_ABS(t) + width);         \
    dy -= m * t;                                     \
    dz -= n * t;
/* clang-format on */

/* The cube-dot (1, y, z) to the decoded (x, y, z), of any length. */
ISO_FUNCTION ISO_VEC3 iso_squeeze(ISO_REAL y, ISO_REAL z)
{
    ISO_REAL dy = 0.0, dz = 0.0, t;
    ISO_SQUEEZE_LINES(ISO_SQUEEZE_LINE)
    ISO_REAL u = 1.0 - y, v = y - z, w = z;
    u = u - dy * u / (u + ISO_SQUEEZE_RIM); /* the edges stay where they are */
    v = v + (dy - dz) * v / (v + ISO_SQUEEZE_RIM);
    w = w + dz * w / (w + ISO_SQUEEZE_RIM);
    u = u * (u + ISO_SQUEEZE_KU * ISO_SQUEEZE_TU) / (u + ISO_SQUEEZE_TU);
    v = v * (v + ISO_SQUEEZE_KV * ISO_SQUEEZE_TV) / (v + ISO_SQUEEZE_TV);
    w = w * (w + ISO_SQUEEZE_KW * ISO_SQUEEZE_TW) / (w + ISO_SQUEEZE_TW);
    ISO_REAL sum = u + v + w;
    y = (v + w) / sum;
    z = w / sum;
    y = y * (1.0 + y * y * (ISO_SQUEEZE_CUBIC + ISO_SQUEEZE_QUINTIC * y * y));
    z = z * (1.0 + z * z * (ISO_SQUEEZE_CUBIC + ISO_SQUEEZE_QUINTIC * z * z));
    return ISO_MAKE_VEC3(1.0 + ISO_SQUEEZE_CUBIC + ISO_SQUEEZE_QUINTIC, y, z);
}

ISO_FUNCTION ISO_VEC3 iso_decode_squeeze(ISO_VEC3 e)
{
    ISO_REAL trust = iso_decode_trust(iso_decode_length(e));
    ISO_REAL ax = ISO_ABS(e.x), ay = ISO_ABS(e.y), az = ISO_ABS(e.z);
    ISO_REAL high = ISO_MAX(1.0e-9, ISO_MAX(ax, ISO_MAX(ay, az)));
    ISO_REAL low = ISO_MIN(ax, ISO_MIN(ay, az));
    ISO_REAL middle = ISO_MAX(ISO_MIN(ax, ay), ISO_MIN(ISO_MAX(ax, ay), az));
    ISO_VEC3 ranked = iso_squeeze(middle / high, low / high);
    ISO_REAL scale = trust / iso_decode_length(ranked);
    ranked = ISO_MAKE_VEC3(ranked.x * scale, ranked.y * scale, ranked.z * scale);
    return ISO_MAKE_VEC3(iso_decode_pick(e.x, high, low, ranked), iso_decode_pick(e.y, high, low, ranked),
                         iso_decode_pick(e.z, high, low, ranked));
}

/* Octahedral map: (x, y) of e; the lower half of the octahedron |x| + |y| + |z| = 1
 * is folded outwards. For nearest fetches only, a filter across a fold is wrong.
 * The corner (-1,-1) stands for "undefined" (the other three corners decode to
 * the same -z). */
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
    return decoder == ISO_DECODER_REGION48  ? iso_decode_region48(e)
           : decoder == ISO_DECODER_UNIT    ? iso_decode_unit(e)
           : decoder == ISO_DECODER_OCT     ? iso_decode_oct(e)
           : decoder == ISO_DECODER_SQUEEZE ? iso_decode_squeeze(e)
                                            : e;
}

/* The flipped fetch. Light is two-sided, so d and -d shade alike, but they cancel
 * where a filter mixes them: between the faces of a thin plate. So of the eight
 * voxels round a point the one that counts most (weight times |d|, the first of
 * equals) is the pivot, and those that oppose it by more than this cosine count as
 * -d: opposite faces do; at 0 the sides of a vessel would, at -0.8 noisy faces
 * would not. */
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
