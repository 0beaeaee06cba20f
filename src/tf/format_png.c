/* SPDX-License-Identifier: MIT */
/* format_png.c - the table as a picture: 256 columns of display color, with the opacity in alpha. */
#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "tf/format.h"

enum { WIDTH = 256, HEIGHT = 16 };

static unsigned char byte_of(double fraction)
{
    return (unsigned char)lrint(255 * fmin(fmax(fraction, 0), 1));
}

static iso_status save_png(const iso_tf_output *output, const char *path, iso_error *err)
{
    const iso_tf_table *table = output->table;
    const double unit_mm = output->unit_mm;
    unsigned char pixels[HEIGHT][WIDTH][4];
    png_image image = {.version = PNG_IMAGE_VERSION, .width = WIDTH, .height = HEIGHT, .format = PNG_FORMAT_RGBA};
    for (int x = 0; x < WIDTH; ++x) {
        double found[4];
        iso_tf_lookup(table, table->lo + (table->hi - table->lo) * x / (WIDTH - 1), found);
        for (int c = 0; c < 3; ++c)
            pixels[0][x][c] = byte_of(iso_linear_to_srgb(fmax(found[c], 0)));
        pixels[0][x][3] = byte_of(-expm1(-found[3] * unit_mm));
    }
    for (int y = 1; y < HEIGHT; ++y)
        memcpy(pixels[y], pixels[0], sizeof pixels[0]);
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
    FREED void *file = malloc(size);
    NEED_MEMORY(file, err, "%s: no memory for %zu bytes", path, (size_t)size);
    return png_image_write_to_memory(&image, file, &size, 0, pixels, 0, NULL)
               ? iso_file_write(path, file, size, err)
               : iso_fail(err, ISO_E_PROGRAM, "%s: libpng: %s", path, image.message);
}

const iso_tf_format iso_tf_format_png = {
    .name = "png",
    .summary = "a picture: 256 columns of display color and opacity; written only",
    .suffix = ".png",
    .save = save_png,
};
