/* SPDX-License-Identifier: MIT */
/* build_for.h - `isoshade build VOLUME --for SCENES|first`: levels that best show scenes or a first picture
 * (plan/scene_levels.h). */
#pragma once

#include "options/cli.h"
#include "plan/optimize.h"
#include "pyramid/pyramid.h"
#include "scene/subject.h"
#include "volume/input.h"

/* Value in --for's list instead of a scene file. */
#define ISO_BUILD_FOR_FIRST "first"

typedef struct iso_build_for {
    const iso_cli *cli;
    const iso_volume_input *input;
    iso_subject_look looks[ISO_SCENES_MOST];
    size_t scene_count;
    const char *volume, *output, *scenes; /* scenes: as given */
    double memory_mb;
    iso_effort effort; /* of optimized levels */
} iso_build_for;

/* Builds the pyramid in memory. ISO_E_MEMORY, with the size, if it needs more than memory_mb. */
iso_status iso_cli_build_for(const iso_build_for *b, const iso_pyramid_options *opt, iso_error *err);
