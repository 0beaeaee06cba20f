/* SPDX-License-Identifier: MIT */
/* Metrics: closed forms, direct sums written from the papers, and faults that must be caught. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "compare/flip.h"
#include "compare/metrics.h"
#include "compare/ssim.h"
#include "metrics_images.h"

TEST(equal_images_have_no_difference)
{
    OWNED(iso_image) a = textured(33, 21, 1);
    iso_metrics m = measure(&a, &a);
    assert_true(m.rmse == 0 && m.max_abs == 0 && m.p99_abs == 0 && m.flip_mean == 0 && isinf(m.psnr_db));
    assert_within(m.ssim, 1, 1e-12); /* a quotient of equal sums, rounded */
    assert_true(iso_metrics_within(&m, &(iso_tolerances){0}));
}

TEST(one_changed_channel_gives_the_closed_form)
{
    OWNED(iso_image) a = uniform(20, 30, 0.25f, 0.25f, 0.25f), b = copy(&a);
    b.rgba[4 * (7 * 20 + 13) + 2] = 0.75f;
    iso_metrics m = measure(&a, &b);
    /* exact in binary: one difference of 1/2 among 2400 channels */
    assert_within(m.rmse, 0.5 / sqrt(2400), 1e-15);
    assert_within(m.psnr_db, 20 * log10(2 * sqrt(2400)), 1e-12);
    assert_true(m.max_abs == 0.5 && m.worst[0] == 13 && m.worst[1] == 7);
    assert_true(m.p99_abs == 0); /* one pixel of 600 is below one percent */
    assert_false(iso_metrics_within(&m, &(iso_tolerances){0}));
    assert_true(iso_metrics_within(&m, &(iso_tolerances){.max_abs = 0.5}));
    assert_false(iso_metrics_within(&m, &(iso_tolerances){.max_abs = 0.4999}));
    assert_false(iso_metrics_within(&m, &(iso_tolerances){.max_abs = 0.5, .rmse = 0.01}));
}

TEST(alpha_counts_as_a_channel)
{
    OWNED(iso_image) a = uniform(12, 12, 0.5f, 0.5f, 0.5f), b = copy(&a);
    b.rgba[3] = 0.5f;
    iso_metrics m = measure(&a, &b);
    assert_true(m.max_abs == 0.5 && m.flip_mean == 0);
}

