/* SPDX-License-Identifier: MIT */
#include "lab/warp.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* ---- positions of fetches: in voxels from a brick's low corner, fine samples at i + 1/2, coarse ones at 2 j --- */

#define WARP_NEAR 1e-12 /* the least 1/2 - v: a few of its type's steps */

/* The coarse neighbor whose primitive contains a point, and the depth of the point in it. */
typedef struct iso_warp_primitive {
    iso_vec3 step; /* towards the neighbor, each -1, 0 or 1 */
    double depth;  /* v, at most 1/2; 0: in none */
    int axes;      /* across it: 1 face, 2 edge, 3 corner */
} iso_warp_primitive;

/* The value is (1 - part) F(top) + part C(foot). F is trilinear among the brick's own samples and their border, which has
 * coarse samples in mode written. C is trilinear among the samples of the coarse neighbor at `step`. */
typedef struct iso_warp_fetch {
    iso_vec3 top, foot, step;
    double part;
} iso_warp_fetch;

/* Returns the bit of a neighbor among 26. */
static int iso_warp_bit(iso_vec3 step)
{
    return 13 + (int)step.x + 3 * (int)step.y + 9 * (int)step.z;
}

/* Returns the better primitive. Written: faces before edges before corners (section 4.1); corrected: the deepest, and
 * of equals the one with fewer axes. */
static iso_warp_primitive iso_warp_better(iso_warp_primitive best, iso_vec3 step, int axes, double depth,
                                          unsigned coarse, int mode)
{
    bool holds = depth > 0.0 && (coarse >> iso_warp_bit(step) & 1u) != 0u;
    bool deeper = depth > best.depth, simpler = axes < best.axes;
    bool wins = mode == ISO_WARP_CORRECTED ? deeper || (depth == best.depth && simpler)
                                           : simpler || (axes == best.axes && deeper);
    if (holds && wins) {
        best.step = step;
        best.depth = depth;
        best.axes = axes;
    }
    return best;
}

static double iso_warp_least(double a, double b)
{
    return a < b ? a : b;
}

/* Chooses a primitive by section 4.2, steps 1 to 3. */
static iso_warp_primitive iso_warp_choose(iso_vec3 p, double side, unsigned coarse, int mode)
{
    double sx = p.x + p.x < side ? -1.0 : 1.0, dx = 0.5 - iso_warp_least(p.x, side - p.x);
    double sy = p.y + p.y < side ? -1.0 : 1.0, dy = 0.5 - iso_warp_least(p.y, side - p.y);
    double sz = p.z + p.z < side ? -1.0 : 1.0, dz = 0.5 - iso_warp_least(p.z, side - p.z);
    double dxy = iso_warp_least(dx, dy), dxz = iso_warp_least(dx, dz), dyz = iso_warp_least(dy, dz);
    iso_warp_primitive best;
    best.step = iso_v3(0.0, 0.0, 0.0);
    best.depth = 0.0;
    best.axes = 4;
    best = iso_warp_better(best, iso_v3(sx, 0.0, 0.0), 1, dx, coarse, mode);
    best = iso_warp_better(best, iso_v3(0.0, sy, 0.0), 1, dy, coarse, mode);
    best = iso_warp_better(best, iso_v3(0.0, 0.0, sz), 1, dz, coarse, mode);
    best = iso_warp_better(best, iso_v3(sx, sy, 0.0), 2, dxy, coarse, mode);
    best = iso_warp_better(best, iso_v3(sx, 0.0, sz), 2, dxz, coarse, mode);
    best = iso_warp_better(best, iso_v3(0.0, sy, sz), 2, dyz, coarse, mode);
    return iso_warp_better(best, iso_v3(sx, sy, sz), 3, iso_warp_least(dxy, dz), coarse, mode);
}

/* Maps an axis along the face at depth v: over a coarse cell a trapezoid (Eq. 6), between cells a triangle (Eq. 8).
 * Returns (position among the fine samples, position among the coarse ones). */
