/* SPDX-License-Identifier: MIT */
/* Gradients against closed forms. */
#include "test.h"

#include "gradient/gradient.h"

/* Unequal sizes and spacings, rotated, sheared and reflected: a swapped or transposed axis shows. */
static iso_geometry oblique(size_t nx, size_t ny, size_t nz)
{
    iso_geometry g = {.size = {nx, ny, nz}, .origin_mm = {3, -5, 7}, .box_index = {(double)nx, (double)ny, (double)nz}};
    g.index_to_world = (iso_mat3){{{0.6, -0.9, 0.2}, {0.8, 1.1, 0.3}, {0.1, 0.2, -2.5}}};
    return g;
}

static iso_vec3 center(const iso_geometry *g, size_t i)
{
    const size_t nx = g->size[0], ny = g->size[1];
    return iso_geometry_to_world(g, iso_v3((double)(i % nx) + 0.5, (double)(i / nx % ny) + 0.5,
                                           (double)(i / nx / ny) + 0.5));
}

static const iso_vec3 slope = {1.5, -0.75, 0.4};

static double ramp(iso_vec3 p)
{
    return iso_dot(slope, p) + 2;
}

static iso_volume sample(const iso_geometry *g, iso_type type, double (*field)(iso_vec3))
{
    iso_volume v;
    assert_ok(iso_volume_create(&v, g, type, "test", &err));
    for (size_t i = 0; i < iso_geometry_voxel_count(g); ++i) {
        if (type == ISO_F32)
            ((float *)v.data)[i] = (float)field(center(g, i));
        else
            ((double *)v.data)[i] = field(center(g, i));
    }
    return v;
}

static float *gradients_by(const iso_volume *v, iso_gradient_method method, int threads)
{
    float *out = malloc(3 * iso_geometry_voxel_count(&v->geometry) * sizeof *out);
    iso_gradient_options opt = iso_gradient_defaults();
    opt.method = method;
    opt.threads = threads;
    assert_non_null(out);
    assert_ok(iso_gradient_compute(v, &opt, out, &err));
    return out;
}

static float *gradients(const iso_volume *v, int threads)
{
    return gradients_by(v, ISO_GRADIENT_CENTRAL, threads);
}

static double largest_error(const iso_geometry *g, const float *out, iso_vec3 expected)
{
    double largest = 0;
    for (size_t i = 0; i < iso_geometry_voxel_count(g); ++i)
        largest = fmax(largest, iso_norm(iso_sub(iso_v3(out[3 * i], out[3 * i + 1], out[3 * i + 2]), expected)));
    return largest;
}

/* Samples are below 64, so a float holds them to 64 x 2^-24; the difference of two, over half a
 * millimeter or more, and the sum of three axes stay within 10 times that. */
static const double rounding = 10 * 64 * 0x1p-24;

TEST(linear_field_is_exact_with_borders_in_any_geometry)
{
    const size_t sizes[][3] = {{7, 5, 6}, {2, 3, 2}, {9, 2, 4}, {33, 4, 3}};
    for (size_t s = 0; s < ISO_GRADIENT_COUNT * (sizeof sizes / sizeof *sizes); ++s) {
        const size_t *n = sizes[s / ISO_GRADIENT_COUNT];
        iso_geometry g = oblique(n[0], n[1], n[2]);
        OWNED(iso_volume) v = sample(&g, ISO_F32, ramp);
        FREED float *out = gradients_by(&v, s % ISO_GRADIENT_COUNT, 2);
        assert_at_most(largest_error(&g, out, slope), rounding);
        /* The faults that this bound has to reject: index axes taken for world axes, the matrix
         * itself instead of its inverse transpose, and 1/2 at the border. */
        iso_vec3 index = iso_mul(iso_mat3_transpose(g.index_to_world), slope);
        assert_more_than(largest_error(&g, out, index), rounding);
        assert_more_than(largest_error(&g, out, iso_mul(g.index_to_world, index)), rounding);
        assert_more_than(largest_error(&g, out, iso_scale(slope, 0.5)), rounding);
    }
}

TEST(an_axis_of_one_voxel_has_no_gradient_along_it)
{
    for (int axis = 0; axis < 3; ++axis) {
        size_t size[3] = {5, 6, 7};
        size[axis] = 1;
        double spacing[3] = {0.5, 1, 2.5};
        iso_geometry g = iso_geometry_axis_aligned(size, spacing);
        OWNED(iso_volume) v = sample(&g, ISO_F32, ramp);
        FREED float *out = gradients(&v, 1);
        iso_vec3 expected = slope;
        *(axis == 0 ? &expected.x : axis == 1 ? &expected.y : &expected.z) = 0;
        assert_at_most(largest_error(&g, out, expected), rounding);
    }
}

