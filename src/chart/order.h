/* SPDX-License-Identifier: MIT */
/* order.h - which setting of a chart is tried next, so that wherever a budget ends the front is there.
 *
 * The grid's order (chart/grid.h) is kept, but for settings that what was measured says cannot matter; these come last:
 *   at the floor   two coarser steps of the same setting had nearly the same error, which is then the level's, and no
 *                  finer step gets below it;
 *   beaten         a setting of the same scene is as fast as this one is foreseen to be, and is below the floor that the
 *                  coarser steps of this one tell.
 * Nothing here looks at a clock, so the order is a function of what was measured. */
#ifndef ISO_CHART_ORDER_H
#define ISO_CHART_ORDER_H

#include "chart/grid.h"

/* What is known of a setting before it is tried, and of one that was. */
typedef struct iso_chart_outlook {
    double (*error)(const void *user, const iso_chart_case *c);         /* of one that is done */
    double (*frame_seconds)(const void *user, const iso_chart_case *c); /* as foreseen; NaN: nothing is known */
    bool (*is_open)(const void *user, const iso_chart_case *c);         /* it may still be tried, and there is time */
    const void *user;
} iso_chart_outlook;

/* Is the setting as likely as not to lie on a front? */
bool iso_chart_matters(const iso_chart_case *cases, size_t count, const iso_chart_case *c,
                       const iso_chart_outlook *outlook);

/* The first open setting that is not done and matters, or the first that does not; count: none is open. Marks those that
 * are put off. */
size_t iso_chart_next(iso_chart_case *cases, size_t count, const iso_chart_outlook *outlook);

#endif
