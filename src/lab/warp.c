/* SPDX-License-Identifier: MIT */
#include "lab/warp.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define ISO_REAL double
#define ISO_VEC3 iso_vec3
#define ISO_MAKE_VEC3(x, y, z) iso_v3(x, y, z)
#define ISO_FLOOR(x) floor(x)
#define ISO_ABS(x) fabs(x)
#define ISO_INT(x) ((int)(x))
#define ISO_WARP_NEAR 1e-12
#include "lab/warp_map.h"

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

void iso_warp_sample(const iso_warp_field *f, iso_vec3 index, double out[ISO_WARP_CHANNELS])
{
    double p[3] = {index.x, index.y, index.z};
    size_t brick[3];
    for (int a = 0; a < 3; ++a) {
        p[a] = fmin(fmax(p[a], 0), (double)f->size[a]);
        size_t b = (size_t)(p[a] / (double)f->brick_voxels), last = iso_warp_bricks(f, a) - 1;
        brick[a] = b < last ? b : last;
    }
    sample_in(f, brick, p, f->channels, out);
}

size_t iso_warp_cache_side(const iso_warp_field *f, const size_t brick[3])
{
    const int here[3] = {0, 0, 0};
    return is_coarse(f, brick, here) ? f->brick_voxels / 2 + 1 : f->brick_voxels + 2;
}

void iso_warp_bake(const iso_warp_field *f, const size_t brick[3], float *restrict out)
{
    const size_t side = iso_warp_cache_side(f, brick);
    const bool coarse = side != f->brick_voxels + 2;
    sample_function *sample = coarse ? sample_coarse : f->mode == ISO_WARP_WRITTEN ? sample_fixed_up : sample_fine;
    const long step = (long)f->brick_voxels / (coarse ? 2 : 1), border = coarse ? 0 : 1;
    for (size_t i = 0; i < side * side * side; ++i) {
        const long at[3] = {(long)brick[0] * step + (long)(i % side) - border,
                            (long)brick[1] * step + (long)(i / side % side) - border,
                            (long)brick[2] * step + (long)(i / (side * side)) - border};
        memcpy(out + f->channels * i, sample(f, brick, at), f->channels * sizeof *out);
    }
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
    if (!f->coarse)
        return iso_fail(err, ISO_E_MEMORY, "warped bricks: no memory for %zu samples", count);
    fill_coarse(f, count);
    return ISO_OK;
}

iso_status iso_warp_field_of_level(iso_warp_field *f, const iso_level *level, iso_code code, size_t brick_voxels,
                                   iso_error *err)
{
    const size_t *from = level->geometry.size;
    size_t size[3], count = 1;
    *f = (iso_warp_field){0};
    if (brick_voxels == 0)
        return iso_fail(err, ISO_E_RANGE, "warped bricks: 0 voxels per side, must be at least 1");
    for (int a = 0; a < 3; ++a)
        count *= size[a] = (from[a] + brick_voxels - 1) / brick_voxels * brick_voxels;
    float *fine = malloc(count * ISO_WARP_CHANNELS * sizeof *fine);
    float *row = malloc(3 * from[0] * sizeof *row);
    if (!fine || !row) {
        free(fine);
        free(row);
        return iso_fail(err, ISO_E_MEMORY, "warped bricks: no memory for %zu voxels", count);
    }
    for (size_t yz = 0; yz < size[1] * size[2]; ++yz) {
        const size_t first = from[0] * (clamp_index((long)(yz % size[1]), from[1]) +
                                        from[1] * clamp_index((long)(yz / size[1]), from[2]));
        iso_code_decode_all(code, level->codes + 3 * first, row, from[0]);
        for (size_t x = 0; x < size[0]; ++x) {
            const size_t i = clamp_index((long)x, from[0]);
            float *voxel = fine + ISO_WARP_CHANNELS * (yz * size[0] + x);
            voxel[0] = level->scalar[first + i];
            memcpy(voxel + 1, row + 3 * i, 3 * sizeof *row);
        }
    }
    free(row);
    iso_status status = iso_warp_field_create(f, fine, ISO_WARP_CHANNELS, size, brick_voxels, err);
    f->owned = fine;
    if (status != ISO_OK)
        iso_warp_field_destroy(f);
    return status;
}

void iso_warp_field_destroy(iso_warp_field *f)
{
    if (!f)
        return;
    free(f->coarse);
    free(f->owned);
    *f = (iso_warp_field){0};
}
