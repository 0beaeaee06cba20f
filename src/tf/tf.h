/* SPDX-License-Identifier: MIT */
/* tf.h - transfer functions: value to linear color and extinction.
 *
 * A TF file (*.tf.json) holds points; opacity is stated for a length, the
 * opacity unit distance u, and becomes extinction = -ln(1 - a) / u in 1/mm (the
 * rule of ANARI's volume appendix), so that no opacity depends on a step, a
 * level or a spacing. What renderers get is a table of entries over [lo, hi],
 * linear between entries, each component interpolated by itself; values beyond
 * the range take the end entries.
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
#ifndef ISO_TF_H
#define ISO_TF_H

#include <stdbool.h>

#include "base/json.h"
#include "volume/geometry.h"

enum { ISO_TF_MOST_ENTRIES = 16384 }; /* of a table: what textures hold in a row */

/* Values of a transfer function's points and range: from minus this to this, as far as those of volumes. */
#define ISO_TF_MOST_VALUE ISO_MOST_VALUE
/* Opacity is capped here before the logarithm: extinction stays finite. */
#define ISO_TF_MAX_OPACITY 0.9999

/* The lengths that opacities may be stated for, in mm or in voxels. */
#define ISO_TF_LEAST_UNIT ISO_LEAST_MM
#define ISO_TF_MOST_UNIT (1e3 * ISO_MOST_MM) /* some of the largest voxels */

/* Per mm: the densest that can be stated, ISO_TF_MAX_OPACITY of ISO_TF_LEAST_UNIT, rounded up. */
#define ISO_TF_MOST_EXTINCTION 9.2104e30

/* How far the table of a TF of another program is from what that program shows, in display color and in opacity, each
 * 0 to 1: at the table's entries, and between them, where a curve may be steeper than the table is fine. */
typedef struct iso_tf_loss {
    bool measured; /* false: nothing was converted, or nobody asked */
    double color, opacity;
    double between;
} iso_tf_loss;

typedef struct iso_tf {
    size_t point_count;
    iso_tf_point *points; /* of the library's header; ascending in value */
    bool fit_range;
    double range[2];      /* when not fit_range */
    double unit_distance; /* in mm, or in voxels */
    bool unit_is_voxels;
    size_t table_size;
    iso_tf_loss loss;
    char of[160]; /* the file or preset that it is of, for messages; "": it stands in another file */
} iso_tf;

/* What a file of another program may leave open. */
typedef struct iso_tf_request {
    const char *name; /* which of several; NULL: there is one */
    char **names;     /* not NULL: nothing is loaded, the names are listed here, a line each; to be freed */
    double unit_mm;   /* that its opacities are for; 0: as the file says */
    bool has_opacity; /* opacity from the range's start to its end, for a file that has colors alone */
    double opacity[2];
    bool has_range, fit; /* range instead of the file's; fit: the volume's */
    double range[2];
    bool measure; /* sets the TF's loss where the file is another program's */
} iso_tf_request;

/* A file of any format that is read (format.h). */
iso_status iso_tf_load(const char *path, iso_tf *tf, iso_error *err);
/* The same with what the file leaves open. ISO_E_USAGE: what has to be said and is not, or is said and the file says it. */
iso_status iso_tf_load_as(const char *path, const iso_tf_request *request, iso_tf *tf, iso_error *err);
/* The same from an object inside another file; `path` is the file that error messages name. */
iso_status iso_tf_from_json(const json_t *object, const char *path, iso_tf *tf, iso_error *err);
/* A new object in the form of the file, points linear. */
json_t *iso_tf_to_json(const iso_tf *tf);
/* Writes the object of a file only if it can be read: the reader's limits hold for each writer. */
iso_status iso_tf_save_json(const json_t *root, const char *path, iso_error *err);
iso_status iso_tf_copy(const iso_tf *from, iso_tf *to, iso_error *err);
void iso_tf_destroy(iso_tf *tf);

/* The form that renderers and exporters use. */
enum { ISO_TF_FEW_POINTS = 32 };
typedef struct iso_tf_table {
    size_t count; /* entries */
    double lo, hi;
    float *entries; /* 4 for each entry: linear r, g, b, extinction per mm */
    /* What the entries were made of, for those who let a person edit it; renderers look at the entries alone. */
    double unit_mm;     /* that opacities are stated for; 0: not known */
    size_t point_count; /* 0: of more points than these, or of none; their values are the volume's */
    iso_tf_point points[ISO_TF_FEW_POINTS];
} iso_tf_table;

/* Resolves range and unit distance against a volume: value_min/max and the
 * geometry of level 0. ISO_E_RANGE for an empty range, and for a peak so narrow that no entry shows it. */
iso_status iso_tf_tabulate(const iso_tf *tf, double value_min, double value_max, const iso_geometry *level0,
                           iso_tf_table *table, iso_error *err);
/* ISO_E_MEMORY. */
iso_status iso_tf_table_copy(const iso_tf_table *from, iso_tf_table *to, iso_error *err);
void iso_tf_table_destroy(iso_tf_table *table);

/* Linear lookup in double precision: r, g, b, extinction. */
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

#endif
