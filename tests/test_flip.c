/* SPDX-License-Identifier: MIT */
/* FLIP: closed forms, direct sums over its filters, and the published program. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "compare/flip.h"
#include "metrics_images.h"

static double flip_mean(const iso_image *a, const iso_image *b)
{
    FREED float *map = malloc(a->width * a->height * sizeof *map);
    assert_ok(iso_flip_ldr(a, b, ISO_FLIP_PIXELS_PER_DEGREE, map, &err));
    double mean = iso_flip_mean(map, a->width * a->height);
    return mean;
}

static const double to_xyz[3][3] = {{0.41239080, 0.35758434, 0.18048079},
                                    {0.21263901, 0.71516868, 0.07219232},
                                    {0.01933082, 0.11919478, 0.95053215}};

static double lab_f(double t)
{
    return t > 216.0 / 24389 ? cbrt(t) : (24389.0 / 27 * t + 16) / 116;
}

/* HyAB of adapted green and blue to the power of .7: 41.28. */
static double largest_flip_color(void)
{
    double lab[2][3];
    for (int k = 0; k < 2; ++k) {
        double n[3];
        for (int i = 0; i < 3; ++i)
            n[i] = lab_f(to_xyz[i][k + 1] / (to_xyz[i][0] + to_xyz[i][1] + to_xyz[i][2]));
        lab[k][0] = 116 * n[1] - 16;
        lab[k][1] = 0.01 * lab[k][0] * 500 * (n[0] - n[1]);
        lab[k][2] = 0.01 * lab[k][0] * 200 * (n[1] - n[2]);
    }
    return pow(fabs(lab[0][0] - lab[1][0]) + hypot(lab[0][1] - lab[1][1], lab[0][2] - lab[1][2]), 0.7);
}

/* sec. 4.1.3: green against blue is the largest difference of the gamut, and maps to 1. */
TEST(flip_of_green_and_blue_is_one)
{
    OWNED(iso_image) a = uniform(9, 14, 0, 1, 0), b = uniform(9, 14, 0, 0, 1);
    assert_within(flip_mean(&a, &b), 1, 1e-6); /* float map */
}

/* Grays have no chroma: HyAB is the difference of L*, here 100 and L*(.5) = 116 cbrt(.5) - 16. */
TEST(flip_of_uniform_grays_is_the_closed_form)
{
    const double largest = largest_flip_color();
    const double levels[] = {0, 0.5, 0.02, 0.9};
    for (int i = 0; i < 4; ++i) {
        OWNED(iso_image)
        a = uniform(12, 12, 1, 1, 1),
        b = uniform(12, 12, (float)levels[i], (float)levels[i], (float)levels[i]);
        double lightness = levels[i] > 0.0088565 ? 116 * cbrt((float)levels[i]) - 16 : 0;
        double d = pow(100 - lightness, 0.7), knee = 0.4 * largest;
        double expected = d < knee ? 0.95 / knee * d : 0.95 + (d - knee) / (largest - knee) * 0.05;
        assert_within(flip_mean(&a, &b), expected, 2e-6); /* digits of the matrix, float map */
    }
}

/* FLIP at one pixel by double sums over 2-D filters, straight from the paper. */
typedef struct direct_percept {
    double lab[3], edge, point;
} direct_percept;

/* Solves m x = y by Cramer's rule: the inverse color matrix without a table. */
static void solve(const double m[3][3], const double y[3], double x[3])
{
    double det = 0, minor[3][3];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            minor[i][j] = m[(i + 1) % 3][(j + 1) % 3] * m[(i + 2) % 3][(j + 2) % 3] -
                          m[(i + 1) % 3][(j + 2) % 3] * m[(i + 2) % 3][(j + 1) % 3];
    for (int j = 0; j < 3; ++j)
        det += m[0][j] * minor[0][j];
    for (int j = 0; j < 3; ++j)
        x[j] = (minor[0][j] * y[0] + minor[1][j] * y[1] + minor[2][j] * y[2]) / det;
}

static void opponent(const iso_image *image, long x, long y, double out[3])
{
    x = x < 0 ? 0 : x >= (long)image->width ? (long)image->width - 1 : x;
    y = y < 0 ? 0 : y >= (long)image->height ? (long)image->height - 1 : y;
    const float *p = image->rgba + 4 * ((size_t)y * image->width + (size_t)x);
    double n[3];
    for (int i = 0; i < 3; ++i) {
        n[i] = 0;
        for (int c = 0; c < 3; ++c)
            n[i] += to_xyz[i][c] * fmin(fmax(p[c], 0), 1);
        n[i] /= to_xyz[i][0] + to_xyz[i][1] + to_xyz[i][2];
    }
    out[0] = 116 * n[1] - 16, out[1] = 500 * (n[0] - n[1]), out[2] = 200 * (n[1] - n[2]);
}

