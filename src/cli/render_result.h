/* SPDX-License-Identifier: MIT */
/* render_result.h - saves the picture of `isoshade render`, and reports on it. */
#pragma once

#include "cli/render_options.h"
#include "image/image.h"
#include "options/cli.h"
#include "options/visible.h"
#include "plan/cached.h"

/* A finished render: the renderer, the time, and the array for JSON. */
typedef struct iso_rendered {
    const char *with, *version;
    double seconds, device_seconds, step_voxels; /* step_voxels: INFINITY if there is none */
    const iso_render_stats *stats;
    json_t *frames;
} iso_rendered;

/* Fails with ISO_E_USAGE if --output is missing, or is not the name of an image. */
iso_status iso_render_check_output(const iso_render_arguments *a, iso_error *err);

/* Saves the image to --output and --png. An OpenEXR file gets the command, the renderer and the step. */
iso_status iso_render_save(const iso_render_arguments *a, const iso_cli *cli, const iso_image *image,
                           const char *version, double step_voxels, iso_error *err);

/* Returns the seconds on the device. NaN for other renderers and for devices without a timer. */
double iso_render_device_seconds(const iso_render_options *opt, iso_renderers *renderers);

/* Reports a render. frames: collects the JSON of each frame of a series; otherwise NULL. */
void iso_render_report(const iso_render_arguments *a, const iso_cli *cli, const iso_pyramid *p, const iso_view *view,
                       const iso_visible *visible, const iso_rendered *done);
/* Reports the bricks per level. */
void iso_render_report_cache(const iso_cached_report *r, const iso_cli *cli);
