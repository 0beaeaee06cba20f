/* SPDX-License-Identifier: MIT */
/* labels.h - whether integers are labels (a segmentation) or intensities.
 *
 * Labels are names: between 2 and 6 there is no 4, so they must not be interpolated. A file seldom says which it has;
 * the samples do. Where an intensity goes from one region to the next it takes on values between, since the scanner's or
 * the grid's resolution blurs the border, and noise changes it from voxel to voxel. A label goes from one region to the
 * next in one step, to a name that is next to it only by chance. So of three samples in a row along an axis, of which at
 * least one differs from its neighbor,
 *   - few of labels change twice (noise, or the slope of a blurred border): at most MAX_TWICE of them;
 *   - and few of labels' changes are to the next value that the volume has (the slow slope of a smooth field): at most
 *     MAX_NEXT of them.
 * Labels are few: 3 to MAX_COUNT values, and MIN_VOXELS voxels each on average. Two values are no labels by this rule:
 * between them lies no third one that would be wrong. What it cannot tell is said by hand (--labels, --no-labels): labels
 * nested by their numbers, or mostly one voxel thin, are taken for intensities, which is what they were before. */
#ifndef ISO_VOLUME_LABELS_H
#define ISO_VOLUME_LABELS_H

#include "volume/stream.h"

enum { ISO_LABELS_MAX_COUNT = 512, ISO_LABELS_MIN_VOXELS = 32, ISO_LABELS_MIN_COUNT = 3 };
#define ISO_LABELS_MAX_TWICE 0.25
#define ISO_LABELS_MAX_NEXT 0.75

typedef struct iso_label_facts {
    size_t count;              /* values that there are, at most ISO_LABELS_MAX_COUNT + 1 */
    double twice, next;        /* parts as above; 0 if nothing changes */
    bool is_map, has_too_many; /* by this rule; more values than ISO_LABELS_MAX_COUNT, or too large ones */
} iso_label_facts;

/* Reads as many planes as needed for a decision, or all that count; none of types that are not integers. The source
 * may be closed then. */
iso_status iso_labels_look(iso_volume_source *source, bool all, iso_label_facts *facts, iso_error *err);
/* The same of a volume in memory. */
iso_status iso_labels_look_at(const iso_volume *v, bool all, iso_label_facts *facts, iso_error *err);

#endif