static direct_percept perceive_directly(const iso_image *image, long cx, long cy)
{
    const double ppd = ISO_FLIP_PIXELS_PER_DEGREE, pi = acos(-1);
    const double table[3][4] = {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}};
    direct_percept out;
    double opp[3], filtered[3], sums[3] = {0}, values[3] = {0};
    for (long j = -10; j <= 10; ++j) /* 3 sigma of .04: 9.05 pixels */
        for (long i = -10; i <= 10; ++i) {
            opponent(image, cx + i, cy + j, opp);
            double d2 = (double)(i * i + j * j) / (ppd * ppd);
            for (int c = 0; c < 3; ++c) {
                const double *t = table[c];
                double w = t[0] * sqrt(pi / t[1]) * exp(-pi * pi * d2 / t[1]) +
                           t[2] * sqrt(pi / t[3]) * exp(-pi * pi * d2 / t[3]);
                sums[c] += w;
                values[c] += w * opp[c];
            }
        }
    for (int c = 0; c < 3; ++c)
        filtered[c] = values[c] / sums[c];
    double y = (filtered[0] + 16) / 116, n[3] = {filtered[1] / 500 + y, y, y - filtered[2] / 200}, xyz[3], rgb[3];
    for (int i = 0; i < 3; ++i)
        xyz[i] = n[i] * (to_xyz[i][0] + to_xyz[i][1] + to_xyz[i][2]);
    solve(to_xyz, xyz, rgb);
    for (int i = 0; i < 3; ++i) {
        n[i] = 0;
        for (int c = 0; c < 3; ++c)
            n[i] += to_xyz[i][c] * fmin(fmax(rgb[c], 0), 1);
        n[i] = lab_f(n[i] / (to_xyz[i][0] + to_xyz[i][1] + to_xyz[i][2]));
    }
    out.lab[0] = 116 * n[1] - 16;
    out.lab[1] = 0.01 * out.lab[0] * 500 * (n[0] - n[1]);
    out.lab[2] = 0.01 * out.lab[0] * 200 * (n[1] - n[2]);

    double sigma = 0.5 * 0.082 * ppd, edge[2] = {0}, point[2] = {0};
    long radius = (long)ceil(3 * sigma);
    for (int axis = 0; axis < 2; ++axis)
        for (int kind = 0; kind < 2; ++kind) {
            double plus = 0, minus = 0, at_plus = 0, at_minus = 0;
            for (long j = -radius; j <= radius; ++j)
                for (long i = -radius; i <= radius; ++i) {
                    double t = (double)(axis ? j : i), g = exp(-(double)(i * i + j * j) / (2 * sigma * sigma));
                    double w = kind ? (t * t / (sigma * sigma) - 1) * g : -t * g;
                    opponent(image, cx + i, cy + j, opp);
                    *(w > 0 ? &plus : &minus) += fabs(w);
                    *(w > 0 ? &at_plus : &at_minus) += w * (opp[0] + 16) / 116;
                }
            (kind ? point : edge)[axis] = at_plus / plus + at_minus / minus;
        }
    out.edge = hypot(edge[0], edge[1]);
    out.point = hypot(point[0], point[1]);
    return out;
}

static double direct_flip(const iso_image *a, const iso_image *b, long x, long y)
{
    direct_percept p = perceive_directly(a, x, y), q = perceive_directly(b, x, y);
    double d = fabs(p.lab[0] - q.lab[0]) + hypot(p.lab[1] - q.lab[1], p.lab[2] - q.lab[2]);
    double e = pow(d, 0.7), largest = largest_flip_color(), knee = 0.4 * largest;
    e = e < knee ? 0.95 / knee * e : 0.95 + (e - knee) / (largest - knee) * 0.05;
    double f = sqrt(fmax(fabs(p.edge - q.edge), fabs(p.point - q.point)) / sqrt(2));
    return pow(e, 1 - f);
}

TEST(flip_equals_a_direct_sum_over_its_filters)
{
    OWNED(iso_image) a = textured(37, 26, 5), b = textured(37, 26, 6);
    for (size_t y = 8; y < 15; ++y)
        for (size_t x = 10; x < 22; ++x)
            for (int c = 0; c < 3; ++c)
                b.rgba[4 * (y * 37 + x) + (size_t)c] = c == 0;
    float map[37 * 26];
    assert_ok(iso_flip_ldr(&a, &b, ISO_FLIP_PIXELS_PER_DEGREE, map, &err));
    double largest = 0;
    for (long y = 0; y < 26; y += 3)
        for (long x = 0; x < 37; x += 4) {
            /* The digits of the matrix above, through pow(., .7) at small differences, and the float map. */
            assert_within(map[y * 37 + x], direct_flip(&a, &b, x, y), 3e-6);
            largest = fmax(largest, map[y * 37 + x]);
        }
    assert_more_than(largest, 0.3);
}

