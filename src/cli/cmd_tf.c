/* SPDX-License-Identifier: MIT */
/* cmd_tf.c - finds and runs an action on transfer functions: adapt, convert, show and others. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/file.h"
#include "cli/tf.h"
#include "base/inputs.h"
#include "scene/subject.h"
#include "scene/viewpoint.h"
#include "report/gnuplot.h"
#include "tf/format.h"
#include "tf/presets.h"

/* ---- triangle: Figure 7 -------------------------------------------------------------- */

#define TRIANGLE_STEPS 20

ISO_ENDING(end_adapter, iso_adapter, iso_adapter_destroy)

/* Measures the error of Eq. 6 for the weights s C + t T + (1 - s - t) G over the triangle of (s, t). */
static iso_status measure_triangle(const iso_joint *joint, const iso_adapt_options *given, const iso_tf_table *tf,
                                   const iso_geometry *level0, size_t level,
                                   double rms[TRIANGLE_STEPS + 1][TRIANGLE_STEPS + 1], iso_error *err)
{
    for (int i = 0; i <= TRIANGLE_STEPS; ++i)
        for (int j = 0; i + j <= TRIANGLE_STEPS; ++j) {
            iso_adapt_options opt = *given;
            ENDED_BY(end_adapter) iso_adapter *adapter = NULL;
            OWNED(iso_tf_table) table = {0};
            iso_adapt_judgment verdict = {0};
            opt.weight = ISO_WEIGHT_MIXED;
            opt.mix_s = (double)i / TRIANGLE_STEPS;
            opt.mix_t = fmin((double)j / TRIANGLE_STEPS, 1 - opt.mix_s);
            NEED(iso_adapter_create(joint, &opt, &adapter, err));
            NEED(iso_adapter_apply(adapter, tf, level0, level, &table, err));
            NEED(iso_adapt_judge(joint, tf, &table, level0, &verdict, err));
            rms[i][j] = verdict.rms_adapted;
        }
    return ISO_OK;
}

typedef struct triangle_picture {
    const iso_tf_arguments *arguments;
    double (*rms)[TRIANGLE_STEPS + 1];
} triangle_picture;

static iso_status write_triangle(FILE *gp, void *user, iso_error *err)
{
    const triangle_picture *t = user;
    (void)err;
    fputs(
        "set key off\nset size ratio 0.866\n"
        "unset border\nunset tics\nset colorbox\nset cbtics\nset cblabel 'RMS error at the voxels'\nset rmargin at screen 0.76\nset xrange [-0.1:1.1]\nset yrange [-0.1:1.0]\n"
        "set label 'Gaussian' at 0,-0.06 center\nset label 'constant' at 1,-0.06 center\nset label 'triangular' at 0.5,0.94 center\n"
        "title = ",
        gp);
    iso_gnuplot_put_quoted(gp, iso_path_base(t->arguments->cli->arguments[1]));
    fprintf(gp, "\nset title title . ', level %d' noenhanced\n$data << EOD\n", t->arguments->level);
    for (int i = 0; i <= TRIANGLE_STEPS; ++i)
        for (int j = 0; i + j <= TRIANGLE_STEPS; ++j)
            fprintf(gp, "%.4f %.4f %.9g\n", (i + 0.5 * j) / TRIANGLE_STEPS, 0.8660254 * j / TRIANGLE_STEPS,
                    t->rms[i][j]);
    fputs("EOD\nplot $data using 1:2:3 with points pt 7 ps 2.2 palette\n", gp);
    return ISO_OK;
}

static void print_triangle(const iso_tf_arguments *a, double rms[TRIANGLE_STEPS + 1][TRIANGLE_STEPS + 1])
{
    const double gauss = rms[0][0], constant = rms[TRIANGLE_STEPS][0], triangular = rms[0][TRIANGLE_STEPS];
    double least = INFINITY, s = 0, t = 0;
    for (int i = 0; i <= TRIANGLE_STEPS; ++i)
        for (int j = 0; i + j <= TRIANGLE_STEPS; ++j)
            if (rms[i][j] < least)
                least = rms[i][j], s = (double)i / TRIANGLE_STEPS, t = (double)j / TRIANGLE_STEPS;
    if (a->cli->json)
        iso_cli_print_results(a->cli,
                              json_pack("{s:f, s:f, s:f, s:f, s:f, s:f}", "rms_gauss", gauss, "rms_constant", constant,
                                        "rms_triangle", triangular, "rms_least", least, "least_s", s, "least_t", t));
    else
        printf(
            "RMS error at the voxels: Gaussian %.6f, constant %.6f, triangular %.6f; least %.6f at s = %.2f, t = %.2f\n",
            gauss, constant, triangular, least, s, t);
}

