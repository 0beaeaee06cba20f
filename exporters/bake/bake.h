/* SPDX-License-Identifier: MIT */
/* bake.h - bakes a level and its transfer function to a grid of extinction and color, which any renderer can show.
 *
 * In:  a level and a view. Out: for each point of a lattice, extinction per mm, linear color, and position in the
 * transfer function's range.
 *
 * isoshade interpolates the scalar and then applies the transfer function. Renderers of baked grids interpolate colors,
 * so features of the transfer function between two points are lost, and edges get wider. bake_error.h measures the
 * effect on the picture. A finer lattice reduces it.
 *
 *      level    |     o     |     o     |          o  a voxel's center
 *      lattice  | x | x | x | x | x | x | x |      x  a point, 3 per voxel; one more around the box, transparent
 *
 * - Extinction is never negative. Renderers read 0 beyond the outermost points, so it fades over one point distance at
 *   the faces of the box; along each line of points the optical depth equals that of the box.
 * - A point whose cell is cut by the box or by clip planes keeps the extinction of the remaining part.
 * - A transparent point has no color of its own; black, or the transfer function's color there, would bleed into its
 *   neighbors if extinction and color are interpolated separately. So transparent points next to visible ones (26
 *   neighbors) get the neighbors' mean color, weighted by extinction. Others have none.
 * - Shaded colors are each sample's color times its shade by the level's directions, for renderers without directions,
 *   which show them as emitted light. They are correct for this camera and these lights only.
 * - Memory: blocks of 8 x 8 x 8 points that are visible or next to visible ones. */
#pragma once

#include "pyramid/pyramid.h"
#include "render/reference.h"
#include "render/sampler.h"
#include "scene/scene.h"

enum { ISO_BAKE_BLOCK = 8, ISO_BAKE_CHANNELS = 5, ISO_BAKE_MOST_POINTS = 8 };

/* Channels of a point: extinction per mm; linear red, green, blue; position in the table's range, 0 to 1. */
enum { ISO_BAKE_EXTINCTION, ISO_BAKE_COLOR, ISO_BAKE_PLACE = ISO_BAKE_COLOR + 3 };

typedef struct iso_bake_options {
    size_t points;  /* lattice points along a voxel's side (1) */
    size_t samples; /* samples along the side of a point's cell, to average (2, which halves the error of sharp TFs) */
    bool shaded;    /* True to bake colors as lit by the view's lights and seen from its camera */
    int threads;
} iso_bake_options;
iso_bake_options iso_bake_defaults(void);

typedef struct iso_baked {
    iso_geometry geometry; /* of the lattice: right-handed; its points are voxel centers */
    const iso_level *level;
    const iso_view *view;
    iso_code code;
    iso_bake_options options;
    bool reversed_x; /* True if x runs against the level, which is left-handed */
    size_t blocks[3];
    float **block; /* ISO_BAKE_CHANNELS per point; NULL: transparent, without color */
    size_t visible_count, color_count;
    double extinction_max, color_max[3];
} iso_baked;

/* Bakes a level. Borrows level and view; the view must not have a region of interest. ISO_E_RANGE, ISO_E_MEMORY. */
iso_status iso_bake(const iso_level *level, iso_code code, const iso_view *view, const iso_bake_options *opt,
                    iso_baked *out, const iso_progress *progress, iso_error *err);
void iso_baked_destroy(iso_baked *b); /* accepts empty and NULL */

/* Returns the channels of a point, or NULL if it has neither extinction nor color. A color below 0: none. */
const float *iso_baked_point(const iso_baked *b, size_t x, size_t y, size_t z);

/* How a renderer interpolates the grids between their points. */
typedef enum iso_baked_pair {
    ISO_BAKED_COLORS,  /* density and Cd: both are interpolated, then multiplied */
    ISO_BAKED_EMISSION /* density and emission, their product at the points */
} iso_baked_pair;
/* Samples at index coordinates of the lattice: returns extinction per mm; color: extinction times linear color. */
double iso_baked_sample(const iso_baked *b, iso_baked_pair pair, iso_vec3 index, double color[3]);
/* Converts index coordinates of the lattice to those of the level. */
iso_vec3 iso_baked_in_level(const iso_baked *b, iso_vec3 index);
