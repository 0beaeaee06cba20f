/* SPDX-License-Identifier: MIT */
/* cmd_figure.c - a publication figure, of a report's pictures or of a volume. */
#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"
#include "cli/figure_drawn.h"
#include "options/cli.h"
#include "options/input.h"
#include "scene/viewpoint.h"
#include "tf/presets.h"

typedef struct figure_arguments {
    iso_figure_drawn drawn; /* its look.scene is a scene's name where the figure is of a report */
    char *output, *kind, *methods, *variant, *with;
    int level, levels, sources;
} figure_arguments;

/* An option that the kind would pass over is an error: its user would believe it. */
static iso_status check_for_kind(const figure_arguments *a, bool of_report, iso_error *err)
{
    const iso_figure_kind kind = a->drawn.figure.kind;
    const char *scene = of_report ? a->drawn.look.scene : NULL;
    if (kind == ISO_FIGURE_LEVELS && (a->level != 0 || scene || a->variant))
        return iso_fail(err, ISO_E_USAGE, "--level, --variant and the name of a scene are for --kind renderers alone");
    if (kind == ISO_FIGURE_RENDERERS && a->methods)
        return iso_fail(err, ISO_E_USAGE, "--methods is for --kind levels alone; --variant chooses among renderers");
    if (kind == ISO_FIGURE_RENDERERS && (a->levels || a->drawn.adapted.wanted))
        return iso_fail(err, ISO_E_USAGE, "--levels and --adapt are for --kind levels alone");
    return ISO_OK;
}

/* The same for options of the other input: a report has its pictures, a volume's are rendered. */
static iso_status check_for_input(const figure_arguments *a, bool of_report, iso_error *err)
{
    const iso_cli_look *look = &a->drawn.look;
    if (of_report &&
        (a->with || a->levels || a->drawn.adapted.wanted || look->tf || look->view || look->zoom > 0 || look->size))
        return iso_fail(err, ISO_E_USAGE,
                        "%s is a report, which has its pictures; --with, --levels, --adapt, --tf, --view, --zoom and "
                        "--size are for a figure of a volume",
                        a->drawn.cli->arguments[0]);
    if (!of_report && (a->methods || a->variant))
        return iso_fail(err, ISO_E_USAGE, "--methods and --variant are for a figure of a report");
    return ISO_OK;
}

static iso_status draw_report(figure_arguments *a, iso_error *err)
{
    char notice[1024] = "";
    iso_figure_options *o = &a->drawn.figure;
    o->methods = a->methods;
    o->variant = a->variant;
    o->scene = a->drawn.look.scene;
    o->notice = notice;
    o->notice_size = sizeof notice;
    const iso_status status = iso_figure_make(a->drawn.cli->arguments[0], o, a->output, err);
    if (status == ISO_OK && notice[0]) {
        iso_progress_line_hide(a->drawn.cli->progress);
        fprintf(stderr, "isoshade figure: warning: %s\n", notice);
    }
    return status;
}

static iso_status draw(figure_arguments *a, iso_error *err)
{
    char *report = iso_path_join(a->drawn.cli->arguments[0], "report.json");
    const bool of_report = report && iso_path_exists(report);
    iso_figure_options *o = &a->drawn.figure;
    free(report);
    iso_status status = iso_words_check_range("--level", a->level, 0, 63, err);
    if (status == ISO_OK && !a->output)
        status = iso_fail(err, ISO_E_USAGE, "-o is missing: the folder for the figure");
    if (status == ISO_OK && a->kind)
        status = iso_figure_from_name(a->kind, &o->kind, err);
    if (status == ISO_OK)
        status = check_for_kind(a, of_report, err);
    if (status == ISO_OK)
        status = check_for_input(a, of_report, err);
    if (status != ISO_OK)
        return status;
    o->level = (size_t)a->level;
    o->with_sources = a->sources;
    a->drawn.output = a->output;
    a->drawn.with = a->with;
    a->drawn.levels = a->levels ? a->levels : 4;
    if (of_report)
        return draw_report(a, err);
    status = iso_figure_draw_volume(&a->drawn, err);
    const char *input = a->drawn.cli->arguments[0];
    /* A folder may be slices of a volume as well as a report. */
    return status != ISO_OK && iso_path_is_dir(input) && !iso_pyramid_is_one(input)
               ? iso_fail_in(err, status, "%s is no report, it has no report.json; as a volume", input)
               : status;
}

