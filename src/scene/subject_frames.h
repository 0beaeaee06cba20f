/* SPDX-License-Identifier: MIT */
/* subject_frames.h - all frames of a series as subjects: one range, one scene and one transfer function, so that a
 * value has one color in all of them. */
#pragma once

#include "scene/subject.h"

typedef struct iso_subject_frames {
    const char *path; /* borrowed, like the next two */
    const iso_volume_input *input;
    const iso_progress *progress;
    iso_pyramid_options build; /* with the value_range of all frames */
    size_t count;
    bool are_labels;
    size_t widest;   /* frame with the widest range, used to suggest a transfer function */
    iso_scene scene; /* the frames' own scene, if a look was given */
    bool has_scene;
    iso_geometry geometry; /* of level 0 */
} iso_subject_frames;

/* Reads all frames of a file with several, or of files (volume/frames_all.h). look: NULL if no picture is made.
 * ISO_E_USAGE: one frame, a pyramid, or only some frames are label maps; ISO_E_RANGE: different grids. To be destroyed
 * in every case. */
iso_status iso_subject_frames_create(const char *path, const iso_volume_input *input, const iso_pyramid_options *build,
                                     const iso_subject_look *look, const iso_progress *progress,
                                     iso_subject_frames *frames, iso_error *err);
/* Loads one frame as a pyramid. */
iso_status iso_subject_frames_load(const iso_subject_frames *frames, size_t frame, iso_pyramid *p, iso_error *err);
/* Makes the common view of all frames; p: a pyramid loaded by the function above. */
iso_status iso_subject_frames_view(const iso_subject_frames *frames, const iso_pyramid *p, iso_view *view,
                                   iso_error *err);
void iso_subject_frames_destroy(iso_subject_frames *frames);
