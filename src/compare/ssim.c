/* SPDX-License-Identifier: MIT */
#include "compare/ssim.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "compare/srgb.h"

#define TAPS 11

static double *luma(const iso_image *image)
{
    size_t count = image->width * image->height;
    double *out = calloc(count, sizeof *out);
    for (size_t i = 0; out && i < count; ++i) {
        const float *p = image->rgba + 4 * i;
        out[i] = 0.299 * iso_srgb_encode(p[0]) + 0.587 * iso_srgb_encode(p[1]) + 0.114 * iso_srgb_encode(p[2]);
    }
    return out;
}

/* Returns the SSIM of one window centered at (x, y), cut by the image, from weighted sums of 1, x, y, xx, yy, xy. */
static double window(const double *restrict a, const double *restrict b, size_t width, size_t height, size_t x,
                     size_t y, const double taps[TAPS])
{
    const size_t r = TAPS / 2;
    double w = 0, ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
    for (size_t j = y < r ? r - y : 0; j < TAPS && y + j - r < height; ++j)
        for (size_t i = x < r ? r - x : 0; i < TAPS && x + i - r < width; ++i) {
            size_t at = (y + j - r) * width + x + i - r;
            double t = taps[i] * taps[j];
            w += t;
            ma += t * a[at];
            mb += t * b[at];
            aa += t * a[at] * a[at];
            bb += t * b[at] * b[at];
            ab += t * a[at] * b[at];
        }
    ma /= w, mb /= w;
    double va = aa / w - ma * ma, vb = bb / w - mb * mb, cov = ab / w - ma * mb;
    const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    return (2 * ma * mb + c1) * (2 * cov + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
}

static bool is_foreground(const iso_image *a, const iso_image *b, size_t pixel)
{
    return a->rgba[4 * pixel + 3] >= ISO_SSIM_FOREGROUND || b->rgba[4 * pixel + 3] >= ISO_SSIM_FOREGROUND;
}

static iso_status mean_of_windows(const iso_image *a, const iso_image *b, bool foreground, double *mean, iso_error *err)
{
    size_t width = a->width, height = a->height;
    if (width == 0 || height == 0 || width != b->width || height != b->height)
        return iso_fail(err, ISO_E_RANGE, "SSIM: images of %zux%zu and %zux%zu pixels", width, height, b->width,
                        b->height);
    double taps[TAPS];
    for (int i = 0; i < TAPS; ++i)
        taps[i] = exp(-(i - TAPS / 2) * (i - TAPS / 2) / (2 * 1.5 * 1.5));
    double *la = luma(a), *lb = luma(b), *rows = calloc(2 * height, sizeof *rows);
    iso_status status = ISO_OK;
    if (la && lb && rows) {
        const int threads = width * height < 40000 ? 1 : iso_threads(0);
        bool inside = width >= TAPS && height >= TAPS;
        size_t margin = inside ? TAPS / 2 : 0;
#pragma omp parallel for schedule(dynamic, 8) num_threads(threads)
        for (size_t y = margin; y < height - margin; ++y)
            for (size_t x = margin; x < width - margin; ++x)
                if (!foreground || is_foreground(a, b, y * width + x)) {
                    rows[2 * y] += window(la, lb, width, height, x, y, taps);
                    rows[2 * y + 1] += 1;
                }
        double sum = 0, count = 0; /* in the order of the rows, so that threads do not show */
        for (size_t y = 0; y < height; ++y) {
            sum += rows[2 * y];
            count += rows[2 * y + 1];
        }
        *mean = count > 0 ? sum / count : 1;
    } else {
        status = iso_fail(err, ISO_E_MEMORY, "SSIM: no memory for %zux%zu pixels", width, height);
    }
    free(la);
    free(lb);
    free(rows);
    return status;
}

iso_status iso_ssim_mean(const iso_image *a, const iso_image *b, double *mean, iso_error *err)
{
    return mean_of_windows(a, b, false, mean, err);
}

iso_status iso_ssim_foreground(const iso_image *a, const iso_image *b, double *mean, iso_error *err)
{
    return mean_of_windows(a, b, true, mean, err);
}
