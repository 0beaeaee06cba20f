/* SPDX-License-Identifier: MIT */
/* paper_kinds.h - figures of the four papers that isoshade implements, as kinds of figures (job.h), drawn from the
 * program's own data. doc/results/paper-figures.md shows each. */
#pragma once

#include "figure/job.h"
#include "pyramid/pyramid.h"

/* [diaz-garcia-2017], Figures 6, 8, 11 and 13; the dots of any code. */
extern const iso_figure_info iso_figure_code_points, iso_figure_code_regions, iso_figure_code_spheres,
    iso_figure_code_table, iso_figure_code_dots;
/* [diaz-garcia-2016], Figures 3 and 2. */
extern const iso_figure_info iso_figure_joint_histogram, iso_figure_joint_row;
/* [beyer-2008], Figures 8 and 9. */
extern const iso_figure_info iso_figure_mixed_volume, iso_figure_mixed_surface;
/* [bremer-2001], Figures 10 to 15. */
extern const iso_figure_info iso_figure_palette_views;

/* Bricks of alternating levels; a region of interest. */
extern const iso_figure_info iso_figure_seams, iso_figure_region;

/* Options that a kind takes (figure/job.h). */
enum {
    ISO_LAB_FIGURE_HAS_CODE = ISO_FIGURE_HAS_MORE,
    ISO_LAB_FIGURE_HAS_BITS = ISO_FIGURE_HAS_MORE << 1,
    ISO_LAB_FIGURE_HAS_BRICKS = ISO_FIGURE_HAS_MORE << 2,
    ISO_LAB_FIGURE_HAS_ENTRIES = ISO_FIGURE_HAS_MORE << 3,
    ISO_LAB_FIGURE_HAS_SURFACE = ISO_FIGURE_HAS_MORE << 4,
    ISO_LAB_FIGURE_HAS_REGION = ISO_FIGURE_HAS_MORE << 5,
};

/* Options of these kinds, in addition to those of all figures. If not given, texts are NULL and numbers 0. */
typedef struct iso_lab_figure_options {
    char *code, *region; /* region: a box, as --roi has it */
    int bits, bricks, entries;
    double surface; /* NaN: not given */
} iso_lab_figure_options;
const iso_lab_figure_options *iso_lab_figure_of(const iso_figure_job *job);

/* Sets *value to the value of --surface, 1/2 of the range by default. ISO_E_RANGE: not between 0 and 1. */
iso_status iso_paper_surface(const iso_figure_job *job, const iso_level *level0, double *value, iso_error *err);
