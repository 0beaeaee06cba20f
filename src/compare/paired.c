/* SPDX-License-Identifier: MIT */
#include "compare/paired.h"

#include <math.h>

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

bool iso_paired_is_larger(iso_paired p, double margin)
{
    return !(p.difference <= margin) && !(p.difference <= p.half_width);
}
