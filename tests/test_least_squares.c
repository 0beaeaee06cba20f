/* SPDX-License-Identifier: MIT */
/* Least-squares levels: against dense solutions with the renderers' own lookup, and by what they promise. */
#include <math.h>
#include <stdlib.h>

#include "pyramid/spline_kernel.h"
#include "pyramids.h"
#include "render/sampler.h"

static iso_pyramid_options least_squares(size_t levels)
{
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.scalar_filter = ISO_SCALAR_LEAST_SQUARES;
    opt.level_count = levels;
    opt.threads = 2;
    return opt;
}

static iso_volume empty(size_t nx, size_t ny, size_t nz)
{
    iso_geometry g = plain(nx, ny, nz);
    iso_volume v;
    assert_ok(iso_volume_create(&v, &g, ISO_F32, "test", &err));
    return v;
}

static iso_geometry coarser_by(const iso_geometry *fine, size_t k)
{
    iso_geometry g = *fine;
    for (; k > 0; --k)
        g = iso_geometry_coarser(&g);
    return g;
}

/* What the reference renderer finds of level k at the center of fine voxel i. */
static double shown_at(const iso_sampler *s, const iso_geometry *fine, size_t i, size_t k)
{
    size_t at[3];
    const double ratio = ldexp(1, (int)k);
    place(fine, i, at);
    return iso_sample_scalar(s, iso_v3(((double)at[0] + 0.5) / ratio, ((double)at[1] + 0.5) / ratio,
                                       ((double)at[2] + 0.5) / ratio));
}

static iso_sampler sampler_of(iso_level *l, const iso_geometry *g, float *scalar)
{
    iso_sampler s;
    *l = (iso_level){.geometry = *g, .scalar = scalar, .max = 1};
    assert_ok(iso_sampler_create(&s, l, ISO_CODE_FIT, ISO_FROM_ON_THE_FLY, &err));
    return s;
}

/* The matrix A, fine.count rows of m, by looking up levels that are one at a single voxel. */
static double *lookup_matrix(const iso_geometry *fine, size_t k, size_t *m)
{
    const iso_geometry g = coarser_by(fine, k);
    const size_t n = iso_geometry_voxel_count(fine);
    *m = iso_geometry_voxel_count(&g);
    double *a = calloc(n * *m, sizeof *a);
    FREED float *one = calloc(*m, sizeof *one);
    iso_level l;
    OWNED(iso_sampler) s = sampler_of(&l, &g, one);
    for (size_t j = 0; j < *m; ++j) {
        one[j] = 1;
        for (size_t i = 0; i < n; ++i)
            a[i * *m + j] = shown_at(&s, fine, i, k);
        one[j] = 0;
    }
    return a;
}

/* Solves the normal equations of A by Cholesky's method for `count` right-hand sides, columns of v; the results are in
 * c, columns of m. */
static void solve_densely(const double *a, size_t n, size_t m, const double *v, size_t count, double *c)
{
    FREED double *g = calloc(m * m, sizeof *g);
    for (size_t i = 0; i < n; ++i)
        for (size_t p = 0; p < m; ++p)
            for (size_t q = 0; a[i * m + p] != 0 && q <= p; ++q)
                g[p * m + q] += a[i * m + p] * a[i * m + q];
    for (size_t p = 0; p < m; ++p)
        for (size_t q = 0; q <= p; ++q) {
            double sum = g[p * m + q];
            for (size_t t = 0; t < q; ++t)
                sum -= g[p * m + t] * g[q * m + t];
            g[p * m + q] = p == q ? sqrt(sum) : sum / g[q * m + q];
        }
    for (size_t r = 0; r < count; ++r) {
        double *x = c + r * m;
        for (size_t p = 0; p < m; ++p) {
            x[p] = 0;
            for (size_t i = 0; i < n; ++i)
                x[p] += a[i * m + p] * v[r * n + i];
            for (size_t t = 0; t < p; ++t)
                x[p] -= g[p * m + t] * x[t];
            x[p] /= g[p * m + p];
        }
        for (size_t p = m; p-- > 0;) {
            for (size_t t = p + 1; t < m; ++t)
                x[p] -= g[t * m + p] * x[t];
            x[p] /= g[p * m + p];
        }
    }
}

