/* SPDX-License-Identifier: MIT */
/* povray_files.h - the files of a POV-Ray scene; private to this folder. */
#ifndef ISO_POVRAY_FILES_H
#define ISO_POVRAY_FILES_H

#include "povray/scene_text.h"

/* ISO_E_RANGE: options outside their limits, a level that is not there. */
iso_status iso_povray_check(const iso_pyramid *p, size_t level, const iso_view *view, const iso_povray_options *opt,
                            iso_error *err);

/* A scene with the data that it points to. */
typedef struct iso_povray_prepared {
    iso_povray_scene scene, roi;
    iso_tf_table envelope; /* of the view's 2D transfer function */
    char *roi_name;
    const iso_pyramid *pyramid; /* borrowed: its code and estimator make the directions */
} iso_povray_prepared;

/* Free it by iso_povray_release(); it is empty after an error. */
iso_status iso_povray_prepare(const iso_pyramid *p, size_t level, const iso_view *view, const char *name,
                              const iso_povray_options *opt, iso_povray_prepared *s, iso_error *err);
void iso_povray_release(iso_povray_prepared *s);

/* All files of a scene into a folder that exists. */
iso_status iso_povray_write_files(const iso_povray_prepared *s, const char *dir, const iso_progress *progress,
                                  iso_error *err);

/* The path of "dir/name_suffix"; to be freed. */
char *iso_povray_file_path(const char *dir, const char *name, const char *suffix);
iso_status iso_povray_no_memory(iso_error *err);

#endif
