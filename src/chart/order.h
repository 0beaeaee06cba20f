/* SPDX-License-Identifier: MIT */
/* order.h - chooses the next setting of a chart, so that the front is complete whenever the budget ends.
 *
 * Settings come in the order of the grid (chart/grid.h), except those that cannot matter; these come last:
 *   at the floor   two coarser steps of the same setting had nearly the same error: the error of the level, which
 *                  no finer step reduces
 *   beaten         another setting of the scene is as fast as this one is estimated to be, and its error is below
 *                  the floor that the coarser steps of this one predict
 * The order depends on the measurements alone, never on a clock. */
#pragma once

#include "chart/grid.h"

/* Measurements and estimates of settings. */
typedef struct iso_chart_outlook {
    double (*error)(const void *user, const iso_chart_case *c);         /* of a measured setting */
    double (*frame_seconds)(const void *user, const iso_chart_case *c); /* estimate; NaN: unknown */
    bool (*is_open)(const void *user, const iso_chart_case *c);         /* True if it may still be tried, and there is
                                                                         * time */
    const void *user;
} iso_chart_outlook;

/* Returns the first open setting that matters, or if none does the first open one; count if none is open. Marks
 * deferred settings as put_off. */
size_t iso_chart_next(iso_chart_case *cases, size_t count, const iso_chart_outlook *outlook);