TEST(a_single_voxel_and_a_constant_have_no_gradient)
{
    const size_t sizes[][3] = {{1, 1, 1}, {3, 4, 5}};
    for (size_t s = 0; s < 2; ++s) {
        iso_geometry g = oblique(sizes[s][0], sizes[s][1], sizes[s][2]);
        OWNED(iso_volume) v;
        assert_ok(iso_volume_create(&v, &g, ISO_U8, "test", &err));
        memset(v.data, 77, iso_geometry_voxel_count(&g));
        FREED float *out = gradients(&v, 1);
        assert_true(largest_error(&g, out, iso_v3(0, 0, 0)) == 0);
    }
}

static double distance(iso_vec3 p)
{
    return iso_norm(p);
}

/* The error of a central difference of |p| is h^2/6 times its third derivative, which is at most
 * 3 / r^2: with h = 1 and r >= 8 the direction is off by less than sqrt(3) / 2 / 64 rad. */
TEST(sphere_gradients_point_outwards_with_an_error_of_second_order)
{
    double worst[2] = {0, 0};
    for (int fine = 0; fine < 2; ++fine) {
        size_t n = fine ? 48 : 24, size[3] = {n, n, n};
        double spacing[3] = {24.0 / (double)n, 24.0 / (double)n, 24.0 / (double)n};
        iso_geometry g = iso_geometry_axis_aligned(size, spacing);
        OWNED(iso_volume) v = sample(&g, ISO_F64, distance);
        float *out = gradients(&v, 2);
        for (size_t i = 0; i < iso_geometry_voxel_count(&g); ++i) {
            iso_vec3 p = center(&g, i), d = iso_v3(out[3 * i], out[3 * i + 1], out[3 * i + 2]);
            if (iso_norm(p) < 8 || fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z))) > 11)
                continue;
            worst[fine] = fmax(worst[fine], iso_norm(iso_sub(d, iso_normalize(p))));
        }
        free(out);
    }
    assert_at_most(worst[0], sqrt(3) / 2 / 64);
    assert_more_than(worst[0] / worst[1], 3.6); /* 4 for the second order, 2 for the first */
    assert_at_most(worst[0] / worst[1], 4.4);
}

TEST(types_agree_where_they_hold_the_same_values)
{
    const iso_type types[] = {ISO_U8, ISO_I8, ISO_U16, ISO_I16, ISO_U32, ISO_I32, ISO_F32, ISO_F64};
    iso_geometry g = oblique(6, 5, 4);
    const size_t count = iso_geometry_voxel_count(&g);
    FREED float *first = NULL;
    for (size_t t = 0; t < sizeof types / sizeof *types; ++t) {
        iso_volume v;
        assert_ok(iso_volume_create(&v, &g, types[t], "test", &err));
        for (size_t i = 0; i < count; ++i) {
            int value = (int)(i * 37 % 101);
            switch (types[t]) {
#define STORE(name, text, ctype) \
    case name: ((ctype *)v.data)[i] = (ctype)value; break;
                ISO_TYPE_LIST(STORE)
#undef STORE
            }
        }
        float *out = gradients(&v, 1);
        if (first)
            assert_memory_equal(out, first, 3 * count * sizeof *out);
        if (first)
            free(out);
        else
            first = out;
        iso_volume_destroy(&v);
    }
}

static double wave(iso_vec3 p)
{
    return sin(p.x) * cos(1.3 * p.y) + sin(0.7 * p.z + p.x);
}

TEST(slabs_and_threads_give_the_same_bytes)
{
    iso_geometry g = oblique(13, 7, 9);
    OWNED(iso_volume) v = sample(&g, ISO_F32, wave);
    const size_t plane = 3 * 13 * 7, bytes = 9 * plane * sizeof(float);
    FREED float *one = gradients(&v, 1), *three = gradients(&v, 3), *slabs = malloc(bytes);
    assert_memory_equal(one, three, bytes);
    iso_gradient_options opt = iso_gradient_defaults();
    const size_t cuts[] = {0, 1, 4, 4, 9};
    for (size_t i = 0; i + 1 < sizeof cuts / sizeof *cuts; ++i)
        assert_ok(iso_gradient_slab(&v, &opt, cuts[i], cuts[i + 1], slabs + cuts[i] * plane, &err));
    assert_memory_equal(one, slabs, bytes);
    assert_status(iso_gradient_slab(&v, &opt, 3, 10, slabs, &err), ISO_E_RANGE);
}

static double cubic(iso_vec3 p)
{
    return 0.02 * p.x * p.x * p.x + 0.1 * p.x * p.y * p.z + 0.03 * p.y * p.z * p.z - p.x;
}