/* The largest difference of a level from the dense solution, as a part of the largest value. */
static double difference(const iso_volume *v, size_t k, const iso_level *level, double spoil)
{
    const size_t n = iso_geometry_voxel_count(&v->geometry);
    size_t m;
    double *a = lookup_matrix(&v->geometry, k, &m), *values = malloc(n * sizeof *values), *c = malloc(m * sizeof *c),
           worst = 0, largest = 0;
    for (size_t i = 0; i < n; ++i)
        values[i] = ((const float *)v->data)[i];
    a[0] *= spoil; /* the corner voxel's row, whose other elements are zero as the lookup is clamped */
    solve_densely(a, n, m, values, 1, c);
    for (size_t j = 0; j < m; ++j) {
        worst = fmax(worst, fabs(c[j] - (double)level->scalar[j]));
        largest = fmax(largest, fabs(c[j]));
    }
    free(a);
    free(values);
    free(c);
    return worst / largest;
}

/* Float arithmetic: sums of some ten products of values below 1, solved at a condition below 30 an axis. */
#define FLOAT_TOLERANCE 3e-6

TEST(levels_are_the_dense_solutions)
{
    for (size_t n = 2; n <= 17; ++n)
        for (int axis = 0; axis < 3; ++axis) {
            OWNED(iso_volume) v = noise(axis == 0 ? n : 5, axis == 1 ? n : axis == 0 ? 3 : 5, axis == 2 ? n : 3);
            const iso_pyramid_options opt = least_squares(4);
            OWNED(iso_pyramid) p = build(&v, &opt);
            for (size_t k = 1; k < p.level_count; ++k) {
                assert_at_most(difference(&v, k, &p.levels[k], 1), FLOAT_TOLERANCE);
                /* Planted: a border row that is not clamped as the renderers clamp it. */
                assert_more_than(difference(&v, k, &p.levels[k], 0.75), 1e-3);
            }
        }
}

TEST(many_planes_are_solved_in_blocks_as_in_one_piece)
{
    static const size_t depths[] = {80, 93, 127};
    for (size_t d = 0; d < 3; ++d) {
        OWNED(iso_volume) v = noise(3, 2, depths[d]);
        const iso_pyramid_options opt = least_squares(3);
        OWNED(iso_pyramid) p = build(&v, &opt);
        for (size_t k = 1; k < p.level_count; ++k)
            assert_at_most(difference(&v, k, &p.levels[k], 1), FLOAT_TOLERANCE);
    }
}

/* From the carry of the cascade: levels above the fifth, on each axis in turn. */
TEST(high_levels_are_the_dense_solutions)
{
    for (int axis = 0; axis < 3; ++axis) {
        OWNED(iso_volume) v = noise(axis == 0 ? 137 : 37, axis == 1 ? 150 : 5, axis == 2 ? 161 : 3);
        const iso_pyramid_options opt = least_squares(8);
        OWNED(iso_pyramid) p = build(&v, &opt);
        assert_true(p.level_count > 6);
        for (size_t k = 4; k < p.level_count; ++k)
            assert_at_most(difference(&v, k, &p.levels[k], 1), FLOAT_TOLERANCE);
    }
}

/* The middle of a long axis from a window with an apron of so many voxels, against the whole. */
static double error_of_apron(size_t apron)
{
    enum { M = 96, J0 = 40, J1 = 48 };
    const iso_spline_axis a = {2 * M, M, 2};
    iso_spline_row rows[M];
    float whole[M], window[M];
    double worst = 0;
    for (size_t j = 0; j < M; ++j)
        whole[j] = window[j] = (float)noise_at(j);
    iso_spline_factorize(&a, 0, M, rows);
    iso_spline_solve(rows, M, whole, 1, 1);
    iso_spline_factorize(&a, J0 - apron, J1 + apron, rows);
    iso_spline_solve(rows, J1 - J0 + 2 * apron, window + J0 - apron, 1, 1);
    for (size_t j = J0; j < J1; ++j)
        worst = fmax(worst, fabs((double)whole[j] - (double)window[j]));
    return worst;
}

