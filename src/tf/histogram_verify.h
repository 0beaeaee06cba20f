/* SPDX-License-Identifier: MIT */
/* histogram_verify.h - are the joint histograms beside a pyramid's levels those of its levels?
 *
 * `tf adapt` and what adapts keep them in the pyramid's folder and read them instead of counting again (histogram.h). They
 * have no checksum, and a count that sums up to level 0's voxels is believed. Counts are integers that neither threads nor
 * slabs change, so each file is counted again from the levels, and compared bin by bin. */
#ifndef ISO_TF_HISTOGRAM_VERIFY_H
#define ISO_TF_HISTOGRAM_VERIFY_H

#include "tf/histogram.h"

typedef struct iso_joint_check {
    iso_joint_key key;
    uint64_t voxels, differing; /* differing: counted in another bin than the levels have them */
    iso_error unreadable;       /* why it is none of this pyramid's at all; or "" */
} iso_joint_check;

/* Counts again all histograms that lie in the pyramid's folder `dir`, level by level. *checks: to be freed, *count of
 * them, in the order of levels, bits and second values. p: with samples. ISO_OK when all were compared, whatever was found;
 * ISO_E_MEMORY. */
iso_status iso_joint_verify(const iso_pyramid *p, const char *dir, int threads, iso_joint_check **checks, size_t *count,
                            const iso_progress *progress, iso_error *err);

bool iso_joint_check_is_good(const iso_joint_check *check);
/* For people: "level 1: its joint histogram of 8 bits counts 160 of 600 voxels in other bins than the levels have them".
 * Returns text, which is cut where it is too long. */
const char *iso_joint_check_text(const iso_joint_check *check, char *text, size_t size);

#endif
