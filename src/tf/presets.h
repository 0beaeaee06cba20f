/* SPDX-License-Identifier: MIT */
/* presets.h - transfer functions by what made the volume, put on its own values.
 *
 * A preset's points stand on a scale of its own, which is laid on the volume as the survey found it:
 *   Hounsfield   as they are where the volume's values are Hounsfield units; else air lies on the background's peak
 *                and +1500 on the 99.9 % quantile
 *   object       0 where the background ends, 1 on the 99.9 % quantile of what lies beyond it
 *   signed       0 on the background's peak, -1 and 1 on the same distance to both sides, which reaches the farther end
 * "auto" is what suggest.h finds. */
#ifndef ISO_TF_PRESETS_H
#define ISO_TF_PRESETS_H

#include "base/names.h"
#include "tf/survey.h"
#include "tf/tf.h"

extern const iso_names iso_tf_preset_names;

/* True where it is the name of a preset, and no file. */
bool iso_tf_preset_find(const char *name, size_t *row);

/* ISO_E_MEMORY. */
iso_status iso_tf_preset_apply(size_t row, const iso_survey *survey, const iso_geometry *level0, iso_tf *tf,
                               iso_error *err);

/* A file of any format that is read, or a preset; NULL: "auto". survey: of level 0; NULL: made where it is needed. */
iso_status iso_tf_of_level(const char *name, const iso_tf_request *request, const iso_survey *survey,
                           const iso_level *level0, int threads, iso_tf *tf, iso_error *err);
/* The same for a volume that is no pyramid's. */
iso_status iso_tf_of_volume(const char *name, const iso_tf_request *request, const iso_volume *v, int threads,
                            iso_tf *tf, iso_error *err);
/* What can be said before a volume is read: an unknown preset, a file that is missing or damaged. */
iso_status iso_tf_check_name(const char *name, const iso_tf_request *request, iso_error *err);

#endif
