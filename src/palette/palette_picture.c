/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "palette/palette_picture.h"

#include <math.h>
#include <stdlib.h>

#include "base/file.h"
#include "base/linalg.h"
#include "image/image.h"

#define SIDE 512 /* pixels of one hemisphere */
#define MARGIN 16

typedef struct view {
    iso_vec3 right, up, toward;
} view;

/* Returns a view from the front right and above, as in the scenes. */
static view front_view(void)
{
    view v;
    v.toward = iso_normalize(iso_v3(0.6, -1.0, 0.45));
    v.right = iso_normalize(iso_cross(iso_v3(0, 0, 1), v.toward));
    v.up = iso_cross(v.toward, v.right);
    return v;
}

static view back_view(void)
{
    view v = front_view();
    v.toward = iso_scale(v.toward, -1);
    v.right = iso_scale(v.right, -1);
    return v;
}

static double srgb_to_linear(double v)
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static void set_pixel(iso_image *image, size_t column, size_t row, const double srgb[3])
{
    float *p = image->rgba + 4 * (row * image->width + column);
    for (int c = 0; c < 3; ++c)
        p[c] = (float)srgb_to_linear(srgb[c]);
    p[3] = 1;
}

/* Finds the nearest entry for each pixel of a hemisphere; 0 outside. */
static void index_hemisphere(const iso_palette_lookup *lookup, const view *v, uint16_t *index)
{
    const double radius = SIDE / 2.0 - MARGIN;
    for (size_t row = 0; row < SIDE; ++row)
        for (size_t column = 0; column < SIDE; ++column) {
            double x = ((double)column + 0.5 - SIDE / 2.0) / radius, y = (SIDE / 2.0 - (double)row - 0.5) / radius;
            uint16_t *at = &index[row * SIDE + column];
            *at = 0;
            if (x * x + y * y >= 1)
                continue;
            iso_vec3 n = iso_madd(iso_madd(iso_scale(v->toward, sqrt(1 - x * x - y * y)), v->right, x), v->up, y);
            float d[3] = {(float)n.x, (float)n.y, (float)n.z};
            iso_palette_assign(lookup, d, at, 1);
        }
}

static void draw_regions(iso_image *image, const iso_palette *palette, const uint16_t *index, size_t left)
{
    for (size_t row = 0; row + 1 < SIDE; ++row)
        for (size_t column = 0; column + 1 < SIDE; ++column) {
            size_t at = row * SIDE + column;
            const float *n = palette->xyz + 3 * (size_t)index[at];
            bool edge = index[at] != index[at + 1] || index[at] != index[at + SIDE];
            if (!index[at] && !edge)
                continue;
            double color[3];
            for (int c = 0; c < 3; ++c)
                color[c] = edge ? 0.1 : 0.25 + 0.35 * ((double)n[c] + 1);
            set_pixel(image, left + column, row, color);
        }
}

static void draw_dots(iso_image *image, const iso_direction_set *set, const view *v, size_t left)
{
    static const double black[3] = {0, 0, 0};
    const double radius = SIDE / 2.0 - MARGIN;
    for (size_t i = 0; i < set->count; ++i) {
        iso_vec3 d = iso_v3((double)set->xyz[3 * i], (double)set->xyz[3 * i + 1], (double)set->xyz[3 * i + 2]);
        if (iso_dot(d, v->toward) > 0)
            set_pixel(image, left + (size_t)(SIDE / 2.0 + radius * iso_dot(d, v->right)),
                      (size_t)(SIDE / 2.0 - radius * iso_dot(d, v->up)), black);
    }
}

/* Largest number of dots for the data; more would hide the regions. */
#define MOST_DOTS 20000

iso_status iso_palette_picture_png(const iso_palette *palette, const iso_direction_set *set, const char *path,
                                   iso_error *err)
{
    static const double white[3] = {1, 1, 1};
    const view views[2] = {front_view(), back_view()};
    iso_palette_lookup *lookup = NULL;
    OWNED(iso_image) image = {0};
    FREED uint16_t *index = malloc((size_t)SIDE * SIDE * sizeof *index);
    iso_status status = index ? iso_palette_lookup_create(palette, &lookup, err)
                              : iso_fail(err, ISO_E_MEMORY, "%s: no memory for its pixels", path);
    TRY(status, iso_image_create(&image, 2 * SIDE, SIDE, err));
    if (status == ISO_OK) {
        for (size_t i = 0; i < image.width * image.height; ++i)
            set_pixel(&image, i % image.width, i / image.width, white);
        for (size_t side = 0; side < 2; ++side) {
            index_hemisphere(lookup, &views[side], index);
            draw_regions(&image, palette, index, side * SIDE);
            if (set && set->count <= MOST_DOTS)
                draw_dots(&image, set, &views[side], side * SIDE);
        }
        status = iso_image_save_png(&image, path, 1, err);
    }
    iso_palette_lookup_destroy(lookup);
    return status;
}

iso_status iso_palette_picture_exr(const iso_palette *palette, const char *path, const char *note, iso_error *err)
{
    const iso_image_note notes[] = {{"isoshadeCommand", note}, {NULL, NULL}};
    OWNED(iso_image) image = {0};
    NEED(iso_image_create(&image, palette->count, 1, err));
    for (size_t i = 0; i < palette->count; ++i) {
        for (size_t c = 0; c < 3; ++c)
            image.rgba[4 * i + c] = palette->xyz[3 * i + c];
        image.rgba[4 * i + 3] = 1;
    }
    return iso_image_save_exr(&image, path, notes, err);
}
