/* SPDX-License-Identifier: MIT */
/* kinds_of_volume.h - kinds of figures of one volume; levels.h has those that compare. */
#pragma once

#include "figure/job.h"

extern const iso_figure_info iso_figure_tf;        /* transfer.c */
extern const iso_figure_info iso_figure_contact;   /* contact.c */
extern const iso_figure_info iso_figure_slices;    /* slices.c */
extern const iso_figure_info iso_figure_turntable; /* turntable.c */
extern const iso_figure_info iso_figure_plan;      /* planned.c */
extern const iso_figure_info iso_figure_grid;      /* grid.c */
extern const iso_figure_info iso_figure_failure;   /* failure.c; has its own volume */
extern const iso_figure_info iso_figure_chart;     /* charted.c; of a chart */
