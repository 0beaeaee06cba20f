/* SPDX-License-Identifier: MIT */
/* fields.h - grids with any names, in the conventions of the target program: unit of length, axes, class.
 *
 * Inside isoshade the world is in millimeters, right-handed, with z up. A convention converts it to scene units:
 *
 *     y up:  (x, y, z) -> (x, z, -y)     a rotation by -90 degrees about x, without mirroring
 *
 * and divides lengths by the unit. The caller converts values per length. */
#pragma once

#include <stdbool.h>

#include "base/progress.h"
#include "base/status.h"
#include "volume/geometry.h"

typedef struct iso_vdb_convention {
    double unit_mm;   /* of a scene unit */
    const char *unit; /* its name; "" if it has none */
    bool y_up;
} iso_vdb_convention;

/* Returns isoshade's own convention: millimeters, z up. */
iso_vdb_convention iso_vdb_own_convention(void);
/* True if OpenVDB and single precision can hold a level's voxels in these units. */
bool iso_vdb_fits(const iso_vdb_convention *c, const iso_geometry *g);
/* Converts a world position to scene units. */
iso_vec3 iso_vdb_in_scene(const iso_vdb_convention *c, iso_vec3 world_mm);
/* Rotates a world direction to the scene's axes. */
iso_vec3 iso_vdb_turned(const iso_vdb_convention *c, iso_vec3 direction);

/* Index of the geometry's first point along each axis, at the start of a leaf, so that the rim has no negative
 * index. */
enum { ISO_VDB_FIELDS_FIRST = 8 };

/* A grid of the file. */
typedef struct iso_vdb_field {
    const char *name, *meaning;
    int channels; /* 1: float; 3: vec3s, a color */
    /* Copies `count` values of row (y, z) from x on, `channels` floats each, and the active flag of each of at most
     * eight; x, y and z count from the first point of the rim. Must be thread-safe. */
    void (*read)(const void *user, size_t x, size_t y, size_t z, size_t count, float *out);
    void (*read_active)(const void *user, size_t x, size_t y, size_t z, size_t count, unsigned char *out);
    const void *user;
    double value_min, value_max;
} iso_vdb_field;

typedef struct iso_vdb_fields {
    const iso_geometry *geometry; /* in mm, right-handed; the points are voxel centers */
    const iso_vdb_field *items;
    size_t count;
    size_t rim; /* points beyond the geometry that may be active; they repeat the values at its faces */
    int level;
    const char *made_from; /* file name without folder */
    const char *values;    /* note on the level's values; "" if they are data */
    iso_vdb_convention convention;
    bool half_float;
    bool nanovdb; /* write a NanoVDB file (vdb.h) */
    int threads;  /* 0: all cores */
} iso_vdb_fields;

/* Saves all grids to one file: class fog volume, background 0, inactive voxels left out, the convention in the
 * metadata. ISO_E_RANGE: the voxels are too small or too large in scene units, so that OpenVDB considers their
 * transform singular. */
iso_status iso_vdb_save_fields(const iso_vdb_fields *f, const char *path, const iso_progress *progress, iso_error *err);
