/* SPDX-License-Identifier: MIT */
#include "compare/metrics.h"

#include <math.h>
#include <stdlib.h>

#include "base/json.h"
#include "compare/flip.h"
#include "compare/ssim.h"

/* Returns the k-th smallest (k from 0) of values, which it reorders: selection, not a sort. */
static float select_smallest(float *values, size_t count, size_t k)
{
    size_t lo = 0, hi = count - 1;
    while (lo < hi) {
        float pivot = values[lo + (hi - lo) / 2];
        size_t i = lo, j = hi;
        for (;;) { /* Hoare: [lo, j] <= pivot <= [j + 1, hi] */
            while (values[i] < pivot)
                ++i;
            while (values[j] > pivot)
                --j;
            if (i >= j)
                break;
            float t = values[i];
            values[i++] = values[j];
            values[j--] = t;
        }
        if (k <= j)
            hi = j;
        else
            lo = j + 1;
    }
    return values[k];
}

static size_t count_nonfinite(const iso_image *a, const iso_image *b)
{
    size_t bad = 0;
    for (size_t i = 0; i < a->width * a->height; ++i) {
        bool good = true;
        for (int c = 0; c < 4; ++c)
            good = good && isfinite(a->rgba[4 * i + c]) && isfinite(b->rgba[4 * i + c]);
        bad += !good;
    }
    return bad;
}

/* Measures rmse, max and worst pixel; largest[i] gets the difference of pixel i. */
static void measure_differences(const iso_image *a, const iso_image *b, float *largest, iso_metrics *m)
{
    size_t count = a->width * a->height;
    double squares = 0;
    m->max_abs = 0;
    m->worst[0] = m->worst[1] = 0;
    for (size_t i = 0; i < count; ++i) {
        double pixel = 0;
        for (int c = 0; c < 4; ++c) {
            double d = fabs((double)a->rgba[4 * i + c] - (double)b->rgba[4 * i + c]);
            squares += d * d;
            pixel = fmax(pixel, d);
        }
        largest[i] = (float)pixel;
        if (pixel > m->max_abs) {
            m->max_abs = pixel;
            m->worst[0] = i % a->width;
            m->worst[1] = i / a->width;
        }
    }
    m->rmse = sqrt(squares / (4 * (double)count));
    m->psnr_db = m->rmse > 0 ? -20 * log10(m->rmse) : INFINITY;
}

static iso_status measure(const iso_image *a, const iso_image *b, bool visual, iso_metrics *m, iso_error *err)
{
    *m = (iso_metrics){.rmse = NAN, .max_abs = NAN, .p99_abs = NAN, .psnr_db = NAN, .ssim = NAN, .flip_mean = NAN};
    size_t count = a->width * a->height;
    if (count == 0 || b->width * b->height == 0)
        return iso_fail(err, ISO_E_RANGE, "an image is empty (%zux%zu and %zux%zu pixels)", a->width,
                        a->height, b->width, b->height);
    if (a->width != b->width || a->height != b->height)
        return iso_fail(err, ISO_E_RANGE, "the images have %zux%zu and %zux%zu pixels, must be of one size",
                        a->width, a->height, b->width, b->height);
    if (a->origin[0] != b->origin[0] || a->origin[1] != b->origin[1])
        return iso_fail(
            err, ISO_E_RANGE,
            "the images begin at column %d, row %d and at column %d, row %d (their display windows), must begin alike",
            a->origin[0], a->origin[1], b->origin[0], b->origin[1]);
    m->nonfinite_count = count_nonfinite(a, b);
    if (m->nonfinite_count > 0)
        return ISO_OK;
    FREED float *map = malloc(count * sizeof *map);
    NEED_MEMORY(map, err, "no memory for %zu pixels", count);
    measure_differences(a, b, map, m);
    size_t rank = count - count / 100; /* at least 99 % of the pixels are at or below it */
    m->p99_abs = select_smallest(map, count, rank - 1);
    iso_status status = visual ? iso_ssim_mean(a, b, &m->ssim, err) : ISO_OK;
    if (status == ISO_OK && visual)
        status = iso_flip_ldr(a, b, ISO_FLIP_PIXELS_PER_DEGREE, map, err);
    if (status == ISO_OK && visual)
        m->flip_mean = iso_flip_mean(map, count);
    return status;
}

