/* SPDX-License-Identifier: MIT */
/* deviation.c - a mean and a deviation per voxel; the transfer function is averaged over their Gaussian. */
#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "lab/rivals/rivals.h"
#include "render/reference_ray.h"
#include "render/sampler.h"

static double cumulative(double x)
{
    return 0.5 * erfc(-x * 0.70710678118654752);
}

static double density(double x)
{
    return 0.39894228040143268 * exp(-0.5 * x * x);
}

static void entry_rgba(const iso_tf_table *tf, size_t i, double length_mm, double rgba[4])
{
    const float *e = tf->entries + 4 * i;
    rgba[3] = -expm1(-(double)e[3] * length_mm);
    for (int c = 0; c < 3; ++c)
        rgba[c] = rgba[3] * (double)e[c];
}

/* Integrates the TF under a Gaussian. Between two neighboring entries x0 and x1 the integral of (p + q (x - x0)) N(x)
 * is, with u = (x - mean) / deviation, (p + q (mean - x0)) [Phi(u)] - q deviation [phi(u)]. */
void iso_tf_under_gaussian(const iso_tf_table *tf, double length_mm, double mean, double deviation, double rgba[4])
{
    const double step = (tf->hi - tf->lo) / (double)(tf->count - 1);
    if (!(deviation > 1e-3 * step)) {
        const double x = fmin(fmax((mean - tf->lo) / step, 0), (double)(tf->count - 1));
        const size_t i = x < (double)(tf->count - 2) ? (size_t)x : tf->count - 2;
        double next[4];
        entry_rgba(tf, i, length_mm, rgba);
        entry_rgba(tf, i + 1, length_mm, next);
        for (int c = 0; c < 4; ++c)
            rgba[c] += (x - (double)i) * (next[c] - rgba[c]);
        return;
    }
    const double reach = 7; /* deviations: the tails beyond have 1e-12 */
    double here[4], next[4], left = (tf->lo - mean) / deviation;
    entry_rgba(tf, 0, length_mm, here);
    for (int c = 0; c < 4; ++c)
        rgba[c] = here[c] * cumulative(left);
    for (size_t i = 0; i + 1 < tf->count; ++i) {
        const double x0 = tf->lo + (double)i * step, right = (x0 + step - mean) / deviation;
        entry_rgba(tf, i + 1, length_mm, next);
        if (right > -reach && left < reach) {
            const double mass = cumulative(right) - cumulative(left), slope = density(right) - density(left);
            for (int c = 0; c < 4; ++c) {
                const double q = (next[c] - here[c]) / step;
                rgba[c] += (here[c] + q * (mean - x0)) * mass - q * deviation * slope;
            }
        }
        left = right;
        for (int c = 0; c < 4; ++c)
            here[c] = next[c];
    }
    for (int c = 0; c < 4; ++c)
        rgba[c] += here[c] * cumulative(-left);
}

/* Tables over the mean, one per deviation: row j has (j / (ROWS - 1))^2 of half the range, denser at 0. */
enum { MEANS = 513, ROWS = 48 };
typedef struct deviation_field {
    double lo, hi, length_mm;
    double table[ROWS][MEANS][4];
    float values[]; /* mean and deviation of each voxel */
} deviation_field;

static void look_up(const deviation_field *f, double mean, double deviation, double rgba[4])
{
    const double x = fmin(fmax((mean - f->lo) / (f->hi - f->lo), 0), 1) * (MEANS - 1);
    const double y = sqrt(fmin(fmax(deviation / (0.5 * (f->hi - f->lo)), 0), 1)) * (ROWS - 1);
    const int i = x < MEANS - 2 ? (int)x : MEANS - 2, j = y < ROWS - 2 ? (int)y : ROWS - 2;
    for (int c = 0; c < 4; ++c) {
        const double below = f->table[j][i][c] + (x - i) * (f->table[j][i + 1][c] - f->table[j][i][c]);
        const double above = f->table[j + 1][i][c] + (x - i) * (f->table[j + 1][i + 1][c] - f->table[j + 1][i][c]);
        rgba[c] = below + (y - j) * (above - below);
    }
}

static double emit(const iso_emitter *e, const iso_emitter_place *at, double color[3])
{
    const deviation_field *f = e->field;
    double v[2], rgba[4];
    iso_sample_floats(at->sampler, f->values, 2, at->index, v);
    look_up(f, v[0], v[1], rgba);
    if (!(rgba[3] > 1e-9))
        return color[0] = color[1] = color[2] = 0;
    const double extinction = -log1p(-fmin(rgba[3], ISO_TF_MAX_OPACITY)) / f->length_mm;
    const double shade = iso_shade(at->view, iso_sample_normal(at->sampler, at->index), at->to_viewer);
    for (int c = 0; c < 3; ++c)
        color[c] = extinction * shade * rgba[c] / rgba[3];
    return extinction;
}

static void make_table(const iso_level_subject *s, deviation_field *f)
{
    const int threads = iso_threads(s->threads);
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (int j = 0; j < ROWS; ++j)
        for (int i = 0; i < MEANS; ++i) {
            const double part = (double)j / (ROWS - 1);
            iso_tf_under_gaussian(s->tf, f->length_mm, f->lo + (f->hi - f->lo) * i / (MEANS - 1),
                                  part * part * 0.5 * (f->hi - f->lo), f->table[j][i]);
        }
}

static void make_values(const iso_level_subject *s, deviation_field *f, size_t count)
{
    const iso_level *level0 = &s->pyramid->levels[0];
    const size_t *n = level0->geometry.size;
    const int threads = iso_threads(s->threads);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t i = 0; i < count; ++i) {
        const iso_fine_box b = iso_fine_box_of(s->pyramid, s->level, i);
        double sum = 0, squares = 0, voxels = 0;
        for (size_t z = b.lo[2]; z < b.hi[2]; ++z)
            for (size_t y = b.lo[1]; y < b.hi[1]; ++y)
                for (size_t x = b.lo[0]; x < b.hi[0]; ++x) {
                    const double v = (double)level0->scalar[x + n[0] * (y + n[1] * z)];
                    sum += v;
                    squares += v * v;
                    voxels += 1;
                }
        f->values[2 * i] = (float)(sum / voxels);
        f->values[2 * i + 1] = (float)sqrt(fmax(squares / voxels - sum / voxels * (sum / voxels), 0));
    }
}

iso_status iso_rival_deviation(const iso_level_subject *s, iso_rival *r, iso_error *err)
{
    const iso_level *level0 = &s->pyramid->levels[0];
    const size_t count = iso_geometry_voxel_count(&s->pyramid->levels[s->level].geometry);
    deviation_field *f = malloc(sizeof *f + 2 * count * sizeof *f->values);
    NEED_MEMORY(f, err, "no memory for the deviations of %zu voxels", count);
    f->lo = level0->min;
    f->hi = level0->max > level0->min ? level0->max : level0->min + 1;
    f->length_mm = iso_geometry_mean_spacing_mm(&level0->geometry);
    make_table(s, f);
    make_values(s, f, count);
    *r = (iso_rival){{emit, f}, f, free};
    return ISO_OK;
}
