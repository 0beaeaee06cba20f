/* SPDX-License-Identifier: MIT */
/* pbrt.h - a scene of pbrt-v4: a box with a medium that absorbs and emits, without scattering.
 *
 * In:  a baked level with shaded colors (bake.h), its view, and a folder. Out: scene.pbrt and medium.pbrt there, a medium
 * "rgbgrid" with sigma_a, Le and sigma_s 0. Emitted light is sigma_a Le.
 *
 * The grid is the smallest box of the lattice that holds all points with an extinction or a color, and a rim of one
 * point. pbrt interpolates trilinearly between the centers of its cells, which are the points. The volume's name appears
 * in comments only, without characters other than letters, digits, ".", "_" and blanks. */
#pragma once

#include "bake/bake.h"

typedef struct iso_medium {
    const iso_baked *baked;
    size_t first[3]; /* in points of the lattice */
    /* Unit of the grid and the camera: mm. For very small or large volumes it is a power of ten of mm that makes them
     * some tens of units across, so that pbrt's absolute epsilons do not show. */
    double units_per_mm;
    char unit[24]; /* length of a unit, for comments */
    iso_geometry geometry;
    iso_camera camera;
    double background[3];  /* light from all directions outside */
    bool camera_is_inside; /* True if the camera is inside the grid's box */
    const char *made_from; /* without folders; or NULL */
} iso_medium;

/* Makes the medium. Borrows b and its view. ISO_E_RANGE: more points than pbrt can count. */
iso_status iso_medium_create(const iso_baked *b, const char *made_from, iso_medium *out, iso_error *err);

/* Returns a grid point's extinction per unit and color; 0 if it has none. */
void iso_medium_point(const iso_medium *m, size_t x, size_t y, size_t z, float *extinction, float color[3]);

/* Writes the files to the folder. ISO_E_IO. */
iso_status iso_medium_write(const iso_medium *m, const char *folder, iso_error *err);
