/* SPDX-License-Identifier: MIT */
/* format_imagej.c - lookup tables of ImageJ: 256 bytes each of red, green and blue, a header is optional; or text. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tf/format.h"

enum { ENTRIES = 256, HEADER = 32 };

/* Reads one entry per line: "index red green blue" or "red green blue"; the first line may be words. */
static iso_status read_text(const iso_tf_file *file, unsigned char (*rgb)[3], iso_error *err)
{
    const char *line = file->text, *end = file->text + file->size;
    size_t entries = 0;
    for (size_t number = 1; line < end; ++number) {
        const char *next = memchr(line, '\n', (size_t)(end - line));
        const char *stop = next ? next : end;
        double v[4];
        int count = 0;
        for (char *after; count < 4; line = after, ++count) {
            v[count] = strtod(line, &after);
            if (after == line || after > stop)
                break;
        }
        if (count >= 3) {
            const double *color = v + count - 3;
            if (entries == ENTRIES)
                return iso_fail(err, ISO_E_FORMAT, "%s:%zu: has more than %d colors", file->path, number, (int)ENTRIES);
            for (int c = 0; c < 3; ++c) {
                if (!(color[c] >= 0 && color[c] <= 255))
                    return iso_fail(err, ISO_E_RANGE, "%s:%zu: a color is %g, must be 0 to 255", file->path, number,
                                    color[c]);
                rgb[entries][c] = (unsigned char)lrint(color[c]);
            }
            ++entries;
        } else if (number > 1 && strspn(line, " \t\r") < (size_t)(stop - line)) {
            return iso_fail(err, ISO_E_FORMAT, "%s:%zu: is not a color, must be red, green and blue, each 0 to 255",
                            file->path, number);
        }
        line = stop + 1;
    }
    return entries == ENTRIES ? ISO_OK
                              : iso_fail(err, ISO_E_FORMAT, "%s: has %zu colors, a lookup table of ImageJ has %d",
                                         file->path, entries, (int)ENTRIES);
}

static bool is_text(const iso_tf_file *file)
{
    for (size_t i = 0; i < file->size; ++i)
        if ((unsigned char)file->text[i] >= 127 || (file->text[i] < ' ' && !strchr("\t\r\n", file->text[i])))
            return false;
    return file->size > 0;
}

static iso_status read_colors(const iso_tf_file *file, unsigned char (*rgb)[3], iso_error *err)
{
    const bool has_header = file->size == HEADER + 3 * ENTRIES && memcmp(file->text, "ICOL", 4) == 0;
    if (!has_header && file->size != 3 * ENTRIES)
        return is_text(file)
                   ? read_text(file, rgb, err)
                   : iso_fail(err, ISO_E_FORMAT,
                              "%s: has %zu bytes, a lookup table of ImageJ has %d, or %d with a header \"ICOL\"",
                              file->path, file->size, 3 * ENTRIES, HEADER + 3 * ENTRIES);
    const unsigned char *planes = (const unsigned char *)file->text + (has_header ? HEADER : 0);
    for (size_t i = 0; i < ENTRIES; ++i)
        for (size_t c = 0; c < 3; ++c)
            rgb[i][c] = planes[ENTRIES * c + i];
    return ISO_OK;
}

static iso_status load_imagej(const iso_tf_file *file, iso_tf *tf, iso_error *err)
{
    unsigned char rgb[ENTRIES][3] = {{0}};
    OWNED(iso_tf_curves) curves = {.are_fractions = true, .unit_is = "as ImageJ has no opacities"};
    NEED(read_colors(file, rgb, err));
    for (int i = 0; i < ENTRIES; ++i)
        NEED(iso_tf_curve_add_color(&curves.color, i / (ENTRIES - 1.0),
                                    (double[]){rgb[i][0] / 255.0, rgb[i][1] / 255.0, rgb[i][2] / 255.0}, file->path,
                                    err));
    return iso_tf_take_curves(file, &curves, tf, err);
}

const iso_tf_format iso_tf_format_imagej = {
    .name = "imagej",
    .summary = "a lookup table of ImageJ, without opacities; read only",
    .suffix = ".lut",
    .load = load_imagej,
};
