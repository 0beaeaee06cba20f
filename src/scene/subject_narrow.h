/* SPDX-License-Identifier: MIT */
/* subject_narrow.h - a narrow pyramid (pyramid/narrow.h) and the view of it, for exports.
 *
 * Level 0 never exists in floats and in directions at once. It is in floats while the view is made; then in
 * directions next to the samples in the file's type. So 512 x 512 x 512 bytes take .67 GB and not 1.1. */
#ifndef ISO_SCENE_SUBJECT_NARROW_H
#define ISO_SCENE_SUBJECT_NARROW_H

#include "scene/subject.h"
#include "scene/visible.h"

/* Whether the view shows anything. */
typedef struct iso_subject_sight {
    iso_view view;
    iso_visible visible;
} iso_subject_sight;

/* Does the work of iso_subject_load_pyramid() and iso_subject_make_view(). look: NULL for no view, and *sight stays
 * empty. If the pyramid has no level 0 scalars, the volume has them, and is to be destroyed after the pyramid. It is
 * empty if a pyramid's folder, labels or samples wider than a float were loaded whole. */
iso_status iso_subject_load_narrow(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt,
                                   const iso_subject_look *look, const iso_progress *progress, iso_pyramid *p,
                                   iso_volume *v, iso_subject_sight *sight, iso_error *err);

#endif