static iso_vec3 iso_warp_along(double x, double v)
{
    double cell = 2.0 * floor(0.5 * x), local = x - cell;
    double u = (local - 0.5 + v) / (1.0 + 2.0 * v);
    if (local >= 0.5 - v && local <= 1.5 + v)
        return iso_v3(cell + 0.5 + u, cell + 2.0 * u, 0.0);
    double apex = local > 1.0 ? cell + 2.0 : cell;
    double shrunk = v < 0.5 ? (x - apex + 0.5 - v) / (1.0 - 2.0 * v) : 0.5;
    return iso_v3(apex - 0.5 + shrunk, apex, 0.0);
}

static iso_vec3 iso_warp_corrected_axis(double p, double step, double side, double v)
{
    double face = step > 0.0 ? side : 0.0;
    if (step == 0.0)
        return iso_warp_along(p, v);
    return iso_v3(v < 0.5 ? face + (p - face) / (1.0 - 2.0 * v) : face, face, 0.0);
}

/* Maps an axis across the primitive. crossing: the axis with the farthest face, at depth v: there v' = 2v (Eq. 7, 9).
 * The others are triangles with their apex on the face. */
static double iso_warp_written_axis(double p, double step, double side, double depth, bool crossing)
{
    double v = iso_warp_least(depth, 0.5 - WARP_NEAR);
    double face = step > 0.0 ? side : 0.0;
    if (step == 0.0)
        return iso_warp_along(p, v).x;
    return crossing ? face + step * (2.0 * depth - 0.5) : face - 0.5 + (p - face + 0.5 - v) / (1.0 - 2.0 * v);
}

static bool iso_warp_crosses(double p, double step, double side, double v)
{
    return step != 0.0 && 0.5 - fabs(p - (step > 0.0 ? side : 0.0)) <= v;
}

/* Computes the fetch by section 4.2, step 4. */
static iso_warp_fetch iso_warp_place(iso_vec3 p, double side, unsigned coarse, int mode)
{
    iso_warp_primitive at = iso_warp_choose(p, side, coarse, mode);
    iso_warp_fetch fetch;
    fetch.top = p;
    fetch.foot = p;
    fetch.step = at.step;
    fetch.part = 0.0;
    if (at.depth <= 0.0)
        return fetch;
    double v = at.depth;
    if (mode == ISO_WARP_CORRECTED) {
        iso_vec3 x = iso_warp_corrected_axis(p.x, at.step.x, side, v),
                 y = iso_warp_corrected_axis(p.y, at.step.y, side, v),
                 z = iso_warp_corrected_axis(p.z, at.step.z, side, v);
        fetch.top = iso_v3(x.x, y.x, z.x);
        fetch.foot = iso_v3(x.y, y.y, z.y);
        fetch.part = 2.0 * v;
        return fetch;
    }
    bool cx = iso_warp_crosses(p.x, at.step.x, side, v);
    bool cy = !cx && iso_warp_crosses(p.y, at.step.y, side, v);
    bool cz = !cx && !cy && iso_warp_crosses(p.z, at.step.z, side, v);
    fetch.top = iso_v3(iso_warp_written_axis(p.x, at.step.x, side, v, cx),
                       iso_warp_written_axis(p.y, at.step.y, side, v, cy),
                       iso_warp_written_axis(p.z, at.step.z, side, v, cz));
    return fetch;
}

/* ---- samples ------------------------------------------------------------------ */

static size_t clamp_index(long i, size_t count)
{
    return i < 0 ? 0 : i >= (long)count ? count - 1 : (size_t)i;
}

static const float *fine_at(const iso_warp_field *f, const long v[3])
{
    return f->fine +
           f->channels * (clamp_index(v[0], f->size[0]) +
                          f->size[0] * (clamp_index(v[1], f->size[1]) + f->size[1] * clamp_index(v[2], f->size[2])));
}

static const float *coarse_at(const iso_warp_field *f, const long j[3])
{
    const size_t n[3] = {f->size[0] / 2 + 1, f->size[1] / 2 + 1, f->size[2] / 2 + 1};
    return f->coarse +
           f->channels * (clamp_index(j[0], n[0]) + n[0] * (clamp_index(j[1], n[1]) + n[1] * clamp_index(j[2], n[2])));
}

