/* SPDX-License-Identifier: MIT */
/* paired.h - tests if one method is worse than another by more than the scatter over the views.
 *
 * Both are measured in the same views, so that a view that is hard for both cancels. The result is the mean of the
 * differences view by view, and an interval that holds the mean over all views with a given confidence. The interval
 * is by Student's t with count - 1 degrees of freedom. Few views have wide intervals: at 95 % half the width is 2.48
 * standard deviations of the differences for 3 views, 1.05 for 6 and .47 for 20. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

typedef struct iso_paired {
    double difference, half_width; /* a - b; infinite of one pair */
} iso_paired;

iso_paired iso_paired_compare(const double *a, const double *b, size_t count, double confidence);
/* Averages differences that scatter together within groups, such as those of neighboring voxels: only the groups count
 * as independent. The variance is the cluster-robust one, n / (n - 1) sum over n groups of (sum of d - mean)^2 /
 * count^2, with n - 1 degrees of freedom. group[i] < group_count is that of difference[i]. Infinite for one group;
 * ISO_E_MEMORY. */
iso_status iso_paired_of_groups(const double *difference, const size_t *group, size_t count, size_t group_count,
                                double confidence, iso_paired *paired, iso_error *err);
/* True if a is larger than b by more than the interval and more than the margin. NaN counts as larger. */
bool iso_paired_is_larger(iso_paired p, double margin);

/* Returns t with P(|T| <= t) = confidence. */
double iso_student_quantile(double confidence, double degrees_of_freedom);
