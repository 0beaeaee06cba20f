/* SPDX-License-Identifier: MIT */
/* levels.h - levels or renderers of a volume side by side: rendered for their places in print, as many pixels as the places
 * have dots, in the scene's own view and aspect; below each how far it is from the first one. */
#ifndef ISO_FIGURE_LEVELS_H
#define ISO_FIGURE_LEVELS_H

#include "figure/job.h"

extern const iso_figure_info iso_figure_levels, iso_figure_renderers;

#endif
