/* SPDX-License-Identifier: MIT */
/* povray_files.h - the files of a POV-Ray scene; private to this folder. */
#pragma once

#include "povray/scene_text.h"

/* Checks the options. ISO_E_RANGE: outside their limits, or no such level. */
iso_status iso_povray_check(const iso_pyramid *p, size_t level, const iso_view *view, const iso_povray_options *opt,
                            iso_error *err);

/* A scene with its data. */
typedef struct iso_povray_prepared {
    iso_povray_scene scene, roi;
    iso_tf_table envelope; /* of the view's 2D transfer function */
    char *roi_name;
    const iso_pyramid *pyramid; /* borrowed: its code and estimator make the directions */
} iso_povray_prepared;

/* Prepares a scene; free it with iso_povray_release(). It is empty after an error. */
iso_status iso_povray_prepare(const iso_pyramid *p, size_t level, const iso_view *view, const char *name,
                              const iso_povray_options *opt, iso_povray_prepared *s, iso_error *err);
void iso_povray_release(iso_povray_prepared *s);

/* Writes all files of a scene into an existing folder. */
iso_status iso_povray_write_files(const iso_povray_prepared *s, const char *dir, const iso_progress *progress,
                                  iso_error *err);

/* Returns the path of "dir/name_suffix"; the caller frees it. */
char *iso_povray_file_path(const char *dir, const char *name, const char *suffix);
iso_status iso_povray_no_memory(iso_error *err);
