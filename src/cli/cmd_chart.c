/* SPDX-License-Identifier: MIT */
/* cmd_chart.c - charts speed against accuracy: measures a grid of settings, and finds the front and the cheapest
 * one. */
#define _GNU_SOURCE
#include <stdio.h>
#include <string.h>

#include "cli/chart_run.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"
#include "scene/viewpoint.h"
#include "tf/presets.h"
#include "renderers/external.h"
#include "cli/renderer_help.h"

static iso_status check(iso_chart_arguments *a, iso_error *err)
{
    if (!a->output)
        return iso_fail(err, ISO_E_USAGE, "-o is missing: folder for the chart");
    iso_status status = iso_renderers_load(a->renderers, err);
    if (status == ISO_OK && a->want_text)
        status = iso_words_parse_error("--want", a->want_text, &a->want, err);
    if (status == ISO_OK && a->metric_text)
        status = iso_chart_metric_from_name(a->metric_text, &a->metric, err);
    a->bytes = a->bytes_text && strcmp(a->bytes_text, "stored") == 0 ? ISO_CHART_STORED : ISO_CHART_DEVICE;
    return status;
}

/* Add the default to the text for --help; to be freed. */
static char *describe_with(const iso_option *option)
{
    char names[256], *text;
    iso_chart_default_renderers(names, sizeof names);
    return asprintf(&text, "%s (default: %s)", option->help, names) < 0 ? NULL : text;
}

static char *describe_codes(const iso_option *option)
{
    char names[256], *text;
    iso_chart_default_codes(names, sizeof names);
    return asprintf(&text, "%s (default: %s)", option->help, names) < 0 ? NULL : text;
}

static const iso_option options[] = {
    {"output", 'o', "folder for the chart", "DIR", ISO_IN(iso_chart_arguments, output)},
    ISO_OPTIONS_OF(iso_chart_arguments, look, iso_look_rows),
    {"want", 0, "print commands of the fastest and smallest setting within this error", "1/255",
     ISO_IN(iso_chart_arguments, want_text)},
    {"metric", 0, "error measure: rmse (default), flip (mean), or ssim (1 - SSIM)", "METRIC",
     ISO_IN(iso_chart_arguments, metric_text)},
    {"bytes", 0, "device (default): memory of the renderer; or stored: size of the files", "device|stored",
     ISO_IN(iso_chart_arguments, bytes_text), .flags = ISO_ONE_OF},
    {"budget", 0, "time limit of the whole run; 0: none, measures the whole grid", "SECONDS",
     ISO_IN(iso_chart_arguments, budget_seconds), .flags = ISO_SHOWN, .most = 1e6},
    {"with", 0, "renderers, or reference; missing default ones are left out", "LIST",
     ISO_IN(iso_chart_arguments, words.with), .describe = describe_with},
    ISO_CLI_RENDERERS_OPTION(iso_chart_arguments, renderers),
    {"steps", 0, "ray steps in voxels of the level", "LIST", ISO_IN(iso_chart_arguments, words.steps),
     .flags = ISO_SHOWN},
    {"quadratures", 0, "of %s", "LIST", ISO_IN(iso_chart_arguments, words.quadratures), .flags = ISO_SHOWN,
     ISO_NAMES_RENDERERS(ISO_READS_QUADRATURE)},
    {"estimators", 0, "gradient estimators for a volume; the reference uses the first", "LIST",
     ISO_IN(iso_chart_arguments, words.estimators), .flags = ISO_SHOWN},
    {"levels", 0, "number of levels of a volume, including the finest", "N", ISO_IN(iso_chart_arguments, level_count),
     .flags = ISO_SHOWN, .least = 1, .most = ISO_CHART_MAX_LEVELS},
    {"filters", 0, "direction filters for a volume's coarse levels", "LIST", ISO_IN(iso_chart_arguments, words.filters),
     .flags = ISO_SHOWN},
    {"codes", 0, "direction codes", "LIST", ISO_IN(iso_chart_arguments, words.codes), .describe = describe_codes},
    {"tfs", 0, "transfer functions of coarse levels: the scene's, adapted, or adapted 2D ones", "LIST",
     ISO_IN(iso_chart_arguments, words.tfs), .flags = ISO_SHOWN},
    {"plans", 0, "%s: bricks of mixed resolution for these predicted errors; or none", "LIST",
     ISO_IN(iso_chart_arguments, words.plans), .flags = ISO_SHOWN, ISO_NAMES_RENDERERS(ISO_HAS_BRICKS)},
    {"processor-time", 0, "measure processor time over all cores: for software GL on a busy machine", NULL,
     ISO_IN(iso_chart_arguments, processor_time)},
    {"resume", 0, "continue from the measurements of an earlier chart of the same scenes", NULL,
     ISO_IN(iso_chart_arguments, resume)},
    {"viewer", 0, "write a viewer page per scene, to which settings link", NULL, ISO_IN(iso_chart_arguments, viewer)},
    {"style", 0, "gnuplot settings to use instead of the built-in style.gp", "STYLE.gp",
     ISO_IN(iso_chart_arguments, style)},
    ISO_OPTIONS_OF(iso_chart_arguments, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    iso_chart_arguments *a = values;
    const iso_status status = check(a, err);
    return status == ISO_OK ? iso_cli_chart(a, cli, err) : status;
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
    ISO_COMMAND_OPTIONS(iso_chart_arguments, options, .words = ISO_CHART_DEFAULT_WORDS, .level_count = 3,
                        .budget_seconds = 120),
    .run = run,
};
