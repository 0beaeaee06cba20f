/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "lab/shading_run.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "lab/quartiles.h"
#include "compare/ssim.h"

static const char *const block_names[ISO_SHADING_BLOCKS] = {"volumes of the set", "analytic volumes of the set",
                                                            "held back"};

int iso_shading_wins(const iso_shading_run *run, const iso_shading_result *r, int m)
{
    int count = 0;
    for (int i = 0; i < run->views; ++i)
        count += r->error[m].dssim[i] < r->error[ISO_SHADING_ON_THE_FLY].dssim[i];
    return count;
}

const char *iso_shading_why_left_out(const iso_shading_run *run, const iso_shading_result *r)
{
    bool errs = false;
    for (int m = 0; m < iso_shading_method_end(run); ++m)
        errs = errs || r->error[m].dssim_mean > 0;
    if (!(r->error[ISO_SHADING_ON_THE_FLY].alpha_max >= ISO_SSIM_FOREGROUND))
        return "this level shows nothing";
    return errs ? NULL : "no method has an error";
}

typedef struct summary {
    size_t images, better, levels_better, cases;
    iso_ratios ratios;   /* of DSSIM to on-the-fly's */
    double angle, truth; /* means */
    size_t truth_cases;
} summary;

static summary summarize(const iso_shading_run *run, iso_shading_block b, size_t k, int m)
{
    summary s = {0};
    double ratios[ISO_SHADING_SUBJECTS];
    for (size_t at = 0; at < run->subject_count; ++at) {
        const iso_shading_result *r = iso_shading_result_of(run, at, k);
        if (run->subjects[at].block != b || !r->done || r->left_out)
            continue;
        const double floor_error = 1e-7; /* two perfect methods have a ratio of 1 */
        ratios[s.cases] = (r->error[m].dssim_mean + floor_error) /
                          (r->error[ISO_SHADING_ON_THE_FLY].dssim_mean + floor_error);
        s.images += (size_t)run->views;
        s.better += (size_t)iso_shading_wins(run, r, m);
        s.levels_better += r->error[m].dssim_mean < r->error[ISO_SHADING_ON_THE_FLY].dssim_mean;
        ++s.cases;
        s.angle += r->error[m].angle_mean_deg;
        s.truth_cases += isfinite(r->error[m].truth_mean_deg);
        s.truth += isfinite(r->error[m].truth_mean_deg) ? r->error[m].truth_mean_deg : 0;
    }
    s.ratios = iso_ratios_summarize(ratios, s.cases);
    s.angle /= (double)s.cases;
    s.truth /= (double)s.truth_cases;
    return s;
}

static json_t *summary_to_json(const summary *s, iso_shading_block b, int m, size_t k)
{
    json_t *o = json_pack("{s:s, s:s, s:i, s:o, s:o, s:o, s:o}", "block", block_names[b], "method",
                          iso_shading_methods[m].name, "level", (int)k, "dssim_ratio",
                          iso_json_number(s->ratios.geometric_mean), "dssim_ratio_median",
                          iso_json_number(s->ratios.median), "dssim_ratio_lower_quartile",
                          iso_json_number(s->ratios.lower), "dssim_ratio_upper_quartile",
                          iso_json_number(s->ratios.upper));
    json_object_update_new(o, json_pack("{s:o, s:o, s:i, s:i, s:i, s:i}", "gradient_angle_mean_deg",
                                        iso_json_number(s->angle), "truth_angle_mean_deg", iso_json_number(s->truth),
                                        "images", (int)s->images, "images_better", (int)s->better, "volumes",
                                        (int)s->cases, "volumes_better", (int)s->levels_better));
    return o;
}

/* Texts with one figure per level. */
typedef struct columns {
    char means[64], medians[160], angles[64], truths[64];
} columns;

static void add(char *text, size_t size, const char *format, double a, double b, double c)
{
    const size_t length = strlen(text);
    snprintf(text + length, size - length, format, a, b, c);
}

