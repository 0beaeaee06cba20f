/* SPDX-License-Identifier: MIT */
/* of_report.h - a figure from a report's own pictures, enlarged by whole numbers.
 *
 *   levels      columns: levels; for each method, under each chosen TF, the
 *               image and, below, its difference from level 0, on one linear scale
 *   renderers   columns: comparisons at one level; both images and their
 *               difference, on one log scale
 * The scale bar applies to the plane through the center of the volume's box. It
 * is omitted if the report does not have the size of a pixel.
 *
 * job->methods: "naive,moments,moments+adapted" (iso_report_consistency_name()), in the report's order; NULL: the first
 * and the last under the original TF. job->variant: comparisons whose name contains it; NULL: those without method and
 * TF. job->look.scene: name of a scene in the report of a suite. */
#pragma once

#include <stdbool.h>

#include "figure/job.h"

bool iso_figure_is_of_report(const iso_figure_job *job);
/* Draws a report. ISO_E_FORMAT: not a report; ISO_E_RANGE: nothing to show, or an unknown method. */
iso_status iso_figure_levels_of_report(const iso_figure_job *job, iso_page *page, iso_error *err);
iso_status iso_figure_renderers_of_report(const iso_figure_job *job, iso_page *page, iso_error *err);
