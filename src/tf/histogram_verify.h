/* SPDX-License-Identifier: MIT */
/* histogram_verify.h - check that the joint histograms in a pyramid's folder belong to its levels.
 *
 * `tf adapt` and others keep joint histograms in the pyramid's folder and read them instead of counting again
 * (histogram.h). They have no checksum; a load accepts any counts that add up to level 0's voxels. Counts are integers
 * that do not depend on threads or slabs, so each file is counted again from the levels and compared bin by bin. */
#pragma once

#include "tf/histogram.h"

typedef struct iso_joint_check {
    iso_joint_key key;
    uint64_t voxels, differing; /* differing: counted in other bins than in the levels */
    iso_error unreadable;       /* reason why the file does not fit the pyramid; or "" */
} iso_joint_check;

/* Recounts all histograms in the pyramid's folder `dir`. *checks: to be freed, *count of them, ordered by level, bits
 * and second value. p needs samples. ISO_OK if all were compared, whether or not they differ; ISO_E_MEMORY. */
iso_status iso_joint_verify(const iso_pyramid *p, const char *dir, int threads, iso_joint_check **checks, size_t *count,
                            const iso_progress *progress, iso_error *err);

bool iso_joint_check_is_good(const iso_joint_check *check);
/* Writes "level 1: its joint histogram of 8 bits counts 160 of 600 voxels in other bins than its levels" into text, cut
 * to size, and returns it. */
const char *iso_joint_check_text(const iso_joint_check *check, char *text, size_t size);
