/* SPDX-License-Identifier: MIT */
#include "gradient/gradient_kernel.h"

#include "base/simd.h"

/* The rows around the row (y, z), and the factors of the differences. At a
 * border the missing neighbor is the row itself and the factor 1 instead of
 * 1/2: the one-sided difference. An axis of one voxel has both neighbors
 * equal, and so no gradient. Samples of 8 and 16 bits are subtracted as
 * integers, which is exact and leaves fewer conversions. */
/* clang-format off */
#define CENTRAL(type, suffix, ctype, wide)                                                                             \
    static inline void central_at_##suffix(const ctype *const row[5], const float factor[3], size_t left, size_t x, \
                                           size_t right, float d[3])                                              \
    {                                                                                                             \
        d[0] = factor[0] * (float)((wide)row[0][right] - (wide)row[0][left]);                                     \
        d[1] = factor[1] * (float)((wide)row[2][x] - (wide)row[1][x]);                                            \
        d[2] = factor[2] * (float)((wide)row[4][x] - (wide)row[3][x]);                                            \
    }                                                                                                             \
    static inline void to_world_##suffix(const float m[9], bool diagonal, const float d[3], size_t x,             \
                                         float *restrict gx, float *restrict gy, float *restrict gz)              \
    {                                                                                                             \
        gx[x] = diagonal ? m[0] * d[0] : m[0] * d[0] + m[1] * d[1] + m[2] * d[2];                                 \
        gy[x] = diagonal ? m[4] * d[1] : m[3] * d[0] + m[4] * d[1] + m[5] * d[2];                                 \
        gz[x] = diagonal ? m[8] * d[2] : m[6] * d[0] + m[7] * d[1] + m[8] * d[2];                                 \
    }                                                                                                             \
    static inline __attribute__((always_inline)) void central_all_##suffix(                                       \
        const ctype *const row[5], const float factor[3], size_t n, const float m[9], bool diagonal,              \
        float *restrict gx, float *restrict gy, float *restrict gz)                                               \
    {                                                                                                             \
        float d[3];                                                                                               \
        const float border[3] = {1, factor[1], factor[2]};                                                        \
        for (size_t x = 1; x + 1 < n; ++x) {                                                                      \
            central_at_##suffix(row, factor, x - 1, x, x + 1, d);                                                 \
            to_world_##suffix(m, diagonal, d, x, gx, gy, gz);                                                     \
        }                                                                                                         \
        central_at_##suffix(row, border, 0, 0, n > 1, d);                                                         \
        to_world_##suffix(m, diagonal, d, 0, gx, gy, gz);                                                         \
        if (n > 1) {                                                                                              \
            central_at_##suffix(row, border, n - 2, n - 1, n - 1, d);                                             \
            to_world_##suffix(m, diagonal, d, n - 1, gx, gy, gz);                                                 \
        }                                                                                                         \
    }                                                                                                             \
    ISO_SIMD static void central_##suffix(const void *const rows[5], const float factor[3], size_t n,             \
                                          const iso_gradient_matrix *matrix, float *restrict gx,                  \
                                          float *restrict gy, float *restrict gz)                                 \
    {                                                                                                             \
        const ctype *const row[5] = {rows[0], rows[1], rows[2], rows[3], rows[4]};                                \
        const float f[3] = {factor[0], factor[1], factor[2]};                                                     \
        float m[9];                                                                                               \
        for (int i = 0; i < 9; ++i)                                                                               \
            m[i] = matrix->m[i];                                                                                  \
        if (matrix->diagonal)                                                                                     \
            central_all_##suffix(row, f, n, m, true, gx, gy, gz);                                                 \
        else                                                                                                      \
            central_all_##suffix(row, f, n, m, false, gx, gy, gz);                                                \
    }
/* clang-format on */

ISO_SAMPLE_TYPES(CENTRAL)

