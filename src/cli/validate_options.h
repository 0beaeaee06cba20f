/* SPDX-License-Identifier: MIT */
/* validate_options.h - the options of `isoshade validate`: which go together, and what they are where they are not given. */
#ifndef ISO_VALIDATE_OPTIONS_H
#define ISO_VALIDATE_OPTIONS_H

#include <math.h>

#include "cli/cycles_options.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"
#include "pyramid/pyramid.h"

#define ISO_NO_BUDGET (-INFINITY)

/* As given; 0 and NULL: not given, of the budget ISO_NO_BUDGET. */
typedef struct iso_validate_arguments {
    iso_volume_input input;
    iso_cli_look look;
    char *output, *with, *renderers, *gl_device, *code, *junit, *summary_md, *suite, **images;
    iso_cli_cycles cycles;
    double budget;
    int level_count, seeds, quick, limit_size, level_views, level_size, resume, anyway, extinction_scale, viewer;
} iso_validate_arguments;

/* More seeds make the tests by pixel and of the bias sharper, and the run longer. */
size_t iso_validate_seeds(const iso_validate_arguments *a);
/* Pixels along the longer edge of the pictures of limits, at most. */
size_t iso_validate_limit_size(const iso_validate_arguments *a);

/* What can be found wrong before the work; *build gets the code. ISO_E_USAGE, ISO_E_RANGE, ISO_E_IO. */
iso_status iso_validate_check_arguments(const iso_validate_arguments *a, const iso_cli *cli, iso_pyramid_options *build,
                                        iso_error *err);

#endif
