/* baseline.h - is a validation still as good as the one that was accepted?
 *
 * A baseline holds the figures of a report, each under a name. A later report
 * is worse where a figure grew beyond factor times the accepted one, plus a
 * floor; or where a figure is missing or no number any more. Being better or
 * having more is no failure. A baseline changes only when someone asks for it.
 *
 *   { "schema": "isoshade.accepted/1", "command": the report's,
 *     "figures": {"agreement/shells/level 0/reference/gl/lock-step/rmse": 6e-7, ...} } */
#ifndef ISO_BASELINE_H
#define ISO_BASELINE_H

#include "base/json.h"

/* The figures of a report.json; new. ISO_E_FORMAT: no report; ISO_E_RANGE: no figure in it, or two of one name. */
iso_status iso_baseline_from_report(const json_t *report, json_t **baseline, iso_error *err);

typedef struct iso_baseline_result {
    size_t same, better, worse, missing, added;
    json_t *changes; /* [{figure, accepted, now, change: "worse" | "better" | "missing" | "new"}], the worse first; owned */
} iso_baseline_result;

/* better: below the accepted figure divided by factor, less floor. ISO_E_FORMAT: no baseline; ISO_E_RANGE: factor
 * below 1, floor negative. */
iso_status iso_baseline_compare(const json_t *now, const json_t *accepted, double factor, double floor,
                                iso_baseline_result *result, iso_error *err);

#endif
