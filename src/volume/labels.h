/* SPDX-License-Identifier: MIT */
/* labels.h - decides whether integers are labels (a segmentation) or intensities.
 *
 * Labels are names: there is no 4 between 2 and 6, so they must not be interpolated. Few files say which of the two
 * they have, but the samples show it. Intensities pass through values in between from one region to the next, because
 * the scanner's or the grid's resolution blurs borders, and noise changes them from voxel to voxel. Labels change in
 * one step, to a name that is the next number only by chance. So for three samples in a row along an axis, with at
 * least one change:
 * - few labels change twice (noise, or the slope of a blurred border): at most MAX_TWICE of them;
 * - few changes of labels go to the next value that the volume has (the slope of a smooth field): at most MAX_NEXT.
 * Labels are few: 3 to MAX_COUNT values, with MIN_VOXELS voxels each on average. Two values are never labels by this
 * rule, as no third value between them could be wrong. The rule takes labels that are nested by their numbers, or
 * mostly one voxel thin, for intensities; then the user decides (--labels, --no-labels). */
#pragma once

#include <jansson.h>

#include "volume/stream.h"

enum { ISO_LABELS_MAX_COUNT = 2048, ISO_LABELS_MIN_VOXELS = 32, ISO_LABELS_MIN_COUNT = 3 };
#define ISO_LABELS_MAX_TWICE 0.25
#define ISO_LABELS_MAX_NEXT 0.75

typedef struct iso_label_facts {
    size_t count;              /* number of different values, at most ISO_LABELS_MAX_COUNT + 1 */
    double twice, next;        /* parts as above; 0 if nothing changes */
    bool is_map, has_too_many; /* is_map: by this rule; has_too_many: more values than ISO_LABELS_MAX_COUNT */
    bool is_far, is_sparse;    /* True if some values are beyond -32768 to 65535; or too far apart for a transfer
                                * function */
    double value[ISO_LABELS_MAX_COUNT + 1]; /* the values, ascending */
} iso_label_facts;

/* Reads as many planes as needed for a decision, or all; none if the type is not an integer. The source may be closed
 * then. */
iso_status iso_labels_look(iso_volume_source *source, bool all, iso_label_facts *facts, iso_error *err);
/* Does the same for a volume in memory. */
iso_status iso_labels_look_at(const iso_volume *v, bool all, iso_label_facts *facts, iso_error *err);

/* Returns the names of sparse labels by their numbers, as segments.h has them, with their values as "id": those of
 * `given`, which has names by values and may be NULL, or the values in digits. A new array. */
json_t *iso_labels_names(const iso_label_facts *facts, const json_t *given);
/* Replaces values by consecutive numbers of 16 bits, in their order; 0 stays 0. v has the values of the facts alone,
 * whose type has 16 bits or more. Its segments become those of iso_labels_names(). */
void iso_labels_number(iso_volume *v, const iso_label_facts *facts);
