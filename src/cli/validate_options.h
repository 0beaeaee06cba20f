/* SPDX-License-Identifier: MIT */
/* validate_options.h - checks the options of `isoshade validate`, and has their defaults. */
#pragma once

#include <math.h>

#include "cli/cycles_options.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"
#include "pyramid/pyramid.h"

#define ISO_NO_BUDGET (-INFINITY)

/* Options as given; 0 and NULL: not given; budget: ISO_NO_BUDGET. */
typedef struct iso_validate_arguments {
    iso_volume_input input;
    iso_cli_look look;
    char *output, *with, *renderers, *gl_device, *code, *junit, *summary_md, *suite, **images;
    char *shared; /* of a rank other than 0: folder of rank 0's pictures; or NULL */
    iso_cli_cycles cycles;
    double budget;
    int level_count, seeds, quick, limit_size, level_views, level_size, resume, anyway, extinction_scale, viewer;
} iso_validate_arguments;

/* Returns the number of seeds. More seeds sharpen the tests of pixels and of the bias, and take longer. */
size_t iso_validate_seeds(const iso_validate_arguments *a);
/* Returns the largest edge, in pixels, of the pictures of limits. */
size_t iso_validate_limit_size(const iso_validate_arguments *a);

/* Checks the options before the work. *build gets the code. ISO_E_USAGE, ISO_E_RANGE, ISO_E_IO. */
iso_status iso_validate_check_arguments(const iso_validate_arguments *a, const iso_cli *cli, iso_pyramid_options *build,
                                        iso_error *err);
