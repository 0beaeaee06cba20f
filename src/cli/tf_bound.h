/* SPDX-License-Identifier: MIT */
/* tf_bound.h - `isoshade tf bound`: how far the images of a scene's coarse levels can be from level 0's. */
#ifndef ISO_TF_BOUND_H
#define ISO_TF_BOUND_H

#include "options/adapted.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"

typedef struct iso_tf_bound_arguments {
    const iso_cli *cli; /* arguments[1]: a volume, or a pyramid */
    const iso_volume_input *input;
    const iso_cli_adapted *adapted; /* how to adapt */
    const iso_cli_look *look;
    int level, level_count; /* level 0: each coarse one; level_count: of a volume's pyramid */
} iso_tf_bound_arguments;

iso_status iso_cli_tf_bound(const iso_tf_bound_arguments *a, iso_error *err);

#endif
