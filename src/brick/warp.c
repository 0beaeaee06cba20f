#include "brick/warp.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

/* ---- samples ------------------------------------------------------------------ */

static size_t clamp_index(long i, size_t count) { return i < 0 ? 0 : i >= (long)count ? count - 1 : (size_t)i; }

static double fine_at(const iso_warp_field *f, const long v[3])
{
    return (double)f->fine[clamp_index(v[0], f->size[0]) +
                           f->size[0] * (clamp_index(v[1], f->size[1]) + f->size[1] * clamp_index(v[2], f->size[2]))];
}

static double coarse_at(const iso_warp_field *f, const long j[3])
{
    const size_t n[3] = {f->size[0] / 2 + 1, f->size[1] / 2 + 1, f->size[2] / 2 + 1};
    return (double)f->coarse[clamp_index(j[0], n[0]) +
                             n[0] * (clamp_index(j[1], n[1]) + n[1] * clamp_index(j[2], n[2]))];
}

typedef double sample_function(const iso_warp_field *f, const size_t brick[3], const long at[3]);

/* Trilinear among samples at whole positions of q. */
static double trilinear(const iso_warp_field *f, const size_t brick[3], sample_function *sample, const double q[3])
{
    long lo[3];
    double part[3], value = 0;
    for (int a = 0; a < 3; ++a) {
        lo[a] = (long)floor(q[a]);
        part[a] = q[a] - (double)lo[a];
    }
    for (int c = 0; c < 8; ++c) {
        double weight = 1;
        long at[3];
        for (int a = 0; a < 3; ++a) {
            weight *= c >> a & 1 ? part[a] : 1 - part[a];
            at[a] = lo[a] + (c >> a & 1);
        }
        if (weight != 0)
            value += weight * sample(f, brick, at);
    }
    return value;
}

static double sample_fine(const iso_warp_field *f, const size_t brick[3], const long at[3])
{
    (void)brick;
    return fine_at(f, at);
}

static double sample_coarse(const iso_warp_field *f, const size_t brick[3], const long at[3])
{
    (void)brick;
    return coarse_at(f, at);
}

/* ---- neighbours ---------------------------------------------------------------- */

static bool is_coarse(const iso_warp_field *f, const size_t brick[3], const int step[3])
{
    size_t index = 0;
    for (int a = 2; a >= 0; --a) {
        size_t count = f->size[a] / f->brick_voxels;
        long b = (long)brick[a] + step[a];
        if (b < 0 || b >= (long)count)
            return false; /* outside the volume nothing is coarser */
        index = index * count + (size_t)b;
    }
    return f->levels[index] > 0;
}

/* Any of the bricks that lie at `step` or at a part of it: those that a border voxel adjoins. */
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

/* Section 4.3: a border voxel of a fine brick holds the nearest coarse sample if it adjoins a coarse brick. */
static double sample_fixed_up(const iso_warp_field *f, const size_t brick[3], const long at[3])
{
    int step[3];
    long nearest[3];
    for (int a = 0; a < 3; ++a) {
        long first = (long)(brick[a] * f->brick_voxels), last = first + (long)f->brick_voxels - 1;
        step[a] = at[a] < first ? -1 : at[a] > last;
        /* The voxel's centre is at + 1/2: even positions nearest to it; outside, the one on the face. */
        nearest[a] = step[a] < 0 ? first / 2 : step[a] > 0 ? (last + 1) / 2 : (at[a] + 1) / 2;
    }
    if (!adjoins_coarse(f, brick, step))
        return fine_at(f, at);
    return coarse_at(f, nearest);
}

/* ---- primitives ----------------------------------------------------------------- */

/* The coarse neighbour whose primitive holds a point: the direction, and the depth of the point in it. */
typedef struct primitive {
    int step[3];
    double depth; /* v, at most 1/2 */
    int axis_count;
} primitive;

static bool choose_primitive(const iso_warp_field *f, const size_t brick[3], const double p[3], primitive *best)
{
    bool found = false;
    for (int k = 0; k < 27; ++k) {
        primitive c = {.step = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1}, .depth = 0.5};
        for (int a = 0; a < 3; ++a) {
            double low = (double)(brick[a] * f->brick_voxels), high = low + (double)f->brick_voxels;
            if (c.step[a])
                c.depth = fmin(c.depth, 0.5 - (c.step[a] < 0 ? p[a] - low : high - p[a]));
            c.axis_count += c.step[a] != 0;
        }
        if (c.axis_count == 0 || c.depth <= 0 || !is_coarse(f, brick, c.step))
            continue;
        bool deeper = c.depth > best->depth, simpler = c.axis_count < best->axis_count;
        bool equal_depth = c.depth == best->depth, equal_axes = c.axis_count == best->axis_count;
        bool wins = f->mode == ISO_WARP_MENDED ? deeper || (equal_depth && simpler) : simpler || (equal_axes && deeper);
        if (!found || wins) {
            *best = c;
            found = true;
        }
    }
    return found;
}

/* An axis along the face at depth v: over a coarse cell a trapezoid (Eq. 6), between cells a triangle (Eq. 8). `low` is
 * the fine sample at its lower end, u the place between it and the next, foot the place among the coarse samples. */
