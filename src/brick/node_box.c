/* SPDX-License-Identifier: MIT */
#include "brick/node_box.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/simd.h"
#include "pyramid/narrow.h"

void *iso_node_buffers_take(iso_node_buffers *buffers, iso_node_buffer part, size_t bytes)
{
    if (bytes > buffers->bytes[part]) {
        free(buffers->parts[part]);
        buffers->parts[part] = malloc(bytes);
        buffers->bytes[part] = buffers->parts[part] ? bytes : 0;
    }
    return buffers->parts[part];
}

void iso_node_buffers_destroy(iso_node_buffers *buffers)
{
    for (size_t i = 0; i < ISO_BUFFER_PARTS; ++i)
        free(buffers->parts[i]);
    *buffers = (iso_node_buffers){0};
}

bool iso_node_box_place(iso_node_box *b, const size_t size[3], bool directed, iso_node_buffers *buffers,
                        iso_node_buffer part)
{
    *b = (iso_node_box){.size = {size[0], size[1], size[2]}, .channels = directed ? ISO_BOX_CHANNELS : 1};
    b->values = iso_node_buffers_take(buffers, part, b->channels * iso_node_box_count(b) * sizeof *b->values);
    return b->values != NULL;
}

/* ---- filling -------------------------------------------------------------------- */

static size_t clamped(long i, size_t last)
{
    return i < 0 ? 0 : (size_t)i < last ? (size_t)i : last;
}

/* Repeats the row's first and last node inside the level outwards. */
static void repeat_ends(float *row, size_t before, size_t count, size_t size)
{
    for (size_t x = 0; x < before; ++x)
        row[x] = row[before];
    for (size_t x = before + count; x < size; ++x)
        row[x] = row[before + count - 1];
}

void iso_node_box_fill(const iso_node_box *b, const iso_node_rows *rows, const long first[3])
{
    assert(b->channels > 0);
    const size_t from = clamped(first[0], rows->last[0]), to = clamped(first[0] + (long)b->size[0] - 1, rows->last[0]);
    const size_t before = first[0] < (long)from ? (size_t)((long)from - first[0]) : 0;
    for (size_t z = 0; z < b->size[2]; ++z)
        for (size_t y = 0; y < b->size[1]; ++y) {
            float *row[ISO_BOX_CHANNELS] = {NULL}, *inner[ISO_BOX_CHANNELS] = {NULL};
            for (size_t c = 0; c < b->channels; ++c) {
                row[c] = iso_node_box_row(b, c, y, z);
                inner[c] = row[c] + (before < b->size[0] ? before : b->size[0] - 1);
            }
            rows->read(rows->user, from, clamped(first[1] + (long)y, rows->last[1]),
                       clamped(first[2] + (long)z, rows->last[2]), to - from + 1, inner);
            for (size_t c = 0; c < b->channels; ++c)
                repeat_ends(row[c], (size_t)(inner[c] - row[c]), to - from + 1, b->size[0]);
        }
}

/* ---- level 0 -------------------------------------------------------------------- */

iso_node_voxels iso_node_voxels_of(const iso_level *level, bool directed)
{
    const double range = level->max - level->min;
    return (iso_node_voxels){
        .level = level,
        .unit = (float)(range > 0 ? iso_geometry_min_spacing_mm(&level->geometry) / range : 1),
        .matrix = iso_gradient_matrix_from(iso_geometry_gradient_to_world(&level->geometry)),
        .directed = directed,
    };
}

bool iso_voxel_box_read(iso_voxel_box *v, const iso_node_voxels *of, const size_t lo[3], const size_t hi[3],
                        iso_node_buffers *buffers)
{
    const iso_gradient_options gradient = iso_gradient_defaults();
    const size_t *n = of->level->geometry.size,
                 reach = of->directed ? iso_gradient_describe(gradient.method)->reach : 0;
    *v = (iso_voxel_box){.of = of};
    for (int a = 0; a < 3; ++a) {
        const size_t last = hi[a] + reach < n[a] ? hi[a] + reach : n[a] - 1;
        v->first[a] = lo[a] > reach ? lo[a] - reach : 0;
        v->size[a] = last - v->first[a] + 1;
    }
    const size_t nx = v->size[0], count = nx * v->size[1] * v->size[2];
    v->values = iso_node_buffers_take(buffers, ISO_BUFFER_VOXELS,
                                      (count + 3 * nx + iso_gradient_scratch_count(nx)) * sizeof *v->values);
    if (!v->values)
        return false;
    v->scratch = v->values + count;
    for (size_t z = 0; z < v->size[2]; ++z)
        for (size_t y = 0; y < v->size[1]; ++y) {
            float *row = v->values + nx * (y + v->size[1] * z);
            const float *from = iso_level_floats(of->level,
                                                 v->first[0] + n[0] * (v->first[1] + y + n[1] * (v->first[2] + z)), nx,
                                                 row);
            if (from != row)
                memcpy(row, from, nx * sizeof *row);
        }
    return true;
}

