/* SPDX-License-Identifier: MIT */
/* consistency_report.h - summary of the cases of `isoshade-lab consistency`. */
#pragma once

#include <stdbool.h>

#include "base/json.h"

/* Excess of 1 - SSIM over the original's that counts as worse. */
#define ISO_CONSISTENCY_WORSE 0.005

/* Summarizes cases. Each is an object per method, the "original" TF's first, with "renderer", "held", "level",
 * "method", "ssim_dissimilarity", "flip_mean", "rmse" and "left_out" (null if the case counts). Returns a block per
 * renderer and value of "held", with means and medians of error / error of the original TF by level (0: all levels) and
 * method, the number of cases worse than the original, and the cases left out by reason. print: also prints tables. */
json_t *iso_consistency_report(const json_t *cases, bool print);
