/* SPDX-License-Identifier: MIT */
/* export_several.h - exports several volumes in one scene: channels of a file, and volumes of --add. */
#pragma once

#include "options/cli.h"
#include "scene/subject.h"
#include "targets/targets.h"

typedef struct iso_export_several {
    const iso_cli *cli;
    const iso_volume_input *input; /* options for the first volume */
    const iso_subject_look *look;
    const char *channels; /* "all", or "0,2,DAPI"; or NULL */
    const char **added;   /* "VOLUME" or "VOLUME,TF"; ends with NULL, or NULL */
    size_t level, level_count;
    double step_voxels; /* 0: the scene's */
    const char *output;
    const iso_export_target *target;
} iso_export_several;

iso_status iso_export_several_volumes(const iso_export_several *several, iso_error *err);
