/* SPDX-License-Identifier: MIT */
#include "chart/pareto.h"

#include <math.h>

static bool dominates(double cost_a, double error_a, double cost_b, double error_b)
{
    return cost_a <= cost_b && error_a <= error_b && (cost_a < cost_b || error_a < error_b);
}

void iso_pareto_front(const double *cost, const double *error, size_t count, bool *front)
{
    for (size_t i = 0; i < count; ++i) {
        front[i] = isfinite(cost[i]) && isfinite(error[i]);
        for (size_t j = 0; j < count && front[i]; ++j)
            if (dominates(cost[j], error[j], cost[i], error[i]))
                front[i] = false;
    }
}

size_t iso_pareto_choose(const double *cost, const double *tie, const double *error, size_t count, double limit)
{
    size_t best = count;
    for (size_t i = 0; i < count; ++i) {
        if (!(error[i] <= limit) || !isfinite(cost[i]))
            continue;
        if (best == count || cost[i] < cost[best] || (cost[i] == cost[best] && tie[i] < tie[best]))
            best = i;
    }
    return best;
}
