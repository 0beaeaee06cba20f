/* SPDX-License-Identifier: MIT */
/* render_result.h - what `isoshade render` leaves: the picture, and what is said of it. */
#ifndef ISO_RENDER_RESULT_H
#define ISO_RENDER_RESULT_H

#include "cli/render_options.h"
#include "image/image.h"
#include "options/cli.h"
#include "options/visible.h"
#include "plan/cached.h"

/* Who rendered, how long, and where the JSON goes. */
typedef struct iso_rendered {
    const char *with, *version;
    double seconds, device_seconds, step_voxels; /* step_voxels: INFINITY where there is none */
    const iso_render_stats *stats;
    json_t *frames;
} iso_rendered;

/* ISO_E_USAGE: there is no --output, or its name is not that of an image. */
iso_status iso_render_check_output(const iso_render_arguments *a, iso_error *err);

/* To --output and --png, with the command, the renderer and the step in an OpenEXR file. */
iso_status iso_render_save(const iso_render_arguments *a, const iso_cli *cli, const iso_image *image,
                           const char *version, double step_voxels, iso_error *err);

/* NaN of other renderers, and of a device without a timer. */
double iso_render_device_seconds(const iso_render_options *opt, iso_renderers *renderers);

/* Of a series the JSON of each frame is collected in `frames`, else NULL. */
void iso_render_report(const iso_render_arguments *a, const iso_cli *cli, const iso_pyramid *p, const iso_view *view,
                       const iso_visible *visible, const iso_rendered *done);
/* Of bricks of several levels: how many stand where. */
void iso_render_report_cache(const iso_cached_report *r, const iso_cli *cli);

#endif