/* Computes m^2 d of each gradient m d, and m^2, the first term of its sum. */
ISO_SIMD static void moments_row(float unit, const float *restrict gx, const float *restrict gy,
                                 const float *restrict gz, size_t count, float *const rows[ISO_BOX_CHANNELS])
{
    float *restrict nx = rows[1], *restrict ny = rows[2], *restrict nz = rows[3], *restrict sum = rows[4];
    for (size_t i = 0; i < count; ++i) {
        const float x = unit * gx[i], y = unit * gy[i], z = unit * gz[i];
        const float m = sqrtf(x * x + y * y + z * z);
        nx[i] = m * x;
        ny[i] = m * y;
        nz[i] = m * z;
        sum[i] = m * m;
    }
}

void iso_voxel_box_moments(const iso_voxel_box *v, size_t x, size_t y, size_t z, size_t count,
                           float *const rows[ISO_BOX_CHANNELS])
{
    const size_t nx = v->size[0], at = x - v->first[0];
    float *const g[3] = {v->scratch, v->scratch + nx, v->scratch + 2 * nx};
    const iso_planes planes = {v->values, ISO_F32, {nx, v->size[1], v->size[2]}, 0, v->size[2], false};
    iso_gradient_row(&planes, iso_gradient_defaults().method, &v->of->matrix, y - v->first[1], z - v->first[2],
                     v->scratch + 3 * nx, g);
    moments_row(v->of->unit, g[0] + at, g[1] + at, g[2] + at, count, rows);
}

static void read_voxels(const void *user, size_t x, size_t y, size_t z, size_t count,
                        float *const rows[ISO_BOX_CHANNELS])
{
    const iso_voxel_box *v = user;
    memcpy(rows[0], iso_voxel_box_at(v, x, y, z), count * sizeof *rows[0]);
    if (v->of->directed)
        iso_voxel_box_moments(v, x, y, z, count, rows);
}

bool iso_node_box_read(const iso_node_box *b, const iso_node_voxels *v, const long first[3], iso_node_buffers *buffers)
{
    iso_node_rows rows = {.read = read_voxels};
    iso_voxel_box voxels;
    size_t lo[3], hi[3];
    for (int a = 0; a < 3; ++a) {
        rows.last[a] = v->level->geometry.size[a] - 1;
        lo[a] = clamped(first[a], rows.last[a]);
        hi[a] = clamped(first[a] + (long)b->size[a] - 1, rows.last[a]);
    }
    if (!iso_voxel_box_read(&voxels, v, lo, hi, buffers))
        return false;
    rows.user = &voxels;
    iso_node_box_fill(b, &rows, first);
    return true;
}

/* ---- filters from level to level ------------------------------------------------- */

/* Adds the weight times [1 2 1] / 4 along x, at every other node. */
ISO_SIMD static void add_smooth_row(float weight, const float *restrict fine, size_t count, float *restrict sum)
{
    const float side = 0.25f * weight, middle = 0.5f * weight;
    for (size_t x = 0; x < count; ++x) {
        float total = sum[x];
        total += side * fine[2 * x + 1];
        total += middle * fine[2 * x + 2];
        total += side * fine[2 * x + 3];
        sum[x] = total;
    }
}

/* Filters by [1 2 1]^3 / 64. */
static void filter_smooth(const iso_node_box *fine, size_t channel, const iso_node_box *coarse)
{
    static const float weights[3] = {0.25f, 0.5f, 0.25f};
    for (size_t z = 0; z < coarse->size[2]; ++z)
        for (size_t y = 0; y < coarse->size[1]; ++y) {
            float *row = iso_node_box_row(coarse, channel, y, z);
            memset(row, 0, coarse->size[0] * sizeof *row);
            for (size_t i = 0; i < 9; ++i)
                add_smooth_row(weights[i % 3] * weights[i / 3],
                               iso_node_box_row(fine, channel, 2 * y + 1 + i % 3, 2 * z + 1 + i / 3), coarse->size[0],
                               row);
        }
}

/* [-1 2 6 2 -1] / 8, the low-pass of the 5/3 wavelets [le-gall-1988]: linear interpolation of its samples is nearest to
 * the fine ones. sharp_row() applies it along x and takes the range of the three nodes in the middle. */
static const float SHARP[5] = {-0.125f, 0.25f, 0.75f, 0.25f, -0.125f};