static int by_value(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

TEST(p99_is_the_value_that_a_sort_finds)
{
    const size_t sizes[][2] = {{1, 1}, {7, 13}, {20, 20}, {10, 10}, {37, 29}};
    for (size_t s = 0; s < 5; ++s)
        for (uint32_t seed = 1; seed < 6; ++seed) {
            size_t count = sizes[s][0] * sizes[s][1];
            OWNED(iso_image) a = uniform(sizes[s][0], sizes[s][1], 0, 0, 0), b = copy(&a);
            FREED float *sorted = malloc(count * sizeof *sorted);
            uint32_t random = seed;
            for (size_t i = 0; i < count; ++i) /* many ties in every other run */
                sorted[i] = b.rgba[4 * i + seed % 3] = (float)(seed % 2 ? noise(&random) : floor(4 * noise(&random)));
            qsort(sorted, count, sizeof *sorted, by_value);
            size_t rank = (99 * count + 99) / 100;
            assert_true(measure(&a, &b).p99_abs == sorted[rank - 1]);
        }
}

TEST(nonfinite_pixels_are_counted_and_never_agree)
{
    const float bad[] = {NAN, INFINITY, -INFINITY};
    for (int k = 0; k < 3; ++k)
        for (int c = 0; c < 4; ++c)
            for (int both = 0; both < 2; ++both) {
                OWNED(iso_image) a = uniform(16, 16, 0.5f, 0.5f, 0.5f), b = copy(&a);
                b.rgba[4 * 100 + c] = bad[k];
                if (both)
                    a.rgba[4 * 100 + c] = bad[k];
                iso_metrics m = measure(&a, &b);
                assert_int_equal(m.nonfinite_count, 1);
                assert_true(isnan(m.rmse) && isnan(m.flip_mean));
                assert_false(iso_metrics_within(&m, &(iso_tolerances){1e9, 1e9, 1e9, 1e9, 1e9}));
                assert_false(iso_metrics_within(&m, &(iso_tolerances){0}));
                json_auto_t *json = iso_metrics_to_json(&m);
                assert_true(json_is_null(json_object_get(json, "rmse")));
                assert_int_equal(json_integer_value(json_object_get(json, "nonfinite_count")), 1);
            }
}

TEST(empty_images_and_different_sizes_are_refused)
{
    iso_image none = {0}, a = uniform(4, 6, 0, 0, 0), b = uniform(6, 4, 0, 0, 0), out = {0};
    iso_metrics m;
    double mean;
    float map[24];
    assert_status(iso_metrics_measure(&none, &none, &m, &err), ISO_E_RANGE);
    assert_status(iso_metrics_measure(&a, &none, &m, &err), ISO_E_RANGE);
    iso_error why = {""};
    assert_true(iso_metrics_measure(&a, &b, &m, &why) == ISO_E_RANGE);
    /* From the first word on: not first by one of the metrics. */
    assert_ptr_equal(strstr(why.text, "the images have 4x6 and 6x4 pixels"), why.text);
    assert_status(iso_image_difference(&a, &b, 1, &out, &err), ISO_E_RANGE);
    assert_status(iso_ssim_mean(&a, &b, &mean, &err), ISO_E_RANGE);
    assert_status(iso_flip_ldr(&a, &b, 67, map, &err), ISO_E_RANGE);
    assert_status(iso_flip_hdr(&a, &b, 67, map, &err), ISO_E_RANGE);
    assert_status(iso_flip_ldr(&a, &a, 0, map, &err), ISO_E_RANGE);
    assert_status(iso_flip_ldr(&a, &a, NAN, map, &err), ISO_E_RANGE);
    assert_status(iso_flip_ldr(&a, &a, 1e9, map, &err), ISO_E_RANGE);
    iso_image_destroy(&a);
    iso_image_destroy(&b);
}

/* As the windows of EXR files put them: the same pixels, elsewhere. */
TEST(images_that_begin_elsewhere_are_refused)
{
    OWNED(iso_image) a = uniform(4, 6, 0, 0, 0), b = uniform(4, 6, 0, 0, 0);
    iso_metrics m;
    assert_ok(iso_metrics_measure(&a, &b, &m, &err));
    for (int axis = 0; axis < 2; ++axis) {
        b.origin[axis] = 1;
        assert_status(iso_metrics_measure(&a, &b, &m, &err), ISO_E_RANGE);
        b.origin[axis] = 0;
    }
}

TEST(each_limit_binds_alone)
{
    iso_metrics m = {.rmse = 2, .max_abs = 3, .p99_abs = 4, .psnr_db = 5, .ssim = 0.4, .flip_mean = 0.5};
    iso_tolerances all = {2, 3, 4, 0.6, 0.5};
    assert_true(iso_metrics_within(&m, &all));
    double *each[] = {&all.rmse, &all.max_abs, &all.p99_abs, &all.ssim_dissimilarity, &all.flip_mean};
    for (int i = 0; i < 5; ++i) {
        double kept = *each[i];
        *each[i] = kept * 0.99;
        assert_false(iso_metrics_within(&m, &all));
        *each[i] = kept;
    }
    m.ssim = NAN;
    assert_false(iso_metrics_within(&m, &all));
}

/* Eq. 13 with variances 0: only the luminance term is left. */
TEST(ssim_of_uniform_images_is_the_luminance_term)
{
    OWNED(iso_image) a = uniform(24, 18, 1, 1, 1), b = uniform(24, 18, 0, 0, 0);
    double mean;
    assert_ok(iso_ssim_mean(&a, &b, &mean, &err));
    assert_within(mean, 1e-4 / (1 + 1e-4), 1e-12); /* luma of white is 1 up to rounding */
}

/* Linear light whose sRGB is the gray v. */
static float linear_of(double v)
{
    return (float)(v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4));
}

