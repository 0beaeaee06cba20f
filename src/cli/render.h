/* SPDX-License-Identifier: MIT */
/* render.h - parts of `isoshade render`.
 *
 *   render_options.c   checks the options, and turns them into options of the renderer
 *   render_result.c    saves the picture, and reports on it
 *   render_paged.c     --memory MB: a level of a pyramid on disk that may be larger than memory */
#pragma once

#include <math.h>

#include "cli/cycles_options.h"
#include "image/image.h"
#include "options/adapted.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"
#include "options/roi.h"
#include "options/visible.h"
#include "plan/cached.h"
#include "renderers/renderers.h"

/* Value of --memory and --cache-bytes if not given: 0 is refused. */
#define ISO_ALL_IN_MEMORY (-INFINITY)
#define ISO_NO_CACHE (-INFINITY)

/* Options as given; 0 and NULL: not given. */
typedef struct iso_render_arguments {
    iso_volume_input input;
    iso_cli_adapted adapted;
    iso_cli_roi roi;
    iso_cli_look look;
    iso_cli_cycles cycles;
    const char *with, *renderers, *gl_device;
    char *output, *png, *frames, *source, *quadrature, *isosurface, *palette;
    int level, intervals, planes, samples, seed, seeds, limit, shade_table, exact_lookups, brick, brick_levels,
        page_side;
    double step, cache_bytes, memory_mb; /* cache_bytes: ISO_NO_CACHE; memory_mb: ISO_ALL_IN_MEMORY, or for pages */
    int refine, progressive;
    char *plan_error_text, *code, *direction_filter, *estimator;
    double plan_error; /* 0: none */
    const char *shader_dir;
} iso_render_arguments;

/* True if bricks of several levels are rendered, by --cache-bytes or --plan-error. */
bool iso_render_is_in_bricks(const iso_render_arguments *a);

/* Fills *opt. ISO_E_USAGE, ISO_E_RANGE: options that exclude each other, or that the renderer would ignore. */
iso_status iso_render_take_options(const iso_render_arguments *a, int threads, iso_render_options *opt, iso_error *err);

/* Writes the renderer's quadratures, such as "midpoint or preintegrated". mark: True to mark the default. Returns
 * text. */
const char *iso_render_list_quadratures(const iso_renderer_info *renderer, bool mark, char text[160]);

/* ---- the result ---- */

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

/* ---- paged ---- */

/* Renders the level. With --refine coarse levels come first, each as its own picture. Statuses as of other renders. */
iso_status iso_cli_render_paged(const iso_render_arguments *a, const iso_cli *cli, iso_error *err);
