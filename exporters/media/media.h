/* SPDX-License-Identifier: MIT */
/* media.h - scenes of path tracers: a box with a medium that absorbs and emits, without scattering.
 *
 * In:  a baked level with shaded colors (bake.h), its view, and a folder. Out: the scene's text and its grids there.
 *
 *   pbrt-v4     scene.pbrt, medium.pbrt   a medium "rgbgrid": sigma_a, Le, sigma_s 0; emitted light is sigma_a Le
 *   Mitsuba 3   scene.xml, sigma_t.vol    a heterogeneous medium that only absorbs, as its media do not emit yet
 *
 * The grid is the smallest box of the lattice that holds all points with an extinction or a color, and a rim of one
 * point. Both programs interpolate trilinearly between the centers of its cells, which are the points. All file and
 * object names are fixed. The volume's name appears in comments only, without characters other than letters, digits,
 * ".", "_" and blanks. */
#pragma once

#include "bake/bake.h"

typedef struct iso_medium {
    const iso_baked *baked;
    size_t first[3]; /* in points of the lattice */
    /* Unit of the grid and the camera: mm. For very small or large volumes it is a power of ten of mm that makes them
     * some tens of units across, so that absolute epsilons of the programs do not show. */
    double units_per_mm;
    char unit[24]; /* length of a unit, for comments */
    iso_geometry geometry;
    iso_camera camera;
    double background[3];  /* light from all directions outside */
    bool camera_is_inside; /* True if the camera is inside the grid's box */
    const char *made_from; /* without folders; or NULL */
} iso_medium;

/* Makes the medium. Borrows b and its view. ISO_E_RANGE: more points than the programs can count. */
iso_status iso_medium_create(const iso_baked *b, const char *made_from, iso_medium *out, iso_error *err);

/* Returns a grid point's extinction per unit and color; 0 if it has none. */
void iso_medium_point(const iso_medium *m, size_t x, size_t y, size_t z, float *extinction, float color[3]);

/* Writes the files of a folder. The first file of each list is the scene file. ISO_E_IO. */
iso_status iso_medium_write_pbrt(const iso_medium *m, const char *folder, iso_error *err);
iso_status iso_medium_write_mitsuba(const iso_medium *m, const char *folder, iso_error *err);

/* Prints made_from, in characters that comments of any language can hold, and a note on optimized values. */
void iso_medium_print_source(const iso_medium *m, FILE *f);
/* Closes f. ISO_E_IO: a write failed. path: for the message. */
iso_status iso_medium_close(FILE *f, const char *path, iso_error *err);
/* Opens folder/name. The caller frees *path. */
iso_status iso_medium_open(const char *folder, const char *name, char **path, FILE **f, iso_error *err);
