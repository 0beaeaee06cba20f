/* SPDX-License-Identifier: MIT */
/* result.h - the result of a chart: files, and lines on stdout.
 *
 *     DIR/pareto.svg, .pdf   error against time and against bytes, with the fronts
 *         pareto.csv         a line a setting: all that is drawn, and the command that renders it again
 *         pareto.gp          draws the CSV; style.gp: fonts, colors, shapes
 *         chart.json         the same as data (schema isoshade.chart/2), with what was not tried
 *         index.html         the same as a page, with a picture of each setting
 *         reference.exr      what errors are measured against; of several scenes reference-SCENE.exr
 *         settings.jsonl     what --resume goes on from (kept.h)
 *         palette-N.csv      the palettes that settings use */
#ifndef ISO_CHART_RESULT_H
#define ISO_CHART_RESULT_H

#include "chart/bench.h"

/* Which figure of a comparison is the error. */
typedef enum iso_chart_metric {
    ISO_CHART_RMSE,
    ISO_CHART_FLIP,
    ISO_CHART_SSIM,
    ISO_CHART_METRIC_COUNT
} iso_chart_metric;
/* "rmse", "flip", "ssim" */
const char *iso_chart_metric_name(iso_chart_metric m);
/* "RMSE", "mean FLIP", "1 - SSIM": of an axis */
const char *iso_chart_metric_title(iso_chart_metric m);
iso_status iso_chart_metric_from_name(const char *name, iso_chart_metric *m, iso_error *err);
double iso_chart_error(const iso_chart_case *c, iso_chart_metric m);

/* Which bytes are the second chart's cost. */
typedef enum iso_chart_bytes { ISO_CHART_DEVICE, ISO_CHART_STORED } iso_chart_bytes;

typedef struct iso_chart_result {
    const char *command_line; /* that made it; borrowed */
    const iso_chart_bench *bench;
    iso_chart_case *cases;
    size_t count, done_count; /* those that are done come first */
    iso_chart_metric metric;
    iso_chart_bytes bytes;
    double want;                          /* 0: none */
    /* Indices of cases, of several scenes the first's: with at most the wanted error in each scene, the fastest by the scene
     * where it is the slowest; done_count: none. */
    size_t fastest, smallest;
    size_t best;                          /* of the least error, in the scene where it is the largest */
    double budget_seconds, spent_seconds; /* budget 0: none; spent in this run */
    size_t kept_count;                    /* settings of an earlier run */
    const char *looks[ISO_CHART_MAX_SCENES]; /* the options of a command line for what a scene's pictures show */
    const char *output, *style;
    char viewers[ISO_CHART_MAX_SCENES][160]; /* pages of the viewer beside it; or empty */
    iso_chart_version versions[ISO_MAX_RENDERERS]; /* empty: not used */
    char left_out[ISO_MAX_RENDERERS][320]; /* why a renderer was; or empty */
    size_t refused_count;                  /* settings that could not be rendered */
    char refusal[320];                     /* why the first could not */
} iso_chart_result;

/* Along a front, from the largest error: a setting is named when its error is this part of the last named one's or less.
 * What gains less is on the front by chance of the clock, or by the last digit of an error. */
#define ISO_CHART_NAMED_PART 0.95

/* "brain.scene.json", or what stands for one. */
const char *iso_chart_scene_title(const iso_chart_result *r, size_t scene);
/* Over all scenes: is the setting of this case done in each of them, and what is the largest there? NaN: it is not. */
double iso_chart_worst_error(const iso_chart_result *r, const iso_chart_case *c);
double iso_chart_worst_seconds(const iso_chart_result *r, const iso_chart_case *c);

/* Sorts measured settings before the others, marks and numbers the fronts of each scene, and chooses fastest, smallest and
 * best. */
iso_status iso_chart_result_sort(iso_chart_result *r, iso_error *err);

/* Of a setting, the bytes that the second chart shows; what they and the times are: "device" or "stored", "processor" or "clock". */
double iso_chart_bytes_of(const iso_chart_case *c, iso_chart_bytes b);
const char *iso_chart_bytes_kind(const iso_chart_result *r);
const char *iso_chart_time_kind(const iso_chart_result *r);

/* "isoshade render ..." that gives the setting's image again as setting.exr; to be freed, NULL when memory ends. */
char *iso_chart_command(const iso_chart_result *r, const iso_chart_case *c);

/* "isoshade compare ..." of setting.exr with the scene's reference; to be freed, NULL when memory ends. */
char *iso_chart_compare_command(const iso_chart_result *r, size_t scene);

json_t *iso_chart_result_json(const iso_chart_result *r);
/* Writes the files into `folder`, which becomes r->output. */
iso_status iso_chart_result_write(const iso_chart_result *r, const char *folder, const json_t *json, iso_error *err);
void iso_chart_result_print(const iso_chart_result *r);

#endif
