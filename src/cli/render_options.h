/* SPDX-License-Identifier: MIT */
/* render_options.h - the options of `isoshade render`: which go together, and what a renderer is asked for by them. */
#ifndef ISO_RENDER_OPTIONS_H
#define ISO_RENDER_OPTIONS_H

#include <math.h>

#include "options/adapted.h"
#include "options/input.h"
#include "options/look.h"
#include "options/roi.h"
#include "renderers/renderers.h"

/* What --memory and --cache-bytes are where they are not given: 0 is refused. */
#define ISO_ALL_IN_MEMORY (-INFINITY)
#define ISO_NO_CACHE (-INFINITY)

/* As given; 0 and NULL: not given. */
typedef struct iso_render_arguments {
    iso_volume_input input;
    iso_cli_adapted adapted;
    iso_cli_roi roi;
    iso_cli_look look;
    const char *with, *renderers, *gl_device;
    char *output, *png, *frames, *source, *quadrature, *isosurface, *palette;
    int level, intervals, planes, samples, seed, seeds, limit, shade_table, exact_lookups, brick, brick_levels,
        page_side;
    double step, cache_bytes, memory_mb; /* cache_bytes: ISO_NO_CACHE; memory_mb: ISO_ALL_IN_MEMORY, or for pages */
    int refine;
    char *plan_error_text, *code, *direction_filter, *estimator;
    double plan_error; /* 0: none */
    const char *shader_dir;
} iso_render_arguments;

/* Bricks of several levels, by --cache-bytes or --plan-error. */
bool iso_render_is_in_bricks(const iso_render_arguments *a);

/* ISO_E_USAGE: options that exclude each other, or that the renderer would pass over; ISO_E_RANGE. */
iso_status iso_render_take_options(const iso_render_arguments *a, int threads, iso_render_options *opt, iso_error *err);

/* "midpoint or preintegrated": what the renderer can be asked for. Its default is marked where mark is true. Returns
 * text. */
const char *iso_render_list_quadratures(const iso_renderer_info *renderer, bool mark, char text[160]);

#endif
