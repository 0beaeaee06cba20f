/* SPDX-License-Identifier: MIT */
/* build_auto.h - `isoshade build VOLUME --auto --tf FILE|PRESET`: the levels that are predicted to show this transfer function most
 * like level 0, within a budget (plan/auto_choice.h). */
#ifndef ISO_CLI_BUILD_AUTO_H
#define ISO_CLI_BUILD_AUTO_H

#include "options/cli.h"
#include "pyramid/pyramid.h"
#include "scene/subject.h"
#include "volume/input.h"

typedef struct iso_build_auto {
    const iso_cli *cli;
    const iso_volume_input *input;
    const iso_subject_look *look; /* its tf is chosen for */
    const char *volume, *output;
    int budget_bytes; /* a voxel of a coarse level beside its scalar */
    double memory_mb;
} iso_build_auto;

/* In memory. ISO_E_MEMORY when that takes more than memory_mb, with what is needed. */
iso_status iso_cli_build_auto(const iso_build_auto *b, const iso_pyramid_options *opt, iso_error *err);

#endif
