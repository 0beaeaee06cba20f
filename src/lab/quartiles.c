/* SPDX-License-Identifier: MIT */
#include "lab/quartiles.h"

#include <math.h>
#include <stdlib.h>

#include "base/order.h"

static double quantile(const double *ordered, size_t count, double part)
{
    const double at = part * (double)(count - 1);
    const size_t below = (size_t)at, above = below + 1 < count ? below + 1 : below;
    return ordered[below] + (at - (double)below) * (ordered[above] - ordered[below]);
}

iso_ratios iso_ratios_summarize(double *ratios, size_t count)
{
    iso_ratios s = {count, NAN, NAN, NAN, NAN};
    double log_sum = 0;
    if (count == 0)
        return s;
    qsort(ratios, count, sizeof *ratios, iso_order_doubles);
    for (size_t i = 0; i < count; ++i)
        log_sum += log(ratios[i]);
    s.geometric_mean = exp(log_sum / (double)count);
    s.median = quantile(ratios, count, 0.5);
    s.lower = quantile(ratios, count, 0.25);
    s.upper = quantile(ratios, count, 0.75);
    return s;
}
