/* SPDX-License-Identifier: MIT */
/* fields.h - grids of any name in the conventions of the program that will read them: unit of length, axes, class.
 *
 * Inside isoshade the world is in millimeters, right-handed, with z up. A convention takes it to scene units:
 *
 *     y up:  (x, y, z) -> (x, z, -y)     a rotation by -90 degrees about x: nothing is mirrored
 *
 * and divides lengths by the unit. What a grid holds per length is the caller's to convert. */
#ifndef ISO_VDB_FIELDS_H
#define ISO_VDB_FIELDS_H

#include <stdbool.h>

#include "base/progress.h"
#include "base/status.h"
#include "volume/geometry.h"

typedef struct iso_vdb_convention {
    double unit_mm;   /* of a scene unit */
    const char *unit; /* its name; "": it has none */
    bool y_up;
} iso_vdb_convention;

/* Millimeters with z up: what isoshade itself has. */
iso_vdb_convention iso_vdb_own_convention(void);
/* Whether OpenVDB and single precision can hold a level's voxels in these units. */
bool iso_vdb_fits(const iso_vdb_convention *c, const iso_geometry *g);
/* A place of the world in scene units. */
iso_vec3 iso_vdb_in_scene(const iso_vdb_convention *c, iso_vec3 world_mm);
/* A direction of the world on the scene's axes. */
iso_vec3 iso_vdb_turned(const iso_vdb_convention *c, iso_vec3 direction);

/* Index of the geometry's first point along each axis, where a leaf begins: the rim has no negative one. */
enum { ISO_VDB_FIELDS_FIRST = 8 };

/* One grid. */
typedef struct iso_vdb_field {
    const char *name, *meaning;
    int channels; /* 1: float; 3: vec3s, a color */
    /* Copies `count` values of the row (y, z) from x on, `channels` floats each; and which of at most eight are active,
     * where x, y and z count from the first point of the rim.
     * Called by several threads at once. */
    void (*read)(const void *user, size_t x, size_t y, size_t z, size_t count, float *out);
    void (*read_active)(const void *user, size_t x, size_t y, size_t z, size_t count, unsigned char *out);
    const void *user;
    double value_min, value_max;
} iso_vdb_field;

typedef struct iso_vdb_fields {
    const iso_geometry *geometry; /* in mm, right-handed; voxels' centers are the points */
    const iso_vdb_field *items;
    size_t count;
    size_t rim; /* points beyond the geometry that may be active; their values are those at its faces */
    int level;
    const char *made_from; /* a file's name without its folder */
    iso_vdb_convention convention;
    bool half_float;
    int threads; /* 0: all cores */
} iso_vdb_fields;

/* All grids into one file: class fog volume, background 0, inactive where they are not active; with the convention in the
 * metadata. ISO_E_RANGE: voxels that are so small or large in scene units that OpenVDB takes their transform for a singular
 * one. */
iso_status iso_vdb_save_fields(const iso_vdb_fields *f, const char *path, const iso_progress *progress, iso_error *err);

#endif
