/* SPDX-License-Identifier: MIT */
/* levels.h - figures that compare levels, renderers or methods side by side, in the scene's view and aspect. */
#pragma once

#include "figure/job.h"

extern const iso_figure_info iso_figure_levels, iso_figure_renderers, iso_figure_methods;

/* Returns a method of directions in words; other names unchanged. */
const char *iso_figure_method_words(const char *name);
