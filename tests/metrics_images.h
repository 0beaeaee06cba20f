/* SPDX-License-Identifier: MIT */
/* metrics_images.h - images for tests of metrics. */
#pragma once

#include <string.h>

#include "compare/metrics.h"
#include "test.h"

static inline iso_image uniform(size_t width, size_t height, float r, float g, float b)
{
    iso_image image;
    assert_ok(iso_image_create(&image, width, height, &err));
    for (size_t i = 0; i < width * height; ++i)
        memcpy(image.rgba + 4 * i, (float[4]){r, g, b, 1}, 16);
    return image;
}

/* Repeatable noise in [0, 1), by this generator because the published program of FLIP was given these images. */
static inline double noise(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (*state >> 8) / 16777216.0;
}

static inline iso_image textured(size_t width, size_t height, uint32_t seed)
{
    iso_image image = uniform(width, height, 0, 0, 0);
    for (size_t y = 0; y < height; ++y)
        for (size_t x = 0; x < width; ++x) {
            float *p = image.rgba + 4 * (y * width + x);
            p[0] = (float)(0.5 + 0.3 * sin(0.31 * (double)x) * cos(0.2 * (double)y) + 0.1 * noise(&seed));
            p[1] = (float)(0.4 + 0.3 * cos(0.17 * (double)(x + 2 * y)) + 0.1 * noise(&seed));
            p[2] = (float)((double)(x + y) / (double)(width + height) + 0.05 * noise(&seed));
        }
    return image;
}

static inline iso_image copy(const iso_image *image)
{
    iso_image out;
    assert_ok(iso_image_create(&out, image->width, image->height, &err));
    memcpy(out.rgba, image->rgba, 16 * image->width * image->height);
    return out;
}

static inline iso_metrics measure(const iso_image *a, const iso_image *b)
{
    iso_metrics m;
    assert_ok(iso_metrics_measure(a, b, &m, &err));
    return m;
}
