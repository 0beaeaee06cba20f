/* SPDX-License-Identifier: MIT */
/* validate.h - parts of `isoshade validate`: its options, the scene next to the report, the final output. */
#pragma once

#include <math.h>

#include "cli/cycles_options.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"
#include "report/levels.h"
#include "validate/validate.h"

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

/* Checks the options before the work. *build gets the code. ISO_E_USAGE, ISO_E_RANGE, ISO_E_IO. */
iso_status iso_validate_check_arguments(const iso_validate_arguments *a, const iso_cli *cli, iso_pyramid_options *build,
                                        iso_error *err);
/* Returns the number of seeds. More seeds sharpen the tests of pixels and of the bias, and take longer. */
size_t iso_validate_seeds(const iso_validate_arguments *a);
/* Returns the largest edge, in pixels, of the pictures of limits. */
size_t iso_validate_limit_size(const iso_validate_arguments *a);

/* DIR.scene.json is written next to the report if the scene has no file. Its comment has a checksum of the rest, so
 * that the next run replaces it only if it is unchanged. Returns its name for the report's folder, to be freed, and
 * announces it as an output (base/inputs.h). */
iso_status iso_validate_scene_name(const char *report, char **path, iso_error *err);
/* Guards an existing file. Call it once the inputs are known, as it may be one. ISO_E_IO: validate did not write it. */
iso_status iso_validate_scene_guard(const char *path, iso_error *err);
iso_status iso_validate_scene_save(const iso_scene *scene, const char *path, iso_error *err);

/* Returns the exit code: nothing differs; a difference of renderers or levels; or a renderer could not be compared. */
iso_status iso_cli_validate_verdict(const iso_validation *v, const iso_report_summary *summary,
                                    const iso_levels_summary *levels, iso_error *err);
/* Prints the verdicts, skipped comparisons with reasons, and the report's path; with --json the report itself. */
void iso_cli_validate_print(const char *output, const iso_cli *cli, const iso_validation *v,
                            const iso_report_summary *s, const iso_levels_summary *levels);
