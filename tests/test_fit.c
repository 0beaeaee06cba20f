/* SPDX-License-Identifier: MIT */
/* The scalar of a level fitted to a transfer function: curves, gradients, a surface at a known place. */
#include "pyramids.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/fit.h"

/* ---- transfer functions and curves ------------------------------------------------------------------------------- */

/* Opacity over 1 mm rises from 0 at lo to .8 at hi. */
static iso_tf_table ramp(double lo, double hi)
{
    iso_tf_table t = {.count = 256, .lo = 0, .hi = 1};
    t.entries = malloc(4 * t.count * sizeof *t.entries);
    for (size_t i = 0; i < t.count; ++i) {
        const double v = (double)i / 255, a = 0.8 * fmin(fmax((v - lo) / (hi - lo), 0), 1);
        const float entry[4] = {(float)(1 - v), 0.5f, (float)v, (float)-log1p(-a)};
        memcpy(t.entries + 4 * i, entry, sizeof entry);
    }
    return t;
}

/* Opacity in the window alone. */
static iso_tf_table peak(double center, double half)
{
    iso_tf_table t = ramp(0.4, 0.6);
    for (size_t i = 0; i < t.count; ++i)
        t.entries[4 * i + 3] = (float)fmax(0, 1 - fabs((double)i / 255 - center) / half);
    return t;
}

static iso_fit_curve curve_of(iso_tf_table t)
{
    iso_fit_curve curve;
    assert_ok(iso_fit_curve_create(&t, 1, &curve, &err));
    iso_tf_table_destroy(&t);
    return curve;
}

static double opacity_at(const iso_fit_curve *curve, double value)
{
    float f;
    const size_t i = iso_fit_curve_find(curve, (float)value, &f);
    return (double)((1 - f) * curve->entries[4 * i + 3] + f * curve->entries[4 * i + 7]);
}

TEST(curve_is_color_and_opacity_of_the_table)
{
    OWNED(iso_fit_curve) c = curve_of(ramp(0.4, 0.6));
    /* Extinction is linear between 256 entries, opacity is not: less than 1e-3. */
    assert_within(opacity_at(&c, 0.5), 0.4, 1e-3);
    assert_within(opacity_at(&c, 0.2), 0, 1e-6);
    assert_within(opacity_at(&c, 3), 0.8, 1e-6);
    assert_within(opacity_at(&c, -3), 0, 1e-6);
    /* The widest place where .8 would be reached by the steepest slope; the table cuts the corners of the ramp. */
    assert_within(iso_fit_curve_ramp_width(&c), 0.2, 0.01);
}

TEST(widened_ramp_is_a_mean_over_its_window)
{
    iso_fit_curve c = curve_of(ramp(0.4, 0.6)), wide = c;
    wide.entries = malloc(4 * c.count * sizeof *c.entries);
    iso_fit_curve_widen(&c, 0.6, &wide);
    for (double v = -0.4; v < 1.4; v += 0.0571) {
        double sum = 0;
        for (int i = 0; i < 6000; ++i)
            sum += opacity_at(&c, v - 0.3 + (i + 0.5) * 1e-4) / 6000;
        assert_within(opacity_at(&wide, v), sum, 1e-4); /* between entries the wide curve is linear */
    }
    iso_fit_curve_widen(&c, 0, &wide);
    assert_memory_equal(wide.entries, c.entries, 4 * c.count * sizeof *c.entries);
    free(wide.entries);
    iso_fit_curve_destroy(&c);
}

TEST(constant_curve_has_no_ramp)
{
    iso_tf_table t = ramp(0.4, 0.6);
    for (size_t i = 0; i < 4 * t.count; ++i)
        t.entries[i] = 0.25f;
    OWNED(iso_fit_curve) c = curve_of(t);
    assert_true(iso_fit_curve_ramp_width(&c) == 0);
}

/* ---- volumes and problems ---------------------------------------------------------------------------------------- */

typedef struct subject {
    iso_pyramid p;
    iso_interpolation map;
    iso_fit_curve curve;
    iso_fit_problem problem;
    iso_fit_options opt;
    size_t level;
    float *coarse; /* a copy of the level's */
} subject;

