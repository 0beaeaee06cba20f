/* SPDX-License-Identifier: MIT */
/* triangle.c - the error at the voxels for mixtures of Gaussian, constant and triangular weights: Figure 7 of
 * younesy-2006. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>

#include "base/file.h"
#include "lab/lab.h"
#include "options/input.h"
#include "report/gnuplot.h"
#include "scene/subject.h"
#include "tf/adapt.h"

enum { STEPS = 20 };

typedef struct triangle {
    const iso_cli *cli;
    iso_volume_input input;
    char *tf, *output;
    int level;
    double rms[STEPS + 1][STEPS + 1]; /* of the weights (s, t), in steps */
} triangle;

ISO_ENDING(end_adapter, iso_adapter, iso_adapter_destroy)

/* Measures the error of Eq. 6 for the weights s C + t T + (1 - s - t) G over the triangle of (s, t). */
static iso_status measure(triangle *t, const iso_joint *joint, const iso_tf_table *tf, const iso_geometry *level0,
                          iso_error *err)
{
    for (int i = 0; i <= STEPS; ++i)
        for (int j = 0; i + j <= STEPS; ++j) {
            iso_adapt_options opt = iso_adapt_defaults();
            ENDED_BY(end_adapter) iso_adapter *adapter = NULL;
            OWNED(iso_tf_table) table = {0};
            iso_adapt_judgment verdict = {0};
            opt.weight = ISO_WEIGHT_MIXED;
            opt.mix_s = (double)i / STEPS;
            opt.mix_t = fmin((double)j / STEPS, 1 - opt.mix_s);
            NEED(iso_adapter_create(joint, &opt, &adapter, err));
            NEED(iso_adapter_apply(adapter, tf, level0, (size_t)t->level, &table, err));
            NEED(iso_adapt_judge(joint, tf, &table, level0, &verdict, err));
            t->rms[i][j] = verdict.rms_adapted;
        }
    return ISO_OK;
}

static iso_status write_triangle(FILE *gp, void *user, iso_error *err)
{
    const triangle *t = user;
    (void)err;
    fputs(
        "set key off\nset size ratio 0.866\n"
        "unset border\nunset tics\nset colorbox\nset cbtics\nset cblabel 'RMS error at the voxels'\nset rmargin at screen 0.76\nset xrange [-0.1:1.1]\nset yrange [-0.1:1.0]\n"
        "set label 'Gaussian' at 0,-0.06 center\nset label 'constant' at 1,-0.06 center\nset label 'triangular' at 0.5,0.94 center\n"
        "title = ",
        gp);
    iso_gnuplot_put_quoted(gp, iso_path_base(t->cli->arguments[0]));
    fprintf(gp, "\nset title title . ', level %d' noenhanced\n$data << EOD\n", t->level);
    for (int i = 0; i <= STEPS; ++i)
        for (int j = 0; i + j <= STEPS; ++j)
            fprintf(gp, "%.4f %.4f %.9g\n", (i + 0.5 * j) / STEPS, 0.8660254 * j / STEPS, t->rms[i][j]);
    fputs("EOD\nplot $data using 1:2:3 with points pt 7 ps 2.2 palette\n", gp);
    return ISO_OK;
}

static void print_triangle(const triangle *t)
{
    const double gauss = t->rms[0][0], constant = t->rms[STEPS][0], triangular = t->rms[0][STEPS];
    double least = INFINITY, least_s = 0, least_t = 0;
    for (int i = 0; i <= STEPS; ++i)
        for (int j = 0; i + j <= STEPS; ++j)
            if (t->rms[i][j] < least)
                least = t->rms[i][j], least_s = (double)i / STEPS, least_t = (double)j / STEPS;
    if (t->cli->json)
        iso_cli_print_results(t->cli, json_pack("{s:f, s:f, s:f, s:f, s:f, s:f}", "rms_gauss", gauss, "rms_constant",
                                                constant, "rms_triangle", triangular, "rms_least", least, "least_s",
                                                least_s, "least_t", least_t));
    else
        printf(
            "RMS error at the voxels: Gaussian %.6f, constant %.6f, triangular %.6f; least %.6f at s = %.2f, t = %.2f\n",
            gauss, constant, triangular, least, least_s, least_t);
}

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    triangle *t = values;
    iso_pyramid_options build = iso_pyramid_defaults();
    const iso_progress progress = iso_cli_progress(cli);
    OWNED(iso_pyramid) p = {0};
    OWNED(iso_tf) tf = {0};
    OWNED(iso_tf_table) table = {0};
    OWNED(iso_joint) joint = {0};
    t->cli = cli;
    build.threads = cli->threads;
    build.level_count = (size_t)t->level + 1;
    if (!t->tf)
        return iso_fail(err, ISO_E_USAGE, "--tf is missing: a transfer function");
    NEED(iso_tf_load(t->tf, &tf, err));
    NEED(iso_subject_load_pyramid(cli->arguments[0], &t->input, &build, &progress, &p, err));
    const iso_level *fine = &p.levels[0];
    NEED(iso_tf_tabulate(&tf, fine->min, fine->max, &fine->geometry, &table, err));
    NEED(iso_joint_compute(&p, (size_t)t->level, ISO_ADAPT_BITS, ISO_SECOND_VALUE_NONE, cli->threads, &joint, err));
    NEED(measure(t, &joint, &table, &fine->geometry, err));
    if (t->output)
        NEED(iso_gnuplot_picture(t->output, 640, 480, write_triangle, t, err));
    print_triangle(t);
    return ISO_OK;
}

static const iso_option options[] = {
    {"output", 'o', "picture to write", "FILE", ISO_IN(triangle, output)},
    {"tf", 0, "transfer function", "FILE", ISO_IN(triangle, tf)},
    {"level", 0, "level", "K", ISO_IN(triangle, level), .flags = ISO_SHOWN, .least = 1, .most = 30},
    ISO_OPTIONS_OF(triangle, input, iso_input_rows),
    ISO_OPTIONS_END,
};

const iso_command iso_lab_triangle = {
    .name = "triangle",
    .summary = "adapted transfer functions: the error at the voxels for mixtures of three weights (Figure 7)",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "VOLUME --tf FILE [options]",
    .examples = "  isoshade make shells --size 48 --type uint8 -o shells.nrrd\n"
                "  isoshade-lab triangle shells.nrrd --tf refscenes/shells.tf.json --level 1 -o triangle.png\n",
    ISO_COMMAND_OPTIONS(triangle, options, .level = 1),
    .run = run,
};
