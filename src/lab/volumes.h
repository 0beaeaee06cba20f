/* SPDX-License-Identifier: MIT */
/* volumes.h - what benchmarks of levels share: the ranges of their options, and the way through the volumes that are named,
 * under each of the four transfer functions. */
#ifndef ISO_LAB_VOLUMES_H
#define ISO_LAB_VOLUMES_H

#include "lab/level_tfs.h"
#include "options/cli.h"
#include "options/input.h"

/* What pictures of levels are asked for. */
typedef struct iso_lab_pictures {
    int views, most_views;   /* --views: 1 to most_views; most_views 0: there is no such option */
    int size;                /* --size: 16 to 4096 */
    int levels, most_levels; /* --levels: 2 to most_levels */
} iso_lab_pictures;
/* ISO_E_USAGE with the option's name. */
iso_status iso_lab_check_pictures(const iso_lab_pictures *pictures, iso_error *err);

/* Leaves of the axes that have more than n voxels the middle n. ISO_E_MEMORY. */
iso_status iso_lab_crop_to_middle(iso_volume *v, size_t n, iso_error *err);

/* A pyramid under a transfer function. */
typedef struct iso_lab_visited {
    const char *volume; /* the file's name */
    const iso_pyramid *pyramid;
    const iso_level_tf *tf;
    size_t number, count; /* of the visit, from 0, and how many there are */
} iso_lab_visited;
typedef iso_status (*iso_lab_visit)(void *user, const iso_lab_visited *visited, iso_error *err);

/* The volumes that the command line names, built with `levels` levels, one after the other. loading: NULL for none. */
typedef struct iso_lab_volumes {
    const iso_cli *cli;
    const iso_volume_input *input;
    int levels;
    const iso_progress *loading;
} iso_lab_volumes;
iso_status iso_lab_visit_volumes(const iso_lab_volumes *volumes, iso_lab_visit visit, void *user, iso_error *err);

#endif
