/* SPDX-License-Identifier: MIT */
/* subject_frames.h - all frames of a series as subjects: one range, one scene and one transfer function, so that a value
 * has one color in all of them. */
#ifndef ISO_SCENE_SUBJECT_FRAMES_H
#define ISO_SCENE_SUBJECT_FRAMES_H

#include "scene/subject.h"

typedef struct iso_subject_frames {
    const char *path; /* borrowed, as the next two */
    const iso_volume_input *input;
    const iso_progress *progress;
    iso_pyramid_options build; /* its value_range is that of all frames */
    size_t count;
    bool are_labels;
    size_t widest;   /* the frame with the widest range, for which a transfer function is suggested */
    iso_scene scene; /* the frames' own scene, if a look was given */
    bool has_scene;
    iso_geometry geometry; /* of level 0 */
} iso_subject_frames;

/* Reads all frames of a file that has several, or of files (volume/frames_all.h). look: NULL if no picture is made.
 * ISO_E_USAGE for one frame, a pyramid, or frames of which only some are label maps; ISO_E_RANGE for several grids.
 * To be destroyed in every case. */
iso_status iso_subject_frames_create(const char *path, const iso_volume_input *input, const iso_pyramid_options *build,
                                     const iso_subject_look *look, const iso_progress *progress,
                                     iso_subject_frames *frames, iso_error *err);
/* One frame as a pyramid. */
iso_status iso_subject_frames_load(const iso_subject_frames *frames, size_t frame, iso_pyramid *p, iso_error *err);
/* The one view of all frames, of a pyramid that was loaded so. */
iso_status iso_subject_frames_view(const iso_subject_frames *frames, const iso_pyramid *p, iso_view *view,
                                   iso_error *err);
void iso_subject_frames_destroy(iso_subject_frames *frames);

#endif