static void print_result(const figure_arguments *a)
{
    const iso_figure_options *o = &a->drawn.figure;
    if (!a->drawn.cli->json) {
        printf("figure: %s/figure.pdf\n", a->output);
        return;
    }
    json_t *root = iso_cli_json(a->drawn.cli);
    json_object_set_new(root, "options",
                        json_pack("{s:s, s:f, s:f, s:f}", "kind", iso_figure_name(o->kind), "width_mm", o->width_mm,
                                  "height_mm", o->height_mm, "dpi", o->dpi));
    json_object_set_new(root, "output", json_string(a->output));
    iso_cli_print_json(root);
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    figure_arguments a = {.drawn = {.figure = iso_figure_defaults()}};
    iso_figure_options *o = &a.drawn.figure;
    iso_cli cli;
    iso_cli_next next;
    a.drawn.cli = &cli;
    a.drawn.adapted.cli = &cli;
    iso_volume_input_defaults(&a.drawn.input);
    iso_cli_adapted_defaults(&a.drawn.adapted);
    struct poptOption options[] = {
        {"output", 'o', POPT_ARG_STRING, &a.output, 0, "the folder for the figure", "DIR"},
        {"kind", 0, POPT_ARG_STRING, &a.kind, 0, "levels (default) or renderers", "KIND"},
        {"methods", 0, POPT_ARG_STRING, &a.methods, 0,
         "a report's levels: such as naive,moments,moments+adapted; else its first and last", "LIST"},
        {"level", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &a.level, 0, "renderers: the level", "K"},
        {"levels", 0, POPT_ARG_INT, &a.levels, 0, "a volume's levels: how many, with level 0 (4)", "N"},
        {"with", 0, POPT_ARG_STRING, &a.with, 0,
         "of a volume: the renderer of its levels (gl), or the renderers to be shown (all)", "LIST"},
        {"variant", 0, POPT_ARG_STRING, &a.variant, 0,
         "a report's renderers: comparisons of such a name, such as naive or \"adapted TF\"; else those of the scene as it is",
         "TEXT"},
        {"width", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &o->width_mm, 0,
         "of the figure, at most; 85 is one column of many journals, 178 both", "MM"},
        {"height", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &o->height_mm, 0, "of the figure, at most", "MM"},
        {"dpi", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &o->dpi, 0, "of its pictures, at least", "DPI"},
        {"sources", 0, POPT_ARG_NONE, &a.sources, 0, "keep the gnuplot scripts and the pixels that it is drawn from",
         NULL},
        {"adapt", 0, POPT_ARG_NONE, &a.drawn.adapted.wanted, 0,
         "a volume's levels: each with the transfer function adapted to it", NULL},
        ISO_CLI_LOOK_OPTIONS(&a.drawn.look),
        ISO_CLI_INPUT_OPTIONS(&a.drawn.input),
        POPT_TABLEEND,
    };
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN) {
        status = draw(&a, err);
        if (status == ISO_OK)
            print_result(&a);
    }
    iso_cli_end(&cli);
    free(a.output);
    free(a.kind);
    free(a.methods);
    free(a.variant);
    free(a.with);
    return status;
}

const iso_command iso_command_figure = {
    .name = "figure",
    .summary = "a publication figure of a volume or a report: pictures, difference maps, scale bar, color legend",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "VOLUME|PYRAMID.iso|REPORT -o DIR [--kind levels|renderers] [options]",
    .details =
        "DIR gets figure.pdf and figure.svg with vector text, and caption.txt with the figures. Of a volume the pictures are\n"
        "rendered for their places in print, with as many pixels as these have dots, in the scene's view and aspect. REPORT is\n"
        "a folder that `isoshade validate` wrote, whose pictures are enlarged by whole numbers; --scene names one of a suite's.\n"
        "--sources keeps the gnuplot scripts: edit style.gp or figure.gp and run gnuplot there.\n"
        "--methods: on-the-fly, naive, eq1 and moments, the ways to make directions, under the original transfer function;\n"
        "on-the-fly+adapted, naive+adapted, eq1+adapted and moments+adapted, under the one adapted to each level.",
    .lists = (const iso_names *const[]){&iso_tf_preset_names, &iso_viewpoint_names, NULL},
    .examples =
        "  isoshade make shells --size 40x44x37 -o shells.nrrd\n"
        "  isoshade figure shells.nrrd --levels 3 --width 85 -o figure-volume\n"
        "  isoshade figure shells.nrrd --scene refscenes/shells.scene.json --kind renderers --with gl --width 85 --dpi 150 -o figure-two\n"
        "  isoshade validate shells.nrrd --scene refscenes/shells.scene.json --quick --with gl --size 32 -o report-fig\n"
        "  isoshade figure report-fig -o figure-levels --methods naive,moments,moments+adapted\n"
        "  isoshade figure report-fig -o figure-renderers --kind renderers --level 1\n",
    .run = run,
};
