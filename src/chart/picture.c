/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "chart/picture.h"

#include <math.h>
#include <stdlib.h>

#include "compare/srgb.h"
#include "report/page.h"

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
                rgb[3 * (y * width + x) + (size_t)c] = isfinite(mean)
                                                           ? (unsigned char)lrint(255 * iso_srgb_encode(mean))
                                                           : 255;
            }
        }
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
    if (!rgb)
        return NULL;
    shrink(image, width, height, rgb);
    return iso_page_png_uri(rgb, width, height);
}
