/* SPDX-License-Identifier: MIT */
/* target_medium.h - shared parts of the targets pbrt and mitsuba: a folder with a medium of a baked level. */
#pragma once

#include "media/media.h"
#include "targets/targets.h"

typedef struct iso_target_medium {
    const char *name;  /* of the target */
    const char *scene; /* main file of the folder */
    bool emits;        /* if false, the medium only absorbs, which the notes report */
    iso_status (*write)(const iso_medium *m, const char *folder, iso_error *err);
} iso_target_medium;

#define ISO_TARGET_MEDIUM_OPTIONS \
    (ISO_EXPORT_TAKES(ISO_EXPORT_SCENE) | ISO_EXPORT_TAKES(ISO_EXPORT_SIZE) | ISO_EXPORT_TAKES(ISO_EXPORT_ADAPT) | \
     ISO_EXPORT_TAKES(ISO_EXPORT_EXTINCTION_SCALE) | ISO_EXPORT_TAKES(ISO_EXPORT_LATTICE))

iso_status iso_target_medium_write(const iso_export_job *job, const iso_target_medium *t, iso_error *err);