iso_status iso_metrics_measure(const iso_image *a, const iso_image *b, iso_metrics *m, iso_error *err)
{
    return measure(a, b, true, m, err);
}

iso_status iso_metrics_measure_differences(const iso_image *a, const iso_image *b, iso_metrics *m, iso_error *err)
{
    return measure(a, b, false, m, err);
}

double iso_metrics_rmse_of_colors(const iso_image *a, const iso_image *b, double most)
{
    const size_t pixels = a->width * a->height;
    double sum = 0;
    for (size_t i = 0; i < 4 * pixels; ++i) {
        const double of_a = (double)a->rgba[i], d = (of_a > most ? most : of_a) - (double)b->rgba[i];
        sum += i % 4 == 3 ? 0 : d * d;
    }
    return sqrt(sum / (3 * (double)pixels));
}

bool iso_metrics_within(const iso_metrics *m, const iso_tolerances *tolerances)
{
    const double pairs[][2] = {
        {m->rmse, tolerances->rmse},           {m->max_abs, tolerances->max_abs},
        {m->p99_abs, tolerances->p99_abs},     {1 - m->ssim, tolerances->ssim_dissimilarity},
        {m->flip_mean, tolerances->flip_mean},
    };
    if (m->nonfinite_count > 0 || !isfinite(m->max_abs))
        return false;
    bool asked = false;
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; ++i) {
        if (!(pairs[i][1] > 0))
            continue;
        asked = true;
        if (!(pairs[i][0] <= pairs[i][1]))
            return false;
    }
    return asked || m->max_abs == 0;
}

json_t *iso_metrics_to_json(const iso_metrics *m)
{
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:I, s:[I, I]}", "rmse", iso_json_number(m->rmse), "max_abs",
                     iso_json_number(m->max_abs), "p99_abs", iso_json_number(m->p99_abs), "psnr_db",
                     iso_json_number(m->psnr_db), "ssim", iso_json_number(m->ssim), "flip_mean",
                     iso_json_number(m->flip_mean), "nonfinite_count", (json_int_t)m->nonfinite_count, "worst_pixel",
                     (json_int_t)m->worst[0], (json_int_t)m->worst[1]);
}

iso_status iso_image_difference(const iso_image *a, const iso_image *b, double scale, iso_image *out, iso_error *err)
{
    if (a->width != b->width || a->height != b->height)
        return iso_fail(err, ISO_E_RANGE,
                        "difference: the images have %zux%zu and %zux%zu pixels, must be of one size", a->width,
                        a->height, b->width, b->height);
    NEED(iso_image_create(out, a->width, a->height, err));
    size_t count = a->width * a->height;
    double largest = 0;
    for (size_t i = 0; i < count; ++i)
        for (int c = 0; c < 3; ++c) {
            double d = fabs((double)a->rgba[4 * i + c] - (double)b->rgba[4 * i + c]);
            largest = isfinite(d) ? fmax(largest, d) : largest;
        }
    if (!(scale > 0))
        scale = largest > 0 ? 1 / largest : 1;
    for (size_t i = 0; i < count; ++i) {
        for (int c = 0; c < 3; ++c) {
            double d = fabs((double)a->rgba[4 * i + c] - (double)b->rgba[4 * i + c]);
            out->rgba[4 * i + c] = isfinite(d) ? (float)(scale * d) : 1; /* a broken pixel shines */
        }
        out->rgba[4 * i + 3] = 1;
    }
    return ISO_OK;
}