static void central_row(const iso_planes *p, iso_gradient_method method, const iso_gradient_matrix *matrix, size_t y,
                        size_t z, float *scratch, float *const g[3])
{
    (void)method, (void)scratch;
    const size_t nx = p->size[0], ny = p->size[1], nz = p->size[2];
    const size_t y0 = y > 0 ? y - 1 : 0, y1 = y + 1 < ny ? y + 1 : y;
    const size_t z0 = z > 0 ? z - 1 : 0, z1 = z + 1 < nz ? z + 1 : z;
    const void *const rows[5] = {iso_planes_row_at(p, y, z), iso_planes_row_at(p, y0, z), iso_planes_row_at(p, y1, z),
                                 iso_planes_row_at(p, y, z0), iso_planes_row_at(p, y, z1)};
    const float factor[3] = {0.5f, y1 - y0 == 2 ? 0.5f : 1, z1 - z0 == 2 ? 0.5f : 1};
    switch (p->type) {
#define CENTRAL_OF(type, suffix, ctype, wide) \
    case type: central_##suffix(rows, factor, nx, matrix, g[0], g[1], g[2]); break;
        ISO_SAMPLE_TYPES(CENTRAL_OF)
#undef CENTRAL_OF
    }
}

const iso_gradient_info iso_gradient_central = {
    .name = "central",
    .summary = "central differences, 6 samples",
    .samples = 6,
    .order = 2,
    .reach = 1,
    .row = central_row,
};

iso_gradient_matrix iso_gradient_matrix_from(iso_mat3 to_world)
{
    iso_gradient_matrix matrix = {.diagonal = true};
    for (int i = 0; i < 9; ++i) {
        matrix.m[i] = (float)to_world.m[i / 3][i % 3];
        if (i % 4 != 0 && matrix.m[i] != 0)
            matrix.diagonal = false;
    }
    return matrix;
}

size_t iso_gradient_scratch_count(size_t nx)
{
    return 2 * nx + 2 * ISO_GRADIENT_MOST_REACH;
}

/* ---- next to voxels without data ---- */

typedef struct sample {
    float value;
    bool is_there;
} sample;

/* Returns a sample; outside of the volume none is there. */
static sample sample_at(const iso_planes *p, ptrdiff_t x, size_t y, size_t z)
{
    if (x < 0 || (size_t)x >= p->size[0] || y >= p->size[1] || z >= p->size[2])
        return (sample){0, false};
    const void *row = iso_planes_row_at(p, y, z);
    const float value = p->type == ISO_F32 ? ((const float *)row)[x] : (float)((const double *)row)[x];
    return (sample){value, !iso_is_no_data(value)};
}

/* Returns the difference per voxel by the neighbors that are there. */
static float difference(sample before, sample at, sample after)
{
    if (before.is_there && after.is_there)
        return 0.5f * (after.value - before.value);
    return after.is_there ? after.value - at.value : before.is_there ? at.value - before.value : 0;
}

static void no_data_row(const iso_planes *p, const iso_gradient_matrix *matrix, size_t y, size_t z, float *const g[3])
{
    const float *m = matrix->m;
    for (size_t i = 0; i < p->size[0]; ++i) {
        const ptrdiff_t x = (ptrdiff_t)i;
        const sample at = sample_at(p, x, y, z);
        float d[3] = {0, 0, 0};
        if (at.is_there) {
            d[0] = difference(sample_at(p, x - 1, y, z), at, sample_at(p, x + 1, y, z));
            d[1] = difference(sample_at(p, x, y - 1, z), at, sample_at(p, x, y + 1, z));
            d[2] = difference(sample_at(p, x, y, z - 1), at, sample_at(p, x, y, z + 1));
        }
        for (size_t a = 0; a < 3; ++a)
            g[a][i] = m[3 * a] * d[0] + m[3 * a + 1] * d[1] + m[3 * a + 2] * d[2];
    }
}

void iso_gradient_row(const iso_planes *p, iso_gradient_method method, const iso_gradient_matrix *matrix, size_t y,
                      size_t z, float *scratch, float *const g[3])
{
    if (p->has_no_data && (p->type == ISO_F32 || p->type == ISO_F64))
        no_data_row(p, matrix, y, z, g);
    else
        iso_gradient_describe(method)->row(p, method, matrix, y, z, scratch, g);
}

ISO_SIMD void iso_add_weighted_row(float weight, const float *restrict row, size_t n, float *restrict sum)
{
    for (size_t x = 0; x < n; ++x)
        sum[x] += weight * row[x];
}

void iso_planes_row(const iso_planes *p, size_t y, size_t z, float *restrict row)
{
    const iso_volume v = {.geometry = {.size = {p->size[0], p->size[1], p->size[2]}},
                          .type = p->type,
                          .data = (void *)p->data};
    iso_volume_row(&v, y, z - p->first, row);
}
