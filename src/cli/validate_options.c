/* SPDX-License-Identifier: MIT */
#include "cli/validate.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "scene/views.h"

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

/* True if dir is the report's folder, which may not exist yet. */
static bool is_report(const char *dir, const char *report)
{
    size_t length = strlen(report);
    while (length > 1 && report[length - 1] == '/')
        --length;
    return strlen(dir) == length && strncmp(dir, report, length) == 0;
}

/* Checks the folder of an output before the work. */
static iso_status check_folder(const char *option, const char *path, const char *report, iso_error *err)
{
    FREED char *dir = path ? iso_path_dir(path) : NULL;
    if (path && (!dir || !(iso_path_is_dir(dir) || is_report(dir, report))))
        return iso_fail(err, ISO_E_IO, "%s %s: the folder %s does not exist", option, path, dir ? dir : "");
    return ISO_OK;
}

iso_status iso_validate_check_arguments(const iso_validate_arguments *a, const iso_cli *cli, iso_pyramid_options *build,
                                        iso_error *err)
{
    if (a->budget != ISO_NO_BUDGET && !(a->budget > 0 && isfinite(a->budget)))
        return iso_fail(err, ISO_E_USAGE, "--budget is %g, must be above 0 seconds", a->budget);
    if (!a->output)
        return iso_fail(err, ISO_E_USAGE, "-o is missing: folder for the report");
    if ((a->suite ? 0 : 1) != cli->argument_count)
        return iso_fail(err, ISO_E_USAGE,
                        a->suite ? "--suite makes its own volumes; remove \"%s\""
                                 : "a volume, a pyramid or --suite is missing",
                        a->suite ? cli->arguments[0] : "");
    if (a->suite && (a->look.scene || a->look.tf || a->look.view || a->look.zoom))
        return iso_fail(err, ISO_E_USAGE, "--scene and --suite exclude each other, --tf, --view and --zoom too");
    if (a->suite && a->extinction_scale)
        return iso_fail(err, ISO_E_USAGE, "--extinction-scale has no effect with --suite, which does not judge levels");
    if (a->code)
        NEED(iso_code_from_name(a->code, &build->code, err));
    NEED(check_folder("--junit", a->junit, a->output, err));
    return check_folder("--summary-md", a->summary_md, a->output, err);
}