static subject subject_of(iso_volume v, size_t level, iso_fit_curve curve)
{
    subject s = {.curve = curve, .opt = iso_fit_defaults(), .level = level};
    iso_pyramid_options build_options = iso_pyramid_defaults();
    build_options.threads = 2;
    s.opt.threads = 2;
    s.p = build(&v, &build_options);
    iso_volume_destroy(&v);
    assert_ok(iso_interpolation_create(&s.map, s.p.levels[0].geometry.size, level, &err));
    s.coarse = malloc(s.map.coarse_count * sizeof *s.coarse);
    memcpy(s.coarse, s.p.levels[level].scalar, s.map.coarse_count * sizeof *s.coarse);
    return s;
}

static void bind(subject *s)
{
    s->problem = (iso_fit_problem){&s->map, s->p.levels[0].scalar, &s->curve};
}

static void drop(subject *s)
{
    free(s->coarse);
    iso_fit_curve_destroy(&s->curve);
    iso_interpolation_destroy(&s->map);
    iso_pyramid_destroy(&s->p);
}

/* Where the surface stands along x: an oblique plane. */
static double surface_at(size_t y, size_t z)
{
    return 10.3 + 0.31 * (double)y + 0.17 * (double)z;
}

/* Two materials, 0 and 1, whose boundary is half a voxel wide. */
static iso_volume two_materials(size_t nx, size_t ny, size_t nz)
{
    iso_volume v = noise(nx, ny, nz);
    for (size_t i = 0; i < nx * ny * nz; ++i) {
        const double d = (double)(i % nx) - surface_at(i / nx % ny, i / nx / ny);
        ((float *)v.data)[i] = (float)fmin(fmax(2 * d, 0), 1);
    }
    return v;
}

TEST(gradient_is_that_of_finite_differences)
{
    iso_tf_table tables[] = {ramp(0.3, 0.7), peak(0.5, 0.3)};
    for (size_t t = 0; t < 2; ++t) {
        subject s = subject_of(noise(13, 10, 7), 1, curve_of(tables[t]));
        bind(&s);
        s.opt.opacity_only = t == 1;
        FREED float *gradient = malloc(s.map.coarse_count * sizeof *gradient);
        double error, largest = 0;
        assert_ok(iso_fit_error(&s.problem, &s.opt, 2, s.coarse, &error, gradient, &err));
        for (size_t i = 0; i < s.map.coarse_count; ++i)
            largest = fmax(largest, fabs((double)gradient[i]));
        for (size_t i = 0; i < s.map.coarse_count; i += 7) {
            double sides[2];
            const float was = s.coarse[i], h = 4e-3f;
            for (int k = 0; k < 2; ++k) {
                s.coarse[i] = k ? was + h : was - h;
                assert_ok(iso_fit_error(&s.problem, &s.opt, 2, s.coarse, &sides[k], NULL, &err));
            }
            s.coarse[i] = was;
            /* The widened curve bends at the ends of its window: a few voxels cross one within h. */
            assert_within((double)gradient[i], (sides[1] - sides[0]) / (2 * (double)h), 0.02 * largest);
        }
        drop(&s);
    }
}

TEST(error_never_ends_above_its_start)
{
    iso_tf_table tables[] = {ramp(0.45, 0.5), peak(0.5, 0.03), peak(0.2, 0.5), ramp(0, 1)};
    for (size_t t = 0; t < 4; ++t)
        for (size_t level = 1; level < 4; ++level) {
            subject s = subject_of(t % 2 ? noise(17, 21, 19) : two_materials(33, 21, 19), level, curve_of(tables[t]));
            bind(&s);
            iso_fit_report report;
            double after;
            assert_ok(iso_fit_scalar(&s.problem, &s.opt, s.coarse, &report, &err));
            assert_at_most(report.error_end, report.error_start);
            assert_ok(iso_fit_error(&s.problem, &s.opt, 1, s.coarse, &after, NULL, &err));
            assert_within(after, report.error_end, 1e-6 * report.error_end); /* the sums' order is another */
            tables[t] = t == 0 ? ramp(0.45, 0.5) : t == 1 ? peak(0.5, 0.03) : t == 2 ? peak(0.2, 0.5) : ramp(0, 1);
            drop(&s);
        }
    for (size_t t = 0; t < 4; ++t)
        iso_tf_table_destroy(&tables[t]);
}

