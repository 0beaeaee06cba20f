/* SPDX-License-Identifier: MIT */
#include "compare/paired.h"

#include <math.h>
#include <stdlib.h>

#include "compare/statistics.h"

double iso_student_quantile(double confidence, double degrees_of_freedom)
{
    double low = 0, high = 1;
    while (iso_student_two_sided(high, degrees_of_freedom) > 1 - confidence)
        high *= 2;
    for (int i = 0; i < 100; ++i) {
        const double middle = 0.5 * (low + high);
        *(iso_student_two_sided(middle, degrees_of_freedom) > 1 - confidence ? &low : &high) = middle;
    }
    return high;
}

iso_paired iso_paired_compare(const double *a, const double *b, size_t count, double confidence)
{
    double mean = 0, squares = 0;
    for (size_t i = 0; i < count; ++i)
        mean += (a[i] - b[i]) / (double)count;
    for (size_t i = 0; i < count; ++i)
        squares += (a[i] - b[i] - mean) * (a[i] - b[i] - mean);
    if (count < 2)
        return (iso_paired){count == 1 ? mean : NAN, INFINITY};
    const double deviation = sqrt(squares / (double)(count - 1));
    return (iso_paired){mean, iso_student_quantile(confidence, (double)(count - 1)) * deviation / sqrt((double)count)};
}

iso_status iso_paired_of_groups(const double *difference, const size_t *group, size_t count, size_t group_count,
                                double confidence, iso_paired *paired, iso_error *err)
{
    FREED double *sums = calloc(group_count + 1, sizeof *sums);
    FREED size_t *sizes = calloc(group_count + 1, sizeof *sizes);
    double mean = 0, squares = 0;
    size_t used = 0;
    *paired = (iso_paired){NAN, INFINITY};
    NEED_MEMORY(sums && sizes, err, "no memory for %zu groups", group_count);
    for (size_t i = 0; i < count; ++i)
        mean += difference[i] / (double)count;
    for (size_t i = 0; i < count; ++i) {
        sums[group[i]] += difference[i] - mean;
        ++sizes[group[i]];
    }
    for (size_t g = 0; g < group_count; ++g) {
        used += sizes[g] > 0;
        squares += sums[g] * sums[g];
    }
    if (count > 0)
        paired->difference = mean;
    if (used > 1)
        paired->half_width = iso_student_quantile(confidence, (double)(used - 1)) *
                             sqrt((double)used / (double)(used - 1) * squares) / (double)count;
    return ISO_OK;
}

bool iso_paired_is_larger(iso_paired p, double margin)
{
    return !(p.difference <= margin) && !(p.difference <= p.half_width);
}
