/* SPDX-License-Identifier: MIT */
/* media.h - scenes of path tracers: a box with a medium that absorbs and emits, and scatters nothing.
 *
 * In:  a baked level whose colors are shaded (bake.h), its view, and a folder. Out: the scene's text and its grids
 * there.
 *
 *   pbrt-v4     scene.pbrt, medium.pbrt   a medium "rgbgrid": sigma_a, Le, sigma_s 0; light that is emitted: sigma_a Le
 *   Mitsuba 3   scene.xml, sigma_t.vol    a heterogeneous medium: its media emit nothing yet, so that it absorbs alone
 *
 * The grid is the smallest box of the lattice that holds all points with an extinction or a color, and one round more;
 * both programs interpolate trilinearly between the middles of its cells, which are the points. All names in the files
 * are fixed: what a volume is called stands in comments, with other characters than letters, digits, ".", "_" and
 * blanks left out. */
#ifndef ISO_EXPORT_MEDIA_H
#define ISO_EXPORT_MEDIA_H

#include "bake/bake.h"

typedef struct iso_medium {
    const iso_baked *baked;
    size_t first[3]; /* of the lattice's points */
    /* The grid and the camera, in units: mm, unless the volume is so small or so large that the programs' absolute
     * epsilons would show; then a power of ten of mm that makes it some tens of units across. */
    double units_per_mm;
    char unit[24]; /* the length of a unit, as comments have it */
    iso_geometry geometry;
    iso_camera camera;
    double background[3];  /* light from everywhere beyond it */
    bool camera_is_inside; /* the grid's box */
    const char *made_from; /* without folders; or NULL */
} iso_medium;

/* Borrows b and its view. ISO_E_RANGE: more points than the programs count. */
iso_status iso_medium_create(const iso_baked *b, const char *made_from, iso_medium *out, iso_error *err);

/* A grid point's extinction per unit and color; 0 if it has none. */
void iso_medium_point(const iso_medium *m, size_t x, size_t y, size_t z, float *extinction, float color[3]);

/* What goes into a folder. The first file of each list is the one that the program is given. ISO_E_IO. */
iso_status iso_medium_write_pbrt(const iso_medium *m, const char *folder, iso_error *err);
iso_status iso_medium_write_mitsuba(const iso_medium *m, const char *folder, iso_error *err);

/* "made_from", as a comment of any language may hold it. */
void iso_medium_print_source(const iso_medium *m, FILE *f);
/* Closes f; ISO_E_IO when something of it could not be written. path: for the message. */
iso_status iso_medium_close(FILE *f, const char *path, iso_error *err);
/* Opens folder/name; *path is to be freed. */
iso_status iso_medium_open(const char *folder, const char *name, char **path, FILE **f, iso_error *err);

#endif
