/* SPDX-License-Identifier: MIT */
/* bake.h - a level seen through its transfer function, as a grid of extinction and color that any program can show.
 *
 * In:  a level and a view. Out: for each point of a lattice its extinction per mm, linear color, and place on the
 * transfer
 *      function's range.
 *
 * Here the scalar is interpolated and the transfer function comes after it. Programs that read colors interpolate what
 * came out of the transfer function at the points of the lattice: fine structures of the transfer function between two
 * points are lost, and edges are wider. bake_error.h measures what that changes in the picture. A finer lattice has
 * less of it.
 *
 *      level    |     o     |     o     |          o  a voxel's center
 *      lattice  | x | x | x | x | x | x | x |      x  a point, 3 to a voxel, and one more round the box, transparent
 *
 * - Extinction is never negative. Programs read 0 beyond the outermost points, so it falls off over a point's
 *   distance at
 *   the faces of the box: along each line of points the optical depth is still that of the box.
 * - A point whose cell the box or clip planes cut keeps the extinction of the part that is left.
 * - A transparent point has no color of its own; were it black, or whatever the transfer function holds there, it
 *   would
 *   bleed into its neighbors where extinction and color are interpolated each by itself. So transparent points next to
 *   visible ones (26 neighbors) have the neighbors' mean color, weighted by extinction. Others have none.
 * - Shaded colors are those of each sample times its shade by the level's directions; a program that knows no
 *   directions
 *   shows them as light. They are right for this camera and these lights alone.
 * - Memory: blocks of 8 x 8 x 8 points that show something or are next to it. */
#ifndef ISO_BAKE_H
#define ISO_BAKE_H

#include "pyramid/pyramid.h"
#include "render/reference.h"
#include "render/sampler.h"
#include "scene/scene.h"

enum { ISO_BAKE_BLOCK = 8, ISO_BAKE_CHANNELS = 5, ISO_BAKE_MOST_POINTS = 8 };

/* Channels of a point: extinction per mm, linear red, green and blue, and the value's place on the table's range, 0 to
 * 1. */
enum { ISO_BAKE_EXTINCTION, ISO_BAKE_COLOR, ISO_BAKE_PLACE = ISO_BAKE_COLOR + 3 };

typedef struct iso_bake_options {
    size_t points; /* of the lattice along a voxel's side: 1 */
    size_t
        samples; /* along the side of a point's cell, whose mean the point gets: 2, which halves the error of sharp ones */
    bool shaded; /* colors as they are seen from the view's camera by its lights, in place of the transfer function's */
    int threads;
} iso_bake_options;
iso_bake_options iso_bake_defaults(void);

typedef struct iso_baked {
    iso_geometry geometry; /* of the lattice: right-handed, its points are the centers of its voxels */
    const iso_level *level;
    const iso_view *view;
    iso_code code;
    iso_bake_options options;
    bool reversed_x; /* against the level, which is left-handed */
    size_t blocks[3];
    float **block; /* ISO_BAKE_CHANNELS a point; NULL: transparent, without color */
    size_t visible_count, color_count;
    double extinction_max, color_max[3];
} iso_baked;

/* Borrows level and view, which is without a region of interest. ISO_E_RANGE, ISO_E_MEMORY. */
iso_status iso_bake(const iso_level *level, iso_code code, const iso_view *view, const iso_bake_options *opt,
                    iso_baked *out, const iso_progress *progress, iso_error *err);
void iso_baked_destroy(iso_baked *b); /* accepts empty and NULL */

/* The channels of a point, or NULL if it has neither extinction nor color. A color below 0: none. */
const float *iso_baked_point(const iso_baked *b, size_t x, size_t y, size_t z);

/* Interpolation of the grids between their points by a program. */
typedef enum iso_baked_pair {
    ISO_BAKED_COLORS,  /* density and Cd: both are interpolated, then multiplied */
    ISO_BAKED_EMISSION /* density and emission, their product at the points */
} iso_baked_pair;
/* At index coordinates of the lattice: extinction per mm; color: extinction times linear color. */
double iso_baked_sample(const iso_baked *b, iso_baked_pair pair, iso_vec3 index, double color[3]);
/* The same place in index coordinates of the level. */
iso_vec3 iso_baked_in_level(const iso_baked *b, iso_vec3 index);

#endif
