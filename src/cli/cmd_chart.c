/* SPDX-License-Identifier: MIT */
/* cmd_chart.c - charts speed against accuracy: measures a grid of settings, and finds the front and the cheapest
 * one. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/chart_run.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"
#include "scene/viewpoint.h"
#include "tf/presets.h"
#include "renderers/external.h"

static iso_status check(iso_chart_arguments *a, iso_error *err)
{
    if (!a->output)
        return iso_fail(err, ISO_E_USAGE, "-o is missing: folder for the chart");
    iso_status status = iso_renderers_load(a->renderers, err);
    TRY(status, iso_words_check_range("--levels", a->level_count, 1, ISO_CHART_MAX_LEVELS, err));
    TRY(status, iso_words_check_range("--budget", a->budget_seconds, 0, 1e6, err));
    if (status == ISO_OK && a->want_text)
        status = iso_words_parse_error("--want", a->want_text, &a->want, err);
    if (status == ISO_OK && a->metric_text)
        status = iso_chart_metric_from_name(a->metric_text, &a->metric, err);
    if (status == ISO_OK && a->bytes_text) {
        a->bytes = strcmp(a->bytes_text, "stored") == 0 ? ISO_CHART_STORED : ISO_CHART_DEVICE;
        if (a->bytes == ISO_CHART_DEVICE && strcmp(a->bytes_text, "device") != 0)
            status = iso_fail(err, ISO_E_USAGE, "--bytes is \"%s\", must be device or stored", a->bytes_text);
    }
    return status;
}

/* Writes "words (default: LIST)" for --help. Returns text. */
static const char *with_default(char *text, size_t size, const char *words, const char *list)
{
    snprintf(text, size, "%s (default: %s)", words, list);
    return text;
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    iso_chart_arguments a = {.level_count = 3, .budget_seconds = 120};
    const iso_chart_words *usual = &iso_chart_default_words;
    char help[8][256], codes[200], renderers[256], quadratures[128], plans[200], names[100];
    snprintf(quadratures, sizeof quadratures, "of %s",
             iso_renderers_with(ISO_READS_QUADRATURE, ", ", " and ", names, sizeof names));
    snprintf(plans, sizeof plans, "%s: bricks of mixed resolution for these predicted errors; or none",
             iso_renderers_with(ISO_HAS_BRICKS, ", ", " and ", names, sizeof names));
    iso_volume_input_defaults(&a.input);
    struct poptOption options[] = {
        {"output", 'o', POPT_ARG_STRING, &a.output, 0, "folder for the chart", "DIR"},
        ISO_CLI_LOOK_OPTIONS(&a.look),
        {"want", 0, POPT_ARG_STRING, &a.want_text, 0,
         "print commands of the fastest and smallest setting within this error", "1/255"},
        {"metric", 0, POPT_ARG_STRING, &a.metric_text, 0,
         "error measure: rmse (default), flip (mean), or ssim (1 - SSIM)", "METRIC"},
        {"bytes", 0, POPT_ARG_STRING, &a.bytes_text, 0,
         "device (default): memory of the renderer; or stored: size of the files", "WHICH"},
        {"budget", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &a.budget_seconds, 0,
         "time limit of the whole run; 0: none, measures the whole grid", "SECONDS"},
        {"with", 0, POPT_ARG_STRING, &a.words.with, 0,
         with_default(help[0], sizeof *help, "renderers, or reference; missing default ones are left out",
                      iso_chart_default_renderers(renderers, sizeof renderers)),
         "LIST"},
        ISO_CLI_RENDERERS_OPTION(&a.renderers),
        {"steps", 0, POPT_ARG_STRING, &a.words.steps, 0,
         with_default(help[1], sizeof *help, "ray steps in voxels of the level", usual->steps), "LIST"},
        {"quadratures", 0, POPT_ARG_STRING, &a.words.quadratures, 0,
         with_default(help[2], sizeof *help, quadratures, usual->quadratures), "LIST"},
        {"estimators", 0, POPT_ARG_STRING, &a.words.estimators, 0,
         with_default(help[3], sizeof *help, "gradient estimators for a volume; the reference uses the first",
                      usual->estimators),
         "LIST"},
        {"levels", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &a.level_count, 0,
         "number of levels of a volume, including the finest", "N"},
        {"filters", 0, POPT_ARG_STRING, &a.words.filters, 0,
         with_default(help[4], sizeof *help, "direction filters for a volume's coarse levels", usual->filters), "LIST"},
        {"codes", 0, POPT_ARG_STRING, &a.words.codes, 0,
         with_default(help[5], sizeof *help, "direction codes", iso_chart_default_codes(codes, sizeof codes)), "LIST"},
        {"tfs", 0, POPT_ARG_STRING, &a.words.tfs, 0,
         with_default(help[6], sizeof *help,
                      "transfer functions of coarse levels: the scene's, adapted, or adapted 2D ones", usual->tfs),
         "LIST"},
        {"plans", 0, POPT_ARG_STRING, &a.words.plans, 0, with_default(help[7], sizeof *help, plans, usual->plans),
         "LIST"},
        {"processor-time", 0, POPT_ARG_NONE, &a.processor_time, 0,
         "measure processor time over all cores: for software GL on a busy machine", NULL},
        {"resume", 0, POPT_ARG_NONE, &a.resume, 0,
         "continue from the measurements of an earlier chart of the same scenes", NULL},
        {"viewer", 0, POPT_ARG_NONE, &a.viewer, 0, "write a viewer page per scene, to which settings link", NULL},
        {"style", 0, POPT_ARG_STRING, &a.style, 0, "gnuplot settings to use instead of the built-in style.gp",
         "STYLE.gp"},
        ISO_CLI_INPUT_OPTIONS(&a.input),
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = check(&a, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = iso_cli_chart(&a, &cli, err);
    iso_cli_end(&cli);
    return status;
}

const iso_command iso_command_chart = {
    .name = "chart",
    .summary = "chart speed against accuracy, and find the setting that is good enough for a scene",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "VOLUME|PYRAMID.iso -o DIR [--scene SCENE.scene.json] [--want 1/255] [options]",
    .details =
        "Renders the scene with every renderer, step, quadrature, estimator, level, direction filter, code, other source of\n"
        "directions (floats, flipped, palettes, on the fly), transfer function and plan of mixed resolution. Errors are measured\n"
        "against one reference: level 0, converged, under the scene's own transfer function, with the directions of\n"
        "the first estimator as floats. The usual choices come first at every level and step, then settings that differ in one\n"
        "axis, in two, and so on; skipped ones are listed, and --budget 0 measures all. A setting is on the\n"
        "front if no other is both as fast (or as small) and as exact; finer steps than the level's error needs come last.\n"
        "--scene A,B measures each setting in each scene, and --want applies to all of them.\n"
        "\n"
        "Times are of one frame, the fastest of up to 5 after a warm-up; settings near the front are timed again at the\n"
        "end, in rounds. The median and the slowest are listed, too, as is the time before the frame (textures; start,\n"
        "export and reading of Blender and POV-Ray). Device bytes are the textures' sizes (gl), Blender's own\n"
        "count, POV-Ray's DF3 files, or the reference's arrays.\n"
        "\n"
        "DIR holds index.html (the chart as a page, with a picture of each setting), pareto.svg, pareto.pdf, pareto.csv,\n"
        "chart.json and reference.exr; edit style.gp there and run \"gnuplot pareto.gp\" to restyle. Exit code 1: no measured\n"
        "setting has the wanted error; the nearest is named.",
    .common =
        "output scene tf view size want metric budget with steps levels filters codes resume viewer spacing threads",
    .examples =
        "  isoshade make marschner-lobb --size 40x56x33 -o ml.nrrd\n"
        "  isoshade chart ml.nrrd --scene refscenes/marschner-lobb.scene.json --size 32 --levels 2 --with gl --codes fit,cube --steps 1,0.5 --budget 0 -o chart\n"
        "  isoshade chart ml.nrrd --scene refscenes/marschner-lobb.scene.json --size 32 --with gl --levels 2 --steps 1,0.5 --metric flip --budget 10 --json -o chart2\n",
    .lists = (const iso_names *const[]){&iso_code_names, &iso_direction_filter_names, &iso_gradient_names,
                                        &iso_tf_preset_names, &iso_viewpoint_names, NULL},
    .run = run,
};
