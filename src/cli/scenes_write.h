/* SPDX-License-Identifier: MIT */
/* scenes_write.h - `isoshade scenes --write DIR`: writes requests to render elsewhere. */
#pragma once

#include "options/cli.h"
#include "options/look.h"
#include "volume/input.h"

typedef struct iso_scenes_write {
    const iso_cli *cli;
    const iso_volume_input *input;
    iso_cli_look look; /* for a volume; a suite uses only its size */
    const char *dir;   /* folder to write */
    const char *suite; /* a folder of scenes that make their volumes; or NULL */
    const char *tier;  /* NULL: "samples" */
    int levels, steps; /* 0: those of validate; below 0: default */
} iso_scenes_write;

iso_status iso_scenes_write_all(const iso_scenes_write *w, iso_error *err);
