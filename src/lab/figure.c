/* SPDX-License-Identifier: MIT */
/* figure.c - isoshade-lab figure: figures of the papers, and of seams. */
#include <math.h>
#include <stdio.h>

#include "lab/figure/paper_kinds.h"
#include "lab/lab.h"
#include "options/input.h"
#include "scene/viewpoint.h"
#include "tf/presets.h"

static const iso_figure_info *const kinds[] = {
    &iso_figure_code_dots,     &iso_figure_code_points,     &iso_figure_code_regions, &iso_figure_code_spheres,
    &iso_figure_code_table,    &iso_figure_joint_histogram, &iso_figure_joint_row,    &iso_figure_mixed_volume,
    &iso_figure_mixed_surface, &iso_figure_palette_views,   &iso_figure_seams,        &iso_figure_region,
};
static const iso_names kind_names = ISO_NAMES_OF_POINTERS("figure", kinds);

const iso_lab_figure_options *iso_lab_figure_of(const iso_figure_job *job)
{
    return job->more;
}

iso_status iso_paper_surface(const iso_figure_job *job, const iso_level *level0, double *value, iso_error *err)
{
    const double part = isnan(iso_lab_figure_of(job)->surface) ? 0.5 : iso_lab_figure_of(job)->surface;
    if (!(part > 0 && part < 1))
        return iso_fail(err, ISO_E_RANGE, "--surface is %g, must be between 0 and 1, a fraction of the volume's range",
                        part);
    *value = level0->min + part * (level0->max - level0->min);
    return ISO_OK;
}

/* Reports options that the kind would ignore. */
static iso_status check_options(const iso_figure_job *job, iso_error *err)
{
    const iso_lab_figure_options *o = iso_lab_figure_of(job);
    const struct {
        unsigned trait;
        bool given;
        const char *name;
    } options[] = {
        {ISO_LAB_FIGURE_HAS_CODE, o->code != NULL, "--code"},
        {ISO_LAB_FIGURE_HAS_BITS, o->bits != 0, "--bits"},
        {ISO_LAB_FIGURE_HAS_BRICKS, o->bricks != 0, "--bricks"},
        {ISO_LAB_FIGURE_HAS_ENTRIES, o->entries != 0, "--entries"},
        {ISO_LAB_FIGURE_HAS_SURFACE, !isnan(o->surface), "--surface"},
        {ISO_LAB_FIGURE_HAS_REGION, o->region != NULL, "--roi"},
    };
    for (size_t i = 0; i < sizeof options / sizeof *options; ++i)
        if (options[i].given && !(job->kind->takes & options[i].trait))
            return iso_fail(err, ISO_E_USAGE, "--kind %s does not take %s", job->kind->name, options[i].name);
    return ISO_OK;
}

static iso_status make(iso_figure_job *job, const char *kind, iso_error *err)
{
    iso_status status = kind ? iso_figure_kind_from_name(&kind_names, kind, &job->kind, err)
                             : iso_fail(err, ISO_E_USAGE, "--kind is missing; for a list: isoshade-lab figure --help");
    TRY(status, iso_colormap_from_name("magma", &job->map, err));
    TRY(status, check_options(job, err));
    return status == ISO_OK ? iso_figure_make(job, err) : status;
}

static void print_result(const iso_figure_job *job)
{
    if (!job->cli->json) {
        printf("figure: %s\n", job->output);
        return;
    }
    json_t *root = iso_cli_json(job->cli);
    json_object_set_new(root, "options", json_pack("{s:s}", "kind", job->kind->name));
    json_object_set_new(root, "output", json_string(job->output));
    if (json_object_size(job->facts))
        json_object_set(root, "facts", job->facts);
    iso_cli_print_json(root);
}

typedef struct lab_figure {
    iso_figure_job job;
    iso_lab_figure_options more;
    char *kind, *output;
} lab_figure;

static const iso_option options[] = {
    {"output", 'o', "write the figure into this folder", "DIR", ISO_IN(lab_figure, output)},
    {"kind", 0, "draw this figure, see below", "KIND", ISO_IN(lab_figure, kind)},
    {"width", 0, "limit the figure's width", "MM", ISO_IN(lab_figure, job.width_mm), .flags = ISO_SHOWN},
    {"height", 0, "limit the figure's height", "MM", ISO_IN(lab_figure, job.height_mm), .flags = ISO_SHOWN},
    {"dpi", 0, "set the resolution of its pictures", "DPI", ISO_IN(lab_figure, job.dpi), .flags = ISO_SHOWN},
    {"formats", 0, "write svg, png and latex next to the PDF (all)", "LIST", ISO_IN(lab_figure, job.formats)},
    {"sources", 0, "keep the gnuplot script and its pixels", NULL, ISO_IN(lab_figure, job.with_sources)},
    {"level", 0, "show this level", "K", ISO_IN(lab_figure, job.level), .flags = ISO_SHOWN, .most = 63},
    {"levels", 0, "use N levels, counting level 0 (4)", "N", ISO_IN(lab_figure, job.levels), .flags = ISO_NOT_ZERO,
     .least = 1, .most = ISO_FIGURE_MOST_LEVELS},
    {"code", 0, "use this direction code (the kind's own)", "CODE", ISO_IN(lab_figure, more.code)},
    {"bits", 0, "use N bits per direction component (5)", "N", ISO_IN(lab_figure, more.bits), .flags = ISO_NOT_ZERO},
    {"bricks", 0, "mixed levels: use N voxels per brick side (16)", "N", ISO_IN(lab_figure, more.bricks),
     .flags = ISO_NOT_ZERO},
    {"entries", 0, "use a palette of N directions (254)", "N", ISO_IN(lab_figure, more.entries), .flags = ISO_NOT_ZERO},
    {"surface", 0, "set the isosurface's value, a fraction of the range (0.5)", "PART",
     ISO_IN(lab_figure, more.surface)},
    {"roi", 0, "set the full-resolution box in level-0 voxels (middle half)", "X0,Y0,Z0,X1,Y1,Z1",
     ISO_IN(lab_figure, more.region)},
    ISO_OPTIONS_OF(lab_figure, job.look, iso_look_rows),
    ISO_OPTIONS_OF(lab_figure, job.volume, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    lab_figure *f = values;
    iso_figure_job *job = &f->job;
    job->cli = cli;
    job->facts = json_object();
    job->more = &f->more;
    job->input = cli->argument_count ? cli->arguments[0] : NULL;
    job->output = f->output;
    const iso_status status = make(job, f->kind, err);
    if (status == ISO_OK)
        print_result(job);
    json_decref(job->facts);
    return status;
}

const iso_command iso_lab_figure = {
    .name = "figure",
    .summary = "the figures of the papers, drawn from the program's own data",
    .max_arguments = 1,
    .usage = "[VOLUME|PYRAMID.iso] --kind KIND -o DIR [options]",
    .lists = (const iso_names *const[]){&kind_names, &iso_tf_preset_names, &iso_viewpoint_names, NULL},
    .examples = "  isoshade-lab figure --kind code-points --bits 3 --width 85 -o figure-points\n",
    ISO_COMMAND_OPTIONS(lab_figure, options,
                        .job = {.width_mm = 178, .height_mm = 230, .dpi = 300, .adapted = ISO_CLI_ADAPTED_DEFAULTS},
                        .more = {.surface = NAN}),
    .run = run,
};