TEST(an_apron_of_12_is_enough_and_of_6_is_not)
{
    assert_at_most(error_of_apron(12), 1e-6);  /* 3^-12 is 2e-6 of what the borders differ by */
    assert_more_than(error_of_apron(6), 1e-5); /* planted */
}

static double residual(const iso_volume *v, const iso_pyramid *p, size_t k)
{
    iso_level l;
    OWNED(iso_sampler) s = sampler_of(&l, &p->levels[k].geometry, p->levels[k].scalar);
    double sum = 0;
    for (size_t i = 0; i < iso_geometry_voxel_count(&v->geometry); ++i) {
        const double d = shown_at(&s, &v->geometry, i, k) - (double)((const float *)v->data)[i];
        sum += d * d;
    }
    return sum;
}

/* Noise, waves, a plane's step, and a single voxel. */
static double sample(int what, const size_t at[3], size_t i)
{
    const double x = (double)at[0], y = (double)at[1], z = (double)at[2];
    return what == 0   ? noise_at(i)
           : what == 1 ? sin(0.7 * x) * cos(0.4 * y + 0.2 * z)
           : what == 2 ? (double)(x + 0.6 * y - 0.3 * z > 7)
                       : (double)(at[0] == 4 && at[1] == 2 && at[2] == 3);
}

TEST(the_residual_is_at_most_that_of_the_means)
{
    static const size_t sizes[][3] = {{16, 16, 16}, {17, 13, 9}, {9, 23, 10}, {5, 6, 31}};
    for (size_t t = 0; t < 4; ++t)
        for (int what = 0; what < 4; ++what) {
            OWNED(iso_volume) v = empty(sizes[t][0], sizes[t][1], sizes[t][2]);
            for (size_t i = 0; i < iso_geometry_voxel_count(&v.geometry); ++i) {
                size_t at[3];
                place(&v.geometry, i, at);
                ((float *)v.data)[i] = (float)sample(what, at, i);
            }
            iso_pyramid_options opt = least_squares(4);
            OWNED(iso_pyramid) p = build(&v, &opt);
            opt.scalar_filter = ISO_SCALAR_MEAN;
            OWNED(iso_pyramid) means = build(&v, &opt);
            for (size_t k = 1; k < p.level_count; ++k) {
                assert_at_most(residual(&v, &p, k), residual(&v, &means, k));
                /* Planted: it is not so of a level that is a little off. */
                const double best = residual(&v, &p, k);
                for (size_t i = 0; i < iso_geometry_voxel_count(&p.levels[k].geometry); ++i)
                    p.levels[k].scalar[i] += 0.01f;
                assert_more_than(residual(&v, &p, k), best);
            }
        }
}

TEST(what_a_level_can_show_is_given_back)
{
    static const size_t sizes[][3] = {{16, 24, 8}, {17, 13, 11}, {9, 30, 43}};
    for (size_t t = 0; t < 3; ++t)
        for (size_t k = 1; k <= 3; ++k) {
            OWNED(iso_volume) v = empty(sizes[t][0], sizes[t][1], sizes[t][2]);
            const iso_geometry g = coarser_by(&v.geometry, k);
            const size_t m = iso_geometry_voxel_count(&g);
            FREED float *c = malloc(m * sizeof *c);
            for (size_t j = 0; j < m; ++j)
                c[j] = (float)noise_at(j);
            iso_level l;
            OWNED(iso_sampler) s = sampler_of(&l, &g, c);
            for (size_t i = 0; i < iso_geometry_voxel_count(&v.geometry); ++i)
                ((float *)v.data)[i] = (float)shown_at(&s, &v.geometry, i, k);
            const iso_pyramid_options opt = least_squares(4);
            OWNED(iso_pyramid) p = build(&v, &opt);
            for (size_t j = 0; j < m; ++j) /* as FLOAT_TOLERANCE; outermost coefficients of odd sizes times 5 an axis */
                assert_within(p.levels[k].scalar[j], c[j], 2e-5);
        }
}

