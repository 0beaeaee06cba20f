/* false_visible.c - where an adapted TF shows what level 0 does not have. */
#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "tf/adapt.h"

static double opacity_over(const iso_tf_table *tf, double value, double length_mm)
{
    double rgbs[4];
    iso_tf_lookup(tf, value, rgbs);
    return -expm1(-rgbs[3] * length_mm);
}

/* One of the fine voxels [lo, hi) is visible. */
static bool any_visible(const float *fine, const size_t n[3], const size_t lo[3], const size_t hi[3], const iso_bins *z,
                        const bool *visible)
{
    const float per_step = (float)(1 / z->step), first = (float)z->lo, last = (float)(z->count - 1);
    for (size_t k = lo[2]; k < hi[2]; ++k)
        for (size_t j = lo[1]; j < hi[1]; ++j) {
            const float *row = fine + (k * n[1] + j) * n[0];
            for (size_t i = lo[0]; i < hi[0]; ++i) {
                float bin = (row[i] - first) * per_step;
                if (visible[(size_t)(fminf(fmaxf(bin, 0), last) + 0.5f)])
                    return true;
            }
        }
    return false;
}

iso_status iso_adapt_false_visible(const iso_pyramid *p, size_t level, const iso_bins *z, const iso_tf_table *tf,
                                   const iso_tf_table *adapted, int threads, double *fraction, iso_error *err)
{
    const iso_level *fine = &p->levels[0], *coarse = &p->levels[level];
    const size_t *n = fine->geometry.size, *m = coarse->geometry.size;
    double length_mm = iso_geometry_mean_spacing_mm(&coarse->geometry);
    size_t real = 0, unreal = 0;
    bool *visible = malloc(z->count * sizeof *visible);
    if (!visible)
        return iso_fail(err, ISO_E_MEMORY, "adapt: no memory for %zu bins", z->count);
    for (size_t i = 0; i < z->count; ++i)
        visible[i] = opacity_over(tf, z->lo + (double)i * z->step, length_mm) > ISO_VISIBLE_OPACITY;
#pragma omp parallel for schedule(static) num_threads(iso_threads(threads)) reduction(+ : real, unreal)
    for (size_t row = 0; row < m[1] * m[2]; ++row) {
        size_t at[3] = {0, row % m[1], row / m[1]}, lo[3], hi[3];
        for (at[0] = 0; at[0] < m[0]; ++at[0]) {
            for (int a = 0; a < 3; ++a) {
                lo[a] = at[a] << level;
                hi[a] = lo[a] + ((size_t)1 << level) < n[a] ? lo[a] + ((size_t)1 << level) : n[a];
            }
            if (any_visible(fine->scalar, n, lo, hi, z, visible))
                ++real;
            else
                unreal += opacity_over(adapted, (double)coarse->scalar[row * m[0] + at[0]], length_mm) > ISO_SHOWN_OPACITY;
        }
    }
    free(visible);
    *fraction = real > 0 ? (double)unreal / (double)real : 0;
    return ISO_OK;
}
