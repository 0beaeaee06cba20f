/* SPDX-License-Identifier: MIT */
/* labels.c - label maps. Cycles interpolates all grids of a volume, but not images. So the labels become an image of
 * class numbers, with the slices of a level in tiles side by side, and the next level's below. The transfer function
 * becomes a table with one entry per class. */
#define _GNU_SOURCE
#include <math.h>
#include <png.h>
#include <stdint.h>
#include <stdlib.h>

#include "base/file.h"
#include "blender/blender_scene.h"
#include "volume/segments.h"

enum { LEAST_LABEL = -32768, MOST_LABEL = 65535, SPAN = MOST_LABEL - LEAST_LABEL + 1, MOST_CLASSES = 65536 };

/* The labels that occur, ascending, with their class numbers. */
typedef struct label_classes {
    size_t count;
    int *values;     /* count */
    uint16_t *class; /* of a label minus LEAST_LABEL */
} label_classes;

static void free_classes(label_classes *c)
{
    free(c->values);
    free(c->class);
}

static iso_status find_classes(const iso_pyramid *p, size_t first, size_t count, label_classes *c, iso_error *err)
{
    *c = (label_classes){.values = malloc(MOST_CLASSES * sizeof *c->values), .class = calloc(SPAN, sizeof *c->class)};
    NEED_MEMORY(c->values && c->class, err, "blender: no memory for labels");
    for (size_t k = first; k < first + count; ++k) {
        const iso_level *l = &p->levels[k];
        for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i) {
            const double label = (double)l->scalar[i];
            if (!(label >= LEAST_LABEL && label <= MOST_LABEL) || label != rint(label))
                return iso_fail(err, ISO_E_RANGE, "blender: label %g is not an integer from %d to %d", label,
                                LEAST_LABEL, MOST_LABEL);
            c->class[(int)label - LEAST_LABEL] = 1;
        }
    }
    for (int i = 0; i < SPAN; ++i)
        if (c->class[i] && c->count < MOST_CLASSES) {
            c->class[i] = (uint16_t)c->count;
            c->values[c->count++] = i + LEAST_LABEL;
        }
    return ISO_OK;
}

/* Position of a level's slices: `across` of them side by side; earlier rows of pixels belong to other levels. */
typedef struct label_tiles {
    size_t across, first_row, rows;
} label_tiles;

/* Arranges the slices as square as possible. */
static label_tiles lay_tiles(const size_t size[3], size_t first_row)
{
    const double wanted = rint(sqrt((double)size[1] * (double)size[2] / (double)size[0]));
    const size_t across = (size_t)fmin(fmax(wanted, 1), (double)size[2]);
    return (label_tiles){across, first_row, (size[2] + across - 1) / across * size[1]};
}

/* Draws class numbers: red + 256 green. */
static void draw_level(const iso_level *l, const label_tiles *t, const label_classes *c, size_t width, uint8_t *pixels)
{
    const size_t *n = l->geometry.size;
    const float *label = l->scalar;
    for (size_t z = 0; z < n[2]; ++z)
        for (size_t y = 0; y < n[1]; ++y) {
            const size_t row = t->first_row + z / t->across * n[1] + y, column = z % t->across * n[0];
            uint8_t *out = pixels + 3 * (row * width + column);
            for (size_t x = 0; x < n[0]; ++x, out += 3) {
                const unsigned class = c->class[(int)*label++ - LEAST_LABEL];
                out[0] = (uint8_t)(class & 255);
                out[1] = (uint8_t)(class >> 8);
            }
        }
}

static iso_status save_png(const char *path, size_t width, size_t height, const uint8_t *pixels, iso_error *err)
{
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = (png_uint_32)width,
                       .height = (png_uint_32)height,
                       .format = PNG_FORMAT_RGB};
    return png_image_write_to_file(&image, path, 0, pixels, 0, NULL)
               ? ISO_OK
               : iso_fail(err, ISO_E_IO, "%s: cannot be written: %s", path, image.message);
}

static iso_status draw_levels(const iso_pyramid *p, size_t first, size_t count, const label_classes *c,
                              label_tiles *tiles, const char *path, iso_error *err)
{
    enum { MOST_PIXELS = 65535 }; /* along a side of Blender's images */
    size_t width = 0, height = 0;
    for (size_t i = 0; i < count; ++i) {
        const size_t *size = p->levels[first + i].geometry.size;
        tiles[i] = lay_tiles(size, height);
        height += tiles[i].rows;
        width = tiles[i].across * size[0] > width ? tiles[i].across * size[0] : width;
    }
    if (width > MOST_PIXELS || height > MOST_PIXELS)
        return iso_fail(err, ISO_E_RANGE, "blender: the labels need an image of %zu x %zu pixels, limit %d per side",
                        width, height, MOST_PIXELS);
    FREED uint8_t *pixels = calloc(width * height, 3);
    NEED_MEMORY(pixels, err, "blender: no memory for an image of %zu x %zu labels", width, height);
    for (size_t i = 0; i < count; ++i)
        draw_level(&p->levels[first + i], &tiles[i], c, width, pixels);
    return save_png(path, width, height, pixels, err);
}

