/* SPDX-License-Identifier: MIT */
/* geometry.h - position of a grid of voxels in the world.
 *
 * Index coordinates are continuous: voxel i covers [i, i+1) and has its center
 * at i + 1/2. World coordinates are millimeters, right-handed:
 *     world = origin_mm + index_to_world * index.
 * The columns of index_to_world are the world steps of one voxel, so they hold
 * spacing, rotation and, if the input has them, shear and reflection.
 *
 * The box that is rendered is [0, box_index] in index coordinates: the outer
 * faces of the level-0 voxels, the same in the world at every level. A coarse
 * level may overhang it where a size is odd.
 *
 *     level 0   |  0  |  1  |  2  |  3  |  4  |          size 5, box 5
 *     level 1   |     0     |     1     |     2     |    size 3, box 2.5
 *
 * Gradients are covariant: world = transpose(inverse(index_to_world)) * index. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/linalg.h"
#include "base/status.h"

/* The ranges of all lengths and places, of files, options and the library: readers and writers share them. They follow
 * from the number formats alone. The cube of a length, its inverse and an extinction of 10 per length fit single
 * precision's range or double's, whichever stores it; a place is far from overflowing in single precision. A voxel's
 * edge, a length that opacities are for, the height of a picture: */
#define ISO_LEAST_MM 1e-30
#define ISO_MOST_MM 1e30
/* Each coordinate of a point: */
#define ISO_MOST_PLACE_MM 1e36
/* Values of samples: each that single precision holds, with its 9 digits in a file rounded up. */
#define ISO_MOST_VALUE 3.4028235e38

typedef struct iso_geometry {
    size_t size[3]; /* voxels along x (fastest), y, z */
    iso_mat3 index_to_world;
    iso_vec3 origin_mm; /* the outer corner of voxel (0, 0, 0) */
    double box_index[3];
    bool has_no_data; /* some voxels have ISO_NO_DATA (type.h): transfer functions are made for that, too */
    bool is_patient; /* the file names an anatomical space: the world is right, anterior, superior of a body */
} iso_geometry;

/* Returns a geometry with that spacing along the world's axes, centered at the world's origin. */
iso_geometry iso_geometry_axis_aligned(const size_t size[3], const double spacing_mm[3]);

/* Checks a geometry. ISO_E_RANGE: a size of 0, a product that overflows, an index_to_world that is singular or not
 * finite, a voxel's edge or an origin out of the ranges above. `name` stands in the message: the file, for instance. */
iso_status iso_geometry_check(const iso_geometry *g, const char *name, iso_error *err);

/* Returns the geometry of the next coarser level: sizes (n + 1) / 2, the same box. */
iso_geometry iso_geometry_coarser(const iso_geometry *g);

static inline size_t iso_geometry_voxel_count(const iso_geometry *g)
{
    return g->size[0] * g->size[1] * g->size[2];
}
iso_vec3 iso_geometry_to_world(const iso_geometry *g, iso_vec3 index);
iso_vec3 iso_geometry_to_index(const iso_geometry *g, iso_vec3 world_mm);
/* Returns the lengths of the columns of index_to_world; the least of them. */
void iso_geometry_spacing_mm(const iso_geometry *g, double spacing_mm[3]);
double iso_geometry_min_spacing_mm(const iso_geometry *g);
/* Returns the cube root of a voxel's volume. */
double iso_geometry_mean_spacing_mm(const iso_geometry *g);
/* Returns the center of the box; half its diagonal. */
iso_vec3 iso_geometry_box_center_mm(const iso_geometry *g);
double iso_geometry_box_radius_mm(const iso_geometry *g);
/* Returns transpose(inverse(index_to_world)), which turns index gradients to world gradients. */
iso_mat3 iso_geometry_gradient_to_world(const iso_geometry *g);
