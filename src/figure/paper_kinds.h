/* SPDX-License-Identifier: MIT */
/* paper_kinds.h - the figures of the four papers that isoshade follows, as kinds of figures (job.h), from its own
 * program's data. doc/paper-figures.md has a picture of each. */
#ifndef ISO_FIGURE_PAPER_KINDS_H
#define ISO_FIGURE_PAPER_KINDS_H

#include "figure/job.h"

/* Levels and renderers, as papers begin: README's first picture. */
extern const iso_figure_info iso_figure_grid;
/* [diaz-garcia-2017], Figures 6, 8, 11 and 13; the dots of any code. */
extern const iso_figure_info iso_figure_code_points, iso_figure_code_regions, iso_figure_code_spheres,
    iso_figure_code_table, iso_figure_code_dots;
/* [diaz-garcia-2016], Figures 3 and 2. */
extern const iso_figure_info iso_figure_joint_histogram, iso_figure_joint_row;
/* [beyer-2008], Figures 8 and 9. */
extern const iso_figure_info iso_figure_mixed_volume, iso_figure_mixed_surface;
/* [bremer-2001], Figures 10 to 15. */
extern const iso_figure_info iso_figure_palette_views;

#endif
