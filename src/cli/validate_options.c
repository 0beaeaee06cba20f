/* SPDX-License-Identifier: MIT */
#include "cli/validate_options.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "scene/views.h"
#include "validate/validate.h"

size_t iso_validate_seeds(const iso_validate_arguments *a)
{
    return a->seeds ? (size_t)a->seeds : a->quick ? 3 : 4;
}

size_t iso_validate_limit_size(const iso_validate_arguments *a)
{
    return a->limit_size ? (size_t)a->limit_size
           : a->quick    ? ISO_VALIDATE_LIMIT_PIXELS_QUICK
                         : ISO_VALIDATE_LIMIT_PIXELS;
}

/* The report's, which may not be there yet. */
static bool is_report(const char *dir, const char *report)
{
    size_t length = strlen(report);
    while (length > 1 && report[length - 1] == '/')
        --length;
    return strlen(dir) == length && strncmp(dir, report, length) == 0;
}

/* Before the work, not after it. */
static iso_status check_folder(const char *option, const char *path, const char *report, iso_error *err)
{
    char *dir = path ? iso_path_dir(path) : NULL;
    iso_status status = ISO_OK;
    if (path && (!dir || !(iso_path_is_dir(dir) || is_report(dir, report))))
        status = iso_fail(err, ISO_E_IO, "%s %s: there is no folder %s", option, path, dir ? dir : "");
    free(dir);
    return status;
}

iso_status iso_validate_check_arguments(const iso_validate_arguments *a, const iso_cli *cli, iso_pyramid_options *build,
                                        iso_error *err)
{
    iso_status status = iso_words_check_range("--levels", a->level_count ? a->level_count : 1, 1, 16, err);
    if (status == ISO_OK && a->seeds)
        status = iso_words_check_range("--seeds", a->seeds, 2, 32, err);
    if (status == ISO_OK && a->level_views)
        status = iso_words_check_range("--level-views", a->level_views, 2, ISO_FACE_VIEWS, err);
    if (status == ISO_OK && a->level_size)
        status = iso_words_check_range("--level-size", a->level_size, 16, 1024, err);
    if (status == ISO_OK && a->budget != ISO_NO_BUDGET && !(a->budget > 0 && isfinite(a->budget)))
        status = iso_fail(err, ISO_E_USAGE, "--budget is %g, must be seconds above 0", a->budget);
    if (status == ISO_OK && a->limit_size)
        status = iso_words_check_range("--limit-size", a->limit_size, 8, 65536, err);
    if (status == ISO_OK && !a->output)
        status = iso_fail(err, ISO_E_USAGE, "-o is missing: the folder for the report");
    if (status == ISO_OK && (a->suite ? 0 : 1) != cli->argument_count)
        status = iso_fail(err, ISO_E_USAGE,
                          a->suite ? "--suite makes its own volumes, \"%s\" is one too many"
                                   : "wanted a volume or a pyramid, or --suite",
                          a->suite ? cli->arguments[0] : "");
    if (status == ISO_OK && a->suite && (a->look.scene || a->look.tf || a->look.view || a->look.zoom))
        status = iso_fail(err, ISO_E_USAGE, "--scene and --suite exclude each other, --tf, --view and --zoom too");
    if (status == ISO_OK && a->suite && a->extinction_scale)
        status = iso_fail(err, ISO_E_USAGE,
                          "--extinction-scale is for the levels of a volume, which --suite does not judge");
    if (status == ISO_OK && a->code)
        status = iso_code_from_name(a->code, &build->code, err);
    TRY(status, check_folder("--junit", a->junit, a->output, err));
    TRY(status, check_folder("--summary-md", a->summary_md, a->output, err));
    return status;
}
