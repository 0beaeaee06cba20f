/* SPDX-License-Identifier: MIT */
/* result.h - the result of a chart: files, and lines on stdout.
 *
 *     DIR/pareto.svg, .pdf   error against time and against bytes, with the fronts
 *         pareto.csv         one line per setting: its figures, and the command that renders it
 *         pareto.gp          draws the CSV; style.gp: fonts, colors, shapes
 *         chart.json         the same as data (schema isoshade.chart/2), with the values that were not tried
 *         index.html         the same as a page, with a picture of each setting
 *         reference.exr      the reference image; for several scenes reference-SCENE.exr
 *         settings.jsonl     measurements, for --resume (kept.h)
 *         palette-N.csv      the palettes that settings use */
#pragma once

#include "chart/bench.h"

/* Metric used as the error. */
typedef enum iso_chart_metric {
    ISO_CHART_RMSE,
    ISO_CHART_FLIP,
    ISO_CHART_SSIM,
    ISO_CHART_METRIC_COUNT
} iso_chart_metric;
/* Returns "rmse", "flip" or "ssim". */
const char *iso_chart_metric_name(iso_chart_metric m);
/* Returns an axis title: "RMSE", "mean FLIP" or "1 - SSIM". */
const char *iso_chart_metric_title(iso_chart_metric m);
iso_status iso_chart_metric_from_name(const char *name, iso_chart_metric *m, iso_error *err);
double iso_chart_error(const iso_chart_case *c, iso_chart_metric m);

/* Bytes used as the cost in the second chart. */
typedef enum iso_chart_bytes { ISO_CHART_DEVICE, ISO_CHART_STORED } iso_chart_bytes;

typedef struct iso_chart_result {
    const char *command_line; /* of this run; borrowed */
    const iso_chart_bench *bench;
    iso_chart_case *cases;
    size_t count, done_count; /* measured ones come first */
    iso_chart_metric metric;
    iso_chart_bytes bytes;
    double want; /* 0: none */
    /* Indices of cases, of the first scene if there are several; done_count: none. fastest, smallest: among settings
     * within the wanted error in each scene, by the worst scene. */
    size_t fastest, smallest;
    size_t best;                             /* smallest error in its worst scene */
    double budget_seconds, spent_seconds;    /* budget 0: none; spent in this run */
    size_t kept_count;                       /* settings measured in an earlier run */
    const char *looks[ISO_CHART_MAX_SCENES]; /* options of a scene's view, for command lines */
    const char *output, *style;
    char viewers[ISO_CHART_MAX_SCENES][160];       /* pages of the viewer next to the chart; or empty */
    iso_chart_version versions[ISO_MAX_RENDERERS]; /* empty: not used */
    char left_out[ISO_MAX_RENDERERS][320];         /* reason why a renderer was left out; or empty */
    size_t refused_count;                          /* settings that could not be rendered */
    char refusal[320];                             /* reason of the first one */
} iso_chart_result;

/* A setting on a front is named if its error is at most this part of the last named one's, from the largest error down.
 * A smaller gain is due to noise of the clock or to the last digit of an error. */
#define ISO_CHART_NAMED_PART 0.95

/* Returns "brain.scene.json", or "first picture". */
const char *iso_chart_scene_title(const iso_chart_result *r, size_t scene);
/* Returns a setting's largest error (below: seconds) over all scenes; NaN if a scene was not measured. */
double iso_chart_worst_error(const iso_chart_result *r, const iso_chart_case *c);
double iso_chart_worst_seconds(const iso_chart_result *r, const iso_chart_case *c);

/* Moves measured settings to the front of the list, marks and numbers the fronts of each scene, and chooses fastest,
 * smallest and best. */
iso_status iso_chart_result_sort(iso_chart_result *r, iso_error *err);

/* Returns a setting's bytes in the second chart. Below: the kinds of bytes ("device", "stored") and of time
 * ("processor", "clock"). */
double iso_chart_bytes_of(const iso_chart_case *c, iso_chart_bytes b);
const char *iso_chart_bytes_kind(const iso_chart_result *r);
const char *iso_chart_time_kind(const iso_chart_result *r);

/* Writes the "isoshade render ..." that renders the setting to setting.exr. The caller frees it; NULL if out of
 * memory. */
char *iso_chart_command(const iso_chart_result *r, const iso_chart_case *c);

/* Writes "isoshade compare ..." of setting.exr with the scene's reference. The caller frees it; NULL if out of
 * memory. */
char *iso_chart_compare_command(const iso_chart_result *r, size_t scene);

json_t *iso_chart_result_json(const iso_chart_result *r);
/* Returns an object whose keys are the values of the axes that the chart had no time for: "level 2", "step 0.5". */
json_t *iso_chart_untried(const iso_chart_result *r);
/* Writes the files to `folder`, which becomes r->output. */
iso_status iso_chart_result_write(const iso_chart_result *r, const char *folder, const json_t *json, iso_error *err);
void iso_chart_result_print(const iso_chart_result *r);
/* Writes DIR/index.html: the chart as a page without network or other files. Pointing at a setting, or selecting it by
 * keys, shows its picture, figures and command. json: from iso_chart_result_json(). */
iso_status iso_chart_page_write(const iso_chart_result *r, const char *folder, const json_t *json, iso_error *err);