/* Clamped lookup bends a linear field in the outer half of the outermost voxels, and only there. Fields that are linear
 * between the outermost centers and constant beyond are exact everywhere; of those linear to the box's faces the
 * error decays from the faces by a third a voxel. */
TEST(linear_fields_are_exact_but_for_clamping)
{
    enum { N = 96 };
    const double slope[3] = {1, -0.5, 0.25};
    for (size_t k = 1; k <= 2; ++k)
        for (int clamped = 0; clamped <= 1; ++clamped) {
            const double ratio = ldexp(1, (int)k);
            OWNED(iso_volume) v = empty(N, 5 * 4, 6 * 4);
            for (size_t i = 0; i < iso_geometry_voxel_count(&v.geometry); ++i) {
                size_t at[3];
                double sum = 0;
                place(&v.geometry, i, at);
                for (int a = 0; a < 3; ++a) {
                    double x = (double)at[a] + 0.5, end = (double)v.geometry.size[a];
                    const bool clamp = clamped || a > 0;
                    sum += slope[a] * (clamp ? fmin(fmax(x, ratio / 2), end - ratio / 2) : x);
                }
                ((float *)v.data)[i] = (float)sum;
            }
            const iso_pyramid_options opt = least_squares(3);
            OWNED(iso_pyramid) p = build(&v, &opt);
            const iso_level *l = &p.levels[k];
            double worst[N] = {0};
            for (size_t j = 0; j < iso_geometry_voxel_count(&l->geometry); ++j) {
                size_t at[3];
                double expected = 0;
                place(&l->geometry, j, at);
                for (int a = 0; a < 3; ++a)
                    expected += slope[a] * ratio * ((double)at[a] + 0.5);
                const size_t other = l->geometry.size[0] - 1 - at[0], from_face = at[0] < other ? at[0] : other;
                worst[from_face] = fmax(worst[from_face], fabs((double)l->scalar[j] - expected));
            }
            const double rounding = 100 * FLOAT_TOLERANCE; /* values up to 100 */
            for (size_t d = 0; d < l->geometry.size[0] / 2; ++d)
                assert_at_most(worst[d], rounding + (clamped ? 0 : 0.2 * ratio * pow(3, -(double)d)));
            if (!clamped)
                assert_more_than(worst[0], 0.05 * ratio);
        }
}

/* The largest sum of magnitudes in a row of (A^T A)^-1 A^T. */
static double norm_of_inverse(size_t n, size_t k, bool inner_only)
{
    const iso_geometry fine = plain(n, 1, 1);
    size_t m;
    double *a = lookup_matrix(&fine, k, &m), *units = calloc(n * n, sizeof *units),
           *columns = malloc(n * m * sizeof *columns), norm = 0;
    for (size_t i = 0; i < n; ++i)
        units[i * n + i] = 1;
    solve_densely(a, n, m, units, n, columns);
    for (size_t j = 0; j + inner_only < m; ++j) {
        double sum = 0;
        for (size_t i = 0; i < n; ++i)
            sum += fabs(columns[i * m + j]);
        norm = fmax(norm, sum);
    }
    free(a);
    free(units);
    free(columns);
    return norm;
}

TEST(an_axis_stretches_the_range_2_2_times_and_its_overhanging_end_6_times)
{
    for (size_t k = 1; k <= 4; ++k)
        for (size_t n = 1; n <= (size_t)5 << k; n += k > 2 ? 3 : 1) {
            assert_at_most(norm_of_inverse(n, k, true), 2.2);
            assert_at_most(norm_of_inverse(n, k, false), 6);
        }
    assert_more_than(norm_of_inverse(33, 2, false), 3); /* that end is what it takes 6 for */
}

