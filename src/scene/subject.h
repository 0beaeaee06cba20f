/* SPDX-License-Identifier: MIT */
/* subject.h - input of a command: a pyramid, or a volume built into one in memory; and a scene resolved for it. */
#pragma once

#include "volume/input.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"
#include "scene/viewpoint.h"
#include "scene/visible.h"
#include "tf/survey.h"

/* Pixels of a first picture along each side. */
enum { ISO_SUBJECT_PIXELS = 512 };

/* Loads or builds a pyramid. path: NAME.iso, or any volume that iso_volume_input_load() reads. A volume is built
 * with `opt`; a pyramid keeps its own options. */
iso_status iso_subject_load_pyramid(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt,
                                    const iso_progress *progress, iso_pyramid *p, iso_error *err);
/* Coarse levels on disk, of a volume whose level 0 is left out. */
typedef struct iso_subject_coarse {
    char *folder;    /* owned: for iso_pyramid_load_from(); NULL: nothing is left out */
    char *temporary; /* owned: the folder around it, removed at the end; or NULL */
} iso_subject_coarse;
/* Loads a pyramid as above if level 0 has at most `most` voxels. Otherwise it loads the outline alone, for a choice of
 * levels, and builds the levels of a volume from 1 on under $TMPDIR, in memory that does not grow with the volume. */
iso_status iso_subject_load_coarse(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt,
                                   double most, const iso_progress *progress, iso_pyramid *p,
                                   iso_subject_coarse *coarse, iso_error *err);
void iso_subject_coarse_destroy(iso_subject_coarse *coarse);
/* Does the same for a picture of level 0 that may need only a part of it: a volume whose samples have at most 4 bytes
 * and are no labels becomes a pyramid of iso_pyramid_begin(), a pyramid one of iso_pyramid_load_begun(). */
iso_status iso_subject_begin_pyramid(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt,
                                     const iso_progress *progress, iso_pyramid *p, iso_error *err);
/* Refuses a label map with ISO_E_USAGE: `what`, an option or a command, would interpolate it. */
iso_status iso_subject_refuse_labels(const iso_pyramid *p, const char *path, const char *what, iso_error *err);

/* A file to build from, for iso_stream_input. */
typedef struct iso_subject_file {
    const char *path;
    const iso_volume_input *input;
} iso_subject_file;
iso_status iso_subject_open(void *file, iso_volume_source **source, iso_error *err);

/* Requested picture; each part is optional. Without a scene file it is a first picture (viewpoint.h) with a suggested
 * transfer function. tf, view, zoom and size override the scene. */
typedef struct iso_subject_look {
    const char *scene, *tf, *view, *size;
    double zoom;            /* 0: not given */
    iso_tf_request request; /* settings missing in the file named by tf */
    int threads;
    bool frames_box; /* True if the camera frames the box instead of its visible part, which may change in a series */
    const iso_survey *survey; /* of the volume if already made, or NULL */
    iso_scene_part *visible;  /* with one volume and TF: kept between views, starts as {0}; or NULL */
} iso_subject_look;

/* True if the transfer function depends on the volume's values: a preset or a suggested one. */
bool iso_subject_look_needs_values(const iso_subject_look *look);

/* Checks all that is known before the volume is read: missing or damaged files, names, numbers. */
iso_status iso_subject_check_look(const iso_subject_look *look, iso_error *err);
/* Makes the scene for a pyramid; if it needs values, a level needs its scalar. */
iso_status iso_subject_make_scene(const iso_subject_look *look, const iso_pyramid *p, iso_scene *scene, iso_error *err);
iso_status iso_subject_make_view(const iso_subject_look *look, const iso_pyramid *p, iso_view *view, iso_error *err);

/* The view, and the measured visible parts. */
typedef struct iso_subject_sight {
    iso_view view;
    iso_visible visible;
} iso_subject_sight;

/* Loads a narrow pyramid (pyramid/narrow.h) and makes the view, for exports. Level 0 is never in memory as floats and
 * as directions at once: it is in floats while the view is made, then in directions next to the samples in the file's
 * type. So 512 x 512 x 512 bytes take .67 GB instead of 1.1. look: NULL for no view; then *sight stays empty. If the
 * pyramid has no level 0 scalars, the volume has them and must be destroyed after the pyramid. The volume is empty if a
 * pyramid's folder, labels or samples wider than a float were loaded as a whole. */
iso_status iso_subject_load_narrow(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt,
                                   const iso_subject_look *look, const iso_progress *progress, iso_pyramid *p,
                                   iso_volume *v, iso_subject_sight *sight, iso_error *err);

/* Parses "320x200", or one number for both, as given to --size. */
iso_status iso_subject_parse_image_size(const char *text, size_t *width, size_t *height, iso_error *err);