typedef const float *sample_function(const iso_warp_field *f, const size_t brick[3], const long at[3]);

/* Adds part times the trilinear value of `channels` channels among samples at integer positions of q. */
static void add_trilinear(const iso_warp_field *f, const size_t brick[3], sample_function *sample, const double q[3],
                          double part, size_t channels, double *out)
{
    long lo[3];
    double fraction[3];
    for (int a = 0; a < 3; ++a) {
        lo[a] = (long)floor(q[a]);
        fraction[a] = q[a] - (double)lo[a];
    }
    for (int c = 0; c < 8; ++c) {
        double weight = part;
        long at[3];
        for (int a = 0; a < 3; ++a) {
            weight *= c >> a & 1 ? fraction[a] : 1 - fraction[a];
            at[a] = lo[a] + (c >> a & 1);
        }
        if (weight == 0)
            continue;
        const float *value = sample(f, brick, at);
        for (size_t k = 0; k < channels; ++k)
            out[k] += weight * (double)value[k];
    }
}

static const float *sample_fine(const iso_warp_field *f, const size_t brick[3], const long at[3])
{
    (void)brick;
    return fine_at(f, at);
}

static const float *sample_coarse(const iso_warp_field *f, const size_t brick[3], const long at[3])
{
    (void)brick;
    return coarse_at(f, at);
}

/* ---- neighbors ---------------------------------------------------------------- */

static bool is_coarse(const iso_warp_field *f, const size_t brick[3], const int step[3])
{
    size_t index = 0;
    for (int a = 2; a >= 0; --a) {
        size_t count = iso_warp_bricks(f, a);
        long b = (long)brick[a] + step[a];
        if (b < 0 || b >= (long)count)
            return false; /* outside the volume there is no coarser brick */
        index = index * count + (size_t)b;
    }
    return f->levels[index] > 0;
}

