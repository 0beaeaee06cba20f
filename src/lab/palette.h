/* SPDX-License-Identifier: MIT */
/* palette.h - the parts of `isoshade-lab palette`. Each prints its table unless --json, and adds its rows. */
#pragma once

#include "lab/rivals/palettes.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"

typedef struct palette_bench {
    const iso_cli *cli;
    iso_volume_input input;
    iso_cli_look look;      /* empty: a scene that suits most volumes */
    iso_subject_look shown; /* the request in `look` */
    int cycles, steps, seeds, entries;
    int no_images;
    char *tessellation;
} palette_bench;

/* Measures Table 1, and rival methods, on the ellipsoid. */
iso_status iso_palette_bench_ellipsoid(const palette_bench *b, json_t *root, iso_error *err);
/* Measures the search for the nearest entry: speed, and the number of wrong results. */
iso_status iso_palette_bench_assign(const palette_bench *b, json_t *root, iso_error *err);
/* Measures Table 1 on a volume. */
iso_status iso_palette_bench_volume(const palette_bench *b, const char *path, json_t *rows, iso_error *err);
/* Measures a volume's images from palettes and from codes, against those from floats. */
iso_status iso_palette_bench_images(const palette_bench *b, const char *path, json_t *rows, iso_error *err);

/* Anneals a tessellation for the ellipsoid, and draws its front over the gradients, as an SVG (Figure 9). */
iso_status iso_palette_bench_tessellation(const palette_bench *b, iso_error *err);

/* Bundles a volume's gradients, read slab by slab. */
iso_status iso_palette_bench_sample(const palette_bench *b, const char *path, iso_direction_set *set, double *seconds,
                                    iso_error *err);
