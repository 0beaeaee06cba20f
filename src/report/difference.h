/* SPDX-License-Identifier: MIT */
/* difference.h - what changed between two reports.
 *
 * Rows are matched by what they are of: scene, level, renderer and comparison; renderer and check; level; level and way.
 * A row has changed where
 *  - its verdict is another one, or the reason for which it is not compared or refused;
 *  - it appeared, or disappeared;
 *  - what is asked of it changed: a stated limit, or of a gate by more than a tenth (gates' limits are estimates);
 *  - a figure that it is held to moved by more than its tolerance.
 * Tolerances are the rows' own. Of a metric: a hundredth of its limit; where a renderer has noise, 1.5 times the noise of
 * both rows together, for two pictures with noise n differ by n sqrt(2), and no RMSE to a third picture can move by more
 * than that; and never less than 1e-7, the rounding of floats. Of gates and calibrations a tenth of their limit, as
 * reports vary by that; of gates of rows with noise half of it. Of levels the margin below which nobody sees a difference,
 * and of angles a tenth of a degree.
 *
 * Versions, options and what scenes ask for are facts; they count as a difference unless only results are asked for. The
 * machine is told and does not count. When something was made, by which command and how long it took is no difference.
 *
 * The later report B is worse where a verdict says less than in A (the order is: agree or pass, not compared, refused, differ or
 * fail), where a figure or a limit grew or is no number any more, and where a row is gone: isoshade baseline.
 *
 * A picture of both reports differs where a bit of it does, and counts where its RMSE to the other is above the tolerance
 * of its row's RMSE. */
#ifndef ISO_REPORT_DIFFERENCE_H
#define ISO_REPORT_DIFFERENCE_H

#include "base/json.h"

typedef struct iso_difference_source {
    const char *dir;    /* that the pictures are in; or NULL */
    const json_t *root; /* report.json */
} iso_difference_source;

/* The rows and the facts, new: keys as in doc/reference/files-report.md, but for the pictures. Tolerances are multiplied by factor.
 * ISO_E_FORMAT: no report. */
iso_status iso_difference_of(const json_t *a, const json_t *b, bool results_only, double factor, json_t **difference,
                             iso_error *err);

/* Counts what of B is worse than A. */
size_t iso_difference_count_worse(const json_t *difference);

/* Makes the report that is kept to compare later ones with: its rows and facts alone. ISO_E_FORMAT: it has no rows. */
iso_status iso_difference_accept(const json_t *report, json_t **accepted, iso_error *err);

/* Adds "pictures", and to inlined, where it is not NULL, what the page shows of those that differ. A picture that is there
 * and cannot be read is an error, with the reader's status. */
iso_status iso_difference_add_pictures(json_t *difference, const iso_difference_source *a,
                                       const iso_difference_source *b, json_t *inlined, iso_error *err);

/* Adds "verdict" ("agree" where there is no difference, else "differ") and "sentence": the last step. */
void iso_difference_conclude(json_t *difference);

/* DIR/index.html and DIR/difference.json; an existing DIR is replaced only if it holds a difference.json. */
iso_status iso_difference_write(const char *dir, const json_t *difference, const json_t *inlined, iso_error *err);

/* The RMSE by which a picture of two rows may differ, and why. */
typedef struct iso_tolerance {
    double value;
    const char *why;
} iso_tolerance;
iso_tolerance iso_difference_tolerance(const json_t *row_a, const json_t *row_b, const char *metric);

#endif
