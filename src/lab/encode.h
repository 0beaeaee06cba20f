/* SPDX-License-Identifier: MIT */
/* encode.h - parts of `isoshade-lab encode` that check the paper. Each prints a table (text) and adds to root. */
#pragma once

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"

/* Adds "table1", holes and their bound, and "figure10", the hole over lambda. chart_dir may be NULL. */
iso_status iso_lab_encode_holes(bool text, const char *chart_dir, json_t *root, iso_error *err);

/* Adds "convexity": angle by which interpolation in the paper's warp leaves the cone of the interpolated directions. */
iso_status iso_lab_encode_convexity(bool text, json_t *root, iso_error *err);

/* Adds "stiffness": error of the best fit between neighbors, by its mu. */
iso_status iso_lab_encode_stiffness(bool text, size_t count, json_t *root, iso_error *err);

/* Adds "coherence": directions with a weight as their length, by code. */
iso_status iso_lab_encode_coherence(bool text, size_t count, json_t *root, iso_error *err);

/* "images", "image_ratios": errors of codes in images of the command's volumes. */
typedef struct iso_image_bench {
    const iso_volume_input *input;
    const iso_subject_look *look;
    size_t level_count; /* at most 8 */
} iso_image_bench;
iso_status iso_lab_encode_images(const iso_cli *cli, const iso_image_bench *b, json_t *root, iso_error *err);