/* How far the surface of value .25 that the level shows stands from the one of level 0: root mean square over the rows,
 * in voxels of level 0. */
static double misplacement(const subject *s, const float *coarse)
{
    const size_t *n = s->p.levels[0].geometry.size, border = 4;
    float *shown = malloc(s->map.fine_count * sizeof *shown);
    double sum = 0, count = 0;
    assert_ok(iso_interpolation_gather(&s->map, coarse, shown, 1, &err));
    for (size_t r = 0; r < n[1] * n[2]; ++r) {
        const size_t y = r % n[1], z = r / n[1];
        const float *rows[2] = {s->p.levels[0].scalar + r * n[0], shown + r * n[0]};
        double at[2] = {0};
        if (y < border || y + border >= n[1] || z < border || z + border >= n[2])
            continue;
        for (int k = 0; k < 2; ++k)
            for (size_t x = 1; x < n[0]; ++x)
                if (rows[k][x - 1] < 0.25f && rows[k][x] >= 0.25f) {
                    at[k] = (double)x - ((double)rows[k][x] - 0.25) / ((double)rows[k][x] - (double)rows[k][x - 1]);
                    break;
                }
        sum += (at[0] - at[1]) * (at[0] - at[1]);
        ++count;
    }
    free(shown);
    return sqrt(sum / count);
}

/* Means put a surface that is not at half the step toward the lesser values; opaque voxels say where it is. */
TEST(fitted_level_shows_a_surface_where_level_0_has_it)
{
    for (size_t level = 1; level < 4; ++level) {
        subject s = subject_of(two_materials(48, 40, 36), level, curve_of(ramp(0.22, 0.28)));
        bind(&s);
        iso_fit_report report;
        const double before = misplacement(&s, s.coarse);
        assert_ok(iso_fit_scalar(&s.problem, &s.opt, s.coarse, &report, &err));
        const double after = misplacement(&s, s.coarse);
        print_message("level %zu: means %.3f voxels from it, fitted %.3f\n", level, before, after);
        assert_more_than(before, 0.2 * (double)(1 << level) * 0.5);
        assert_at_most(after, 0.75 * before);
        drop(&s);
    }
}

TEST(threads_change_no_bit)
{
    subject s = subject_of(noise(23, 19, 22), 2, curve_of(ramp(0.3, 0.5)));
    bind(&s);
    const size_t bytes = s.map.coarse_count * sizeof *s.coarse;
    FREED float *one = malloc(bytes), *more = malloc(bytes);
    iso_fit_report report;
    memcpy(one, s.coarse, bytes);
    s.opt.threads = 1;
    assert_ok(iso_fit_scalar(&s.problem, &s.opt, one, &report, &err));
    assert_true(memcmp(one, s.coarse, bytes) != 0);
    for (s.opt.threads = 2; s.opt.threads < 6; s.opt.threads += 3) {
        memcpy(more, s.coarse, bytes);
        assert_ok(iso_fit_scalar(&s.problem, &s.opt, more, &report, &err));
        assert_memory_equal(one, more, bytes);
    }
    drop(&s);
}

TEST(what_a_constant_curve_shows_stays)
{
    iso_tf_table t = ramp(0.4, 0.6);
    for (size_t i = 0; i < 4 * t.count; ++i)
        t.entries[i] = 0.25f;
    subject s = subject_of(noise(9, 9, 9), 1, curve_of(t));
    bind(&s);
    iso_fit_report report;
    assert_ok(iso_fit_scalar(&s.problem, &s.opt, s.coarse, &report, &err));
    assert_memory_equal(s.coarse, s.p.levels[1].scalar, s.map.coarse_count * sizeof *s.coarse);
    assert_true(report.best_round == 0);
    drop(&s);
}

TEST_MAIN(NULL, NULL)
