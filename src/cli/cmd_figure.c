/* SPDX-License-Identifier: MIT */
/* cmd_figure.c - a publication figure, by one of the kinds of src/figure. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "figure/job.h"
#include "options/cli.h"
#include "options/input.h"
#include "scene/viewpoint.h"
#include "tf/presets.h"

typedef struct figure_arguments {
    iso_figure_job job;
    char *output, *kind, *map, *zoom, *error, *background;
} figure_arguments;

/* One number enlarges the middle of the picture, four choose a part of it. */
static iso_status parse_zoom(char *text, iso_figure_job *job, iso_error *err)
{
    double *z = job->inset;
    char after;
    const int count = sscanf(text, "%lf,%lf,%lf,%lf %c", &z[0], &z[1], &z[2], &z[3], &after);
    if (count == 1 && !strchr(text, ',')) {
        memset(job->inset, 0, sizeof job->inset);
        job->look.zoom = text;
        return iso_cli_zoom_parse(text, &(double){0}, err);
    }
    return count == 4 ? ISO_OK : iso_fail(err, ISO_E_USAGE, "--zoom is \"%s\", wanted X or X,Y,W,H", text);
}

/* A name, or three parts of linear light. */
static iso_status parse_background(const char *text, iso_figure_job *job, iso_error *err)
{
    double *c = job->background;
    char after;
    job->has_background = true;
    c[0] = c[1] = c[2] = strcmp(text, "white") == 0;
    if (!strcmp(text, "white") || !strcmp(text, "black"))
        return ISO_OK;
    if (sscanf(text, "%lf,%lf,%lf %c", &c[0], &c[1], &c[2], &after) != 3)
        return iso_fail(err, ISO_E_USAGE, "--background is \"%s\", wanted white, black or R,G,B", text);
    for (int i = 0; i < 3; ++i)
        if (!(c[i] >= 0 && c[i] <= 1))
            return iso_fail(err, ISO_E_RANGE, "--background is \"%s\", each part must be between 0 and 1", text);
    return ISO_OK;
}

static iso_status take_names(figure_arguments *a, iso_error *err)
{
    iso_status status = iso_figure_kind_from_name(&iso_figure_kind_names, a->kind ? a->kind : iso_figure_usual_kind(a->job.input),
                                                  &a->job.kind, err);
    TRY(status, iso_colormap_from_name(a->map ? a->map : "magma", &a->job.map, err));
    if (status == ISO_OK && a->error)
        status = iso_words_parse_error("--error", a->error, &a->job.error, err);
    if (status == ISO_OK && a->background)
        status = parse_background(a->background, &a->job, err);
    if (status == ISO_OK && a->zoom)
        status = parse_zoom(a->zoom, &a->job, err);
    return status;
}

static void print_result(const figure_arguments *a)
{
    const iso_figure_job *job = &a->job;
    if (!job->cli->json) {
        printf("figure: %s\n", a->output);
        return;
    }
    json_t *root = iso_cli_json(job->cli);
    json_object_set_new(root, "options",
                        json_pack("{s:s, s:f, s:f, s:f, s:s}", "kind", job->kind->name, "width_mm", job->width_mm,
                                  "height_mm", job->height_mm, "dpi", job->dpi, "map", job->map->name));
    json_object_set_new(root, "output", json_string(a->output));
    if (json_object_size(job->facts))
        json_object_set(root, "facts", job->facts);
    iso_cli_print_json(root);
}