TEST(values_overshoot_by_no_more_and_the_level_says_so)
{
    OWNED(iso_volume) v = empty(19, 14, 16);
    for (size_t i = 0; i < iso_geometry_voxel_count(&v.geometry); ++i) {
        size_t at[3];
        place(&v.geometry, i, at);
        ((float *)v.data)[i] = at[0] + at[1] < 15 ? 0 : 1;
    }
    const iso_pyramid_options opt = least_squares(4);
    OWNED(iso_pyramid) p = build(&v, &opt);
    for (size_t k = 1; k < p.level_count; ++k) {
        const iso_level *l = &p.levels[k];
        double lo = INFINITY, hi = -INFINITY, norm = 1;
        for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i) {
            lo = fmin(lo, (double)l->scalar[i]);
            hi = fmax(hi, (double)l->scalar[i]);
        }
        for (int a = 0; a < 3; ++a)
            norm *= norm_of_inverse(v.geometry.size[a], k, false);
        assert_true(l->min == lo && l->max == hi);
        assert_more_than(hi, 1.01);
        assert_at_most(hi, 0.5 + norm / 2);
        assert_at_most(-lo, norm / 2 - 0.5);
    }
}

TEST(a_constant_stays_one)
{
    OWNED(iso_volume) v = empty(21, 10, 70);
    for (size_t i = 0; i < iso_geometry_voxel_count(&v.geometry); ++i)
        ((float *)v.data)[i] = 1000;
    const iso_pyramid_options opt = least_squares(4);
    OWNED(iso_pyramid) p = build(&v, &opt);
    for (size_t k = 1; k < p.level_count; ++k) {
        assert_within(p.levels[k].min, 1000, 1000 * FLOAT_TOLERANCE);
        assert_within(p.levels[k].max, 1000, 1000 * FLOAT_TOLERANCE);
    }
}

/* ---- damped levels ---- */

static iso_pyramid with_filter(const iso_volume *v, iso_scalar_filter filter, size_t levels)
{
    iso_pyramid_options opt = least_squares(levels);
    opt.scalar_filter = filter;
    return build(v, &opt);
}

/* Mean and range of the fine voxels that voxel j of level k covers. */
static void measure_own(const iso_volume *v, const size_t j[3], size_t k, double *mean, double limits[2])
{
    const size_t *n = v->geometry.size;
    double sum = 0, count = 0;
    limits[0] = INFINITY, limits[1] = -INFINITY;
    for (size_t z = j[2] << k; z < (j[2] + 1) << k && z < n[2]; ++z)
        for (size_t y = j[1] << k; y < (j[1] + 1) << k && y < n[1]; ++y)
            for (size_t x = j[0] << k; x < (j[0] + 1) << k && x < n[0]; ++x) {
                const double value = (double)((const float *)v->data)[(z * n[1] + y) * n[0] + x];
                limits[0] = fmin(limits[0], value);
                limits[1] = fmax(limits[1], value);
                sum += value;
                count += 1;
            }
    *mean = sum / count;
}

TEST(damped_levels_are_means_and_a_part_of_least_squares)
{
    static const size_t sizes[][3] = {{16, 16, 16}, {17, 13, 9}, {2, 23, 10}, {5, 1, 75}, {40, 66, 3}, {37, 150, 5}};
    for (size_t t = 0; t < 6; ++t) {
        OWNED(iso_volume) v = noise(sizes[t][0], sizes[t][1], sizes[t][2]);
        for (size_t i = 0; i < iso_geometry_voxel_count(&v.geometry); ++i) { /* slabs, as noise alone rings little */
            size_t at[3];
            place(&v.geometry, i, at);
            ((float *)v.data)[i] = 0.05f * ((float *)v.data)[i] + ((at[0] + at[1] + at[2]) % 16 > 7 ? 1.f : 0.f);
        }
        OWNED(iso_pyramid)
        free_values = with_filter(&v, ISO_SCALAR_LEAST_SQUARES, 8),
        damped = with_filter(&v, ISO_SCALAR_DAMPED, 8);
        size_t outside = 0;
        for (size_t k = 1; k < damped.level_count; ++k)
            for (size_t i = 0; i < iso_geometry_voxel_count(&damped.levels[k].geometry); ++i) {
                const iso_level *l = &damped.levels[k];
                size_t at[3];
                double mean, limits[2], value = (double)free_values.levels[k].scalar[i];
                place(&l->geometry, i, at);
                measure_own(&v, at, k, &mean, limits);
                outside += k == 1 && (value < limits[0] || value > limits[1]);
                value = k == 1 ? fmin(fmax(value, limits[0]), limits[1]) : value;
                assert_within((double)l->scalar[i], mean + (double)ISO_DAMPED_PART * (value - mean), 1e-5);
                assert_true((double)l->scalar[i] >= l->min && (double)l->scalar[i] <= l->max);
                if (k == 1) /* level 1 never leaves the range of its own voxels, but by rounding */
                    assert_true((double)l->scalar[i] >= limits[0] - 1e-6 && (double)l->scalar[i] <= limits[1] + 1e-6);
            }
        assert_true(outside > 0); /* a build that holds nothing is noticed */
    }
}

