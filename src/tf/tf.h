/* SPDX-License-Identifier: MIT */
/* tf.h - transfer functions: value to linear color and extinction.
 *
 * A TF file (*.tf.json) holds points. Opacity a is given for a length, the opacity
 * unit distance u, and becomes extinction = -ln(1 - a) / u in 1/mm (the rule of
 * ANARI's volume appendix), so that it depends on no step, level or spacing.
 * Renderers get a table of entries over [lo, hi], linear between entries, each
 * component interpolated by itself; values beyond the range take the end entries.
 *
 *   { "schema": "isoshade.tf/1",
 *     "range": [0, 255] | "fit",         fit: points' values are fractions of the volume's range
 *     "unit_distance_mm": 2              or "unit_distance_voxels": 2 (level-0 mean spacing)
 *     "color_space": "linear" | "srgb",  points are made linear first, then interpolated
 *     "table_size": 256,                 2 to 16384
 *     "points": [ {"value": 0, "r": 0, "g": 0, "b": 0, "opacity": 0}, ... ] }
 *
 * Between points color and opacity are linear in value; entry i of M stands at
 * lo + i (hi - lo) / (M - 1). Two points of equal value make a step. */
#pragma once

#include <stdbool.h>

#include "base/json.h"
#include "volume/geometry.h"

enum { ISO_TF_MOST_ENTRIES = 16384 }; /* of a table: limit of a texture row */

/* Largest magnitude of the values of a transfer function's points and range, the same as for volumes. */
#define ISO_TF_MOST_VALUE ISO_MOST_VALUE
/* Opacity is capped here before the logarithm, so that extinction stays finite. */
#define ISO_TF_MAX_OPACITY 0.9999

/* Limits of the length that opacities are for, in mm or in voxels. */
#define ISO_TF_LEAST_UNIT ISO_LEAST_MM
#define ISO_TF_MOST_UNIT (1e3 * ISO_MOST_MM) /* some of the largest voxels */

/* Largest extinction, per mm: ISO_TF_MAX_OPACITY over ISO_TF_LEAST_UNIT, rounded up. */
#define ISO_TF_MOST_EXTINCTION 9.2104e30

/* Difference between the table made from another program's TF and that program's display, in display color and opacity,
 * each 0 to 1: at the table's entries, and between them, where a curve may be too steep for the table. */
typedef struct iso_tf_loss {
    bool measured; /* False: not converted, or not requested */
    double color, opacity;
    double between;
} iso_tf_loss;

typedef struct iso_tf {
    size_t point_count;
    iso_tf_point *points; /* ascending in value */
    bool fit_range;
    double range[2];      /* when not fit_range */
    double unit_distance; /* in mm, or in voxels */
    bool unit_is_voxels;
    size_t table_size;
    iso_tf_loss loss;
    char of[160]; /* its file or preset, for messages; "": inside another file */
} iso_tf;

/* Settings for fields that a file of another program may lack. */
typedef struct iso_tf_request {
    const char *name; /* one of several; NULL: the only one */
    char **names;     /* not NULL: set to the names, one per line, to be freed; nothing is loaded */
    double unit_mm;   /* length that opacities are for; 0: from the file */
    bool has_opacity; /* opacity from the range's start to its end, for a file without */
    double opacity[2];
    bool has_range, fit; /* range instead of the file's; fit: the volume's */
    double range[2];
    bool measure; /* True to set the TF's loss for files of other programs */
} iso_tf_request;

/* Loads a file of any input format (format.h). */
iso_status iso_tf_load(const char *path, iso_tf *tf, iso_error *err);
/* Does the same with a request. ISO_E_USAGE: a needed field is missing, or one is given that the file has. */
iso_status iso_tf_load_as(const char *path, const iso_tf_request *request, iso_tf *tf, iso_error *err);
/* Reads a TF from an object inside another file; `path` is named in messages. */
iso_status iso_tf_from_json(const json_t *object, const char *path, iso_tf *tf, iso_error *err);
/* Returns a new object in the file's form, with linear points. */
json_t *iso_tf_to_json(const iso_tf *tf);
/* Writes a file's object, but only if the reader accepts it. */
iso_status iso_tf_save_json(const json_t *root, const char *path, iso_error *err);
iso_status iso_tf_copy(const iso_tf *from, iso_tf *to, iso_error *err);
void iso_tf_destroy(iso_tf *tf);

/* The form that renderers and exporters use. */
enum { ISO_TF_FEW_POINTS = 32 };
typedef struct iso_tf_table {
    size_t count; /* entries */
    double lo, hi;
    float *entries; /* 4 per entry: linear r, g, b, extinction per mm */
    /* Points that the entries were made from, for interactive editing; renderers use the entries alone. */
    double unit_mm;     /* length that opacities are for; 0: unknown */
    size_t point_count; /* 0: more points than fit, or none; their values are the volume's */
    iso_tf_point points[ISO_TF_FEW_POINTS];
} iso_tf_table;

/* Creates a table; resolves range and unit distance by the value range and the geometry of level 0. ISO_E_RANGE: an
 * empty range, or a peak so narrow that no entry shows it. If level0 has voxels without data, the table shows nothing
 * there (iso_tf_table_end_below). */
iso_status iso_tf_tabulate(const iso_tf *tf, double value_min, double value_max, const iso_geometry *level0,
                           iso_tf_table *table, iso_error *err);
/* Lets a table end below value_min with an entry that shows nothing, for voxels without data: values below the range
 * take the first entry. Does nothing if that shows nothing already. Values that would need more than
 * ISO_TF_MOST_ENTRIES entries show nothing either. ISO_E_MEMORY. */
iso_status iso_tf_table_end_below(iso_tf_table *table, double value_min, iso_error *err);
/* Copies a table. ISO_E_MEMORY. */
iso_status iso_tf_table_copy(const iso_tf_table *from, iso_tf_table *to, iso_error *err);
void iso_tf_table_destroy(iso_tf_table *table);
/* True if range and entries are the same bits. */
bool iso_tf_table_equals(const iso_tf_table *a, const iso_tf_table *b);

/* Looks up r, g, b, extinction linearly in double precision. */
static inline void iso_tf_lookup(const iso_tf_table *t, double value, double rgbs[4])
{
    double x = (value - t->lo) / (t->hi - t->lo) * (double)(t->count - 1);
    double last = (double)(t->count - 1);
    x = x > 0 ? (x < last ? x : last) : 0;
    size_t i = (size_t)x;
    if (i + 1 >= t->count)
        i = t->count - 2;
    double f = x - (double)i;
    const float *e = t->entries + 4 * i;
    for (int c = 0; c < 4; ++c)
        rgbs[c] = (1 - f) * (double)e[c] + f * (double)e[4 + c];
}
