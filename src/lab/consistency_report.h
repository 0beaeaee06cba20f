/* SPDX-License-Identifier: MIT */
/* consistency_report.h - what the cases of `isoshade-lab consistency` come to. */
#ifndef ISO_LAB_CONSISTENCY_REPORT_H
#define ISO_LAB_CONSISTENCY_REPORT_H

#include <stdbool.h>

#include "base/json.h"

/* Errors above the original's that count as worse, of 1 - SSIM. */
#define ISO_CONSISTENCY_WORSE 0.005

/* cases: an object for each method of a case, that of the "original" TF first, with "renderer", "held", "level", "method",
 * "ssim_dissimilarity", "flip_mean", "rmse" and "left_out", null where the case counts.
 * The blocks, one for each renderer, of what was held back or not: means and medians of error / error of the original TF,
 * by level (0: all levels) and method, how often a method is behind the original, and the cases left out, by reason.
 * print: as tables as well. */
json_t *iso_consistency_report(const json_t *cases, bool print);

#endif