static void report_method(const iso_shading_run *run, iso_shading_block b, int m, json_t *rows)
{
    columns text = {"", "", "", ""};
    size_t better = 0, images = 0, levels_better = 0, cases = 0;
    for (size_t k = 1; k < (size_t)run->levels; ++k) {
        const summary s = summarize(run, b, k, m);
        add(text.means, sizeof text.means, " %6.3f", s.ratios.geometric_mean, 0, 0);
        add(text.medians, sizeof text.medians, " %.3f (%.3f-%.3f)", s.ratios.median, s.ratios.lower, s.ratios.upper);
        add(text.angles, sizeof text.angles, " %5.1f", s.angle, 0, 0);
        if (isfinite(s.truth))
            add(text.truths, sizeof text.truths, " %5.1f", s.truth, 0, 0);
        better += s.better;
        images += s.images;
        levels_better += s.levels_better;
        cases += s.cases;
        json_array_append_new(rows, summary_to_json(&s, b, m, k));
    }
    if (!run->cli->json)
        printf("%-12s %s  | %s  | %s  | %-18s  | %zu of %zu, %zu of %zu\n", iso_shading_methods[m].name, text.means,
               text.medians, text.angles, text.truths, levels_better, cases, better, images);
}

static size_t count_of_block(const iso_shading_run *run, iso_shading_block b)
{
    size_t count = 0;
    for (size_t at = 0; at < run->subject_count; ++at)
        count += run->subjects[at].block == b;
    return count;
}

static void report_block(const iso_shading_run *run, iso_shading_block b, json_t *rows)
{
    if (count_of_block(run, b) == 0)
        return;
    if (!run->cli->json)
        printf(
            "\n%s, levels 1 to %d: DSSIM / on-the-fly's: geometric mean, median (quartiles); mean angle to G0;\n"
            "to exact gradients; better than on the fly: of all volumes and levels (mean of the views), of all views\n",
            block_names[b], run->levels - 1);
    for (int m = 0; m < iso_shading_method_end(run); ++m)
        report_method(run, b, m, rows);
}

/* Reports volumes left out, and levels of the others. */
static void report_left_out(const iso_shading_run *run, json_t *rows)
{
    for (size_t at = 0; at < run->subject_count; ++at) {
        const iso_otsu_surface *surface = &run->surfaces[at];
        if (surface->left_out)
            json_array_append_new(rows, json_pack("{s:s, s:s, s:n, s:s, s:f, s:f, s:f}", "volume",
                                                  run->subjects[at].name, "block", block_names[run->subjects[at].block],
                                                  "level", "why", surface->left_out, "surface", surface->fraction,
                                                  "border_shown", surface->border, "ramp", surface->ramp));
        for (size_t k = 1; k < (size_t)run->levels; ++k) {
            const iso_shading_result *r = iso_shading_result_of(run, at, k);
            if (r->done && r->left_out)
                json_array_append_new(rows, json_pack("{s:s, s:s, s:i, s:s}", "volume", run->subjects[at].name, "block",
                                                      block_names[run->subjects[at].block], "level", (int)k, "why",
                                                      r->left_out));
        }
    }
    if (run->cli->json)
        return;
    printf("\nleft out of means and medians: %zu\n", json_array_size(rows));
    size_t i;
    json_t *row;
    json_array_foreach (rows, i, row) {
        const json_t *level = json_object_get(row, "level");
        printf("%s, %s", json_string_value(json_object_get(row, "volume")), json_is_integer(level) ? "level " : "");
        if (json_is_integer(level))
            printf("%lld: ", (long long)json_integer_value(level));
        printf("%s\n", json_string_value(json_object_get(row, "why")));
    }
}

/* Returns why the default lost. A direction shorter than half stands for children that disagree by 45 degrees. */
static const char *cause_of(const iso_shading_result *r, int view)
{
    const double fly = r->error[ISO_SHADING_ON_THE_FLY].dssim[view];
    if (fly >= 0.49)
        return "the surface has vanished at this level";
    if (r->floor.dssim[view] >= fly)
        return "the scalar: level 0's own directions are no better";
    return r->error[ISO_SHADING_DEFAULT].length_mean < 0.5 ? "directions that cancel within a voxel" : "the directions";
}

