/* SPDX-License-Identifier: MIT */
/* tf_bound.h - `isoshade tf bound`: bounds the error of images of coarse levels. */
#pragma once

#include "options/adapted.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"

typedef struct iso_tf_bound_arguments {
    const iso_cli *cli; /* arguments[1]: a volume, or a pyramid */
    const iso_volume_input *input;
    const iso_cli_adapted *adapted; /* how to adapt */
    const iso_cli_look *look;
    int level, level_count; /* level: 0 for all coarse levels; level_count: for a volume */
} iso_tf_bound_arguments;

iso_status iso_cli_tf_bound(const iso_tf_bound_arguments *a, iso_error *err);