static void set_gray(iso_image *image, size_t x, size_t y, double v)
{
    for (size_t c = 0; c < 3; ++c)
        image->rgba[4 * (y * image->width + x) + c] = linear_of(v);
}

/* A checkerboard m + s A, s = 1 or -1, and m + d + s B: under the window the mean of s is q = +-S^2, S the alternating
 * sum of the taps, so that Eq. 13 has its means m + q A and m + d + q B, variances (1 - q^2) of A^2 and B^2 and
 * covariance of A B. */
TEST(ssim_of_shifted_and_stretched_contrast_is_the_closed_form)
{
    enum { n = 21 };
    const struct {
        double m, d, amplitude_a, amplitude_b;
    } pairs[] = {
        {0.5, 0, 0.2, 0.1},    {0.5, 0, 0.05, 0.15},     {0.4, 0.3, 0.1, 0.1}, {0.3, 0.1, 0.02, 0.05},
        {0.2, 0, 0.004, 0.01}, {0.02, 0.03, 0.01, 0.01}, {0.5, 0, 0.2, -0.2},
    };
    double alternating = 0, sum = 0;
    for (int i = -5; i <= 5; ++i) {
        alternating += (i % 2 ? -1 : 1) * exp(-i * i / 4.5);
        sum += exp(-i * i / 4.5);
    }
    const double S = alternating / sum, q = S * S, c1 = 1e-4, c2 = 9e-4;
    for (size_t k = 0; k < sizeof pairs / sizeof *pairs; ++k) {
        OWNED(iso_image) a = uniform(n, n, 0, 0, 0), b = uniform(n, n, 0, 0, 0);
        double mean, expected = 0, m = pairs[k].m, d = pairs[k].d, A = pairs[k].amplitude_a, B = pairs[k].amplitude_b;
        for (size_t y = 0; y < n; ++y)
            for (size_t x = 0; x < n; ++x) {
                set_gray(&a, x, y, m + ((x + y) % 2 ? -A : A));
                set_gray(&b, x, y, m + d + ((x + y) % 2 ? -B : B));
            }
        for (size_t y = 5; y < n - 5; ++y)
            for (size_t x = 5; x < n - 5; ++x) {
                double s = (x + y) % 2 ? -q : q, ma = m + s * A, mb = m + d + s * B, v = 1 - q * q;
                expected += (2 * ma * mb + c1) * (2 * v * A * B + c2) /
                            ((ma * ma + mb * mb + c1) * (v * A * A + v * B * B + c2));
            }
        assert_ok(iso_ssim_mean(&a, &b, &mean, &err));
        assert_within(mean, expected / ((n - 10) * (n - 10)),
                      2e-6); /* float pixels of 6e-8 against contrasts of .004 */
    }
}

/* One white pixel against black shows each tap of the window by itself: mean w, variance w - w^2, and nothing beyond 5
 * pixels. */
TEST(ssim_of_a_single_pixel_shows_the_window)
{
    enum { n = 31 };
    OWNED(iso_image) a = uniform(n, n, 0, 0, 0), b = uniform(n, n, 0, 0, 0);
    double taps[11], sum = 0, mean, expected = 0;
    set_gray(&a, 15, 15, 1);
    for (int i = 0; i < 11; ++i)
        sum += taps[i] = exp(-(i - 5) * (i - 5) / (2 * 1.5 * 1.5));
    for (int j = 0; j < 11; ++j)
        for (int i = 0; i < 11; ++i) {
            double w = taps[i] * taps[j] / (sum * sum);
            expected += 1 - 1e-4 * 9e-4 / ((w * w + 1e-4) * (w - w * w + 9e-4));
        }
    assert_ok(iso_ssim_mean(&a, &b, &mean, &err));
    assert_within(1 - mean, expected / ((n - 10) * (n - 10)), 1e-12); /* white and black are exact: rounding only */
}

