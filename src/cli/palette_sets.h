/* SPDX-License-Identifier: MIT */
/* palette_sets.h - the directions that `isoshade palette` fits a palette to. */
#ifndef ISO_PALETTE_SETS_H
#define ISO_PALETTE_SETS_H

#include "options/cli.h"
#include "options/input.h"
#include "options/transfer.h"
#include "palette/palette.h"
#include "pyramid/pyramid.h"

typedef struct iso_palette_arguments {
    const iso_cli *cli;
    iso_volume_input input;
    iso_cli_transfer transfer; /* of the file that tf names */
    iso_tf_request request;    /* what it says */
    char **outputs;            /* ends with NULL */
    char *method, *tf;
    int entries, seed, level, per_level, by_magnitude, ellipsoid, on_surface, swap_trials, cycles, steps;
    double start_prob, temp_fac, move_min, move_max;
} iso_palette_arguments;

/* The paper's ellipsoid. */
iso_status iso_palette_ellipsoid_set(const iso_palette_arguments *a, iso_direction_set *set, iso_error *err);
/* The gradients of a file. */
iso_status iso_palette_volume_set(const iso_palette_arguments *a, const char *path, iso_direction_set *set,
                                  iso_error *err);
/* Levels first to last; their directions are those before encoding where the pyramid keeps them, else decoded ones. */
iso_status iso_palette_pyramid_set(const iso_palette_arguments *a, const iso_pyramid *p, size_t first, size_t last,
                                   iso_direction_set *set, iso_error *err);

#endif
