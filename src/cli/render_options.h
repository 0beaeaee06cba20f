/* SPDX-License-Identifier: MIT */
/* render_options.h - checks the options of `isoshade render`, and turns them into options of the renderer. */
#pragma once

#include <math.h>

#include "cli/cycles_options.h"
#include "options/adapted.h"
#include "options/input.h"
#include "options/look.h"
#include "options/roi.h"
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
