/* SPDX-License-Identifier: MIT */
/* volumes.h - shared by benchmarks of levels: ranges of their options, and iteration over the given volumes under each
 * of the four transfer functions. */
#pragma once

#include "lab/level_tfs.h"
#include "options/cli.h"
#include "options/input.h"

/* Limits of the options for pictures of levels. */
typedef struct iso_lab_pictures {
    int views, most_views;   /* --views: 1 to most_views; most_views 0: no such option */
    int size;                /* --size: 16 to 4096 */
    int levels, most_levels; /* --levels: 2 to most_levels */
} iso_lab_pictures;
/* Checks the ranges. ISO_E_USAGE names the option. */
iso_status iso_lab_check_pictures(const iso_lab_pictures *pictures, iso_error *err);

/* Crops axes with more than n voxels to the middle n. Errors: ISO_E_MEMORY. */
iso_status iso_lab_crop_to_middle(iso_volume *v, size_t n, iso_error *err);

/* A pyramid under a transfer function. */
typedef struct iso_lab_visited {
    const char *volume; /* the file's name */
    const iso_pyramid *pyramid;
    const iso_level_tf *tf;
    size_t number, count; /* of the visit, from 0; number of visits */
} iso_lab_visited;
typedef iso_status (*iso_lab_visit)(void *user, const iso_lab_visited *visited, iso_error *err);

/* The volumes of the command line, built one after the other with `levels` levels. loading: NULL for none. */
typedef struct iso_lab_volumes {
    const iso_cli *cli;
    const iso_volume_input *input;
    int levels;
    const iso_progress *loading;
} iso_lab_volumes;
iso_status iso_lab_visit_volumes(const iso_lab_volumes *volumes, iso_lab_visit visit, void *user, iso_error *err);
