/* SPDX-License-Identifier: MIT */
/* pareto.h - the Pareto front of settings: those for which no other is both cheaper and more exact.
 *
 * Cost and error are both better when smaller. Costs or errors that are NaN or
 * infinite are never on the front and never chosen. */
#ifndef ISO_CHART_PARETO_H
#define ISO_CHART_PARETO_H

#include <stdbool.h>
#include <stddef.h>

/* front[i]: no other has cost and error at most those of i, and one of them smaller. Of equals, all are on it. */
void iso_pareto_front(const double *cost, const double *error, size_t count, bool *front);

/* The cheapest with error at most limit; of equal costs the one with the smaller tie (time among equal bytes,
 * say). count when there is none. */
size_t iso_pareto_choose(const double *cost, const double *tie, const double *error, size_t count, double limit);

#endif
