/* SPDX-License-Identifier: MIT */
/* palette.h - the parts of `isoshade-lab palette`. Each prints its table unless --json, and adds its rows. */
#ifndef ISO_LAB_PALETTE_H
#define ISO_LAB_PALETTE_H

#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"
#include "palette/palette.h"

typedef struct palette_bench {
    const iso_cli *cli;
    iso_volume_input input;
    iso_cli_look look;      /* empty: a scene that suits most volumes */
    iso_subject_look shown; /* what it asks for */
    int cycles, steps, seeds;
    int sensitivity, no_images;
} palette_bench;

/* Table 1's shape, and its rivals, on the ellipsoid. */
iso_status iso_palette_bench_ellipsoid(const palette_bench *b, json_t *root, iso_error *err);
/* The nearest entry: speed, and how often it is not the nearest. */
iso_status iso_palette_bench_assign(const palette_bench *b, json_t *root, iso_error *err);
/* Figure 8: the annealing's parameters, on the ellipsoid or on a volume. */
iso_status iso_palette_bench_sensitivity(const palette_bench *b, const char *volume, json_t *root, iso_error *err);
/* Table 1 on a volume. */
iso_status iso_palette_bench_volume(const palette_bench *b, const char *path, json_t *rows, iso_error *err);
/* Images of it from palettes and from codes, against those from floats. */
iso_status iso_palette_bench_images(const palette_bench *b, const char *path, json_t *rows, iso_error *err);

/* A volume's gradients in bundles, read slab by slab. */
iso_status iso_palette_bench_sample(const palette_bench *b, const char *path, iso_direction_set *set, double *seconds,
                                    iso_error *err);

#endif
