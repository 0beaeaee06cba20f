/* SPDX-License-Identifier: MIT */
/* suggest.h - a suggested transfer function for an unknown volume.
 *
 * It is derived from the joint histogram of value and gradient magnitude (survey.h). The values on the faces of the box
 * are the background and stay invisible. Materials are peaks of flat voxels; a material begins at the value at which
 * the arch from its predecessor rises. Of several materials the last one is opaque and the others are veils. If there
 * are values on both sides of the background, as in an orbital or a difference, each side gets its color; a dark object
 * is treated as a bright one, mirrored. Without a background only the surface in the middle of the steepest arch is
 * shown, as a thin shell. A label map has a plateau per label instead, in its segment's color if the file names one. At
 * most ISO_SUGGEST_POINTS points, in the volume's own values, so that they can be edited. Results do not depend on the
 * number of threads. */
#pragma once

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
        double begins;  /* value of its surface */
        double peak;    /* most frequent value */
        double part;    /* of the volume's voxels */
        double opacity; /* over the transfer function's unit distance */
    } materials[ISO_SUGGEST_MATERIALS];
} iso_suggestion;

/* Creates a suggestion. ISO_E_MEMORY; ISO_E_RANGE: labels too far apart for one entry each. */
iso_status iso_suggest(const iso_survey *survey, const iso_geometry *level0, iso_suggestion *suggestion,
                       iso_error *err);
void iso_suggestion_destroy(iso_suggestion *suggestion);
