/* SPDX-License-Identifier: MIT */
/* baseline.h - is a validation still as good as the one that was accepted?
 *
 * A baseline holds the verdict and the figures of each row of a report - agreement
 * with its error bar, its limits and its gates, levels, consistency, and calibrations - under
 * the row's name, sorted and with 4 digits, so that a change of one figure is a
 * change of one line. A later report is worse where a verdict says less than before
 * (the order is: agree or pass, reported, refused, differ or fail), where a figure or a
 * limit grew beyond factor times the accepted one plus a floor, and where a row or a
 * figure is missing or is no longer a number. The value of a gate is kept in parts of its
 * limit, with a floor of a tenth. Better or additional figures are no failure; nor are
 * other versions or options, but they are listed. A baseline changes only when someone
 * asks for it.
 *
 *   { "schema": "isoshade.accepted/2", "command": the report's, "options": its, "versions": its,
 *     "rows": {"agreement/shells/level 0/reference/gl/lock-step": {"verdict": "agree", "rmse": 6.1e-7, ...}, ...} } */
#ifndef ISO_REPORT_BASELINE_H
#define ISO_REPORT_BASELINE_H

#include "base/json.h"

#define ISO_BASELINE_SCHEMA "isoshade.accepted/2"

/* The rows of a report.json; new. ISO_E_FORMAT: no report; ISO_E_RANGE: no figure in it, or two rows of one name. */
iso_status iso_baseline_from_report(const json_t *report, json_t **baseline, iso_error *err);

typedef struct iso_baseline_result {
    size_t same, better, worse, missing, added; /* figures, verdicts among them */
    json_t *
        changes; /* [{figure, accepted, now, change: "worse" | "better" | "missing" | "new"}], the worse first; owned */
    json_t *facts; /* [{fact, accepted, now}]: versions and options that are others; owned */
} iso_baseline_result;

/* Figures and verdicts of all its rows; 0: nothing would be compared. */
size_t iso_baseline_figure_count(const json_t *baseline);

/* better: below the accepted figure divided by factor, less floor. ISO_E_FORMAT: no baseline; ISO_E_RANGE: factor
 * below 1, floor negative. */
iso_status iso_baseline_compare(const json_t *now, const json_t *accepted, double factor, double floor,
                                iso_baseline_result *result, iso_error *err);
void iso_baseline_result_destroy(iso_baseline_result *result);

#endif
