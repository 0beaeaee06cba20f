/* SPDX-License-Identifier: MIT */
/* gradient_stencil.c - the estimators other than central differences: sums of
 * rows along z and y, then stencils along x, in floats. */
#include <string.h>

#include "base/simd.h"
#include "gradient/gradient_kernel.h"

enum { OFFSETS = 5, MIDDLE = 2 }; /* -2 .. 2 */

/* Computes weights of the samples i - 2 .. i + 2 for the derivative at sample i of n. All are exact on linear data,
 * borders included. */
static void derivative_weights(iso_gradient_method method, size_t i, size_t n, float w[OFFSETS])
{
    memset(w, 0, OFFSETS * sizeof *w);
    const size_t after = n - 1 - i;
    float *at = w + MIDDLE;
    if (n == 1)
        return;
    if (method == ISO_GRADIENT_INTERMEDIATE && after > 0) { /* to the next sample */
        at[0] = -1, at[1] = 1;
    } else if (method == ISO_GRADIENT_FOURTH && i >= 2 && after >= 2) { /* Taylor: f' + O(h^4) */
        at[-2] = 1.0f / 12, at[-1] = -8.0f / 12, at[1] = 8.0f / 12, at[2] = -1.0f / 12;
    } else if (method == ISO_GRADIENT_SMOOTH && i >= 2 && after >= 2) { /* central differences of means by 1 2 1 */
        at[-2] = -0.125f, at[-1] = -0.25f, at[1] = 0.25f, at[2] = 0.125f;
    } else if (method == ISO_GRADIENT_FOURTH && i == 0 && n > 2) { /* one-sided, of second order */
        at[0] = -1.5f, at[1] = 2, at[2] = -0.5f;
    } else if (method == ISO_GRADIENT_FOURTH && after == 0 && n > 2) {
        at[0] = 1.5f, at[-1] = -2, at[-2] = 0.5f;
    } else if (i > 0 && after > 0) {
        at[-1] = -0.5f, at[1] = 0.5f;
    } else if (after > 0) {
        at[0] = -1, at[1] = 1;
    } else {
        at[-1] = -1, at[0] = 1;
    }
}

static bool smooths(iso_gradient_method method)
{
    return method == ISO_GRADIENT_SOBEL || method == ISO_GRADIENT_CORNERS || method == ISO_GRADIENT_SMOOTH;
}

/* Computes the weights across: 1 2 1, or 1 4 6 4 1 of the 5x5x5 operator. The edge's sample replaces a missing one. */
static void smoothing_weights(iso_gradient_method method, size_t i, size_t n, float w[OFFSETS])
{
    static const float wide[OFFSETS] = {1 / 16.0f, 4 / 16.0f, 6 / 16.0f, 4 / 16.0f, 1 / 16.0f};
    memset(w, 0, OFFSETS * sizeof *w);
    if (method == ISO_GRADIENT_SMOOTH && i >= 2 && i + 2 < n) {
        memcpy(w, wide, sizeof wide);
        return;
    }
    w[MIDDLE] = 0.5f;
    w[i > 0 ? MIDDLE - 1 : MIDDLE] += 0.25f;
    w[i + 1 < n ? MIDDLE + 1 : MIDDLE] += 0.25f;
}

static const float only_middle[OFFSETS] = {0, 0, 1, 0, 0};

/* Sums the rows around (y, z), weighted along both axes. */
static void sum_rows(const iso_planes *p, size_t y, size_t z, const float wy[OFFSETS], const float wz[OFFSETS],
                     float *row, float *restrict sum)
{
    memset(sum, 0, p->size[0] * sizeof *sum);
    for (size_t c = 0; c < OFFSETS; ++c)
        for (size_t b = 0; b < OFFSETS; ++b) {
            if (wy[b] == 0 || wz[c] == 0)
                continue;
            iso_planes_row(p, y + b - MIDDLE, z + c - MIDDLE, row);
            iso_add_weighted_row(wy[b] * wz[c], row, p->size[0], sum);
        }
}

ISO_SIMD static void stencil_inside(const float w[OFFSETS], const float *restrict row, size_t n, float *restrict out)
{
    for (size_t x = 2; x + 2 < n; ++x)
        out[x] = (w[0] * row[x - 2] + w[4] * row[x + 2]) + (w[1] * row[x - 1] + w[3] * row[x + 1]) + w[2] * row[x];
}

/* Has the same sums as stencil_inside(), so that a box of a volume has the same bits as the whole. */
static float stencil_at(const float w[OFFSETS], const float *row, size_t x)
{
    float part[OFFSETS];
    for (size_t o = 0; o < OFFSETS; ++o)
        part[o] = w[o] != 0 ? w[o] * row[x + o - MIDDLE] : 0;
    return (part[0] + part[4]) + (part[1] + part[3]) + part[2];
}

static void along_x(iso_gradient_method method, bool derivative, const float *restrict row, size_t n,
                    float *restrict out)
{
    float w[OFFSETS];
    for (size_t x = 0; x < n; ++x) {
        if (x == 2 && n > 5) { /* all inner samples at once */
            if (derivative)
                derivative_weights(method, x, n, w);
            else
                smoothing_weights(method, x, n, w);
            stencil_inside(w, row, n, out);
            x = n - 2;
        }
        if (derivative)
            derivative_weights(method, x, n, w);
        else
            smoothing_weights(method, x, n, w);
        out[x] = stencil_at(w, row, x);
    }
}

