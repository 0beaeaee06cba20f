/* SPDX-License-Identifier: MIT */
/* cmd_figure.c - a publication figure from a report. */
#include <stdio.h>
#include <stdlib.h>

#include "options/cli.h"
#include "report/figure.h"

/* An option that the kind would pass over is an error: its user would believe it. */
static iso_status check_for_kind(const iso_figure_options *opt, int level, const char *methods, const char *scene,
                                 const char *variant, iso_error *err)
{
    if (opt->kind == ISO_FIGURE_LEVELS && (level != 0 || scene || variant))
        return iso_fail(err, ISO_E_USAGE, "--level, --scene and --variant are for --kind renderers alone");
    if (opt->kind == ISO_FIGURE_RENDERERS && methods)
        return iso_fail(err, ISO_E_USAGE, "--methods is for --kind levels alone; --variant chooses among renderers");
    return ISO_OK;
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    iso_figure_options opt = iso_figure_defaults();
    char *output = NULL, *kind = NULL, *methods = NULL, *variant = NULL, *scene = NULL;
    char notice[1024] = "";
    int level = 0;
    struct poptOption options[] = {
        {"output", 'o', POPT_ARG_STRING, &output, 0, "the folder for the figure", "DIR"},
        {"kind", 0, POPT_ARG_STRING, &kind, 0, "levels (default) or renderers", "KIND"},
        {"methods", 0, POPT_ARG_STRING, &methods, 0,
         "levels: of the report, such as naive,moments,moments+adapted; else its first and last", "LIST"},
        {"level", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &level, 0, "renderers: the level", "K"},
        {"scene", 0, POPT_ARG_STRING, &scene, 0, "renderers: which scene of a suite", "NAME"},
        {"variant", 0, POPT_ARG_STRING, &variant, 0,
         "renderers: comparisons of such a name, such as naive or \"adapted TF\"; else those of the scene as it is",
         "TEXT"},
        {"width", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &opt.width_mm, 0,
         "of the figure, at most; 85 is one column of many journals, 178 both", "MM"},
        {"height", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &opt.height_mm, 0, "of the figure, at most", "MM"},
        {"dpi", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &opt.dpi, 0, "of its pictures, at least", "DPI"},
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN) {
        status = iso_words_check_range("--level", level, 0, 63, err);
        if (status == ISO_OK && !output)
            status = iso_fail(err, ISO_E_USAGE, "-o is missing: the folder for the figure");
        if (status == ISO_OK && kind)
            status = iso_figure_from_name(kind, &opt.kind, err);
        if (status == ISO_OK)
            status = check_for_kind(&opt, level, methods, scene, variant, err);
        opt.level = (size_t)level;
        opt.methods = methods;
        opt.variant = variant;
        opt.scene = scene;
        opt.notice = notice;
        opt.notice_size = sizeof notice;
        if (status == ISO_OK)
            status = iso_figure_make(cli.arguments[0], &opt, output, err);
        if (status == ISO_OK && notice[0]) {
            iso_progress_line_hide(cli.progress);
            fprintf(stderr, "isoshade figure: warning: %s\n", notice);
        }
        if (status == ISO_OK && cli.json) {
            json_t *root = iso_cli_json(&cli);
            json_object_set_new(root, "options",
                                json_pack("{s:s, s:f, s:f, s:f}", "kind", iso_figure_name(opt.kind), "width_mm",
                                          opt.width_mm, "height_mm", opt.height_mm, "dpi", opt.dpi));
            json_object_set_new(root, "output", json_string(output));
            iso_cli_print_json(root);
        } else if (status == ISO_OK) {
            printf("figure: %s/figure.pdf\n", output);
        }
    }
    iso_cli_end(&cli);
    free(output);
    free(kind);
    free(methods);
    free(variant);
    free(scene);
    return status;
}

const iso_command iso_command_figure = {
    .name = "figure",
    .summary = "a publication figure from a report: pictures, difference maps, scale bar, colour legend",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "REPORT -o DIR [--kind levels|renderers] [options]",
    .details =
        "REPORT is a folder that `isoshade validate` wrote. DIR gets figure.pdf and figure.svg with vector text, caption.txt\n"
        "with the figures, and the gnuplot scripts that draw it: edit style.gp or figure.gp and run gnuplot there.\n"
        "--methods: on-the-fly, naive, eq1 and moments, the ways to make directions, under the original transfer function;\n"
        "on-the-fly+adapted, naive+adapted, eq1+adapted and moments+adapted, under the one adapted to each level.",
    .examples =
        "  isoshade make shells --size 40x44x37 -o shells.nrrd\n"
        "  isoshade validate shells.nrrd --scene refscenes/shells.scene.json --quick --with gl --size 32 -o report-fig\n"
        "  isoshade figure report-fig -o figure-levels --methods naive,moments,moments+adapted\n"
        "  isoshade figure report-fig -o figure-renderers --kind renderers --level 1\n",
    .run = run,
};
