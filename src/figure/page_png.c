/* SPDX-License-Identifier: MIT */
#include "figure/page_png.h"

#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"

typedef struct canvas {
    size_t wide, high;
    unsigned char *rgb;
} canvas;

/* Computes the mean of the pixels that a dot covers; if a pixel covers whole dots, that pixel. */
static void sample(const iso_page_pixels *p, size_t x, size_t y, unsigned char rgb[3])
{
    const size_t left = x * p->width / p->wide, top = y * p->height / p->high;
    const size_t right = ((x + 1) * p->width + p->wide - 1) / p->wide,
                 bottom = ((y + 1) * p->height + p->high - 1) / p->high;
    for (size_t c = 0; c < 3; ++c) {
        size_t sum = 0;
        for (size_t v = top; v < bottom; ++v)
            for (size_t u = left; u < right; ++u)
                sum += p->rgb[3 * (v * p->width + u) + c];
        const size_t count = (right - left) * (bottom - top);
        rgb[c] = (unsigned char)((sum + count / 2) / count);
    }
}

static void put_pictures(canvas *c, const iso_page_pixels *pictures, size_t count)
{
    memset(c->rgb, 255, 3 * c->wide * c->high);
    for (size_t i = 0; i < count; ++i) {
        const iso_page_pixels *p = &pictures[i];
        for (size_t y = 0; y < p->high && p->y + y < c->high; ++y)
            for (size_t x = 0; x < p->wide && p->x + x < c->wide; ++x)
                sample(p, x, y, c->rgb + 3 * ((p->y + y) * c->wide + p->x + x));
    }
}

/* Blends a row of the drawing over the canvas; bytes under transparent dots stay unchanged. */
static void put_over(canvas *c, const unsigned char *rgba)
{
    for (size_t i = 0; i < c->wide * c->high; ++i) {
        const int alpha = rgba[4 * i + 3];
        for (size_t k = 0; k < 3; ++k)
            c->rgb[3 * i + k] = (unsigned char)((rgba[4 * i + k] * alpha + c->rgb[3 * i + k] * (255 - alpha) + 127) /
                                                255);
    }
}

/* Reads the file without libpng, which does not distinguish an unreadable file from one that is not a PNG. */
static iso_status read_overlay(const char *path, const canvas *c, unsigned char **rgba, iso_error *err)
{
    png_image png = {.version = PNG_IMAGE_VERSION};
    FREED char *bytes = NULL;
    size_t size;
    *rgba = NULL;
    iso_status status = iso_file_read(path, &bytes, &size, err);
    if (status == ISO_OK && !png_image_begin_read_from_memory(&png, bytes, size))
        status = iso_fail(err, ISO_E_FORMAT, "%s: %s", path, png.message);
    if (status != ISO_OK)
        return status;
    png.format = PNG_FORMAT_RGBA;
    if (png.width != c->wide || png.height != c->high)
        status = iso_fail(err, ISO_E_FORMAT, "%s: gnuplot drew %u x %u dots of %zu x %zu", path, png.width, png.height,
                          c->wide, c->high);
    else if (!(*rgba = malloc(PNG_IMAGE_SIZE(png))))
        status = iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
    else if (!png_image_finish_read(&png, NULL, *rgba, 0, NULL))
        status = iso_fail(err, ISO_E_FORMAT, "%s: %s", path, png.message);
    png_image_free(&png);
    return status;
}

/* Replaces libpng's own messages. */
static void stop(png_structp png, png_const_charp text)
{
    (void)text;
    png_longjmp(png, 1);
}

static void pass_over(png_structp png, png_const_charp text)
{
    (void)png, (void)text;
}

/* Writes the rows. libpng's calls jump on errors, so no variable changes after setjmp(). */
static int write_rows(FILE *f, png_structp png, png_infop info, const canvas *c, double dpi)
{
    if (setjmp(png_jmpbuf(png)))
        return 0;
    const png_uint_32 per_meter = (png_uint_32)lrint(dpi / 0.0254);
    png_init_io(png, f);
    png_set_IHDR(png, info, (png_uint_32)c->wide, (png_uint_32)c->high, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_set_pHYs(png, info, per_meter, per_meter, PNG_RESOLUTION_METER);
    png_write_info(png, info);
    for (size_t y = 0; y < c->high; ++y)
        png_write_row(png, c->rgb + 3 * y * c->wide);
    png_write_end(png, info);
    return 1;
}

static iso_status write_png(const char *path, const canvas *c, double dpi, iso_error *err)
{
    FILE *f = fopen(path, "wb");
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, stop, pass_over);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    int whole = f && info && write_rows(f, png, info, c, dpi);
    png_destroy_write_struct(&png, &info);
    if (f && fclose(f) != 0)
        whole = 0;
    return whole ? ISO_OK : iso_fail(err, ISO_E_IO, "%s: cannot be written", path);
}

iso_status iso_page_png_compose(const char *path, const iso_page_pixels *pictures, size_t count, size_t wide,
                                size_t high, double dpi, iso_error *err)
{
    FREED unsigned char *rgb = malloc(3 * wide * high), *overlay = NULL;
    canvas c = {wide, high, rgb};
    NEED(rgb ? read_overlay(path, &c, &overlay, err) : iso_fail(err, ISO_E_MEMORY, "figure: out of memory"));
    put_pictures(&c, pictures, count);
    put_over(&c, overlay);
    return write_png(path, &c, dpi, err);
}
