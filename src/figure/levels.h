/* SPDX-License-Identifier: MIT */
/* levels.h - levels, renderers or methods of a volume side by side, in the scene's own view and aspect. */
#ifndef ISO_FIGURE_LEVELS_H
#define ISO_FIGURE_LEVELS_H

#include "figure/job.h"

extern const iso_figure_info iso_figure_levels, iso_figure_renderers, iso_figure_methods;

/* A way to make directions in words; the name itself where it is none of --kind methods. */
const char *iso_figure_method_words(const char *name);

#endif