/* x alternates by rows of a period of 2; y = 1 - x: means equal in the limit, covariance = -variance. */
TEST(ssim_of_an_inverted_pattern_is_negative)
{
    OWNED(iso_image) a = uniform(31, 31, 0, 0, 0), b = uniform(31, 31, 0, 0, 0);
    for (size_t y = 0; y < 31; ++y)
        for (size_t x = 0; x < 31; ++x)
            for (int c = 0; c < 3; ++c) {
                a.rgba[4 * (y * 31 + x) + (size_t)c] = (float)((x + y) % 2);
                b.rgba[4 * (y * 31 + x) + (size_t)c] = (float)((x + y + 1) % 2);
            }
    double mean;
    assert_ok(iso_ssim_mean(&a, &b, &mean, &err));
    /* Variance 1/4, covariance -1/4, C2 = 9e-4; a Gaussian of sigma 1.5 sees both colors alike to 1e-4. */
    assert_within(mean, (-0.5 + 9e-4) / (0.5 + 9e-4), 1e-4);
}

/* What ssim.c sums in one pass, by two passes over means and deviations, at one window. */
static double direct_ssim(const iso_image *a, const iso_image *b, size_t cx, size_t cy)
{
    double w[11][11], total = 0, mean[2] = {0}, var[2] = {0}, cov = 0;
    double v[2][11][11];
    for (int j = 0; j < 11; ++j)
        for (int i = 0; i < 11; ++i) {
            total += w[j][i] = exp(-((i - 5) * (i - 5) + (j - 5) * (j - 5)) / 4.5);
            for (int k = 0; k < 2; ++k) {
                const iso_image *image = k ? b : a;
                const float *p = image->rgba + 4 * ((cy + (size_t)j - 5) * image->width + cx + (size_t)i - 5);
                double luma = 0;
                for (int c = 0; c < 3; ++c) {
                    double x = fmin(fmax(p[c], 0), 1);
                    double s = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
                    luma += (c == 0 ? 0.299 : c == 1 ? 0.587 : 0.114) * s;
                }
                v[k][j][i] = luma;
            }
        }
    for (int k = 0; k < 2; ++k) {
        for (int j = 0; j < 11; ++j)
            for (int i = 0; i < 11; ++i)
                mean[k] += w[j][i] / total * v[k][j][i];
        for (int j = 0; j < 11; ++j)
            for (int i = 0; i < 11; ++i)
                var[k] += w[j][i] / total * pow(v[k][j][i] - mean[k], 2);
    }
    for (int j = 0; j < 11; ++j)
        for (int i = 0; i < 11; ++i)
            cov += w[j][i] / total * (v[0][j][i] - mean[0]) * (v[1][j][i] - mean[1]);
    return (2 * mean[0] * mean[1] + 1e-4) * (2 * cov + 9e-4) /
           ((mean[0] * mean[0] + mean[1] * mean[1] + 1e-4) * (var[0] + var[1] + 9e-4));
}

TEST(ssim_is_the_mean_of_its_definition)
{
    OWNED(iso_image) a = textured(23, 17, 3), b = textured(23, 17, 99);
    double mean, sum = 0;
    assert_ok(iso_ssim_mean(&a, &b, &mean, &err));
    for (size_t y = 5; y < 12; ++y)
        for (size_t x = 5; x < 18; ++x)
            sum += direct_ssim(&a, &b, x, y);
    assert_within(mean, sum / (7 * 13), 1e-10); /* one pass against two: rounding only */
    assert_more_than(fabs(mean - 1), 1e-3);     /* and the pair does differ */
}

