/* SPDX-License-Identifier: MIT */
/* The table of kinds, and making a figure. */
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/words.h"
#include "figure/job.h"
#include "figure/kinds.h"
#include "pyramid/pyramid.h"

const iso_figure_info *const iso_figure_kinds[] = {
    &iso_figure_levels, &iso_figure_renderers, &iso_figure_grid,      &iso_figure_methods,
    &iso_figure_tf,     &iso_figure_contact,   &iso_figure_failure,   &iso_figure_chart,
    &iso_figure_plan,   &iso_figure_slices,    &iso_figure_turntable, NULL,
};
const iso_names iso_figure_kind_names = {
    "kind of figure",
    "kinds of figures",
    iso_figure_kinds,
    sizeof iso_figure_kinds / sizeof *iso_figure_kinds - 1,
    sizeof iso_figure_kinds[0],
    offsetof(iso_figure_info, name),
    offsetof(iso_figure_info, summary),
    true,
};

iso_status iso_figure_kind_from_name(const iso_names *kinds, const char *name, const iso_figure_info **kind,
                                     iso_error *err)
{
    size_t row = 0;
    NEED(iso_names_find(kinds, name, &row, err));
    *kind = ((const iso_figure_info *const *)kinds->rows)[row];
    return ISO_OK;
}

/* Returns the usual kind of figure: a folder of `isoshade chart` shows only a chart. */
const char *iso_figure_usual_kind(const char *input)
{
    FREED char *path = input ? iso_path_join(input, "chart.json") : NULL;
    const bool is_chart = path && iso_path_is_file(path);
    return is_chart ? iso_figure_chart.name : iso_figure_levels.name;
}

/* ---- options ---- */

static iso_status check_numbers(const iso_figure_job *job, iso_error *err)
{
    const double *z = job->inset;
    if (!(job->width_mm >= 40 && job->width_mm <= 1000))
        return iso_fail(err, ISO_E_RANGE, "--width is %g, must be 40 to 1000 mm", job->width_mm);
    if (!(job->height_mm >= 40 && job->height_mm <= 1000))
        return iso_fail(err, ISO_E_RANGE, "--height is %g, must be 40 to 1000 mm", job->height_mm);
    if (!(job->dpi >= 36 && job->dpi <= 1200))
        return iso_fail(err, ISO_E_RANGE, "--dpi is %g, must be 36 to 1200", job->dpi);
    if (z[2] != 0 && !(z[0] >= 0 && z[1] >= 0 && z[2] >= 0.01 && z[3] >= 0.01 && z[0] + z[2] <= 1 && z[1] + z[3] <= 1))
        return iso_fail(err, ISO_E_RANGE,
                        "--zoom is %g,%g,%g,%g: must be parts of the picture from 0 to 1, at least 0.01 wide and high",
                        z[0], z[1], z[2], z[3]);
    return ISO_OK;
}