ISO_SIMD static void sharp_row(const float *restrict fine, size_t count, float *restrict along, float *restrict lowest,
                               float *restrict highest)
{
    for (size_t x = 0; x < count; ++x) {
        const float *v = fine + 2 * x;
        float sum = 0, low = INFINITY, high = -INFINITY;
        for (size_t i = 0; i < 5; ++i)
            sum += SHARP[i] * v[i];
        for (size_t i = 1; i < 4; ++i) {
            low = v[i] < low ? v[i] : low; /* fminf() is a call */
            high = v[i] > high ? v[i] : high;
        }
        along[x] = sum;
        lowest[x] = low;
        highest[x] = high;
    }
}

/* Results of sharp_row() for each row of a fine box. */
typedef struct sharp_rows {
    const float *along, *lowest, *highest;
    size_t width, height; /* nodes along x, rows along y */
} sharp_rows;

static size_t row_at(const sharp_rows *s, size_t y, size_t z)
{
    return s->width * (y + s->height * z);
}

/* Filters along y and z, clamped to the range of the 27 nodes around, so that no new values appear. */
ISO_SIMD static void join_sharp_rows(const sharp_rows *s, size_t y, size_t z, float *restrict out)
{
    for (size_t x = 0; x < s->width; ++x) {
        float sum = 0, low = INFINITY, high = -INFINITY;
        for (size_t dz = 0; dz < 5; ++dz)
            for (size_t dy = 0; dy < 5; ++dy)
                sum += SHARP[dy] * SHARP[dz] * s->along[row_at(s, 2 * y + dy, 2 * z + dz) + x];
        for (size_t dz = 1; dz < 4; ++dz)
            for (size_t dy = 1; dy < 4; ++dy) {
                const size_t i = row_at(s, 2 * y + dy, 2 * z + dz) + x;
                low = s->lowest[i] < low ? s->lowest[i] : low;
                high = s->highest[i] > high ? s->highest[i] : high;
            }
        sum = sum > low ? sum : low;
        out[x] = sum < high ? sum : high;
    }
}

static bool filter_sharp(const iso_node_box *fine, const iso_node_box *coarse, iso_node_buffers *buffers)
{
    const size_t width = coarse->size[0], rows = fine->size[1] * fine->size[2];
    float *along = iso_node_buffers_take(buffers, ISO_BUFFER_ROWS, 3 * width * rows * sizeof *along);
    if (!along)
        return false;
    const sharp_rows s = {along, along + width * rows, along + 2 * width * rows, width, fine->size[1]};
    for (size_t i = 0; i < rows; ++i)
        sharp_row(fine->values + fine->size[0] * i, width, along + width * i, along + width * (rows + i),
                  along + width * (2 * rows + i));
    for (size_t z = 0; z < coarse->size[2]; ++z)
        for (size_t y = 0; y < coarse->size[1]; ++y)
            join_sharp_rows(&s, y, z, iso_node_box_row(coarse, ISO_BOX_SCALAR, y, z));
    return true;
}

bool iso_node_box_filter(const iso_node_box *fine, const iso_node_box *coarse, iso_node_buffers *buffers)
{
    for (size_t c = ISO_BOX_MOMENTS; c < coarse->channels; ++c)
        filter_smooth(fine, c, coarse);
    return filter_sharp(fine, coarse, buffers);
}

/* ---- conversion to nodes -------------------------------------------------------- */

/* Computes the scale of iso_node_to_direction(). */
ISO_SIMD static void scale_moments(const float *const in[ISO_BOX_CHANNELS], size_t count, double *restrict scale)
{
    for (size_t i = 0; i < count; ++i) {
        const double x = (double)in[1][i], y = (double)in[2][i], z = (double)in[3][i], sum = (double)in[4][i];
        const double norm = sqrt(x * x + y * y + z * z), length = sum > 0 ? norm / sum : 0;
        scale[i] = norm > 0 ? length * length / norm : 0;
    }
}

void iso_node_box_finish(const iso_node_box *b, float *restrict nodes)
{
    enum { BATCH = 256 };
    const size_t count = iso_node_box_count(b);
    double scale[BATCH];
    for (size_t first = 0; first < count; first += BATCH) {
        const size_t m = count - first < BATCH ? count - first : BATCH;
        const float *in[ISO_BOX_CHANNELS];
        for (size_t c = 0; c < ISO_BOX_CHANNELS; ++c)
            in[c] = b->values + (b->channels > 1 ? c * count : 0) + first;
        if (b->channels > 1)
            scale_moments(in, m, scale);
        for (size_t i = 0; i < m; ++i) {
            float *node = nodes + ISO_NODE_CHANNELS * (first + i);
            node[0] = in[0][i];
            for (size_t a = 1; a < 4; ++a)
                node[a] = b->channels > 1 ? (float)((double)in[a][i] * scale[i]) : 0;
        }
    }
}
