/* SPDX-License-Identifier: MIT */
/* vdb.h - OpenVDB files of pyramids and lattices. A C interface to a C++ library: no exception leaves it.
 *
 * Metadata say the unit of the file's world (isoshade_unit_mm, isoshade_unit where it has a name); it is the millimetre
 * as a rule.
 *
 * A file holds a float grid "density" (the scalar) and a vec3s grid "gradient"
 * (decoded shading directions, world axes) of one level, and where asked for a
 * float grid "second_value" (tf/tf_2d.h) or "log2_extinction_scale" (fit/extinction_scale.h). The transform puts the
 * centre of voxel (i, j, k) at integer index (i, j, k), as OpenVDB has it: world
 * = origin + index_to_world (ijk + 1/2). Where index_to_world is left-handed, as in
 * many scans, x is stored in reverse order and the transform is reversed with it: voxels stay in
 * their place in the world. Blender draws left-handed grids wrong.
 * All voxels are active and there are no
 * active tiles (Cycles misreads them). Metadata: name, level, value range,
 * directions' meaning, what made it. Several levels in one file are named
 * density_level_N, gradient_level_N, as OpenVDB's vdb_lod does. */
#ifndef ISO_EXPORT_VDB_H
#define ISO_EXPORT_VDB_H

#include <stdbool.h>
#include <stdint.h>

#include "base/progress.h"
#include "brick/lattice.h"
#include "pyramid/pyramid.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct iso_vdb_options {
    bool half_float;      /* store as half: loses precision */
    bool gradient;        /* write the gradient grid */
    const uint8_t *tf_2d; /* of one level, a byte a voxel: a float grid "second_value" of byte / 255 as well; or NULL */
    const uint8_t
        *extinction_scale; /* likewise: a float grid "log2_extinction_scale", 0 where the scale is 1; or NULL */
    size_t pad_voxels;     /* rim of edge values around the level: renderers that fade at the border need one. Voxel 0 then
                              has the index pad_voxels + 1, so that no renderer that adds a voxel sees negative indices */
    const char *creator;   /* metadata */
    /* A unit of the file's world is so many mm, and its origin stands there in the world; geometries are in it. 0: the
     * geometries are in mm, and so is the file, but for voxels so small or large that OpenVDB takes their transform for
     * a singular one: these files have a unit in which they are of a size between 1e-3 and 1e3. */
    double unit_mm;
    iso_vec3 origin_mm;
    const char *unit; /* the name of the unit that is taken where it suits such voxels: the volume file's; or NULL */
} iso_vdb_options;
iso_vdb_options iso_vdb_defaults(void);

/* Whether the files store x in reverse order. */
bool iso_vdb_reverses_x(const iso_geometry *g);

/* Levels [first, first + count) of p into one file; one level: plain names. */
iso_status iso_vdb_save(const iso_pyramid *p, size_t first, size_t count, const char *path, const iso_vdb_options *opt,
                        const iso_progress *progress, iso_error *err);

/* The lattices of a plan (brick/lattice.h): the active nodes alone, the background elsewhere. One lattice: plain names;
 * more: density_level_N. A voxel's index is the number of its node at its level, so that bricks of 8 or more nodes
 * begin where leaves do. pad_voxels has no meaning here. */
iso_status iso_vdb_save_lattices(const iso_lattice *lattices, size_t count, const char *made_from, const char *path,
                                 const iso_vdb_options *opt, const iso_progress *progress, iso_error *err);

/* A grid read back dense over `size` voxels from index (0, 0, 0); channels 1 or
 * 3; out holds channels * size floats, x fastest. *geometry, when not NULL, gets
 * the transform in isoshade's convention. ISO_E_FORMAT when there is no such grid. */
iso_status iso_vdb_load_grid(const char *path, const char *grid, int channels, const size_t size[3], float *out,
                             iso_geometry *geometry, iso_error *err);

/* What a file's grids take once they are read, by OpenVDB's own count, and how long reading takes. */
typedef struct iso_vdb_stats {
    size_t file_bytes, active_voxels, memory_bytes;
    double read_seconds;
} iso_vdb_stats;
iso_status iso_vdb_measure(const char *path, iso_vdb_stats *stats, iso_error *err);

const char *iso_vdb_version(void);

#ifdef __cplusplus
}
#endif

#endif