static void free_list(char **list)
{
    for (size_t i = 0; list && list[i]; ++i)
        free(list[i]);
    free(list);
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    figure_arguments a = {.job = {.width_mm = 178, .height_mm = 230, .dpi = 300}};
    iso_figure_job *job = &a.job;
    iso_cli cli;
    iso_cli_next next;
    job->cli = &cli;
    job->facts = json_object();
    job->adapted.cli = &cli;
    iso_volume_input_defaults(&job->volume);
    iso_cli_adapted_defaults(&job->adapted);
    struct poptOption options[] = {
        {"output", 'o', POPT_ARG_STRING, &a.output, 0, "the folder for the figure", "DIR"},
        {"kind", 0, POPT_ARG_STRING, &a.kind, 0, "what it shows (levels; of a chart: chart)", "KIND"},
        {"width", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &job->width_mm, 0,
         "of the figure, at most; 85 is one column of many journals, 178 both", "MM"},
        {"height", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &job->height_mm, 0, "of the figure, at most", "MM"},
        {"dpi", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &job->dpi, 0, "of its pictures", "DPI"},
        {"map", 0, POPT_ARG_STRING, &a.map, 0, "the color map of its data (magma)", "MAP"},
        {"zoom", 0, POPT_ARG_STRING, &a.zoom, 0,
         "enlarge the middle of the pictures so many times; or an inset of a part of each: its left, top, width and "
         "height as parts of the picture",
         "X|X,Y,W,H"},
        {"background", 0, POPT_ARG_STRING, &a.background, 0,
         "of rendered pictures: white, as paper is, black, or R,G,B in parts of linear light (the scene's)", "COLOR"},
        {"letters", 0, POPT_ARG_NONE, &job->letters, 0, "panels get letters, (a), (b) and so on, for the text to name",
         NULL},
        {"formats", 0, POPT_ARG_STRING, &job->formats, 0, "beside the PDF: of svg, png and latex (all)", "LIST"},
        {"sources", 0, POPT_ARG_NONE, &job->with_sources, 0,
         "keep the gnuplot script and the pixels that it is drawn from", NULL},
        {"with", 0, POPT_ARG_STRING, &job->with, 0,
         "of a volume: the renderer (gl, or cpu where OpenGL is software alone), or the renderers to be shown (all)", "LIST"},
        {"level", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &job->level, 0, "the level that is shown", "K"},
        {"levels", 0, POPT_ARG_INT, &job->levels, ISO_CLI_NOT_ZERO, "how many levels, with level 0 (4)", "N"},
        {"adapt", 0, POPT_ARG_NONE, &job->adapted.wanted, 0,
         "a volume's levels: each with the transfer function adapted to it", NULL},
        {"frames", 0, POPT_ARG_INT, &job->frames, ISO_CLI_NOT_ZERO, "of a turntable (8)", "N"},
        {"error", 0, POPT_ARG_STRING, &a.error, 0, "of a plan: the largest RMSE allowed in the picture (1/255)",
         "1/255"},
        {"case", 0, POPT_ARG_STRING, &job->atlas_case, 0, "failure: which entry of isoshade atlas (its first)", "NAME"},
        {"methods", 0, POPT_ARG_STRING, &job->methods, 0,
         "which methods, such as naive,moments,moments+adapted; of a report's levels else its first and last", "LIST"},
        {"variant", 0, POPT_ARG_STRING, &job->variant, 0,
         "a report's renderers: comparisons of such a name, such as naive or \"adapted TF\"; else those of the scene as it is",
         "TEXT"},
        ISO_CLI_SCENE_OPTION(&job->look),
        {"tf", 0, POPT_ARG_ARGV, &job->tfs, 0,
         "transfer function: a file, or a preset of isoshade list (the scene's; auto); of a sheet repeated for several",
         "FILE|PRESET"},
        ISO_CLI_TRANSFER_OPTIONS(&job->look.transfer),
        {"view", 0, POPT_ARG_ARGV, &job->views, 0,
         "where to look from: a name of isoshade list, or degrees (the scene's; front of a patient, else iso); of a sheet "
         "repeated for several (front, left, top, iso)",
         "NAME|AZ,EL"},
        {"size", 0, POPT_ARG_STRING, &job->look.size, 0, "the aspect of the pictures instead of the scene's, or of 1x1",
         "WxH"},
        ISO_CLI_INPUT_OPTIONS(&job->volume),
        POPT_TABLEEND,
    };
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN) {
        job->look.tf = job->tfs ? job->tfs[0] : NULL;
        job->look.view = job->views ? job->views[0] : NULL;
        job->input = cli.argument_count ? cli.arguments[0] : NULL;
        job->output = a.output;
        status = take_names(&a, err);
        TRY(status, iso_figure_make(job, err));
        if (status == ISO_OK)
            print_result(&a);
    }
    iso_cli_end(&cli);
    json_decref(job->facts);
    char *texts[] = {a.output,  a.kind,  a.map,        a.zoom,    job->methods,    job->variant,
                     job->with, a.error, a.background, job->atlas_case, job->formats};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i)
        free(texts[i]);
    free_list(job->tfs);
    free_list(job->views);
    return status;
}

const iso_command iso_command_figure = {
    .name = "figure",
    .summary =
        "a publication figure of a volume, a report or a chart: pictures at print size, difference maps, scale bar",
    .min_arguments = 0,
    .max_arguments = 1,
    .usage = "VOLUME|PYRAMID.iso|REPORT|CHART -o DIR [--kind KIND] [options]",
    .details =
        "DIR gets figure.pdf and figure.svg with vector text, figure.png, figure-latex.tex for \\input, whose text is set by LaTeX\n"
        "in the fonts of the paper, and caption.txt with the figures. Of a volume the pictures are rendered for their places in\n"
        "print, with as many pixels as these have dots, in the scene's view and aspect. REPORT is a folder that `isoshade\n"
        "validate` wrote, whose pictures are enlarged by whole numbers; --scene names one of a suite's.\n"
        "--sources keeps figure.gp: edit it or style.gp and run gnuplot there.\n"
        "--methods: on-the-fly, naive, eq1 and moments, the ways to make directions, under the original transfer function;\n"
        "on-the-fly+adapted, naive+adapted, eq1+adapted and moments+adapted, under the one adapted to each level.",
    .lists = (const iso_names *const[]){&iso_figure_kind_names, &iso_colormap_names, &iso_tf_preset_names,
                                        &iso_viewpoint_names, NULL},
    .common = "output kind width height dpi with level levels scene tf view size zoom background letters formats threads",
    .examples =
        "  isoshade make shells --size 40x44x37 -o shells.nrrd\n"
        "  isoshade figure shells.nrrd --levels 3 --width 85 -o figure-volume\n"
        "  isoshade figure shells.nrrd --scene refscenes/shells.scene.json --kind renderers --with gl --width 85 --dpi 150 -o figure-two\n"
        "  isoshade validate shells.nrrd --scene refscenes/shells.scene.json --quick --with gl --size 32 -o report-fig\n"
        "  isoshade figure report-fig -o figure-levels --methods naive,moments,moments+adapted\n"
        "  isoshade figure report-fig -o figure-renderers --kind renderers --level 1\n"
        "  isoshade figure shells.nrrd --kind tf --width 85 -o figure-tf\n"
        "  isoshade figure shells.nrrd --kind sheet --tf auto --tf simulation --view front --view 30,20 --width 85 -o figure-sheet\n"
        "  isoshade figure --kind failure --case thin-plates --width 85 -o figure-failure\n",
    .run = run,
};