TEST(flip_sees_a_firefly_that_rmse_hardly_sees)
{
    OWNED(iso_image) a = uniform(41, 41, 0.2f, 0.2f, 0.2f), b = copy(&a);
    for (int c = 0; c < 3; ++c)
        b.rgba[4 * (20 * 41 + 20) + c] = 1;
    float map[41 * 41];
    assert_ok(iso_flip_ldr(&a, &b, ISO_FLIP_PIXELS_PER_DEGREE, map, &err));
    assert_more_than(map[20 * 41 + 20], 100 * measure(&a, &b).rmse / 8); /* 0.39 against an RMSE of .017 */
    assert_at_most(map[0], 0);
}

TEST(flip_is_symmetric)
{
    OWNED(iso_image) a = textured(19, 31, 7), b = textured(19, 31, 8);
    assert_true(flip_mean(&a, &b) == flip_mean(&b, &a));
}

TEST(hdr_flip_sees_what_is_clipped_away_in_ldr)
{
    OWNED(iso_image) a = textured(24, 24, 9), b;
    for (size_t i = 0; i < 24 * 24; ++i)
        for (int c = 0; c < 3; ++c)
            a.rgba[4 * i + (size_t)c] = 2 + 4 * a.rgba[4 * i + (size_t)c];
    b = copy(&a);
    for (size_t i = 0; i < 24 * 12; ++i)
        b.rgba[4 * i] *= 1.5f;
    float map[24 * 24];
    assert_ok(iso_flip_ldr(&a, &b, ISO_FLIP_PIXELS_PER_DEGREE, map, &err));
    assert_true(iso_flip_mean(map, 24 * 24) == 0);
    assert_ok(iso_flip_hdr(&a, &b, ISO_FLIP_PIXELS_PER_DEGREE, map, &err));
    assert_more_than(iso_flip_mean(map, 24 * 24), 0.05);
    assert_ok(iso_flip_hdr(&a, &a, ISO_FLIP_PIXELS_PER_DEGREE, map, &err));
    assert_true(iso_flip_mean(map, 24 * 24) == 0);
}

/* [andersson-2021] sec. 3.2: from where the brightest pixel, to where the median is shown at 0.85 by the tone curve;
 * the published example's 2^-12.5423 to 2^0.9427 are 14 exposures. */
TEST(hdr_exposures_show_the_brightest_and_the_median_at_085)
{
    OWNED(iso_image) a = uniform(5, 1, 0, 0, 0), dark = uniform(5, 1, 0, 0, 0);
    const float grays[] = {12, 0.5f, 3, 40, 0.01f}; /* the median is 3, the brightest 40 */
    double start, stop;
    size_t count;
    for (size_t i = 0; i < 5; ++i)
        for (size_t c = 0; c < 3; ++c)
            a.rgba[4 * i + c] = grays[i];
    assert_ok(iso_flip_exposures(&a, &start, &stop, &count, &err));
    const double shown[] = {40 * exp2(start), 3 * exp2(stop)};
    for (int i = 0; i < 2; ++i) {
        double x = 0.6 * shown[i];
        assert_within(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.85, 1e-9);
    }
    assert_within(stop - start, log2(40.0 / 3), 1e-9);
    assert_int_equal(count, 4); /* 3.74 stops */
    for (size_t c = 0; c < 3; ++c)
        a.rgba[4 * 3 + c] = (float)(3 * exp2(0.9427 + 12.5423));
    assert_ok(iso_flip_exposures(&a, &start, &stop, &count, &err));
    assert_int_equal(count, 14);
    for (size_t c = 0; c < 3; ++c)
        dark.rgba[c] = 1;
    assert_ok(iso_flip_exposures(&dark, &start, &stop, &count, &err)); /* a black median has no end of exposures */
    assert_true(stop - start == 8 && count == 8);
}

static void brighten(iso_image *image, float gain)
{
    for (size_t i = 0; i < image->width * image->height; ++i)
        for (int c = 0; c < 3; ++c)
            image->rgba[4 * i + (size_t)c] *= gain;
}

/* Means that the authors' own program gives for these pairs. It works in single precision with
 * color matrices of other digits: up to 8e-6 of a value near 1. */
TEST(flip_equals_the_published_program)
{
    const double tolerance = 1e-5;
    OWNED(iso_image) a = textured(61, 47, 5), b = textured(61, 47, 6), c = copy(&a);
    assert_within(flip_mean(&a, &b), 0.0789761, tolerance);
    for (size_t y = 8; y < 15; ++y)
        for (size_t x = 10; x < 22; ++x)
            memcpy(c.rgba + 4 * (y * 61 + x), (float[4]){1, 0, 0, 1}, 16);
    assert_within(flip_mean(&a, &c), 0.0489542, tolerance);
    OWNED(iso_image) white = uniform(8, 8, 1, 1, 1), black = uniform(8, 8, 0, 0, 0);
    assert_within(flip_mean(&white, &black), 0.9673710, tolerance);
    brighten(&a, 8);
    brighten(&b, 8);
    float map[61 * 47];
    assert_ok(iso_flip_hdr(&a, &b, ISO_FLIP_PIXELS_PER_DEGREE, map, &err));
    assert_within(iso_flip_mean(map, 61 * 47), 0.0702070, tolerance);
}

TEST_MAIN(NULL, NULL)
