/* SPDX-License-Identifier: MIT */
/* difference.h - differences between two reports.
 *
 * Rows are matched by name: scene, level, renderer and comparison; renderer and check; level; level and method. A row
 * has changed if
 *  - its verdict changed, or the reason for which it is not compared or refused;
 *  - it appeared or disappeared;
 *  - a stated limit changed, or the limit of a gate by more than a tenth (limits of gates are estimates);
 *  - a figure with a limit moved by more than its tolerance.
 *
 * Tolerance of a metric: a hundredth of its limit, at least 1e-7, the rounding of floats. With noise it is at least 1.5
 * times the noise of both rows: two pictures with noise n differ by n sqrt(2), and no RMSE to a third picture can move
 * by more. Tolerance of gates and calibrations: a tenth of their limit, which is how much reports vary; of gates of
 * rows with noise: half of it. Tolerance of levels: the visible margin, and a tenth of a degree.
 *
 * Versions, options and the limits of scenes are facts. They count as a difference unless only results are compared.
 * The machine is shown and does not count. Dates, commands and durations are not compared.
 *
 * The later report B is worse if a verdict is less certain than in A (in this order: agree or pass, not compared,
 * refused, differ or fail), if a figure or a limit grew or became NaN, or if a row disappeared: report diff --worse.
 *
 * A picture of both reports differs if any bit does. It counts if the RMSE between the two is above the tolerance of
 * its row's RMSE. */
#pragma once

#include "report/sections.h"

/* Compares two reports. *difference is new: rows and facts with keys as in doc/reference/files-report.md, without
 * pictures. Tolerances are multiplied by factor. ISO_E_FORMAT: a or b is not a report. */
iso_status iso_difference_of(const json_t *a, const json_t *b, bool results_only, double factor, json_t **difference,
                             iso_error *err);

/* Counts the changes for the worse in B. */
size_t iso_difference_count_worse(const json_t *difference);

/* Makes a baseline of a report: its rows and facts alone. ISO_E_FORMAT: it has no rows. */
iso_status iso_difference_accept(const json_t *report, json_t **accepted, iso_error *err);

/* Adds "pictures", and to inlined, if it is not NULL, the images of differing pictures for the page. An unreadable
 * picture is an error, with the reader's status. */
iso_status iso_difference_add_pictures(json_t *difference, const iso_report_source *a, const iso_report_source *b,
                                       json_t *inlined, iso_error *err);

/* Adds "verdict" ("agree" if there are no differences, otherwise "differ") and "sentence". This is the last step. */
void iso_difference_conclude(json_t *difference);

/* Writes DIR/index.html and DIR/difference.json; an existing DIR is replaced only if it has a difference.json. */
iso_status iso_difference_write(const char *dir, const json_t *difference, const json_t *inlined, iso_error *err);

/* The RMSE by which a picture of two rows may differ, and the reason. */
typedef struct iso_tolerance {
    double value;
    const char *why;
} iso_tolerance;
iso_tolerance iso_difference_tolerance(const json_t *row_a, const json_t *row_b, const char *metric);