static void map_along(double x, double v, double *low, double *u, double *foot)
{
    double cell = 2 * floor(x / 2), local = x - cell;
    if (local >= 0.5 - v && local <= 1.5 + v) {
        *u = (local - 0.5 + v) / (1 + 2 * v);
        *low = cell + 0.5;
        *foot = cell + 2 * *u;
        return;
    }
    double apex = local > 1 ? cell + 2 : cell;
    *low = apex - 0.5;
    *u = (x - *low - v) / (1 - 2 * v);
    *foot = apex;
}

/* Two fetches: (1 - 2v) F(top) + 2v C(foot). */
static double evaluate_mended(const iso_warp_field *f, const size_t brick[3], const double p[3], const primitive *at)
{
    double top[3], foot[3], v = at->depth;
    for (int a = 0; a < 3; ++a) {
        double face = (double)((brick[a] + (at->step[a] > 0)) * f->brick_voxels), low, u;
        if (at->step[a]) {
            foot[a] = face;
            top[a] = v < 0.5 ? face + (p[a] - face) / (1 - 2 * v) : face;
        } else {
            map_along(p[a], v, &low, &u, &foot[a]);
            top[a] = low + u;
        }
    }
    for (int a = 0; a < 3; ++a) {
        top[a] -= 0.5; /* fine samples at i + 1/2, coarse ones at 2 j */
        foot[a] /= 2;
    }
    double fine = v < 0.5 ? trilinear(f, brick, sample_fine, top) : 0;
    return (1 - 2 * v) * fine + 2 * v * trilinear(f, brick, sample_coarse, foot);
}

/* One fetch at the warped place: v' = 2v across the axis whose face is the farthest (its depth is v), Eq. 6 or 8 along
 * the others; an edge's or a corner's own axes are always triangles with their apex on the face. */
static double evaluate_written(const iso_warp_field *f, const size_t brick[3], const double p[3], const primitive *at)
{
    double place[3], v = fmin(at->depth, 0.5 - 1e-12);
    bool crossed = false;
    for (int a = 0; a < 3; ++a) {
        double face = (double)((brick[a] + (at->step[a] > 0)) * f->brick_voxels), low, u, foot;
        if (at->step[a] && !crossed && 0.5 - fabs(p[a] - face) <= at->depth) {
            place[a] = face + at->step[a] * (2 * at->depth - 0.5) - 0.5;
            crossed = true;
        } else if (at->step[a]) {
            place[a] = face - 1 + (p[a] - face + 0.5 - v) / (1 - 2 * v);
        } else {
            map_along(p[a], v, &low, &u, &foot);
            place[a] = low + u - 0.5;
        }
    }
    return trilinear(f, brick, sample_fixed_up, place);
}

double iso_warp_sample_in(const iso_warp_field *f, const size_t brick[3], const double p[3])
{
    const int here[3] = {0, 0, 0};
    if (is_coarse(f, brick, here))
        return trilinear(f, brick, sample_coarse, (const double[3]){p[0] / 2, p[1] / 2, p[2] / 2});
    primitive at = {.axis_count = 4};
    if (f->mode != ISO_WARP_NONE && choose_primitive(f, brick, p, &at))
        return f->mode == ISO_WARP_MENDED ? evaluate_mended(f, brick, p, &at) : evaluate_written(f, brick, p, &at);
    return trilinear(f, brick, sample_fine, (const double[3]){p[0] - 0.5, p[1] - 0.5, p[2] - 0.5});
}

/* ---- life ----------------------------------------------------------------------- */

iso_status iso_warp_field_create(iso_warp_field *f, const float *fine, const size_t size[3], size_t brick_voxels,
                                 iso_error *err)
{
    *f = (iso_warp_field){.fine = fine, .brick_voxels = brick_voxels};
    size_t count = 1;
    for (int a = 0; a < 3; ++a) {
        if (brick_voxels == 0 || brick_voxels % 2 || size[a] == 0 || size[a] % brick_voxels)
            return iso_fail(err, ISO_E_RANGE, "warped bricks: %zu x %zu x %zu voxels, must be whole bricks of an even side, %zu",
                            size[0], size[1], size[2], brick_voxels);
        f->size[a] = size[a];
        count *= size[a] / 2 + 1;
    }
    f->coarse = malloc(count * sizeof *f->coarse);
    if (!f->coarse)
        return iso_fail(err, ISO_E_MEMORY, "warped bricks: no memory for %zu samples", count);
    for (size_t i = 0; i < count; ++i) {
        const size_t n[2] = {size[0] / 2 + 1, size[1] / 2 + 1};
        const long at[3] = {2 * (long)(i % n[0]), 2 * (long)(i / n[0] % n[1]), 2 * (long)(i / (n[0] * n[1]))};
        double sum = 0;
        for (int c = 0; c < 8; ++c)
            sum += fine_at(f, (const long[3]){at[0] - (c & 1), at[1] - (c >> 1 & 1), at[2] - (c >> 2)});
        f->coarse[i] = (float)(sum / 8);
    }
    return ISO_OK;
}

void iso_warp_field_destroy(iso_warp_field *f)
{
    if (!f)
        return;
    free(f->coarse);
    *f = (iso_warp_field){0};
}