/* Refuses options that the kind does not use. */
static iso_status check_options(const iso_figure_job *job, bool of_report, iso_error *err)
{
    const iso_cli_look *look = &job->look;
    const struct {
        unsigned trait;
        bool given;
        const char *name;
    } options[] = {
        {ISO_FIGURE_HAS_LOOK, look->scene || look->tf || look->view || look->size, "--scene, --tf, --view or --size"},
        {ISO_FIGURE_HAS_WITH, job->with != NULL, "--with"},
        {ISO_FIGURE_HAS_LEVEL, job->level != 0, "--level"},
        {ISO_FIGURE_HAS_LEVELS, job->levels != 0, "--levels"},
        {ISO_FIGURE_HAS_METHODS, job->methods != NULL, "--methods"},
        {ISO_FIGURE_HAS_VARIANT, job->variant != NULL, "--variant"},
        {ISO_FIGURE_HAS_ADAPT, job->adapted.wanted != 0, "--adapt"},
        {ISO_FIGURE_HAS_FRAMES, job->frames != 0, "--frames"},
        {ISO_FIGURE_HAS_CASE, job->atlas_case != NULL, "--case"},
        {ISO_FIGURE_HAS_ERROR, job->error != 0, "--error"},
        {ISO_FIGURE_HAS_LOOKS,
         (job->tfs && job->tfs[0] && job->tfs[1]) || (job->views && job->views[0] && job->views[1]),
         "several of --tf or --view"},
        {ISO_FIGURE_HAS_LOOK, job->has_background, "--background"},
        {ISO_FIGURE_HAS_INSET, job->inset[2] != 0, "--zoom X,Y,W,H"},
    };
    for (size_t i = 0; i < sizeof options / sizeof *options; ++i)
        if (options[i].given && !(job->kind->takes & options[i].trait))
            return iso_fail(err, ISO_E_USAGE, "--kind %s does not take %s", job->kind->name, options[i].name);
    if (of_report && (job->with || job->levels || job->adapted.wanted || look->tf || look->view || look->zoom ||
                      look->size || job->inset[2] != 0 || job->has_background))
        return iso_fail(
            err, ISO_E_USAGE,
            "%s is a report, with its own pictures; --with, --levels, --adapt, --tf, --view, --zoom, --size "
            "and --background are for figures of a volume",
            job->input);
    if (!of_report && (job->kind->takes & ISO_FIGURE_OF_REPORT) && job->variant)
        return iso_fail(err, ISO_E_USAGE, "--variant is for figures of a report");
    if (of_report && look->scene && !strcmp(job->kind->name, "levels"))
        return iso_fail(err, ISO_E_USAGE, "--scene is for --kind renderers of a report");
    return ISO_OK;
}

static iso_status check_input(const iso_figure_job *job, bool of_report, iso_error *err)
{
    const unsigned takes = job->kind->takes;
    if (!job->input && !(takes & ISO_FIGURE_OF_NOTHING))
        return iso_fail(err, ISO_E_USAGE, "--kind %s needs %s", job->kind->name,
                        takes & ISO_FIGURE_OF_CHART ? "the folder of a chart" : "a volume");
    if (job->input && !(takes & (ISO_FIGURE_OF_VOLUME | ISO_FIGURE_OF_REPORT | ISO_FIGURE_OF_CHART)))
        return iso_fail(err, ISO_E_USAGE, "--kind %s takes no input", job->kind->name);
    if (of_report && !(takes & ISO_FIGURE_OF_REPORT))
        return iso_fail(err, ISO_E_USAGE, "%s is a report; --kind %s is of %s", job->input, job->kind->name,
                        takes & ISO_FIGURE_OF_CHART ? "a chart" : "a volume");
    return ISO_OK;
}

/* ---- the figure ---- */

ISO_ENDING(end_page, iso_page, iso_page_destroy)

static iso_status draw_page(const iso_figure_job *job, const char *dir, iso_error *err)
{
    ENDED_BY(end_page) iso_page *page = NULL;
    NEED(iso_page_create(&page, dir, job->dpi, err));
    if (job->letters)
        iso_page_letter_panels(page);
    NEED(job->kind->draw(job, page, err));
    return iso_page_finish(page, job->formats, job->with_sources, err);
}

static iso_status make(const iso_figure_job *job, bool of_report, iso_error *err)
{
    ENDED_BY(iso_output_abandon) iso_output out = {0};
    if (!job->output)
        return iso_fail(err, ISO_E_USAGE, "-o is missing; give the folder for the figure");
    NEED(check_input(job, of_report, err));
    NEED(check_options(job, of_report, err));
    NEED(check_numbers(job, err));
    NEED(iso_page_check_forms(job->formats, err));
    NEED(iso_output_begin_dir(&out, job->output, "figure.pdf", err));
    NEED(draw_page(job, out.temp_path, err));
    return iso_output_commit(&out, err);
}

iso_status iso_figure_make(const iso_figure_job *job, iso_error *err)
{
    const bool of_report = iso_figure_is_of_report(job);
    const iso_status status = make(job, of_report, err);
    /* A folder may hold slices of a volume instead of a report. */
    return status != ISO_OK && status != ISO_E_USAGE && job->input && (job->kind->takes & ISO_FIGURE_OF_REPORT) &&
                   !of_report && iso_path_is_dir(job->input) && !iso_pyramid_is_one(job->input)
               ? iso_fail_in(err, status, "%s is not a report, it has no report.json; as a volume", job->input)
               : status;
}
