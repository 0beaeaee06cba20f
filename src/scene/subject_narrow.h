/* SPDX-License-Identifier: MIT */
/* subject_narrow.h - a narrow pyramid (pyramid/narrow.h) and the view of it, for exports.
 *
 * Level 0 is never in memory as floats and as directions at once: it is in floats while the view is made, then in
 * directions next to the samples in the file's type. So 512 x 512 x 512 bytes take .67 GB instead of 1.1. */
#pragma once

#include "scene/subject.h"
#include "scene/visible.h"

/* The view, and the measured visible parts. */
typedef struct iso_subject_sight {
    iso_view view;
    iso_visible visible;
} iso_subject_sight;

/* Replaces iso_subject_load_pyramid() and iso_subject_make_view(). look: NULL for no view; then *sight stays empty. If
 * the pyramid has no level 0 scalars, the volume has them and must be destroyed after the pyramid. The volume is empty
 * if a pyramid's folder, labels or samples wider than a float were loaded as a whole. */
iso_status iso_subject_load_narrow(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt,
                                   const iso_subject_look *look, const iso_progress *progress, iso_pyramid *p,
                                   iso_volume *v, iso_subject_sight *sight, iso_error *err);
