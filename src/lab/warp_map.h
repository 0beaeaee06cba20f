/* SPDX-License-Identifier: MIT */
/* warp_map.h - positions of fetches for the transitions of [beyer-2008], defined once
 * for C (lab/warp.c) and GLSL (shaders/transition.glsl). lab/warp.h describes the
 * two schemes and the reasons for them.
 *
 * GLSL: put this text after the #version line; it needs no definitions.
 * C: define before the inclusion
 *     ISO_REAL             float or double
 *     ISO_VEC3             a struct with ISO_REAL x, y, z
 *     ISO_MAKE_VEC3(x, y, z), ISO_FLOOR(x), ISO_ABS(x), ISO_INT(x)
 *     ISO_WARP_NEAR        the least 1/2 - v: a few of its type's steps
 *
 * Positions are in voxels from a brick's low corner, 0 .. side: fine samples at i + 1/2,
 * coarse ones at 2 j. `coarse` has a bit for each of the 26 neighbors that is
 * coarse, iso_warp_bit(). The value at p is
 *     (1 - part) F(top) + part C(foot)
 * F is trilinear among the brick's own samples and their border, which has coarse samples
 * in mode written. C is trilinear among the samples of the coarse neighbor at `step`. */
#ifndef __STDC__ /* GLSL */
#ifndef ISO_REAL
#define ISO_REAL float
#define ISO_VEC3 vec3
#define ISO_MAKE_VEC3(x, y, z) vec3(x, y, z)
#define ISO_ABS(x) abs(x)
#define ISO_FUNCTION
#endif
#define ISO_UINT uint
#define ISO_FLOOR(x) floor(x)
#define ISO_INT(x) int(x)
#define ISO_WARP_NEAR 1.0e-6
#else
#define ISO_FUNCTION static inline
#define ISO_UINT unsigned
typedef struct iso_warp_primitive iso_warp_primitive;
typedef struct iso_warp_fetch iso_warp_fetch;
#endif

#define ISO_TRANSITION_NONE 0
#define ISO_TRANSITION_WRITTEN 1
#define ISO_TRANSITION_CORRECTED 2

/* The coarse neighbor whose primitive contains a point, and the depth of the point in it. */
struct iso_warp_primitive {
    ISO_VEC3 step;  /* towards the neighbor, each -1, 0 or 1 */
    ISO_REAL depth; /* v, at most 1/2; 0: in none */
    int axes;       /* across it: 1 face, 2 edge, 3 corner */
};

struct iso_warp_fetch {
    ISO_VEC3 top, foot, step;
    ISO_REAL part;
};

ISO_FUNCTION int iso_warp_bit(ISO_VEC3 step)
{
    return 13 + ISO_INT(step.x) + 3 * ISO_INT(step.y) + 9 * ISO_INT(step.z);
}

/* Returns the better primitive. Written: faces before edges before corners (section 4.1); corrected: the deepest, and
 * of equals the one with fewer axes. */
ISO_FUNCTION iso_warp_primitive iso_warp_better(iso_warp_primitive best, ISO_VEC3 step, int axes, ISO_REAL depth,
                                                ISO_UINT coarse, int mode)
{
    bool holds = depth > 0.0 && (coarse >> iso_warp_bit(step) & 1u) != 0u;
    bool deeper = depth > best.depth, simpler = axes < best.axes;
    bool wins = mode == ISO_TRANSITION_CORRECTED ? deeper || (depth == best.depth && simpler)
                                                 : simpler || (axes == best.axes && deeper);
    if (holds && wins) {
        best.step = step;
        best.depth = depth;
        best.axes = axes;
    }
    return best;
}

ISO_FUNCTION ISO_REAL iso_warp_least(ISO_REAL a, ISO_REAL b)
{
    return a < b ? a : b;
}

/* Chooses a primitive by section 4.2, steps 1 to 3. */
ISO_FUNCTION iso_warp_primitive iso_warp_choose(ISO_VEC3 p, ISO_REAL side, ISO_UINT coarse, int mode)
{
    ISO_REAL sx = p.x + p.x < side ? -1.0 : 1.0, dx = 0.5 - iso_warp_least(p.x, side - p.x);
    ISO_REAL sy = p.y + p.y < side ? -1.0 : 1.0, dy = 0.5 - iso_warp_least(p.y, side - p.y);
    ISO_REAL sz = p.z + p.z < side ? -1.0 : 1.0, dz = 0.5 - iso_warp_least(p.z, side - p.z);
    ISO_REAL dxy = iso_warp_least(dx, dy), dxz = iso_warp_least(dx, dz), dyz = iso_warp_least(dy, dz);
    iso_warp_primitive best;
    best.step = ISO_MAKE_VEC3(0.0, 0.0, 0.0);
    best.depth = 0.0;
    best.axes = 4;
    best = iso_warp_better(best, ISO_MAKE_VEC3(sx, 0.0, 0.0), 1, dx, coarse, mode);
    best = iso_warp_better(best, ISO_MAKE_VEC3(0.0, sy, 0.0), 1, dy, coarse, mode);
    best = iso_warp_better(best, ISO_MAKE_VEC3(0.0, 0.0, sz), 1, dz, coarse, mode);
    best = iso_warp_better(best, ISO_MAKE_VEC3(sx, sy, 0.0), 2, dxy, coarse, mode);
    best = iso_warp_better(best, ISO_MAKE_VEC3(sx, 0.0, sz), 2, dxz, coarse, mode);
    best = iso_warp_better(best, ISO_MAKE_VEC3(0.0, sy, sz), 2, dyz, coarse, mode);
    return iso_warp_better(best, ISO_MAKE_VEC3(sx, sy, sz), 3, iso_warp_least(dxy, dz), coarse, mode);
}

