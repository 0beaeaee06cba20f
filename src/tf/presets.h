/* SPDX-License-Identifier: MIT */
/* presets.h - transfer functions by kind of volume, scaled to the volume's values.
 *
 * A preset's points have a scale of their own, which is fitted to the volume by its survey:
 *   Hounsfield   unchanged if the volume's values are Hounsfield units; otherwise -1000 on the background's peak and
 *                +1500 on the 99.9 % quantile
 *   object       0 at the end of the background, 1 on the 99.9 % quantile of the values beyond it
 *   signed       0 on the background's peak, -1 and 1 at equal distances, one of them at the farther end of the values
 * The preset "auto" is the result of suggest.h. */
#pragma once

#include "base/names.h"
#include "tf/survey.h"
#include "tf/tf.h"

extern const iso_names iso_tf_preset_names;

/* True if the name is that of a preset, with its *row. */
bool iso_tf_preset_find(const char *name, size_t *row);

/* Creates *tf from a preset. ISO_E_MEMORY. */
iso_status iso_tf_preset_apply(size_t row, const iso_survey *survey, const iso_geometry *level0, iso_tf *tf,
                               iso_error *err);

/* Loads a file of any input format or a preset; NULL: "auto". survey: of level 0; NULL: made if needed. */
iso_status iso_tf_of_level(const char *name, const iso_tf_request *request, const iso_survey *survey,
                           const iso_level *level0, int threads, iso_tf *tf, iso_error *err);
/* Does the same for a volume outside a pyramid. */
iso_status iso_tf_of_volume(const char *name, const iso_tf_request *request, const iso_volume *v, int threads,
                            iso_tf *tf, iso_error *err);
/* Checks a name before the volume is read: unknown preset, missing or damaged file. */
iso_status iso_tf_check_name(const char *name, const iso_tf_request *request, iso_error *err);
