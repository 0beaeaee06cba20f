/* SPDX-License-Identifier: MIT */
/* palette_sets.h - gathers the directions for the palettes of `isoshade palette`. */
#pragma once

#include "options/cli.h"
#include "options/input.h"
#include "options/transfer.h"
#include "palette/palette.h"
#include "pyramid/pyramid.h"

typedef struct iso_palette_arguments {
    const iso_cli *cli;
    iso_volume_input input;
    iso_cli_transfer transfer; /* options for the file of --tf */
    iso_tf_request request;    /* read from them */
    char **outputs;            /* ends with NULL */
    char *method, *tf;
    int entries, seed, level, per_level, by_magnitude;
} iso_palette_arguments;

/* Gathers the gradients of a volume's file. */
iso_status iso_palette_volume_set(const iso_palette_arguments *a, const char *path, iso_direction_set *set,
                                  iso_error *err);
/* Gathers the directions of levels first to last: floats if the pyramid keeps them, otherwise decoded ones. */
iso_status iso_palette_pyramid_set(const iso_palette_arguments *a, const iso_pyramid *p, size_t first, size_t last,
                                   iso_direction_set *set, iso_error *err);