/* The residual is a square, with its least value at least squares, so on the way there from the means it falls as
 * (1 - part)^2: so it is below that of the means. Level 1 is held to ranges, which this volume does not leave. */
TEST(the_residual_falls_with_the_square_of_what_is_left)
{
    OWNED(iso_volume) v = noise(16, 24, 8);
    iso_pyramid p[3];
    static const iso_scalar_filter filters[] = {ISO_SCALAR_MEAN, ISO_SCALAR_LEAST_SQUARES, ISO_SCALAR_DAMPED};
    const double left = 1 - (double)ISO_DAMPED_PART;
    for (size_t i = 0; i < 3; ++i)
        p[i] = with_filter(&v, filters[i], 4);
    for (size_t k = 2; k < p[0].level_count; ++k) {
        const double means = residual(&v, &p[0], k), least = residual(&v, &p[1], k);
        assert_within(residual(&v, &p[2], k), least + left * left * (means - least), 1e-5 * means);
        assert_more_than(means - least, 1e-3 * means); /* else any part would do */
    }
    for (size_t i = 0; i < 3; ++i)
        iso_pyramid_destroy(&p[i]);
}

/* Means and least squares give linear fields back where voxels are whole. */
TEST(linear_fields_are_exact_in_damped_levels)
{
    enum { N = 64 };
    OWNED(iso_volume) v = empty(N, N, N);
    for (size_t i = 0; i < iso_geometry_voxel_count(&v.geometry); ++i)
        ((float *)v.data)[i] = (float)(i % N) - 0.5f * (float)(i / N % N) + 0.25f * (float)(i / N / N);
    OWNED(iso_pyramid) p = with_filter(&v, ISO_SCALAR_DAMPED, 3);
    for (size_t k = 1; k < 3; ++k)
        for (size_t z = 6; z + 6 < (size_t)N >> k; ++z)
            for (size_t x = 6; x + 6 < (size_t)N >> k; ++x) { /* 6 voxels from a face: 3^-6 of what clamping bends */
                const size_t m = (size_t)N >> k, y = m / 2;
                const double ratio = ldexp(1, (int)k), center = 0.5 * (ratio - 1);
                const double expected = (double)x * ratio + center - 0.5 * ((double)y * ratio + center) +
                                        0.25 * ((double)z * ratio + center);
                assert_within((double)p.levels[k].scalar[(z * m + y) * m + x], expected, 4e-3);
            }
}

TEST(values_whose_levels_may_overflow_are_refused)
{
    OWNED(iso_volume) v = noise(6, 5, 4);
    ((float *)v.data)[7] = 3e37f;
    iso_pyramid_options opt = least_squares(2);
    OWNED(iso_pyramid) p;
    assert_status(iso_pyramid_build(&v, "test", &opt, &p, NULL, &err), ISO_E_RANGE);
    opt.scalar_filter = ISO_SCALAR_MEAN; /* sums of eight */
    assert_status(iso_pyramid_build(&v, "test", &opt, &p, NULL, &err), ISO_E_RANGE);
    ((float *)v.data)[7] = 1e36f;
    assert_ok(iso_pyramid_build(&v, "test", &opt, &p, NULL, &err));
}

TEST_MAIN(NULL, NULL)