unsigned iso_warp_neighbors(const iso_warp_field *f, const size_t brick[3])
{
    unsigned bits = 0;
    const int here[3] = {0, 0, 0};
    if (is_coarse(f, brick, here))
        return 0;
    for (int k = 0; k < 27; ++k) {
        const int step[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
        if (is_coarse(f, brick, step))
            bits |= 1u << iso_warp_bit(iso_v3(step[0], step[1], step[2]));
    }
    return bits;
}

/* True if a coarse brick is at `step` or at some of its components: the neighbors of a border voxel. */
static bool adjoins_coarse(const iso_warp_field *f, const size_t brick[3], const int step[3])
{
    for (int part = 1; part < 8; ++part) {
        int some[3];
        bool within = true;
        for (int a = 0; a < 3; ++a) {
            some[a] = part >> a & 1 ? step[a] : 0;
            within = within && (!(part >> a & 1) || step[a] != 0);
        }
        if (within && is_coarse(f, brick, some))
            return true;
    }
    return false;
}

/* Returns a fine brick's border voxel: the nearest coarse sample if it adjoins a coarse brick (section 4.3). */
static const float *sample_fixed_up(const iso_warp_field *f, const size_t brick[3], const long at[3])
{
    int step[3];
    long nearest[3];
    bool inside = true;
    for (int a = 0; a < 3; ++a) {
        long first = (long)(brick[a] * f->brick_voxels), last = first + (long)f->brick_voxels - 1;
        step[a] = at[a] < first ? -1 : at[a] > last;
        inside = inside && step[a] == 0;
        /* The center is at + 1/2; coarse samples are at even positions, outside on the face. */
        nearest[a] = step[a] < 0 ? first / 2 : step[a] > 0 ? (last + 1) / 2 : (at[a] + 1) / 2;
    }
    if (inside || !adjoins_coarse(f, brick, step))
        return fine_at(f, at);
    return coarse_at(f, nearest);
}

/* ---- field ---------------------------------------------------------------------- */

static void sample_in(const iso_warp_field *f, const size_t brick[3], const double p[3], size_t channels, double *out)
{
    const int here[3] = {0, 0, 0};
    const double half[3] = {0.5 * p[0], 0.5 * p[1], 0.5 * p[2]};
    memset(out, 0, channels * sizeof *out);
    if (is_coarse(f, brick, here)) {
        add_trilinear(f, brick, sample_coarse, half, 1, channels, out); /* coarse samples at 2 j */
        return;
    }
    const double side = (double)f->brick_voxels;
    const iso_vec3 low = {side * (double)brick[0], side * (double)brick[1], side * (double)brick[2]};
    iso_warp_fetch at = {.top = iso_sub(iso_v3(p[0], p[1], p[2]), low)};
    if (f->mode != ISO_WARP_NONE)
        at = iso_warp_place(at.top, side, iso_warp_neighbors(f, brick), (int)f->mode);
    const iso_vec3 top = iso_add(low, at.top), foot = iso_add(low, at.foot);
    if (at.part < 1)
        add_trilinear(f, brick, f->mode == ISO_WARP_WRITTEN ? sample_fixed_up : sample_fine,
                      (const double[3]){top.x - 0.5, top.y - 0.5, top.z - 0.5}, 1 - at.part, channels, out);
    if (at.part > 0)
        add_trilinear(f, brick, sample_coarse, (const double[3]){0.5 * foot.x, 0.5 * foot.y, 0.5 * foot.z}, at.part,
                      channels, out);
}

double iso_warp_sample_in(const iso_warp_field *f, const size_t brick[3], const double p[3])
{
    double value;
    sample_in(f, brick, p, 1, &value);
    return value;
}

/* ---- creation ------------------------------------------------------------------- */

/* Computes coarse samples: means of the eight voxels around each. */
static void fill_coarse(iso_warp_field *f, size_t count)
{
    const size_t n[2] = {f->size[0] / 2 + 1, f->size[1] / 2 + 1};
    for (size_t i = 0; i < count; ++i) {
        const long at[3] = {2 * (long)(i % n[0]), 2 * (long)(i / n[0] % n[1]), 2 * (long)(i / (n[0] * n[1]))};
        double sum[ISO_WARP_CHANNELS] = {0};
        for (int c = 0; c < 8; ++c) {
            const float *value = fine_at(f, (const long[3]){at[0] - (c & 1), at[1] - (c >> 1 & 1), at[2] - (c >> 2)});
            for (size_t k = 0; k < f->channels; ++k)
                sum[k] += (double)value[k];
        }
        for (size_t k = 0; k < f->channels; ++k)
            f->coarse[f->channels * i + k] = (float)(sum[k] / 8);
    }
}

iso_status iso_warp_field_create(iso_warp_field *f, const float *fine, size_t channels, const size_t size[3],
                                 size_t brick_voxels, iso_error *err)
{
    *f = (iso_warp_field){.fine = fine, .brick_voxels = brick_voxels, .channels = channels};
    size_t count = 1;
    if (channels < 1 || channels > ISO_WARP_CHANNELS)
        return iso_fail(err, ISO_E_RANGE, "warped bricks: %zu channels, must be 1 to %d", channels, ISO_WARP_CHANNELS);
    for (int a = 0; a < 3; ++a) {
        if (brick_voxels == 0 || brick_voxels % 2 || size[a] == 0 || size[a] % brick_voxels)
            return iso_fail(err, ISO_E_RANGE,
                            "warped bricks: %zu x %zu x %zu voxels, must be whole bricks of an even side, %zu", size[0],
                            size[1], size[2], brick_voxels);
        f->size[a] = size[a];
        count *= size[a] / 2 + 1;
    }
    f->coarse = malloc(count * channels * sizeof *f->coarse);
    NEED_MEMORY(f->coarse, err, "warped bricks: no memory for %zu samples", count);
    fill_coarse(f, count);
    return ISO_OK;
}

void iso_warp_field_destroy(iso_warp_field *f)
{
    if (!f)
        return;
    free(f->coarse);
    *f = (iso_warp_field){0};
}
