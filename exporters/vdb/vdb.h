/* SPDX-License-Identifier: MIT */
/* vdb.h - OpenVDB files of pyramids and lattices. A C interface to a C++ library: no exception leaves it.
 *
 * A file holds, for one level, a float grid "density" (the scalar) and a vec3s grid "gradient" (decoded shading
 * directions, world axes). Optional float grids are "second_value" (tf/tf_2d.h) and "log2_extinction_scale"
 * (fit/extinction_scale.h). With several levels in a file, their grids are named density_level_N, gradient_level_N, as
 * OpenVDB's vdb_lod does.
 *
 * The transform puts the center of voxel (i, j, k) at integer index (i, j, k), as usual in OpenVDB: world = origin +
 * index_to_world (ijk + 1/2). If index_to_world is left-handed, as in many scans, x is stored in reverse order with a
 * reversed transform, because Blender draws left-handed grids wrong. The voxels' world positions stay the same.
 *
 * Active are all voxels, or those that a transfer function shows and those next to them that filtering reads
 * (iso_vdb_shown; rule and proof: vdb_sparse.h). The first and the last voxel of the box are always active. There are
 * no active tiles, which Cycles misreads.
 *
 * "density" has the class fog volume if it is never negative, has background 0 and is not a label map. It is stored in
 * half floats if that is lossless, as for bytes. Directions in half floats (half_directions) are multiplied by
 * isoshade_direction_scale: 127/128 for linear codes, whose bytes c / 127 become c / 128, which half floats hold
 * exactly. A direction's length matters only relative to ISO_DIRECTION_EPS, which readers must scale too.
 *
 * Metadata of the file: creator, command, source (name without folders) and units. Metadata of a grid: level, value
 * range, meaning of directions, its origin, and the unit of the world (isoshade_unit_mm, and isoshade_unit if it has a
 * name), usually the millimeter.
 *
 * Files are written leaf by leaf. Besides the voxels themselves, memory holds one mask per leaf: 30 MB for 512 x 512 x
 * 512. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/progress.h"
#include "brick/lattice.h"
#include "pyramid/pyramid.h"
#include "tf/tf.h"

#ifdef __cplusplus
extern "C" {
#endif

/* True if the file's metadata names isoshade as its creator; false for files that another program saved, and for
 * unreadable ones. */
bool iso_vdb_is_ours(const char *path);

/* Transfer functions with which a level is shown. Without any, voxels of value `background` are left out. */
typedef struct iso_vdb_shown {
    const iso_tf_table *tfs; /* all rows of a 2D transfer function */
    size_t tf_count;
    bool has_background; /* with transfer functions; if false, a background is chosen */
    double background;
} iso_vdb_shown;

typedef struct iso_vdb_options {
    bool half_float;      /* all grids as half floats, with loss of precision */
    bool half_directions; /* only the gradient grid as half floats: see above */
    bool nanovdb;         /* write a NanoVDB file; without half_directions, whose scale it cannot note */
    bool gradient;        /* write the gradient grid */
    const uint8_t *tf_2d; /* of one level, one byte per voxel: adds a float grid "second_value" of byte / 255; or
                           * NULL */
    const uint8_t
        *extinction_scale; /* same layout: adds a float grid "log2_extinction_scale", 0 for scale 1; or NULL: levels
                            * with has_no_data add theirs */
    size_t pad_voxels; /* rim of edge values around the level, for renderers that fade at the border. Voxel 0 then gets
                        * index pad_voxels + 1, so that no renderer that adds a voxel sees negative indices */
    const iso_vdb_shown *shown; /* one per saved level: leaves other voxels out; NULL: keeps all. Not for label maps */
    const iso_volume *volume;   /* scalars of level 0 if the pyramid has none (pyramid/narrow.h); or NULL */
    const char *creator, *command; /* metadata; command: without its private parts, or NULL */
    int threads;                   /* 0: all cores */
    /* Size in mm of the unit of the file's world and of the geometries; the origin counts in this unit too. 0:
     * geometries are in mm. The file is then in mm too, unless OpenVDB would consider the transform singular: such
     * files use the unit of iso_vdb_choose_unit(). */
    double unit_mm;
    iso_vec3 origin_mm;
    const char *unit; /* preferred unit for such voxels, that of the volume file; or NULL */
} iso_vdb_options;
iso_vdb_options iso_vdb_defaults(void);

/* Finds the version of NanoVDB's files, e.g. "32.4.2". path: for the message. ISO_E_MISSING: isoshade was built without
 * NanoVDB. */
iso_status iso_vdb_find_nanovdb(const char *path, const char **version, iso_error *err);

/* Chooses the unit of a file for a voxel size in mm: mm if it suits, otherwise `preferred` or another named unit
 * of unit.h, or a power of ten of mm, named "". preferred may be NULL. */
const char *iso_vdb_choose_unit(double voxel_mm, const char *preferred, double *mm);

/* Factor of half_directions for linear codes and lattices; other codes use 1. */
#define ISO_VDB_LINEAR_SCALE (127.0 / 128)
double iso_vdb_direction_scale(iso_code code);

/* True if the files store x in reverse order. */
bool iso_vdb_reverses_x(const iso_geometry *g);

/* Saves levels [first, first + count) of p to one file; a single level gets plain names. */
iso_status iso_vdb_save(const iso_pyramid *p, size_t first, size_t count, const char *path, const iso_vdb_options *opt,
                        const iso_progress *progress, iso_error *err);

/* Saves the lattices of a plan (brick/lattice.h): only active nodes, background elsewhere; directions at lit nodes. A
 * single lattice gets plain names, several get density_level_N. A voxel's index is the number of its node at its level,
 * so bricks of 8 or more nodes start at leaf borders. Ignores pad_voxels. */
iso_status iso_vdb_save_lattices(const iso_lattice *lattices, size_t count, const char *made_from, const char *path,
                                 const iso_vdb_options *opt, const iso_progress *progress, iso_error *err);

#ifdef __cplusplus
}
#endif
