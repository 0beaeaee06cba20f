/* SPDX-License-Identifier: MIT */
/* cmd_tf.c - finds and runs an action on transfer functions: adapt, convert, show and others. */
#define _GNU_SOURCE
#include <string.h>

#include "base/inputs.h"
#include "cli/tf.h"
#include "scene/viewpoint.h"
#include "tf/format.h"
#include "tf/presets.h"

/* Announces the output, except the files per level of adapt, which announces them once it knows the levels. */
static iso_status announce_output(const iso_tf_arguments *a, iso_error *err)
{
    const bool is_stem = strcmp(a->cli->arguments[0], "adapt") == 0 && a->level == 0;
    return a->output && !is_stem ? iso_inputs_announce(a->output, err) : ISO_OK;
}

static const struct {
    const char *name;
    iso_status (*run)(const iso_tf_arguments *a, iso_error *err);
} actions[] = {{"adapt", iso_cli_tf_adapt}, {"bound", iso_cli_tf_bound}, {"convert", iso_cli_tf_convert},
               {"names", iso_cli_tf_names}, {"show", iso_cli_tf_show},   {"suggest", iso_cli_tf_suggest}};
static const iso_names action_names = ISO_NAMES_OF_NAMES("action", actions);

static const iso_option options[] = {
    {"output", 'o', "file to write", "FILE", ISO_IN(iso_tf_arguments, output)},
    ISO_OPTIONS_OF(iso_tf_arguments, look, iso_look_rows),
    {"level", 0, "adapt, bound: only this level (adapt: all, as NAME_level_K.tf.json)", "K",
     ISO_IN(iso_tf_arguments, level), .most = 30},
    {"levels", 0, "adapt, bound: number of levels of a volume", "N", ISO_IN(iso_tf_arguments, level_count),
     .flags = ISO_SHOWN, .least = 2, .most = 30},
    {"optimize", 0, "adapt: by rendering too, kept if nearer to level 0", NULL, ISO_IN(iso_tf_arguments, optimize)},
    {"volume", 0, "convert, show: volume for fitted ranges; show: draw its histogram", "FILE",
     ISO_IN(iso_tf_arguments, volume)},
    ISO_OPTIONS_OF(iso_tf_arguments, adapted, iso_adapt_method_rows),
    ISO_OPTIONS_OF(iso_tf_arguments, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    iso_tf_arguments *a = values;
    size_t row = 0;
    a->cli = cli;
    NEED(announce_output(a, err));
    NEED(iso_names_find(&action_names, cli->arguments[0], &row, err));
    return actions[row].run(a, err);
}

const iso_command iso_command_tf = {
    .name = "tf",
    .summary = "suggest transfer functions, adapt them to levels, bound their error, convert and show them",
    .min_arguments = 1,
    .max_arguments = 16,
    .usage =
        "adapt VOLUME|PYRAMID.iso [--tf FILE|PRESET] -o OUT | bound VOLUME|PYRAMID.iso [--scene FILE.scene.json] | convert FILE|PRESET OUT | names FILE | show FILE|PRESET... -o PICTURE | suggest VOLUME|PYRAMID.iso [--tf PRESET] -o FILE.tf.json",
    .details =
        "adapt    writes a transfer function for each coarse level: a value gets the mean that level 0 shows in places\n"
        "         where the level has this value; small views of the level decide whether to use it. Joint histograms are kept\n"
        "         in the pyramid. render and export apply it with --adapt.\n"
        "bound    prints how far images of a scene's coarse levels can be from level 0's, without rendering: an upper\n"
        "         bound of the RMSE, with its own transfer function and with --adapt.\n"
        "convert  reads and writes the formats below, by endings and content; prints how far lookups are from\n"
        "         those of the other program. Lengths and opacities that the file lacks must be given.\n"
        "names    lists the transfer functions of a file for --name, one per line.\n"
        "show     draws a picture with gnuplot, .png, .svg or .pdf, a panel per transfer function; with --volume over the\n"
        "         histogram of its values, in logs.\n"
        "suggest  finds materials in the volume's joint histogram of value and gradient magnitude, and writes a transfer function\n"
        "         of at most 8 points to edit; with --tf, a preset of the list below for the volume's values.\n"
        "A transfer function is a file, a preset or a scene's (--scene); by default, the one that suggest finds. convert and\n"
        "show fit a preset to the values of --volume. --view, --zoom and --size set the pictures for bound.",
    .common = "output tf scene level levels range opacity volume view spacing threads",
    .examples =
        "  isoshade make shells --size 48 --type uint8 -o shells.nrrd\n"
        "  isoshade tf suggest shells.nrrd -o first.tf.json\n"
        "  isoshade tf suggest shells.nrrd --tf simulation -o simulation.tf.json\n"
        "  isoshade tf adapt shells.nrrd --tf refscenes/shells.tf.json -o shells\n"
        "  isoshade tf bound shells.nrrd --scene refscenes/shells.scene.json --size 48 --level 1\n"
        "  isoshade tf show refscenes/shells.tf.json shells_level_1.tf.json --volume shells.nrrd -o shells-tf.png\n"
        "  isoshade tf convert refscenes/shells.tf.json shells.vp.json --volume shells.nrrd\n"
        "  isoshade tf convert shells.vp.json --range fit -o again.tf.json\n"
        "  isoshade tf convert refscenes/shells.tf.json -o shells.paraview.json\n"
        "  isoshade tf names shells.paraview.json\n"
        "  isoshade tf convert shells.paraview.json --unit-distance 2 -o ramp.png\n",
    .lists = (const iso_names *const[]){&iso_tf_format_names, &iso_tf_preset_names, &iso_viewpoint_names, NULL},
    ISO_COMMAND_OPTIONS(iso_tf_arguments, options, .level_count = 4, .adapted = ISO_CLI_ADAPTED_DEFAULTS),
    .run = run,
};
