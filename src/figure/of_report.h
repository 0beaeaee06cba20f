/* SPDX-License-Identifier: MIT */
/* of_report.h - a figure from a report's own pictures, enlarged by whole numbers.
 *
 *   levels      columns: levels; for each method, under each TF asked for, the
 *               image and, below, its difference from level 0, on one linear scale
 *   renderers   columns: comparisons at one level; both images and their
 *               difference, on one log scale
 * The scale bar holds in the plane through the center of the volume's box; it
 * is left out where the report does not know the size of a pixel.
 *
 * job->methods: "naive,moments,moments+adapted" (iso_report_consistency_name()), in the report's order; NULL: the first and
 * the last under the original TF. job->variant: comparisons whose name holds it; NULL: neither method nor TF. job->look.scene:
 * of a suite's report, the scene's name. */
#ifndef ISO_FIGURE_OF_REPORT_H
#define ISO_FIGURE_OF_REPORT_H

#include <stdbool.h>

#include "figure/job.h"

bool iso_figure_is_of_report(const iso_figure_job *job);
/* ISO_E_FORMAT: no report; ISO_E_RANGE: nothing to show, an unknown method. */
iso_status iso_figure_levels_of_report(const iso_figure_job *job, iso_page *page, iso_error *err);
iso_status iso_figure_renderers_of_report(const iso_figure_job *job, iso_page *page, iso_error *err);

#endif
