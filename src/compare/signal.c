/* SPDX-License-Identifier: MIT */
#include "compare/signal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/order.h"
#include "compare/statistics.h"

/* Sorts values and returns the one that 99 % of the pixels stay below. */
static double p99_of(double *values, size_t count)
{
    qsort(values, count, sizeof *values, iso_order_doubles);
    return values[(size_t)ceil(0.99 * (double)count) - 1];
}

/* Measures the color's largest difference from the background, and alpha; NaN stays NaN. */
static void measure_pixel(const float *rgba, const double background[3], double *color, double *alpha)
{
    *color = 0;
    for (int c = 0; c < 3; ++c)
        *color = iso_larger(*color, fabs((double)rgba[c] - background[c]));
    *alpha = fabs((double)rgba[3]);
}

static iso_status measure_p99(const iso_image *image, const double background[3], iso_signal *s, iso_error *err)
{
    const size_t count = image->width * image->height;
    FREED double *values = malloc(2 * count * sizeof *values);
    NEED_MEMORY(values, err, "signal: no memory for %zu pixels", count);
    bool finite = true;
    for (size_t i = 0; i < count; ++i) {
        measure_pixel(image->rgba + 4 * i, background, &values[i], &values[count + i]);
        finite = finite && isfinite(values[i]) && isfinite(values[count + i]);
    }
    s->color = finite ? p99_of(values, count) : NAN;
    s->alpha = finite ? p99_of(values + count, count) : NAN;
    return ISO_OK;
}

static void measure_rms(const iso_image *image, const double background[3], iso_signal *s)
{
    const size_t count = image->width * image->height;
    double color = 0, alpha = 0;
    for (size_t i = 0; i < count; ++i) {
        const float *rgba = image->rgba + 4 * i;
        for (int c = 0; c < 3; ++c) {
            const double d = (double)rgba[c] - background[c];
            color += d * d;
        }
        alpha += (double)rgba[3] * (double)rgba[3];
    }
    s->color = sqrt(color / (3 * (double)count));
    s->alpha = sqrt(alpha / (double)count);
}

iso_status iso_signal_of(const iso_image *image, const double background[3], double limit, iso_signal_measure measure,
                         iso_signal *s, iso_error *err)
{
    *s = (iso_signal){.least = ISO_SIGNAL_FACTOR * limit, .measure = measure};
    if (measure == ISO_SIGNAL_P99)
        return measure_p99(image, background, s, err);
    measure_rms(image, background, s);
    return ISO_OK;
}

bool iso_signal_suffices(const iso_signal *s)
{
    return s->color >= s->least && s->alpha >= s->least;
}

void iso_signal_explain(const iso_signal *s, char *text, size_t size)
{
    const bool color = !(s->color >= s->least);
    const double shown = color ? s->color : s->alpha;
    const char *what = s->measure == ISO_SIGNAL_P99 ? "in the brightest 1 % of its pixels" : "(RMS)";
    snprintf(
        text, size,
        "the reference shows only %.3g above its background %s in %s, where this limit asks for at least %.3g: a renderer "
        "that draws something else, or nothing, could be within the limit",
        shown, what, color ? "color" : "alpha", s->least);
}

bool iso_image_is_empty(const iso_image *image, const double background[3])
{
    for (size_t i = 0; i < image->width * image->height; ++i) {
        const float *rgba = image->rgba + 4 * i;
        if (rgba[0] != (float)background[0] || rgba[1] != (float)background[1] || rgba[2] != (float)background[2] ||
            rgba[3] != 0)
            return false;
    }
    return true;
}
