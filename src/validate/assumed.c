/* SPDX-License-Identifier: MIT */
/* assumed.c - the agreement tier of a scene that does not state one.
 *
 * Smooth TFs have error bars a tenth as wide as sharp ones, so the choice must not be a guess. The question is whether
 * a ray step resolves the TF on this volume. Rays from voxels of level 0 to their neighbors are composited with steps
 * of 1/4 and 1/8 of the way, the first steps of halving, and compared with steps of 1/64. The TF is sharp if the
 * coarser one is wrong by more than 1/150 of the shown color, RMS over the pairs. It is also sharp if the error is
 * above 1/1000 and halving leaves more of it than smooth TFs are allowed (0.354: limit_gates.c). Among the suite's
 * scenes, which state their tier, the roughest smooth one has 1/180, the mildest sharp one 1/130. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "validate/validate.h"

static const double most_error = 1.0 / 150, error_that_counts = 1e-3, most_left = 0.354;

/* Two neighbors: their values, and how far they are apart. */
typedef struct pair {
    double from, to, mm;
} pair;

/* Composites color (premultiplied) and alpha from one voxel to the other, with ray samples in the middles of `steps`
 * steps. */
static void composite(const iso_tf_table *tf, const pair *p, int steps, double rgba[4])
{
    double through = 1;
    memset(rgba, 0, 4 * sizeof *rgba);
    for (int i = 0; i < steps; ++i) {
        double entry[4];
        iso_tf_lookup(tf, p->from + (p->to - p->from) * (i + 0.5) / steps, entry);
        const double alpha = -expm1(-entry[3] * p->mm / steps);
        for (int c = 0; c < 3; ++c)
            rgba[c] += through * alpha * entry[c];
        rgba[3] += through * alpha;
        through *= 1 - alpha;
    }
}

static double square_between(const double a[4], const double b[4])
{
    double sum = 0;
    for (int c = 0; c < 4; ++c)
        sum += (a[c] - b[c]) * (a[c] - b[c]);
    return sum;
}

/* Sums of squared errors, and of squared shown colors. */
typedef struct squares {
    double shown, quarter, eighth;
} squares;

static void add_pair(const iso_tf_table *tf, const pair *p, squares *s)
{
    double fine[4], quarter[4], eighth[4];
    const double nothing[4] = {0};
    composite(tf, p, 64, fine);
    composite(tf, p, 4, quarter);
    composite(tf, p, 8, eighth);
    s->shown += square_between(fine, nothing);
    s->quarter += square_between(fine, quarter);
    s->eighth += square_between(fine, eighth);
}

/* Adds up at most about 10000 pairs along each axis, evenly strided. */
static squares add_up(const iso_level *level, const iso_tf_table *tf)
{
    enum { wanted = 10000 };
    const size_t *n = level->geometry.size, step[3] = {1, n[0], n[0] * n[1]},
                 total = iso_geometry_voxel_count(&level->geometry), stride = total / wanted | 1;
    squares s = {0, 0, 0};
    double mm[3];
    iso_geometry_spacing_mm(&level->geometry, mm);
    for (int axis = 0; axis < 3; ++axis)
        for (size_t i = 0; i < total; i += stride)
            if (i / step[axis] % n[axis] + 1 < n[axis])
                add_pair(tf, &(pair){(double)level->scalar[i], (double)level->scalar[i + step[axis]], mm[axis]}, &s);
    return s;
}

void iso_validate_assume(const iso_level *level0, const iso_view *view, iso_scene_agreement *agreement)
{
    if (!agreement->assumed)
        return;
    const squares s = add_up(level0, &view->tf);
    const double error = s.shown > 0 ? sqrt(s.quarter / s.shown) : 0,
                 left = s.quarter > 0 ? sqrt(s.eighth / s.quarter) : 0;
    agreement->sharp = error > most_error || (error > error_that_counts && left > most_left);
    snprintf(
        agreement->why, sizeof agreement->why,
        "the scene states no agreement: between neighbors of level 0 a ray step of 1/4 voxel is wrong by %.2g of the "
        "visible color, and half of it leaves %.2g of that error, so the TF is taken for %s (smooth: at most %.2g, or "
        "%.2g if half of it leaves more than %.3g)",
        error, left, agreement->sharp ? "sharp" : "smooth", most_error, error_that_counts, most_left);
}

void iso_validate_report_asked(const iso_validation *v)
{
    const iso_scene_agreement *a = &v->scene->agreement;
    iso_report_put(v->report, "asked", v->scene_name,
                   json_pack("{s:s, s:s, s:s, s:b}", "tier", iso_tier_name(a->tier), "tf",
                             a->sharp ? "sharp" : "smooth", "why", a->why, "assumed", a->assumed));
}
