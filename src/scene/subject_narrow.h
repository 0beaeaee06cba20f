/* SPDX-License-Identifier: MIT */
/* subject_narrow.h - a narrow pyramid (pyramid/narrow.h) and the view of it, for exports.
 *
 * Level 0 is never there in floats and in directions at once: floats for as long as the view is made, then directions
 * beside the samples as the file has them. 512 x 512 x 512 bytes take .67 GB then instead of 1.1. */
#ifndef ISO_SCENE_SUBJECT_NARROW_H
#define ISO_SCENE_SUBJECT_NARROW_H

#include "scene/subject.h"
#include "scene/visible.h"

/* Whether the view shows anything. */
typedef struct iso_subject_sight {
    iso_view view;
    iso_visible visible;
} iso_subject_sight;

/* As iso_subject_load_pyramid() and iso_subject_make_view(); look: NULL where no view is wanted, and *sight stays empty. The
 * volume has level 0's scalars where the pyramid has none, and is to be destroyed after it; it is empty where a pyramid's
 * folder, labels or samples wider than a float were loaded whole. */
iso_status iso_subject_load_narrow(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt,
                                   const iso_subject_look *look, const iso_progress *progress, iso_pyramid *p,
                                   iso_volume *v, iso_subject_sight *sight, iso_error *err);

#endif