static iso_status triangle(const iso_tf_arguments *a, iso_error *err)
{
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_adapt_options opt;
    OWNED(iso_pyramid) p = {0};
    OWNED(iso_joint) joint = {0};
    iso_subject_look look;
    OWNED(iso_tf_table) table = {0};
    double rms[TRIANGLE_STEPS + 1][TRIANGLE_STEPS + 1] = {{0}};
    if (a->cli->argument_count != 2 || a->level < 1)
        return iso_fail(err, ISO_E_USAGE,
                        "usage: isoshade tf triangle VOLUME|PYRAMID.iso --level K [--tf FILE|PRESET] [-o PICTURE]");
    const char *input = a->cli->arguments[1];
    build.threads = a->cli->threads;
    build.level_count = (size_t)a->level + 1;
    NEED(iso_cli_adapt_options(&a->adapted, a->cli->threads, &opt, err));
    NEED(iso_cli_look_check(&a->look, a->cli->threads, &look, err));
    NEED(iso_cli_tf_load_subject(a, &look, false, &build, &p, err));
    NEED(iso_cli_tf_tabulate(&look, &p, &table, err));
    NEED(iso_joint_obtain(&p, iso_pyramid_is_one(input) ? input : NULL,
                          &(iso_joint_key){(size_t)a->level, opt.bits, ISO_SECOND_VALUE_NONE}, opt.threads, &joint,
                          err));
    NEED(measure_triangle(&joint, &opt, &table, &p.levels[0].geometry, (size_t)a->level, rms, err));
    if (a->output)
        NEED(iso_gnuplot_picture(a->output, 640, 480, write_triangle, &(triangle_picture){a, rms}, err));
    print_triangle(a, rms);
    return ISO_OK;
}

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
               {"names", iso_cli_tf_names}, {"show", iso_cli_tf_show},   {"suggest", iso_cli_tf_suggest},
               {"triangle", triangle}};
static const iso_names action_names = ISO_NAMES_OF_NAMES("action", actions);

static const iso_option options[] = {
    {"output", 'o', "file to write", "FILE", ISO_IN(iso_tf_arguments, output)},
    ISO_OPTIONS_OF(iso_tf_arguments, look, iso_look_rows),
    {"level", 0, "adapt, triangle: level (adapt: all, as NAME_level_K.tf.json)", "K", ISO_IN(iso_tf_arguments, level),
     .most = 30},
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
        "adapt VOLUME|PYRAMID.iso [--tf FILE|PRESET] -o OUT | bound VOLUME|PYRAMID.iso [--scene FILE.scene.json] | convert FILE|PRESET OUT | names FILE | show FILE|PRESET... -o PICTURE | suggest VOLUME|PYRAMID.iso [--tf PRESET] -o FILE.tf.json | triangle VOLUME|PYRAMID.iso [--tf FILE|PRESET] --level K",
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
        "show fit a preset to the values of --volume. --view, --zoom and --size set the pictures for bound.\n"
        "triangle draws the error at the voxels for mixtures of Gaussian, constant and triangular weights.",
    .common = "output tf scene level levels range opacity volume view spacing threads",
    .examples =
        "  isoshade make shells --size 48 --type uint8 -o shells.nrrd\n"
        "  isoshade tf suggest shells.nrrd -o first.tf.json\n"
        "  isoshade tf suggest shells.nrrd --tf simulation -o simulation.tf.json\n"
        "  isoshade tf adapt shells.nrrd --tf refscenes/shells.tf.json -o shells\n"
        "  isoshade tf bound shells.nrrd --scene refscenes/shells.scene.json --size 48 --level 1\n"
        "  isoshade tf show refscenes/shells.tf.json shells_level_1.tf.json --volume shells.nrrd -o shells-tf.png\n"
        "  isoshade tf triangle shells.nrrd --tf refscenes/shells.tf.json --level 1\n"
        "  isoshade tf convert refscenes/shells.tf.json shells.vp.json --volume shells.nrrd\n"
        "  isoshade tf convert shells.vp.json --range fit -o again.tf.json\n"
        "  isoshade tf convert refscenes/shells.tf.json -o shells.paraview.json\n"
        "  isoshade tf names shells.paraview.json\n"
        "  isoshade tf convert shells.paraview.json --unit-distance 2 -o ramp.png\n",
    .lists = (const iso_names *const[]){&iso_tf_format_names, &iso_tf_preset_names, &iso_viewpoint_names, NULL},
    ISO_COMMAND_OPTIONS(iso_tf_arguments, options, .level_count = 4, .adapted = ISO_CLI_ADAPTED_DEFAULTS),
    .run = run,
};