/* Makes the table of all labels' colors. A single label is repeated, since a table needs two entries. */
static iso_status make_table(const iso_tf_table *tf, const label_classes *c, iso_tf_table *table, iso_error *err)
{
    const size_t count = c->count > 1 ? c->count : 2;
    *table = (iso_tf_table){.count = count,
                            .hi = (double)(count - 1),
                            .entries = malloc(4 * count * sizeof(float)),
                            .unit_mm = tf->unit_mm};
    NEED_MEMORY(table->entries, err, "blender: no memory for %zu classes", count);
    for (size_t i = 0; i < count; ++i) {
        double rgbs[4];
        iso_tf_lookup(tf, c->values[i < c->count ? i : c->count - 1], rgbs);
        for (int a = 0; a < 4; ++a)
            table->entries[4 * i + (size_t)a] = (float)rgbs[a];
    }
    return ISO_OK;
}

/* Replaces the ramp by a stop per class, halfway from the previous class: with constant colors between stops it is
 * exact. */
static void describe_class_ramp(json_t *ramp, const iso_tf_table *table, const label_classes *c)
{
    const double last = table->hi, unit_mm = json_number_value(json_object_get(ramp, "unit_distance_mm"));
    json_t *stops = json_array();
    for (size_t i = 0; i < c->count; ++i) {
        const float *e = &table->entries[4 * i];
        json_array_append_new(stops,
                              iso_json_numbers((double[]){i > 0 ? ((double)i - 0.5) / last : 0, (double)e[0],
                                                          (double)e[1], (double)e[2], -expm1(-(double)e[3] * unit_mm)},
                                               5));
    }
    json_object_update_new(ramp,
                           json_pack("{so sf sf sf sf sb sb}", "stops", stops, "lo", 0.0, "hi", last, "color_loss", 0.0,
                                     "opacity_loss", 0.0, "constant", true, "own_points", false));
}

static iso_status describe_tables(json_t *about, const iso_blender_levels *levels, const label_classes *c, double units,
                                  iso_error *err)
{
    const iso_view *views = levels->views;
    const size_t first = levels->first, count = levels->count;
    iso_view *by_class = calloc(count, sizeof *by_class);
    iso_status status = by_class ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "blender: out of memory");
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        status = make_table(&views[i].tf, c, &by_class[i].tf, err);
    if (status == ISO_OK) {
        json_t *tf = iso_blender_describe_tf(by_class, first, count, units), *ramps = json_object_get(tf, "ramps"), *t;
        size_t i;
        json_array_foreach (json_object_get(tf, "tables"), i, t)
            if (c->count <= ISO_RAMP_MAX_STOPS)
                describe_class_ramp(json_array_get(ramps, (size_t)json_integer_value(json_object_get(t, "ramp"))),
                                    &by_class[i].tf, c);
        json_object_set_new(about, "tf", tf);
    }
    for (size_t i = 0; by_class && i < count; ++i)
        iso_tf_table_destroy(&by_class[i].tf);
    free(by_class);
    return status;
}

static void describe_tiles(json_t *level, const iso_geometry *g, const label_tiles *t)
{
    const double size[3] = {(double)g->size[0], (double)g->size[1], (double)g->size[2]};
    json_object_set_new(level, "labels",
                        json_pack("{so so s[fff]}", "cells", iso_json_numbers(g->box_index, 3), "size",
                                  iso_json_numbers(size, 3), "tiles", (double)t->across, (double)t->first_row, 0.0));
}

iso_status iso_blender_describe_labels(json_t *about, const iso_pyramid *p, const iso_blender_levels *levels,
                                       double units, const char *folder, iso_error *err)
{
    const size_t first = levels->first, count = levels->count;
    for (size_t i = 0; i < count; ++i)
        if (levels->views[i].roi || levels->views[i].tf_2d)
            return iso_fail(err, ISO_E_USAGE, "blender: a label map has no region of interest or 2D transfer function");
    label_classes classes;
    FREED label_tiles *tiles = calloc(count, sizeof *tiles);
    FREED char *path = iso_path_join(folder, "labels.png");
    iso_status status = find_classes(p, first, count, &classes, err);
    if (status == ISO_OK && !(tiles && path))
        status = iso_fail(err, ISO_E_MEMORY, "blender: out of memory");
    TRY(status, draw_levels(p, first, count, &classes, tiles, path, err));
    TRY(status, describe_tables(about, levels, &classes, units, err));
    if (status == ISO_OK) {
        json_t *list = json_array();
        for (size_t i = 0; i < classes.count; ++i)
            json_array_append_new(list, json_pack("[is]", classes.values[i],
                                                  iso_segments_name(p->segments, classes.values[i])));
        json_object_set_new(about, "labels", json_pack("{ss so}", "image", path, "classes", list));
        for (size_t i = 0; i < count; ++i)
            describe_tiles(json_array_get(json_object_get(about, "levels"), i), &p->levels[first + i].geometry,
                           &tiles[i]);
    }
    free_classes(&classes);
    return status;
}
