/* SPDX-License-Identifier: MIT */
#include "lab/level_error.h"

#include <math.h>
#include <stdlib.h>

#include "compare/flip.h"
#include "compare/ssim.h"

static bool is_shown(const iso_image *a, const iso_image *b, size_t pixel)
{
    return a->rgba[4 * pixel + 3] >= ISO_SSIM_FOREGROUND || b->rgba[4 * pixel + 3] >= ISO_SSIM_FOREGROUND;
}

static void measure_shown(const iso_image *a, const iso_image *b, const float *flip, iso_level_error *e)
{
    double squares = 0, sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < a->width * a->height; ++i) {
        if (!is_shown(a, b, i))
            continue;
        for (size_t c = 0; c < 3; ++c) {
            const double d = (double)a->rgba[4 * i + c] - (double)b->rgba[4 * i + c];
            squares += d * d;
        }
        sum += (double)flip[i];
        ++count;
    }
    e->rmse = count > 0 ? sqrt(squares / (3 * (double)count)) : 0;
    e->flip = count > 0 ? sum / (double)count : 0;
}

iso_status iso_level_error_measure(const iso_image *finest, const iso_image *shown, iso_level_error *e, iso_error *err)
{
    double ssim = 1;
    *e = (iso_level_error){0};
    NEED(iso_ssim_foreground(finest, shown, &ssim, err));
    e->dssim = (1 - ssim) / 2;
    FREED float *flip = malloc(finest->width * finest->height * sizeof *flip);
    NEED_MEMORY(flip, err, "no memory for FLIP of %zux%zu pixels", finest->width, finest->height);
    NEED(iso_flip_ldr(finest, shown, ISO_FLIP_PIXELS_PER_DEGREE, flip, err));
    measure_shown(finest, shown, flip, e);
    return ISO_OK;
}

static void mean_of_box(const iso_image *image, size_t n, size_t column, size_t row, float mean[4])
{
    double sum[4] = {0}, count = 0;
    for (size_t y = row * n; y < (row + 1) * n && y < image->height; ++y)
        for (size_t x = column * n; x < (column + 1) * n && x < image->width; ++x) {
            const float *pixel = image->rgba + 4 * (y * image->width + x);
            for (int c = 0; c < 4; ++c)
                sum[c] += (double)pixel[c];
            count += 1;
        }
    for (int c = 0; c < 4; ++c)
        mean[c] = (float)(sum[c] / count);
}

iso_status iso_image_minify(const iso_image *image, size_t n, iso_image *out, iso_error *err)
{
    if (n < 1)
        return iso_fail(err, ISO_E_RANGE, "boxes of %zu pixels", n);
    iso_status status = iso_image_create(out, (image->width + n - 1) / n, (image->height + n - 1) / n, err);
    for (size_t i = 0; status == ISO_OK && i < out->width * out->height; ++i)
        mean_of_box(image, n, i % out->width, i / out->width, out->rgba + 4 * i);
    return status;
}
