/* SPDX-License-Identifier: MIT */
/* kinds.h - the kinds of figures (figure/job.h), one file each. */
#pragma once

#include <stdbool.h>

#include "figure/job.h"

extern const iso_figure_info iso_figure_tf;        /* transfer.c */
extern const iso_figure_info iso_figure_contact;   /* contact.c */
extern const iso_figure_info iso_figure_slices;    /* slices.c */
extern const iso_figure_info iso_figure_turntable; /* turntable.c */
extern const iso_figure_info iso_figure_plan;      /* planned.c */
extern const iso_figure_info iso_figure_grid;      /* grid.c */
extern const iso_figure_info iso_figure_failure;   /* failure.c; has its own volume */
extern const iso_figure_info iso_figure_chart;     /* charted.c; of a chart */
/* levels.c: side by side, in the scene's view and aspect */
extern const iso_figure_info iso_figure_levels, iso_figure_renderers, iso_figure_methods;

/* Returns a method of directions in words; other names unchanged. */
const char *iso_figure_method_words(const char *name);

bool iso_figure_is_of_report(const iso_figure_job *job);
/* Draws a report (of_report.c). ISO_E_FORMAT: not a report; ISO_E_RANGE: nothing to show, or an unknown method. */
iso_status iso_figure_draw_report(const iso_figure_job *job, bool of_levels, iso_page *page, iso_error *err);