static void report_exceptions(const iso_shading_run *run, json_t *rows)
{
    size_t count = 0;
    for (size_t at = 0; at < run->subject_count; ++at)
        for (size_t k = 1; k < (size_t)run->levels; ++k) {
            const iso_shading_result *r = iso_shading_result_of(run, at, k);
            for (int i = 0; r->done && !r->left_out && i < run->views; ++i) {
                const double fly = r->error[ISO_SHADING_ON_THE_FLY].dssim[i],
                             own = r->error[ISO_SHADING_DEFAULT].dssim[i], least = r->floor.dssim[i];
                if (own < fly)
                    continue;
                const char *cause = cause_of(r, i);
                if (!run->cli->json)
                    printf("%s%s, level %zu, view %d: %.5f, on the fly %.5f, floor %.5f, mean length %.2f: %s\n",
                           count++ ? "" : "\nnot better than on the fly:\n", run->subjects[at].name, k, i, own, fly,
                           least, r->error[ISO_SHADING_DEFAULT].length_mean, cause);
                json_array_append_new(rows, json_pack("{s:s, s:i, s:o, s:i, s:f, s:f, s:f, s:s}", "volume",
                                                      run->subjects[at].name, "level", (int)k, "length_mean",
                                                      iso_json_number(r->error[ISO_SHADING_DEFAULT].length_mean),
                                                      "view", i, "dssim", own, "dssim_on_the_fly", fly, "dssim_floor",
                                                      least, "cause", cause));
            }
        }
}

static json_t *cases_to_json(const iso_shading_run *run)
{
    json_t *cases = json_array();
    for (size_t at = 0; at < run->subject_count; ++at)
        for (size_t k = 1; k < (size_t)run->levels; ++k)
            for (int m = 0; m < iso_shading_method_end(run) && iso_shading_result_of(run, at, k)->done; ++m) {
                const iso_shading_error *e = &iso_shading_result_of(run, at, k)->error[m];
                json_array_append_new(cases,
                                      json_pack("{s:s, s:f, s:b, s:s, s:i, s:s, s:f, s:o, s:o, s:o, s:o, s:s?}",
                                                "volume", run->subjects[at].name, "surface", run->surfaces[at].fraction,
                                                "shown_below", run->surfaces[at].below, "block",
                                                block_names[run->subjects[at].block], "level", (int)k, "method",
                                                iso_shading_methods[m].name, "dssim_mean", e->dssim_mean, "dssim",
                                                iso_json_numbers(e->dssim, (size_t)run->views),
                                                "gradient_angle_mean_deg", iso_json_number(e->angle_mean_deg),
                                                "gradient_angle_p95_deg", iso_json_number(e->angle_p95_deg),
                                                "truth_angle_mean_deg", iso_json_number(e->truth_mean_deg), "left_out",
                                                iso_shading_result_of(run, at, k)->left_out));
            }
    return cases;
}

iso_status iso_shading_write_csv(const iso_shading_run *run, iso_error *err)
{
    FREED char *text = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size);
    NEED_MEMORY(memory, err, "no memory for the table");
    fprintf(memory,
            "block,volume,level,method,dssim_mean,gradient_angle_mean_deg,gradient_angle_p95_deg,truth_angle_mean_deg");
    for (int i = 0; i < run->views; ++i)
        fprintf(memory, ",dssim_%d", i);
    for (size_t at = 0; at < run->subject_count; ++at)
        for (size_t k = 1; k < (size_t)run->levels; ++k)
            for (int m = 0; m < iso_shading_method_end(run) && iso_shading_result_of(run, at, k)->done; ++m) {
                const iso_shading_error *e = &iso_shading_result_of(run, at, k)->error[m];
                fprintf(memory, "\n%s,%s,%zu,%s,%.6f,%.3f,%.3f,%.3f", block_names[run->subjects[at].block],
                        run->subjects[at].name, k, iso_shading_methods[m].name, e->dssim_mean, e->angle_mean_deg,
                        e->angle_p95_deg, e->truth_mean_deg);
                for (int i = 0; i < run->views; ++i)
                    fprintf(memory, ",%.6f", e->dssim[i]);
            }
    fputc('\n', memory);
    fclose(memory);
    return iso_file_write(run->csv, text, size, err);
}

void iso_shading_report(const iso_shading_run *run)
{
    json_t *root = iso_cli_json(run->cli), *summaries = json_array(), *exceptions = json_array(),
           *left_out = json_array();
    json_object_update_new(json_object_get(root, "options"),
                           json_pack("{s:i, s:i, s:i, s:i}", "views", run->views, "size", run->size, "levels",
                                     run->levels, "analytic_size", run->analytic_size));
    for (int b = 0; b < ISO_SHADING_BLOCKS; ++b)
        report_block(run, (iso_shading_block)b, summaries);
    report_exceptions(run, exceptions);
    report_left_out(run, left_out);
    json_object_set_new(root, "summary", summaries);
    json_object_set_new(root, "exceptions", exceptions);
    json_object_set_new(root, "left_out", left_out);
    json_object_set_new(root, "cases", cases_to_json(run));
    if (run->cli->json)
        iso_cli_print_json(root);
    else
        json_decref(root);
}
