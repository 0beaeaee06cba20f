/* SPDX-License-Identifier: MIT */
/* volume.h - a scalar volume in memory, in the type that its file has.
 *
 * Samples stand x fastest, then y, then z. Stages that follow read rows as
 * float (iso_volume_row): exact for 8 and 16 bits and float; 32-bit integers
 * and doubles are rounded to the nearest float, which `isoshade info` reports. */
#pragma once

#include "base/progress.h"
#include "base/status.h"
#include "volume/geometry.h"
#include "volume/type.h"

/* A file's facts besides geometry and samples. */
typedef struct iso_volume_notes {
    bool world_is_ras;                       /* True if the world is right, anterior, superior; false: the file's own
                                              * frame */
    double scale_slope, scale_intercept;     /* physical value = slope * sample + intercept; iso_source_apply_scale() */
    double applied_slope, applied_intercept; /* the scale that samples have been given; slope 0: none */
    char unit[16];                 /* of lengths, as the file or the caller names it; "" if none does: mm */
    double unit_mm;                /* the unit in mm */
    char value_unit[16];           /* of values with their scale applied, as the file names it: "HU"; "": it does not */
    size_t frame_count, frame;     /* time steps in the file, and the one that was read, from 0; 0: one volume */
    double frame_step;             /* from one to the next; 0: not in the file */
    char frame_unit[16];           /* as the file calls it */
    bool says_labels;              /* True if the file marks itself as a label map */
    size_t label_count;            /* of a label map (labels.h); 0: intensities */
    size_t channel_count, channel; /* numbers a voxel in the file, and the one that was read */
    char channel_name[48];         /* "": it has none */
    char channel_list[320];        /* of several, by number and name: "0 red, 1 green" */
} iso_volume_notes;

typedef struct iso_volume {
    iso_geometry geometry;
    iso_type type;
    void *data; /* owned */
    iso_volume_notes notes;
    struct json_t *segments; /* owned: names and colors of a label map's labels (segments.h); or NULL */
} iso_volume;

/* Allocates zeroed samples after iso_geometry_check. */
iso_status iso_volume_create(iso_volume *v, const iso_geometry *g, iso_type type, const char *name, iso_error *err);
void iso_volume_destroy(iso_volume *v); /* accepts empty and NULL */

/* Copies the row (y, z) as nx floats. */
void iso_volume_row(const iso_volume *v, size_t y, size_t z, float *restrict row);
/* Copies the whole volume as iso_geometry_voxel_count() floats. */
void iso_volume_floats(const iso_volume *v, float *restrict out);

typedef struct iso_volume_stats {
    double min, max, mean;     /* of the finite samples; without data min > max */
    size_t no_data_count;      /* ISO_NO_DATA */
    size_t nonfinite_count;    /* NaN and Inf */
    size_t first_nonfinite[3]; /* x, y, z */
} iso_volume_stats;
iso_volume_stats iso_volume_measure(const iso_volume *v);
/* Returns ISO_E_RANGE if a sample is NaN or infinite, or if no voxel has data. */
iso_status iso_volume_check_stats(const iso_volume_stats *s, const iso_geometry *g, const char *path, iso_error *err);

/* Loads by the file's content (doc/reference/formats-read.md), values as they are stored. ISO_E_IO. ISO_E_FORMAT:
 * truncated, wrong magic, sizes that do not match the file, unsupported types and dimensions. ISO_E_RANGE: sizes
 * that overflow, NaN or Inf voxels. ISO_E_MEMORY. stream.h reads slab by slab and defines the world coordinates. */
iso_status iso_volume_load(const char *path, iso_volume *v, iso_error *err);

/* Values that the caller declares to be no data, instead of the file's fill values. NaN is none unless is_none. */
typedef struct iso_no_data {
    bool is_given, is_none; /* True if there is such a rule; if all values are data */
    double lo, hi;          /* both included */
} iso_no_data;
/* Parses "none", a value, or "LO,HI"; NULL: no rule. ISO_E_USAGE. */
iso_status iso_no_data_parse(const char *text, iso_no_data *rule, iso_error *err);

/* A file without a header. */
typedef struct iso_raw_layout {
    iso_type type;
    iso_form form; /* unless it is ISO_FORM_TYPE, instead of the type */
    size_t size[3];
    double spacing_mm[3];
    bool big_endian;
    size_t skip_bytes;
    iso_no_data no_data;
} iso_raw_layout;

/* iso_volume_save() writes NRRD: in the library's header. */
