/* SPDX-License-Identifier: MIT */
/* pareto.h - the Pareto front of settings: those for which no other is both cheaper and more exact.
 *
 * Smaller costs and errors are better. NaN and infinite ones are never on the front and never chosen. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

/* Sets front[i] if no other entry has cost and error at most those of i, and one of them smaller. Equal entries are all
 * on the front. */
void iso_pareto_front(const double *cost, const double *error, size_t count, bool *front);

/* Returns the cheapest entry with error at most `limit`; among equal costs, the smallest tie (e.g. time among equal
 * bytes). Returns count if there is none. */
size_t iso_pareto_choose(const double *cost, const double *tie, const double *error, size_t count, double limit);
