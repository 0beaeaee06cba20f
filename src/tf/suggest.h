/* SPDX-License-Identifier: MIT */
/* suggest.h - a transfer function for a volume that nobody has looked at yet.
 *
 * From the joint histogram of value and gradient magnitude (survey.h): what the faces of the box show is background and
 * stays invisible; materials are peaks of flat voxels, and a material begins where the arch from what is before it rises.
 * Of several materials the last one is opaque and those before it are a veil. Values on both sides of the background, as
 * an orbital or a difference has them, get a color a side; darker values than the background's are treated as brighter
 * ones, mirrored. Without a background only the surface in the middle of the steepest arch is shown, as a thin shell.
 * At most ISO_SUGGEST_POINTS points, in the volume's own values: to be edited. A label map has a plateau a label instead, in
 * the color of its segment where the file names one.
 *
 * The same volume gives the same points, whatever the number of threads. */
#ifndef ISO_TF_SUGGEST_H
#define ISO_TF_SUGGEST_H

#include "tf/survey.h"
#include "tf/tf.h"

enum { ISO_SUGGEST_POINTS = 8, ISO_SUGGEST_MATERIALS = 3 };

typedef enum iso_suggest_kind {
    ISO_SUGGEST_OBJECT, /* brighter than the background */
    ISO_SUGGEST_DARK,   /* darker than it */
    ISO_SUGGEST_SIGNED, /* both */
    ISO_SUGGEST_SHELL,  /* no background: the steepest isosurface */
    ISO_SUGGEST_LABELS, /* a label map */
    ISO_SUGGEST_FLAT    /* one value */
} iso_suggest_kind;
const char *iso_suggest_kind_text(iso_suggest_kind kind);

typedef struct iso_suggestion {
    iso_suggest_kind kind;
    iso_tf tf;
    size_t material_count;
    struct iso_suggest_material {
        double begins;  /* the value at which its surface is */
        double peak;    /* its most frequent value */
        double part;    /* of the volume's voxels */
        double opacity; /* over the transfer function's unit distance */
    } materials[ISO_SUGGEST_MATERIALS];
} iso_suggestion;

/* ISO_E_MEMORY; ISO_E_RANGE: labels that are too far apart for one entry each. */
iso_status iso_suggest(const iso_survey *survey, const iso_geometry *level0, iso_suggestion *suggestion,
                       iso_error *err);
void iso_suggestion_destroy(iso_suggestion *suggestion);

#endif
