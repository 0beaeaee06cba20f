/* SPDX-License-Identifier: MIT */
#include "tf/histogram_kernel.h"

#include "base/simd.h"

iso_phase iso_phase_at(size_t fine, size_t level, size_t coarse_count)
{
    size_t cell = fine >> level, phase = fine & (((size_t)1 << level) - 1), width = (size_t)1 << level;
    /* from the cell's center to the fine voxel's, in cells */
    float offset = ((float)(2 * phase + 1) - (float)width) / (float)(2 * width);
    iso_phase p = {cell, cell, 1, 0};
    if (offset < 0) {
        p.left = cell > 0 ? cell - 1 : 0;
        p.weight_left = -offset, p.weight_right = 1 + offset;
    } else {
        p.right = cell + 1 < coarse_count ? cell + 1 : cell;
        p.weight_left = 1 - offset, p.weight_right = offset;
    }
    return p;
}

ISO_SIMD void iso_blend_rows(const float *const rows[4], const float weights[4], iso_row_scale scale, size_t count,
                             float *restrict out)
{
    const float *r0 = rows[0], *r1 = rows[1], *r2 = rows[2], *r3 = rows[3];
    const float w0 = weights[0], w1 = weights[1], w2 = weights[2], w3 = weights[3], last = scale.last;
    for (size_t x = 0; x < count; ++x) {
        float at = ((w0 * r0[x] + w1 * r1[x]) + (w2 * r2[x] + w3 * r3[x]) - scale.lo) * scale.per_step;
        at = at > 0 ? at : 0;
        out[x + 1] = (at < last ? at : last) + 0.5f;
    }
    out[0] = out[1];
    out[count + 1] = out[count];
}

/* Expands the cells [0, cells) of a level whose voxels are `width` wide. After inlining, `width` is a constant: the
 * inner loop unrolls and its stores become vectors. */
static inline __attribute__((always_inline)) void expand_cells(const float *row, size_t width, size_t cells,
                                                               uint32_t *restrict bins)
{
    for (size_t c = 0; c < cells; ++c) {
        const float left = row[c], own = row[c + 1], right = row[c + 2];
        for (size_t m = 0; m < width; ++m) {
            const float offset = ((float)(2 * m + 1) - (float)width) / (float)(2 * width);
            const float at = offset < 0 ? (1 + offset) * own - offset * left : (1 - offset) * own + offset * right;
            bins[c * width + m] = (uint32_t)(int32_t)at;
        }
    }
}

ISO_SIMD static void expand_by_2(const float *row, size_t cells, uint32_t *restrict bins)
{
    expand_cells(row, 2, cells, bins);
}

ISO_SIMD static void expand_by_4(const float *row, size_t cells, uint32_t *restrict bins)
{
    expand_cells(row, 4, cells, bins);
}

ISO_SIMD static void expand_by_8(const float *row, size_t cells, uint32_t *restrict bins)
{
    expand_cells(row, 8, cells, bins);
}

void iso_expand_bins(const float *row, size_t level, size_t fine_count, uint32_t *restrict bins)
{
    const size_t width = (size_t)1 << level, cells = fine_count >> level;
    switch (level) {
    case 1: expand_by_2(row, cells, bins); break;
    case 2: expand_by_4(row, cells, bins); break;
    case 3: expand_by_8(row, cells, bins); break;
    default: expand_cells(row, width, cells, bins); break;
    }
    for (size_t x = cells * width; x < fine_count; ++x) { /* the last cell is cut off by the edge */
        const float offset = ((float)(2 * (x - cells * width) + 1) - (float)width) / (float)(2 * width),
                    *own = row + cells + 1;
        bins[x] = (uint32_t)(int32_t)(offset < 0 ? (1 + offset) * own[0] - offset * own[-1]
                                                 : (1 - offset) * own[0] + offset * own[1]);
    }
}

ISO_SIMD void iso_join_bins(const float *values, size_t n, iso_row_scale scale, uint32_t z_count,
                            uint32_t *restrict keys)
{
    for (size_t x = 0; x < n; ++x) {
        float at = (values[x] - scale.lo) * scale.per_step;
        at = at > 0 ? at : 0;
        at = at < scale.last ? at : scale.last;
        keys[x] = keys[x] * z_count + (uint32_t)(int32_t)(at + 0.5f);
    }
}

void iso_count_keys(const uint32_t *keys, size_t n, uint32_t *even, uint32_t *odd)
{
    size_t x = 0;
    for (; x + 8 <= n; x += 8) {
        const uint32_t *k = keys + x, first = k[0];
        uint32_t other = 0;
        for (int i = 1; i < 8; ++i)
            other |= k[i] ^ first;
        if (!other) {
            even[first] += 8;
            continue;
        }
        for (int i = 0; i < 8; i += 2) {
            ++even[k[i]];
            ++odd[k[i + 1]];
        }
    }
    for (; x < n; ++x)
        ++even[keys[x]];
}