/* Maps an axis along the face at depth v: over a coarse cell a trapezoid (Eq. 6), between cells a triangle (Eq. 8).
 * Returns (position among the fine samples, position among the coarse ones). */
ISO_FUNCTION ISO_VEC3 iso_warp_along(ISO_REAL x, ISO_REAL v)
{
    ISO_REAL cell = 2.0 * ISO_FLOOR(0.5 * x), local = x - cell;
    ISO_REAL u = (local - 0.5 + v) / (1.0 + 2.0 * v);
    if (local >= 0.5 - v && local <= 1.5 + v)
        return ISO_MAKE_VEC3(cell + 0.5 + u, cell + 2.0 * u, 0.0);
    ISO_REAL apex = local > 1.0 ? cell + 2.0 : cell;
    ISO_REAL shrunk = v < 0.5 ? (x - apex + 0.5 - v) / (1.0 - 2.0 * v) : 0.5;
    return ISO_MAKE_VEC3(apex - 0.5 + shrunk, apex, 0.0);
}

ISO_FUNCTION ISO_VEC3 iso_warp_corrected_axis(ISO_REAL p, ISO_REAL step, ISO_REAL side, ISO_REAL v)
{
    ISO_REAL face = step > 0.0 ? side : 0.0;
    if (step == 0.0)
        return iso_warp_along(p, v);
    return ISO_MAKE_VEC3(v < 0.5 ? face + (p - face) / (1.0 - 2.0 * v) : face, face, 0.0);
}

/* Maps an axis across the primitive. crossing: the axis with the farthest face, at depth v: there v' = 2v (Eq. 7, 9).
 * The others are triangles with their apex on the face. */
ISO_FUNCTION ISO_REAL iso_warp_written_axis(ISO_REAL p, ISO_REAL step, ISO_REAL side, ISO_REAL depth, bool crossing)
{
    ISO_REAL v = iso_warp_least(depth, 0.5 - ISO_WARP_NEAR);
    ISO_REAL face = step > 0.0 ? side : 0.0;
    if (step == 0.0)
        return iso_warp_along(p, v).x;
    return crossing ? face + step * (2.0 * depth - 0.5) : face - 0.5 + (p - face + 0.5 - v) / (1.0 - 2.0 * v);
}

ISO_FUNCTION bool iso_warp_crosses(ISO_REAL p, ISO_REAL step, ISO_REAL side, ISO_REAL v)
{
    return step != 0.0 && 0.5 - ISO_ABS(p - (step > 0.0 ? side : 0.0)) <= v;
}

/* Computes the fetch by section 4.2, step 4. */
ISO_FUNCTION iso_warp_fetch iso_warp_place(ISO_VEC3 p, ISO_REAL side, ISO_UINT coarse, int mode)
{
    iso_warp_primitive at = iso_warp_choose(p, side, coarse, mode);
    iso_warp_fetch fetch;
    fetch.top = p;
    fetch.foot = p;
    fetch.step = at.step;
    fetch.part = 0.0;
    if (at.depth <= 0.0)
        return fetch;
    ISO_REAL v = at.depth;
    if (mode == ISO_TRANSITION_CORRECTED) {
        ISO_VEC3 x = iso_warp_corrected_axis(p.x, at.step.x, side, v),
                 y = iso_warp_corrected_axis(p.y, at.step.y, side, v),
                 z = iso_warp_corrected_axis(p.z, at.step.z, side, v);
        fetch.top = ISO_MAKE_VEC3(x.x, y.x, z.x);
        fetch.foot = ISO_MAKE_VEC3(x.y, y.y, z.y);
        fetch.part = 2.0 * v;
        return fetch;
    }
    bool cx = iso_warp_crosses(p.x, at.step.x, side, v);
    bool cy = !cx && iso_warp_crosses(p.y, at.step.y, side, v);
    bool cz = !cx && !cy && iso_warp_crosses(p.z, at.step.z, side, v);
    fetch.top = ISO_MAKE_VEC3(iso_warp_written_axis(p.x, at.step.x, side, v, cx),
                              iso_warp_written_axis(p.y, at.step.y, side, v, cy),
                              iso_warp_written_axis(p.z, at.step.z, side, v, cz));
    return fetch;
}
