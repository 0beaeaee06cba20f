/* SPDX-License-Identifier: MIT */
/* reference.c - speedup of the reference by empty space, bounded rules and instruction sets: renders each picture with
 * and without them (iso_reference_options.plain) in turn, and compares processor times and values. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "lab/lab.h"
#include "lab/look.h"
#include "lab/volumes.h"
#include "render/reference.h"
#include "scene/views.h"

enum { WAYS = 2, RULES = 2 };
static const iso_quadrature rules[RULES] = {ISO_QUADRATURE_CONVERGED, ISO_QUADRATURE_MIDPOINT};
static const char *const rule_names[RULES] = {"converged", "midpoint"};

typedef struct reference_bench {
    const iso_cli *cli;
    iso_volume_input input;
    int size, runs;
    double log_sum[RULES];
    size_t count;
    json_t *rows;
} reference_bench;

typedef struct reference_times {
    double seconds[WAYS], error, difference; /* seconds: without, with */
    bool is_proved;
} reference_times;

static iso_status measure(const reference_bench *b, const iso_lab_visited *at, const iso_view *view,
                          iso_quadrature quadrature, reference_times *t, iso_error *err)
{
    const iso_pyramid *p = at->pyramid;
    const size_t values = 4 * view->width * view->height;
    double *rgba[WAYS] = {malloc(values * sizeof(double)), malloc(values * sizeof(double))};
    iso_status status = rgba[0] && rgba[1] ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for a picture");
    *t = (reference_times){.seconds = {INFINITY, INFINITY}};
    for (int run = 0; run < b->runs; ++run)
        for (int way = 0; way < WAYS && status == ISO_OK; ++way) {
            iso_reference_result result = {.rgba = rgba[way]};
            iso_reference_options opt = iso_reference_defaults();
            iso_image image;
            opt.quadrature = quadrature;
            opt.plain = way == 0;
            opt.threads = b->cli->threads;
            opt.result = &result;
            const double start = iso_cpu_seconds();
            status = iso_reference_render(&p->levels[0], p->options.code, view, &opt, &image, NULL, err);
            t->seconds[way] = fmin(t->seconds[way], iso_cpu_seconds() - start);
            t->error = result.error;
            t->is_proved = result.is_proved;
            if (status == ISO_OK)
                iso_image_destroy(&image);
        }
    for (size_t i = 0; i < values && status == ISO_OK; ++i)
        t->difference = fmax(t->difference, fabs(rgba[0][i] - rgba[1][i]));
    free(rgba[0]);
    free(rgba[1]);
    return status;
}

static iso_status visit(void *user, const iso_lab_visited *at, iso_error *err)
{
    reference_bench *b = user;
    const iso_lab_look look = {(size_t)b->size, true, 0.5};
    const iso_tf tf = iso_level_tf_of(at->tf);
    iso_view view;
    iso_status status = iso_lab_view(&look, &at->pyramid->levels[0], &tf, iso_view_of_faces(0, 1), &view, err);
    if (status != ISO_OK)
        return status;
    reference_times t[RULES];
    for (int r = 0; r < RULES && status == ISO_OK; ++r)
        status = measure(b, at, &view, rules[r], &t[r], err);
    iso_view_destroy(&view);
    if (status != ISO_OK)
        return status;
    ++b->count;
    for (int r = 0; r < RULES; ++r) {
        const double ratio = t[r].seconds[0] / t[r].seconds[1];
        b->log_sum[r] += log(ratio);
        json_t *row = json_pack("{s:s, s:s, s:s, s:f, s:f, s:f, s:f}", "volume", at->volume, "tf", at->tf->name, "rule",
                                rule_names[r], "plain_seconds", t[r].seconds[0], "seconds", t[r].seconds[1], "ratio",
                                ratio, "difference", t[r].difference);
        if (rules[r] == ISO_QUADRATURE_CONVERGED)
            json_object_update_new(row, json_pack("{s:f, s:b}", "error_bound", t[r].error, "error_bound_is_proved",
                                                  (int)t[r].is_proved));
        json_array_append_new(b->rows, row);
    }
    if (!b->cli->json)
        printf("%-20s %-13s %9.3f %9.3f %7.1f   %8.1e %8.1e %9.3f %9.3f %7.1f   %8.1e\n", at->volume, at->tf->name,
               t[0].seconds[0], t[0].seconds[1], t[0].seconds[0] / t[0].seconds[1], t[0].error, t[0].difference,
               t[1].seconds[0], t[1].seconds[1], t[1].seconds[0] / t[1].seconds[1], t[1].difference);
    fflush(stdout);
    return ISO_OK;
}

static iso_status bench(reference_bench *b, iso_error *err)
{
    iso_status status = ISO_OK;
    if (status != ISO_OK)
        return status;
    json_t *root = iso_cli_json(b->cli);
    b->rows = json_array();
    if (!b->cli->json)
        printf("%-20s %-13s %29s   %17s %29s   %8s\n%-20s %-13s %9s %9s %7s   %8s %8s %9s %9s %7s   %8s\n", "", "",
               "converged: plain s, s, ratio", "", "midpoint: plain s, s, ratio", "", "volume", "tf", "plain", "now",
               "ratio", "bound", "apart", "plain", "now", "ratio", "apart");
    const iso_lab_volumes volumes = {b->cli, &b->input, 1, NULL};
    status = iso_lab_visit_volumes(&volumes, visit, b, err);
    json_t *means = json_object();
    for (int r = 0; r < RULES && b->count > 0; ++r)
        json_object_set_new(means, rule_names[r], json_real(exp(b->log_sum[r] / (double)b->count)));
    if (!b->cli->json && status == ISO_OK && b->count > 0)
        printf("geometric mean of the ratios: %.1f converged, %.1f midpoint\n", exp(b->log_sum[0] / (double)b->count),
               exp(b->log_sum[1] / (double)b->count));
    json_object_set_new(root, "rows", b->rows);
    json_object_set_new(root, "mean_ratio", means);
    if (b->cli->json && status == ISO_OK)
        iso_cli_print_json(root);
    else
        json_decref(root);
    return status;
}

static const iso_option options[] = {
    {"size", 0, "pixels per side", "N", ISO_IN(reference_bench, size), .flags = ISO_SHOWN, .least = 4, .most = 1024},
    {"runs", 0, "render each picture N times; the least time counts", "N", ISO_IN(reference_bench, runs),
     .flags = ISO_SHOWN, .least = 1, .most = 100},
    ISO_OPTIONS_OF(reference_bench, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    reference_bench *b = values;
    b->cli = cli;
    return bench(b, err);
}

const iso_command iso_lab_reference = {
    .name = "reference",
    .summary = "the reference: with its empty space and bounded rules, and without",
    .min_arguments = 1,
    .max_arguments = 64,
    .usage = "VOLUME... [options]",
    .details =
        "Each volume under four transfer functions, shaded. Times are processor time of all threads. plain: no empty\n"
        "space is skipped, and every piece of a ray is halved until the result is stable. bound: upper bound of a\n"
        "pixel value's distance from the equation. apart: largest difference of the two pictures.",
    .examples = "  isoshade-lab reference v.nrrd --size 8\n",
    ISO_COMMAND_OPTIONS(reference_bench, options, .size = 24, .runs = 1),
    .run = run,
};
