#include "tf/histogram_kernel.h"

iso_phase iso_phase_at(size_t fine, size_t level, size_t coarse_count)
{
    size_t cell = fine >> level, phase = fine & (((size_t)1 << level) - 1), width = (size_t)1 << level;
    /* the centre of the fine voxel against the centre of its cell, in halves of fine voxels */
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

void iso_blend_rows(const float *const rows[4], const float weights[4], size_t count, float *restrict out)
{
    const float *r0 = rows[0], *r1 = rows[1], *r2 = rows[2], *r3 = rows[3];
    float w0 = weights[0], w1 = weights[1], w2 = weights[2], w3 = weights[3];
    for (size_t x = 0; x < count; ++x)
        out[x] = (w0 * r0[x] + w1 * r1[x]) + (w2 * r2[x] + w3 * r3[x]);
}

void iso_expand_row(const float *coarse, size_t coarse_count, size_t level, size_t fine_count, float *restrict fine)
{
    size_t width = (size_t)1 << level;
    for (size_t m = 0; m < width; ++m) {
        float offset = ((float)(2 * m + 1) - (float)width) / (float)(2 * width);
        size_t cells = fine_count > m ? (fine_count - m + width - 1) / width : 0;
        for (size_t c = 0; c < cells; ++c) {
            float other = offset < 0 ? coarse[c > 0 ? c - 1 : 0] : coarse[c + 1 < coarse_count ? c + 1 : c];
            float w = offset < 0 ? -offset : offset;
            fine[c * width + m] = (1 - w) * coarse[c] + w * other;
        }
    }
}

void iso_nearest_bins(const float *values, size_t n, float lo, float per_step, uint32_t count, uint32_t *restrict bins)
{
    const float last = (float)(count - 1);
    for (size_t x = 0; x < n; ++x) {
        float at = (values[x] - lo) * per_step;
        at = at > 0 ? at : 0;
        at = at < last ? at : last;
        bins[x] = (uint32_t)(int32_t)(at + 0.5f);
    }
}
