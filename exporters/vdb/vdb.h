/* SPDX-License-Identifier: MIT */
/* vdb.h - OpenVDB files of pyramids and lattices. A C interface to a C++ library: no exception leaves it.
 *
 * A file holds a float grid "density" (the scalar) and a vec3s grid "gradient" (decoded shading directions, world axes)
 * of one level, and where asked for a float grid "second_value" (tf/tf_2d.h) or "log2_extinction_scale"
 * (fit/extinction_scale.h). The transform puts the center of voxel (i, j, k) at integer index (i, j, k), as OpenVDB has
 * it: world = origin + index_to_world (ijk + 1/2). Where index_to_world is left-handed, as in many scans, x is stored
 * in reverse order and the transform is reversed with it: voxels stay in their place in the world. Blender draws
 * left-handed grids wrong. Several levels in one file are named density_level_N, gradient_level_N, as OpenVDB's vdb_lod
 * does.
 *
 * Active are all voxels, or those that a transfer function shows and what filtering touches beside them (iso_vdb_shown;
 * the rule and its proof are in vdb_sparse.h); the first and the last voxel of the box are always. There are no active
 * tiles (Cycles misreads them).
 *
 * "density" has the class fog volume where it is one: never negative, with a background of 0, and no label map. It is
 * stored in half floats where that loses nothing, as of bytes. Directions in half floats (half_directions) are
 * multiplied by isoshade_direction_scale: 127/128 for linear codes, whose bytes c / 127 become c / 128, which a half
 * float holds exactly. A direction's length has a meaning relative to ISO_DIRECTION_EPS alone, which is to be scaled
 * likewise.
 *
 * Metadata of the file: creator, command, source (the name of what it was made from, without folders) and units. Of a
 * grid: level, value range, directions' meaning, what made it, and the unit of the world (isoshade_unit_mm,
 * isoshade_unit where it has a name), which is the millimeter as a rule.
 *
 * Files are written leaf by leaf: beside the voxels themselves memory holds a mask a leaf, 30 MB of 512 x 512 x 512. */
#ifndef ISO_EXPORT_VDB_H
#define ISO_EXPORT_VDB_H

#include <stdbool.h>
#include <stdint.h>

#include "base/progress.h"
#include "brick/lattice.h"
#include "pyramid/pyramid.h"
#include "tf/tf.h"

#ifdef __cplusplus
extern "C" {
#endif

/* True if a file's own metadata names isoshade as its creator; false for files that another program saved or that
 * cannot be read. */
bool iso_vdb_is_ours(const char *path);

/* Transfer functions that show a level. Without any, voxels of `background` are left out. */
typedef struct iso_vdb_shown {
    const iso_tf_table *tfs; /* of a 2D transfer function all rows */
    size_t tf_count;
    bool has_background; /* with transfer functions: else one is chosen */
    double background;
} iso_vdb_shown;

typedef struct iso_vdb_options {
    bool half_float;      /* all grids in half floats: loses precision */
    bool half_directions; /* the gradient's alone: see above */
    bool gradient;        /* write the gradient grid */
    const uint8_t *tf_2d; /* of one level, one byte per voxel: a float grid "second_value" of byte / 255 as well; or
                           * NULL */
    const uint8_t
        *extinction_scale; /* in the same way: a float grid "log2_extinction_scale", 0 if the scale is 1; or NULL */
    size_t pad_voxels; /* rim of edge values around the level: renderers that fade at the border need one. Voxel 0 then
                              has the index pad_voxels + 1, so that no renderer that adds a voxel sees negative indices */
    const iso_vdb_shown
        *shown; /* one a level that is saved: other voxels are left out; NULL: none are. Not of label maps */
    const iso_volume *volume;      /* level 0's scalars where the pyramid has none (pyramid/narrow.h); or NULL */
    const char *creator, *command; /* metadata; command: NULL, or without its private parts */
    int threads;                   /* 0: all cores */
    /* A unit of the file's world is so many mm, and its origin stands there in the world; geometries are in it. 0: the
     * geometries are in mm, and so is the file, but for voxels so small or large that OpenVDB takes their transform for
     * a singular one: these files have the unit of iso_vdb_choose_unit(). */
    double unit_mm;
    iso_vec3 origin_mm;
    const char *unit; /* the name of the unit that is taken where it suits such voxels: the volume file's; or NULL */
} iso_vdb_options;
iso_vdb_options iso_vdb_defaults(void);
/* Chooses the unit of a file with voxels of so many mm: mm if they suit it, else `preferred` or another name of unit.h,
 * else a power of ten of mm, which has the name "". preferred may be NULL. */
const char *iso_vdb_choose_unit(double voxel_mm, const char *preferred, double *mm);

/* What half_directions multiplies the directions of a code by: this for those that are linear, and of lattices, else
 * 1. */
#define ISO_VDB_LINEAR_SCALE (127.0 / 128)
double iso_vdb_direction_scale(iso_code code);

/* Whether the files store x in reverse order. */
bool iso_vdb_reverses_x(const iso_geometry *g);

/* Levels [first, first + count) of p into one file; one level: plain names. */
iso_status iso_vdb_save(const iso_pyramid *p, size_t first, size_t count, const char *path, const iso_vdb_options *opt,
                        const iso_progress *progress, iso_error *err);

/* The lattices of a plan (brick/lattice.h): the active nodes alone, the background elsewhere; directions where they are
 * lit. One lattice: plain names; more: density_level_N. A voxel's index is the number of its node at its level, so that
 * bricks of 8 or more nodes begin where leaves do. pad_voxels has no meaning here. */
iso_status iso_vdb_save_lattices(const iso_lattice *lattices, size_t count, const char *made_from, const char *path,
                                 const iso_vdb_options *opt, const iso_progress *progress, iso_error *err);

/* A grid read back dense over `size` voxels from index (0, 0, 0); channels 1 or
 * 3; out holds channels * size floats, x fastest. *geometry, when not NULL, gets
 * the transform in isoshade's convention. ISO_E_FORMAT when there is no such grid. */
iso_status iso_vdb_load_grid(const char *path, const char *grid, int channels, const size_t size[3], float *out,
                             iso_geometry *geometry, iso_error *err);

/* Memory of a file's grids once they are read, by OpenVDB's own count, and the seconds of reading. */
typedef struct iso_vdb_stats {
    size_t file_bytes, active_voxels, memory_bytes;
    double read_seconds;
} iso_vdb_stats;
iso_status iso_vdb_measure(const char *path, iso_vdb_stats *stats, iso_error *err);

#ifdef __cplusplus
}
#endif

#endif