TEST(ssim_of_the_foreground_leaves_out_what_both_images_leave_empty)
{
    OWNED(iso_image) a = textured(23, 17, 3), b = textured(23, 17, 99);
    double mean, sum = 0, all;
    size_t count = 0;
    for (size_t i = 0; i < 23 * 17; ++i) {
        a.rgba[4 * i + 3] = i % 3 == 0 ? 1 : 0.003f; /* below 1/255 */
        b.rgba[4 * i + 3] = i % 4 == 0 ? 0.004f : 0;
    }
    assert_ok(iso_ssim_foreground(&a, &b, &mean, &err));
    for (size_t y = 5; y < 12; ++y)
        for (size_t x = 5; x < 18; ++x)
            if ((y * 23 + x) % 3 == 0 || (y * 23 + x) % 4 == 0) {
                sum += direct_ssim(&a, &b, x, y);
                ++count;
            }
    assert_within(mean, sum / (double)count, 1e-10);
    assert_ok(iso_ssim_mean(&a, &b, &all, &err));
    assert_more_than(fabs(all - mean), 1e-4); /* the mean over all windows is another */
    for (size_t i = 0; i < 23 * 17; ++i)
        a.rgba[4 * i + 3] = b.rgba[4 * i + 3] = 0;
    assert_ok(iso_ssim_foreground(&a, &b, &mean, &err));
    assert_within(mean, 1, 0);
}

/* Faults that a renderer may have; tolerances as the reference scenes use them must reject each. */
TEST(planted_faults_are_rejected)
{
    enum { n = 48 };
    OWNED(iso_image) a = textured(n, n, 11);
    const iso_tolerances tolerances = {.rmse = 1e-3, .max_abs = 1e-2, .flip_mean = 5e-3, .ssim_dissimilarity = 5e-3};
    for (int fault = 0; fault < 6; ++fault) {
        OWNED(iso_image) b = copy(&a);
        for (size_t y = 0; y < n; ++y)
            for (size_t x = 0; x < n; ++x) {
                float *p = b.rgba + 4 * (y * n + x);
                const float *right = a.rgba + 4 * (y * n + (x + 1 < n ? x + 1 : x));
                const float *turned = a.rgba + 4 * (x * n + y);
                for (int c = 0; c < 3; ++c)
                    switch (fault) {
                    case 0: p[c] = 0.5f * (p[c] + right[c]); break;                  /* half a pixel aside */
                    case 1: p[c] = turned[c]; break;                                 /* axes swapped */
                    case 2: p[c] = powf(p[c], 1 / 2.2f); break;                      /* encoded twice */
                    case 3: p[c] *= 0.9f; break;                                     /* premultiplied twice */
                    case 4: p[c] = a.rgba[4 * (y * n + x) + (size_t)(2 - c)]; break; /* blue for red */
                    default: p[c] = fminf(p[c], 0.6f); break;                        /* highlights clipped */
                    }
            }
        iso_metrics m = measure(&a, &b);
        assert_false(iso_metrics_within(&m, &(iso_tolerances){.rmse = tolerances.rmse}));
        assert_false(iso_metrics_within(&m, &(iso_tolerances){.max_abs = tolerances.max_abs}));
        assert_false(iso_metrics_within(&m, &(iso_tolerances){.flip_mean = tolerances.flip_mean}));
        if (fault != 3) /* SSIM hardly sees a change of brightness: why it is never the only gate */
            assert_false(
                iso_metrics_within(&m, &(iso_tolerances){.ssim_dissimilarity = tolerances.ssim_dissimilarity}));
    }
}

TEST(difference_image_is_scaled_to_its_largest)
{
    iso_image a = uniform(5, 4, 0.5f, 0.5f, 0.5f), b = copy(&a), d;
    b.rgba[4 * 7 + 1] = 0.75f;
    b.rgba[4 * 9 + 2] = 0.375f;
    b.rgba[4 * 3] = NAN;
    assert_ok(iso_image_difference(&a, &b, 0, &d, &err));
    assert_true(d.rgba[4 * 7 + 1] == 1 && d.rgba[4 * 9 + 2] == 0.5f && d.rgba[0] == 0 && d.rgba[4 * 3] == 1);
    iso_image_destroy(&d);
    assert_ok(iso_image_difference(&a, &b, 2, &d, &err));
    assert_true(d.rgba[4 * 7 + 1] == 0.5f);
    iso_image_destroy(&d);
    iso_image_destroy(&a);
    iso_image_destroy(&b);
}

TEST_MAIN(NULL, NULL)