/* Of one sample's rounding, 3e-4 x 2^-24 x 512 of values up to 512 each: below 2e-4. */
TEST(cubic_fields_are_exact_for_the_estimator_of_fourth_order)
{
    const size_t size[3] = {11, 9, 12};
    const double spacing[3] = {1, 0.5, 1.5};
    iso_geometry g = iso_geometry_axis_aligned(size, spacing);
    OWNED(iso_volume) v = sample(&g, ISO_F32, cubic);
    double worst[2] = {0, 0};
    for (int i = 0; i < 2; ++i) {
        float *out = gradients_by(&v, i ? ISO_GRADIENT_CENTRAL : ISO_GRADIENT_FOURTH, 1);
        for (size_t k = 0; k < iso_geometry_voxel_count(&g); ++k) {
            const size_t x = k % 11, y = k / 11 % 9, z = k / 99;
            if (x < 2 || x > 8 || y < 2 || y > 6 || z < 2 || z > 9)
                continue;
            iso_vec3 p = center(&g, k);
            iso_vec3 d = iso_v3(0.06 * p.x * p.x + 0.1 * p.y * p.z - 1, 0.1 * p.x * p.z + 0.03 * p.z * p.z,
                                0.1 * p.x * p.y + 0.06 * p.y * p.z);
            worst[i] = fmax(worst[i], iso_norm(iso_sub(d, iso_v3(out[3 * k], out[3 * k + 1], out[3 * k + 2]))));
        }
        free(out);
    }
    assert_at_most(worst[0], 2e-4);
    assert_more_than(worst[1], 2e-4); /* central differences miss the third derivative */
}

/* The border's weights sum to 8 at most, of values up to 300, each rounded to 2^-24: below 2e-4, over half a step
 * 4e-4. */
TEST(cubic_fields_are_exact_for_the_spline_up_to_the_border)
{
    const size_t sizes[][3] = {{11, 9, 12}, {40, 4, 5}, {4, 30, 27}};
    const double spacing[3] = {0.5, 0.5, 0.5};
    for (size_t s = 0; s < 3; ++s) {
        const size_t *n = sizes[s];
        iso_geometry g = iso_geometry_axis_aligned(n, spacing);
        OWNED(iso_volume) v = sample(&g, ISO_F32, cubic);
        double worst[2] = {0, 0};
        for (int i = 0; i < 2; ++i) {
            FREED float *out = gradients_by(&v, i ? ISO_GRADIENT_FOURTH : ISO_GRADIENT_BSPLINE, 1);
            for (size_t k = 0; k < iso_geometry_voxel_count(&g); ++k) {
                iso_vec3 p = center(&g, k);
                iso_vec3 d = iso_v3(0.06 * p.x * p.x + 0.1 * p.y * p.z - 1, 0.1 * p.x * p.z + 0.03 * p.z * p.z,
                                    0.1 * p.x * p.y + 0.06 * p.y * p.z);
                worst[i] = fmax(worst[i], iso_norm(iso_sub(d, iso_v3(out[3 * k], out[3 * k + 1], out[3 * k + 2]))));
            }
        }
        assert_at_most(worst[0], 4e-4);
        assert_more_than(worst[1], 4e-4); /* whose borders are of second order */
    }
}

/* The pre-filter as a recursion over the whole row, in double: c of (1 4 1) / 6 * c = f by elimination, then central
 * differences of c. Its ends are natural, which 24 voxels further in is 1e-13 of the samples. */
static void spline_by_recursion(const double *f, size_t n, double *d)
{
    double c[128], factor[128];
    c[0] = f[0], factor[0] = 0;
    for (size_t i = 1; i + 1 < n; ++i) {
        factor[i] = 1 / (4 - factor[i - 1]);
        c[i] = (6 * f[i] - c[i - 1]) * factor[i];
    }
    c[n - 1] = f[n - 1];
    for (size_t i = n - 2; i > 0; --i)
        c[i] -= factor[i] * c[i + 1];
    for (size_t i = 1; i + 1 < n; ++i)
        d[i] = (c[i + 1] - c[i - 1]) / 2;
}

/* 12 taps end at .268^12 = 1.4e-7 of the samples, some times more with what the last two take up; floats add 24 x
 * 2^-24. */