/* Sums the rows of a voxel's corners, signed. The 8 corners, half a step away along each axis, are means of 8 samples,
 * as a trilinear fetch returns them [sigg-2005]. At voxel centers their differences are those of the 3x3x3 Sobel
 * operator: two halves (1 1) make (1 2 1). */
static void corner_rows(const iso_planes *p, size_t y, size_t z, float sign_y, float sign_z, float *row,
                        float *restrict sum)
{
    const size_t ny = p->size[1], nz = p->size[2];
    const float edge_y = sign_y < 0 && ny > 1 && (y == 0 || y + 1 == ny) ? 2
                                                                         : 1; /* one side is missing: twice the other */
    const float edge_z = sign_z < 0 && nz > 1 && (z == 0 || z + 1 == nz) ? 2 : 1;
    memset(sum, 0, p->size[0] * sizeof *sum);
    for (size_t corner = 0; corner < 4; ++corner) {
        const bool up_y = corner & 1, up_z = corner & 2;
        const size_t y1 = up_y ? (y + 1 < ny ? y + 1 : y) : y > 0 ? y - 1 : y;
        const size_t z1 = up_z ? (z + 1 < nz ? z + 1 : z) : z > 0 ? z - 1 : z;
        const float weight = 0.25f * edge_y * edge_z * (up_y ? 1 : sign_y) * (up_z ? 1 : sign_z) *
                             (sign_y < 0 ? 2 : 1) * (sign_z < 0 ? 2 : 1);
        const size_t rows[4][2] = {{y, z}, {y1, z}, {y, z1}, {y1, z1}};
        for (size_t r = 0; r < 4; ++r) {
            iso_planes_row(p, rows[r][0], rows[r][1], row);
            iso_add_weighted_row(0.25f * weight, row, p->size[0], sum);
        }
    }
}

ISO_SIMD void iso_gradient_to_world(const iso_gradient_matrix *matrix, size_t n, float *restrict gx, float *restrict gy,
                                    float *restrict gz)
{
    float m[9];
    memcpy(m, matrix->m, sizeof m);
    for (size_t x = 0; x < n; ++x) {
        float dx = gx[x], dy = gy[x], dz = gz[x];
        gx[x] = m[0] * dx + m[1] * dy + m[2] * dz;
        gy[x] = m[3] * dx + m[4] * dy + m[5] * dz;
        gz[x] = m[6] * dx + m[7] * dy + m[8] * dz;
    }
}

static void stencil_row(const iso_planes *p, iso_gradient_method method, const iso_gradient_matrix *matrix, size_t y,
                        size_t z, float *scratch, float *const g[3])
{
    const size_t n = p->size[0];
    float *row = scratch, *sum = scratch + n;
    float dy[OFFSETS], dz[OFFSETS], sy[OFFSETS], sz[OFFSETS];
    derivative_weights(method, y, p->size[1], dy);
    derivative_weights(method, z, p->size[2], dz);
    memcpy(sy, only_middle, sizeof sy);
    memcpy(sz, only_middle, sizeof sz);
    if (smooths(method)) {
        smoothing_weights(method, y, p->size[1], sy);
        smoothing_weights(method, z, p->size[2], sz);
    }
    for (int a = 0; a < 3; ++a) {
        if (method == ISO_GRADIENT_CORNERS)
            corner_rows(p, y, z, a == 1 ? -1 : 1, a == 2 ? -1 : 1, row, sum);
        else
            sum_rows(p, y, z, a == 1 ? dy : sy, a == 2 ? dz : sz, row, sum);
        if (a == 0 || smooths(method))
            along_x(method, a == 0, sum, n, g[a]);
        else
            memcpy(g[a], sum, n * sizeof *sum);
    }
    iso_gradient_to_world(matrix, n, g[0], g[1], g[2]);
}

const iso_gradient_info iso_gradient_intermediate = {
    .name = "intermediate",
    .summary = "differences to the next sample, 3 samples; half a voxel off",
    .samples = 3,
    .order = 1,
    .reach = 1,
    .row = stencil_row,
};

const iso_gradient_info iso_gradient_sobel = {
    .name = "sobel",
    .summary = "3x3x3: central along, 1 2 1 across, 26 samples",
    .samples = 26,
    .order = 2,
    .reach = 1,
    .row = stencil_row,
};

const iso_gradient_info iso_gradient_corners = {
    .name = "corners",
    .summary = "Sobel from the 8 corners of the voxel [sigg-2005]",
    .samples = 26,
    .order = 2,
    .reach = 1,
    .row = stencil_row,
};

const iso_gradient_info iso_gradient_fourth = {
    .name = "fourth",
    .summary = "Taylor-designed, of fourth order, 12 samples",
    .samples = 12,
    .order = 4,
    .reach = 2,
    .row = stencil_row,
};

const iso_gradient_info iso_gradient_smooth = {
    .name = "smooth",
    .summary = "5x5x5: central of 1 2 1 along, 1 4 6 4 1 across, 100 samples; for noisy data",
    .samples = 100,
    .order = 2,
    .reach = 2,
    .row = stencil_row,
};
