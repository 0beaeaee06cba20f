/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "chart/picture.h"

#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/base64.h"

static unsigned char srgb(double linear)
{
    const double x = fmin(fmax(linear, 0), 1);
    return (unsigned char)lrint(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055));
}

/* Shrinks an image: a small pixel is the mean of the pixels that it covers. */
static void shrink(const iso_image *image, size_t width, size_t height, unsigned char *rgb)
{
    for (size_t y = 0; y < height; ++y)
        for (size_t x = 0; x < width; ++x) {
            const size_t x0 = x * image->width / width, x1 = (x + 1) * image->width / width,
                         y0 = y * image->height / height, y1 = (y + 1) * image->height / height;
            double sum[3] = {0};
            for (size_t v = y0; v < y1; ++v)
                for (size_t u = x0; u < x1; ++u)
                    for (int c = 0; c < 3; ++c)
                        sum[c] += (double)image->rgba[4 * (v * image->width + u) + (size_t)c];
            for (int c = 0; c < 3; ++c) {
                const double mean = sum[c] / (double)((x1 - x0) * (y1 - y0));
                rgb[3 * (y * width + x) + (size_t)c] = isfinite(mean) ? srgb(mean) : 255;
            }
        }
}

static char *uri_of(const unsigned char *rgb, size_t width, size_t height)
{
    png_image info = {.version = PNG_IMAGE_VERSION, .format = PNG_FORMAT_RGB};
    info.width = (png_uint_32)width;
    info.height = (png_uint_32)height;
    png_alloc_size_t size = 0;
    FREED unsigned char *png = NULL;
    char *text = NULL;
    size_t length = 0;
    FILE *f = NULL;
    if (png_image_write_to_memory(&info, NULL, &size, 0, rgb, 0, NULL))
        png = malloc(size);
    if (png && png_image_write_to_memory(&info, png, &size, 0, rgb, 0, NULL) && (f = open_memstream(&text, &length))) {
        fputs("data:image/png;base64,", f);
        iso_base64_put(f, png, size);
        fclose(f);
    }
    png_image_free(&info);
    return text;
}

char *iso_chart_picture(const iso_image *image)
{
    const size_t longest = image->width > image->height ? image->width : image->height;
    size_t width = image->width, height = image->height;
    if (longest > ISO_CHART_PICTURE_PIXELS) {
        width = width * ISO_CHART_PICTURE_PIXELS / longest;
        height = height * ISO_CHART_PICTURE_PIXELS / longest;
    }
    width = width > 0 ? width : 1;
    height = height > 0 ? height : 1;
    FREED unsigned char *rgb = malloc(3 * width * height);
    if (rgb)
        shrink(image, width, height, rgb);
    char *text = rgb ? uri_of(rgb, width, height) : NULL;
    return text;
}
