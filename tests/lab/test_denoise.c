/* SPDX-License-Identifier: MIT */
/* The estimate of noise, non-local means, and the wide estimator of gradients, on fields whose truth is known. */
#include "lab/denoise.h"
#include "lab/shading_method.h"
#include "tests/test.h"

enum { n = 32 };
static const size_t size[3] = {n, n, n};

static void sample(iso_field_kind kind, double noise, float *values)
{
    iso_field field;
    OWNED(iso_volume) v;
    assert_ok(iso_shading_sample(kind, n, noise, &field, &v, &err));
    memcpy(values, v.data, n * n * n * sizeof *values);
}

static double rms_between(const float *a, const float *b)
{
    double sum = 0;
    for (size_t i = 0; i < n * n * n; ++i)
        sum += ((double)a[i] - (double)b[i]) * ((double)a[i] - (double)b[i]);
    return sqrt(sum / (n * n * n));
}

/* 30^3 figures, not independent: 3 %. A ramp has no second differences, so that all of it is noise. */
TEST(the_deviation_of_noise_is_found)
{
    FREED float *values = malloc(n * n * n * sizeof *values);
    double deviation;
    for (double noise = 0.01; noise < 0.2; noise *= 3) {
        sample(ISO_FIELD_RAMP, noise, values);
        assert_ok(iso_noise_estimate(values, size, &deviation, &err));
        assert_within(deviation, noise, 0.03 * noise);
    }
    sample(ISO_FIELD_SPHERE, 0.05, values); /* bends little */
    assert_ok(iso_noise_estimate(values, size, &deviation, &err));
    assert_within(deviation, 0.05, 0.05 * 0.05);
    sample(ISO_FIELD_CONSTANT, 0, values);
    assert_ok(iso_noise_estimate(values, size, &deviation, &err));
    assert_true(deviation == 0);
}

/* 125 values have a mean whose noise is an eleventh; edges and patches leave more. */
TEST(denoising_is_nearer_to_the_truth)
{
    FREED float *truth = malloc(n * n * n * sizeof *truth), *noisy = malloc(n * n * n * sizeof *noisy),
                *out = malloc(n * n * n * sizeof *out);
    sample(ISO_FIELD_SPHERE, 0, truth);
    sample(ISO_FIELD_SPHERE, 0.05, noisy);
    assert_ok(iso_denoise(noisy, size, 0.05, out, &err));
    assert_at_most(rms_between(out, truth), 0.5 * rms_between(noisy, truth));
    assert_ok(iso_denoise(noisy, size, 0, out, &err));
    assert_true(memcmp(out, noisy, n * n * n * sizeof *out) == 0);
}

/* A step of fifty deviations stays where it is: voxels beyond it have no weight. */
TEST(an_edge_is_kept)
{
    FREED float *values = malloc(n * n * n * sizeof *values), *out = malloc(n * n * n * sizeof *out);
    for (size_t i = 0; i < n * n * n; ++i)
        values[i] = i % n < n / 2 ? 0 : 1;
    assert_ok(iso_denoise(values, size, 0.02, out, &err));
    assert_at_most(rms_between(out, values), 1e-6);
}

static double mean_angle(const iso_field *field, const iso_volume *v, iso_gradient_method method)
{
    float *g = malloc(3 * n * n * n * sizeof *g);
    double sum = 0, count = 0;
    assert_ok(iso_gradient_compute(v, &(iso_gradient_options){method, 1}, g, &err));
    for (size_t z = 4; z + 4 < n; ++z)
        for (size_t y = 4; y + 4 < n; ++y)
            for (size_t x = 4; x + 4 < n; ++x) {
                const float *d = g + 3 * (x + n * (y + n * z));
                iso_vec3 truth;
                iso_field_value(field,
                                iso_geometry_to_world(&v->geometry,
                                                      iso_v3((double)x + 0.5, (double)y + 0.5, (double)z + 0.5)),
                                &truth);
                if (iso_norm(truth) < 1e-9)
                    continue; /* beyond the sphere */
                sum += acos(
                    fmin(iso_dot(iso_normalize(iso_v3((double)d[0], (double)d[1], (double)d[2])), iso_normalize(truth)),
                         1));
                count += 1;
            }
    free(g);
    return sum / count;
}

/* The noise of the sum: weights' squares are .156 * .273^2 against .5 of central differences, a sixth of the
 * deviation. */
TEST(smooth_gradients_hold_noise_down)
{
    iso_field field;
    OWNED(iso_volume) v;
    assert_ok(iso_shading_sample(ISO_FIELD_SPHERE, n, 0.01, &field, &v, &err));
    const double central = mean_angle(&field, &v, ISO_GRADIENT_CENTRAL),
                 sobel = mean_angle(&field, &v, ISO_GRADIENT_SOBEL),
                 smooth = mean_angle(&field, &v, ISO_GRADIENT_SMOOTH);
    assert_at_most(smooth, 0.25 * central);
    assert_at_most(smooth, 0.6 * sobel);
}

TEST_MAIN(NULL, NULL)
