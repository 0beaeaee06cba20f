/* SPDX-License-Identifier: MIT */
/* scene_text.h - the texts of a POV-Ray scene: NAME.inc, NAME.pov, NAME.ini.
 *
 * The volume is built in voxel (index) coordinates and placed by one matrix, which covers anisotropic, rotated and
 * sheared grids. POV-Ray's tolerances are absolute (1e-3 units): if a cutting plane is closer than that to the face
 * through which a ray enters, a piece of the ray is lost, and the pixel is wrong. So world millimeters are scaled to a
 * centered box of ISO_POVRAY_UNITS_ACROSS. At 100 units one pixel in 25600 was lost with 7, 14 or 15 planes, at 10000
 * none. */
#pragma once

#define ISO_POVRAY_UNITS_ACROSS 10000.0

#include <stdio.h>

#include "povray/df3.h"
#include "povray/povray.h"

/* Inputs of the texts. A region of interest has its own, with declared names Iso_Roi_... and files NAME_roi.... */
typedef struct iso_povray_scene {
    const char *name; /* of the files */
    bool is_roi;
    const iso_pyramid_unit *unit;
    char source[256]; /* for comments: one line that cannot end them */
    size_t level;
    const iso_geometry *geometry;            /* of the level, which the container fills */
    const iso_level *voxels;                 /* the level, or part of a finer one for a region of interest */
    double lattice_scale, lattice_offset[3]; /* index in voxels = scale * index in the container - offset */
    const struct iso_povray_scene *roi;      /* data and TF of the region of interest; or NULL */
    const iso_view *view;
    const iso_tf_2d *tf_2d;          /* the view's; NULL for a surface */
    const uint8_t *extinction_scale; /* the view's; NULL for a surface */
    const iso_tf_table *tf;          /* the view's, or the envelope of the 2D one */
    const iso_povray_options *options;
    iso_df3_coding scalar, direction;
    double max_gradient; /* of the stored scalar, per voxel; for the isosurface */
    iso_vec3 center_mm;  /* world to POV-Ray: (world - center) * units_per_mm */
    double units_per_mm;
    double peak_extinction, peak_color; /* of the TF: divisors of its tables; at least 1 for color */
    double peak;                        /* brightest possible pixel */
} iso_povray_scene;

/* Sets the peaks from the TF. */
void iso_povray_measure_peaks(iso_povray_scene *s);

#define ISO_POVRAY_COLOR_MAP_ENTRIES 256

/* True if the TF needs DF3 tables, because it does not fit a color_map or is 2D (row by row): NAME_tf_extinction.df3,
 * or _red, _green and _blue. NAME_second.df3 is the second value. NAME_scale.df3 has the bytes of an extinction scale
 * (fit/extinction_scale.h). */
bool iso_povray_needs_tables(const iso_povray_scene *s, bool color);

/* Passes, declared on the command line. */
typedef enum iso_povray_pass {
    ISO_POVRAY_PICTURE,       /* with the background */
    ISO_POVRAY_EMISSION,      /* times 1 / peak, over black */
    ISO_POVRAY_TRANSMITTANCE, /* no emission, over white */
} iso_povray_pass;

void iso_povray_write_include(FILE *file, const iso_povray_scene *s);
void iso_povray_write_scene(FILE *file, const iso_povray_scene *s);
/* Writes NAME_tf.inc. */
void iso_povray_write_map(FILE *file, const iso_povray_scene *s);
void iso_povray_write_ini(FILE *file, const iso_povray_scene *s);