TEST(the_spline_is_that_of_the_recursive_pre_filter_along_each_axis)
{
    for (int axis = 0; axis < 3; ++axis) {
        size_t size[3] = {2, 2, 2};
        size[axis] = 100;
        const double spacing[3] = {1, 1, 1};
        iso_geometry g = iso_geometry_axis_aligned(size, spacing);
        OWNED(iso_volume) v;
        assert_ok(iso_volume_create(&v, &g, ISO_I16, "test", &err));
        double f[100], d[100], worst[2] = {0, 0};
        const size_t stride = axis == 0 ? 1 : axis == 1 ? 2 : 4;
        for (size_t i = 0; i < 100; ++i)
            f[i] = (double)((i * 2654435761u >> 7) % 2001) - 1000;
        for (size_t k = 0; k < 400; ++k)
            ((int16_t *)v.data)[k] = (int16_t)f[k / stride % 100];
        spline_by_recursion(f, 100, d);
        for (int i = 0; i < 2; ++i) {
            FREED float *out = gradients_by(&v, i ? ISO_GRADIENT_FOURTH : ISO_GRADIENT_BSPLINE, 1);
            for (size_t at = 24; at < 76; ++at)
                worst[i] = fmax(worst[i], fabs((double)out[3 * at * stride + (size_t)axis] - d[at]));
        }
        assert_at_most(worst[0], 1000 * 5e-6);
        assert_more_than(worst[1], 100);
    }
}

/* Float sums of 27 values of 2 or less, in two orders: within 30 x 2 x 2^-24 of each other, over half a step. */
TEST(corners_are_the_sobel_operator_at_voxel_centers)
{
    const size_t sizes[][3] = {{13, 7, 9}, {1, 5, 2}, {6, 1, 1}, {2, 2, 2}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; ++s) {
        iso_geometry g = oblique(sizes[s][0], sizes[s][1], sizes[s][2]);
        OWNED(iso_volume) v = sample(&g, ISO_F32, wave);
        FREED float *a = gradients_by(&v, ISO_GRADIENT_SOBEL, 1), *b = gradients_by(&v, ISO_GRADIENT_CORNERS, 1),
                    *c = gradients_by(&v, ISO_GRADIENT_CENTRAL, 1);
        double apart = 0, from_central = 0;
        for (size_t i = 0; i < 3 * iso_geometry_voxel_count(&g); ++i) {
            apart = fmax(apart, fabs(a[i] - b[i]));
            from_central = fmax(from_central, fabs(a[i] - c[i]));
        }
        assert_at_most(apart, 120 * 0x1p-24);
        if (s == 0)
            assert_more_than(from_central, 120 * 0x1p-24);
    }
}

TEST(names_lead_back_to_their_methods)
{
    iso_gradient_method method;
    for (int i = 0; i < ISO_GRADIENT_COUNT; ++i) {
        assert_ok(iso_gradient_from_name(iso_gradient_name((iso_gradient_method)i), &method, &err));
        assert_int_equal(method, i);
    }
    assert_status(iso_gradient_from_name("best", &method, &err), ISO_E_USAGE);
}

/* x^degree along one axis, x whole numbers from the middle, so that floats hold the samples: the largest error for |x|
 * <= 4. */
static double polynomial_error(iso_gradient_method method, int degree, int axis)
{
    enum { N = 32 };
    OWNED(iso_volume) v;
    size_t size[3] = {3, 3, 3};
    size[axis] = N;
    const iso_geometry g = iso_geometry_axis_aligned(size, (double[]){1, 1, 1});
    assert_ok(iso_volume_create(&v, &g, ISO_F64, "polynomial", &err));
    const size_t step = axis == 0 ? 1 : axis == 1 ? 3 : 9;
    for (size_t i = 0; i < 9 * N; ++i)
        ((double *)v.data)[i] = pow((double)(i / step % N) - N / 2, degree);
    FREED float *out = gradients_by(&v, method, 1);
    double largest = 0;
    const size_t middle = axis == 0 ? 3 * N + N : axis == 1 ? 3 * N + 1 : 4; /* the middle one of the nine lines */
    for (size_t x = N / 2 - 4; x <= N / 2 + 4; ++x) {
        const double expected = degree * pow((double)x - N / 2, degree - 1);
        largest = fmax(largest, fabs((double)out[3 * (middle + x * step) + (size_t)axis] - expected));
    }
    return largest;
}

/* Exact but for the rounding of the sums, whose terms are below 8^order where weights count. Of the next degree each
 * errs by a constant: half the second derivative (intermediate), a sixth of the third (central), 120 / 30 and 120 / 180
 * of x^5. */
TEST(each_estimator_has_the_order_that_its_row_says)
{
    for (int m = 0; m < ISO_GRADIENT_COUNT; ++m)
        for (int axis = 0; axis < 3; ++axis) {
            const int order = iso_gradient_describe((iso_gradient_method)m)->order;
            const double tolerance = 16 * pow(8, order) * 0x1p-24;
            for (int degree = 1; degree <= order; ++degree)
                assert_at_most(polynomial_error((iso_gradient_method)m, degree, axis), tolerance);
            assert_more_than(polynomial_error((iso_gradient_method)m, order + 1, axis), 0.5);
        }
}

TEST_MAIN(NULL, NULL)
