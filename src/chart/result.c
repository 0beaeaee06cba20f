/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "chart/result.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "base/file.h"
#include "base/machine.h"
#include "base/names.h"
#include "base/version.h"
#include "base/words.h"
#include "report/gnuplot.h"
#include "chart/pareto.h"

ISO_EMBED(iso_pareto_gp, "src/chart/pareto.gp");

/* ---- errors and fronts --------------------------------------------------------------- */

static const struct {
    const char *name, *summary;
} metrics[] = {{"rmse", "RMSE"}, {"flip", "mean FLIP"}, {"ssim", "1 - SSIM"}};
static const iso_names metric_names = ISO_NAMES_OF_ROWS("--metric", metrics);

const char *iso_chart_metric_name(iso_chart_metric m) { return metrics[m].name; }

iso_status iso_chart_metric_from_name(const char *name, iso_chart_metric *m, iso_error *err)
{
    size_t row = 0;
    const iso_status status = iso_names_find(&metric_names, name, &row, err);
    if (status == ISO_OK)
        *m = (iso_chart_metric)row;
    return status;
}

double iso_chart_error(const iso_chart_case *c, iso_chart_metric m)
{
    return m == ISO_CHART_FLIP ? c->metrics.flip_mean : m == ISO_CHART_SSIM ? 1 - c->metrics.ssim : c->metrics.rmse;
}

static double bytes_of(const iso_chart_case *c, iso_chart_bytes b) { return b == ISO_CHART_STORED ? c->stored_bytes : c->took.bytes; }

static const char *bytes_kind(const iso_chart_result *r) { return r->bytes == ISO_CHART_STORED ? "stored" : "device"; }
static const char *time_kind(const iso_chart_result *r) { return r->bench->processor_time ? "processor" : "clock"; }

static int by_falling_error(const void *a, const void *b)
{
    const double *x = a, *y = b; /* error, index */
    return x[0] != y[0] ? (x[0] < y[0]) - (x[0] > y[0]) : (x[1] > y[1]) - (x[1] < y[1]);
}

/* Along a front, from the largest error: a setting is named when its error is this part of the last named one's or less.
 * What gains less is on the front by chance of the clock, or by the last digit of an error. */
static const double NAMED_PART = 0.95;

/* keys: two numbers a setting. The smallest with the wanted error is the fastest of its bytes, and so may stand above the
 * front, on which the most exact of its bytes is. Numbers those that are named on either front from 1, by falling error. */
static void number_fronts(iso_chart_result *r, const double *error, double *keys)
{
    size_t count = 0, number = 0;
    for (size_t i = 0; i < r->done_count; ++i)
        if (r->cases[i].on_time_front || r->cases[i].on_bytes_front || i == r->smallest) {
            keys[2 * count] = error[i];
            keys[2 * count++ + 1] = (double)i;
        }
    qsort(keys, count, 2 * sizeof *keys, by_falling_error);
    double last[2] = {INFINITY, INFINITY};
    for (size_t k = 0; k < count; ++k) {
        const size_t i = (size_t)keys[2 * k + 1];
        iso_chart_case *c = &r->cases[i];
        const bool on[2] = {c->on_time_front, c->on_bytes_front};
        bool named = i == r->fastest || i == r->smallest;
        for (int f = 0; f < 2; ++f)
            named = named || (on[f] && !(error[i] > NAMED_PART * last[f]));
        c->number = named ? ++number : 0;
        for (int f = 0; f < 2 && named; ++f)
            last[f] = on[f] ? error[i] : last[f];
    }
}

/* Plans for several errors may come out as one: of equal bytes and errors the fastest is enough. */
static void drop_ties(iso_chart_result *r, const double *bytes, const double *error, const double *seconds)
{
    for (size_t i = 0; i < r->done_count; ++i)
        for (size_t j = 0; j < r->done_count && r->cases[i].on_bytes_front; ++j)
            if (j != i && r->cases[j].on_bytes_front && bytes[j] == bytes[i] && error[j] == error[i] &&
                (seconds[j] < seconds[i] || (seconds[j] == seconds[i] && j < i)))
                r->cases[i].on_bytes_front = false;
}

/* Keeps the order among those that are done, and among the others. */
static iso_status move_done_first(iso_chart_result *r, iso_error *err)
{
    iso_chart_case *skipped = malloc((r->count + 1) * sizeof *skipped);
    size_t done = 0, left = 0;
    if (!skipped)
        return iso_fail(err, ISO_E_MEMORY, "chart: no memory for %zu settings", r->count);
    for (size_t i = 0; i < r->count; ++i) {
        if (r->cases[i].done)
            r->cases[done++] = r->cases[i];
        else
            skipped[left++] = r->cases[i];
    }
    memcpy(r->cases + done, skipped, left * sizeof *skipped);
    r->done_count = done;
    free(skipped);
    return ISO_OK;
}

iso_status iso_chart_result_sort(iso_chart_result *r, iso_error *err)
{
    iso_status status = move_done_first(r, err);
    const size_t n = r->done_count;
    double *seconds = calloc(5 * n + 1, sizeof *seconds), *bytes = seconds + n, *error = bytes + n, *keys = error + n;
    bool *front = calloc(n + 1, sizeof *front);
    if (status == ISO_OK && (!seconds || !front))
        status = iso_fail(err, ISO_E_MEMORY, "chart: no memory for %zu settings", n);
    r->fastest = r->smallest = r->best = n;
    if (status == ISO_OK) {
        for (size_t i = 0; i < n; ++i) {
            seconds[i] = r->cases[i].took.seconds;
            bytes[i] = bytes_of(&r->cases[i], r->bytes);
            error[i] = iso_chart_error(&r->cases[i], r->metric);
        }
        iso_pareto_front(seconds, error, n, front);
        for (size_t i = 0; i < n; ++i)
            r->cases[i].on_time_front = front[i];
        iso_pareto_front(bytes, error, n, front);
        for (size_t i = 0; i < n; ++i)
            r->cases[i].on_bytes_front = front[i];
        drop_ties(r, bytes, error, seconds);
        if (r->want > 0) {
            r->fastest = iso_pareto_choose(seconds, error, error, n, r->want);
            r->smallest = iso_pareto_choose(bytes, seconds, error, n, r->want);
        }
        r->best = iso_pareto_choose(error, seconds, error, n, INFINITY);
        number_fronts(r, error, keys);
    }
    free(seconds);
    free(front);
    return status;
}

/* ---- the command of a setting -------------------------------------------------------- */

static void put_option(FILE *f, const char *option, const char *word)
{
    if (!word)
        return;
    fprintf(f, " --%s ", option);
    iso_words_put_quoted(f, word);
}

/* As few digits as give the number again. */
static void put_number(FILE *f, const char *option, double value)
{
    char text[32];
    for (int digits = 6; digits <= 17; ++digits) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    fprintf(f, " --%s %s", option, text);
}

static void put_input(FILE *f, const iso_volume_input *in)
{
    char *line = iso_volume_input_line(in);
    fputs(line ? line : "", f);
    free(line);
}

/* What differs from what `render` does by itself. */
static void put_directions(FILE *f, const iso_chart_result *r, const iso_chart_case *c)
{
    const iso_pyramid_options usual = r->bench->is_volume ? iso_pyramid_defaults() : r->bench->first.options;
    char palette[64];
    if (c->code != usual.code && (c->source == ISO_FROM_CODES || c->source == ISO_FROM_FLIPPED))
        put_option(f, "code", iso_code_describe(c->code)->name);
    if (c->source != ISO_FROM_ON_THE_FLY && c->estimator != usual.gradient.method)
        put_option(f, "estimator", iso_gradient_name(c->estimator));
    if (c->source != ISO_FROM_ON_THE_FLY && c->level > 0 && c->filter != usual.direction_filter)
        put_option(f, "direction-filter", iso_direction_filter_name(c->filter));
    if (c->source != ISO_FROM_CODES)
        put_option(f, "shading-from", iso_direction_source_name(c->source));
    if (c->source != ISO_FROM_PALETTE)
        return;
    snprintf(palette, sizeof palette, "palette-%zu.csv", iso_chart_palettes[c->palette]);
    char *path = iso_path_join(r->output, palette);
    put_option(f, "palette", path);
    free(path);
}

char *iso_chart_command(const iso_chart_result *r, const iso_chart_case *c)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f)
        return NULL;
    fputs("isoshade render ", f);
    iso_words_put_quoted(f, r->bench->path);
    put_input(f, r->bench->input);
    put_option(f, "scene", r->scene);
    put_option(f, "size", r->size);
    if (c->renderer != iso_renderers_usual())
        put_option(f, "with", c->renderer->name);
    if (c->plan_error > 0) {
        put_number(f, "plan-error", c->plan_error);
        fprintf(f, " --brick %d --brick-levels %d", ISO_CHART_BRICK_VOXELS, ISO_CHART_BRICK_LEVELS);
        if (c->estimator != iso_pyramid_defaults().gradient.method && r->bench->is_volume)
            put_option(f, "estimator", iso_gradient_name(c->estimator));
    } else {
        if (c->level > 0)
            fprintf(f, " --level %zu", c->level);
        put_directions(f, r, c);
        if (c->adapted)
            fputs(" --adapt", f);
        if (c->second != ISO_SECOND_VALUE_NONE)
            put_option(f, "tf-2d", iso_chart_name_tf(c));
    }
    put_number(f, "step", c->step_voxels);
    if (c->preintegrated)
        put_option(f, "quadrature", "preintegrated");
    else if (iso_renderer_has(c->renderer, ISO_READS_QUADRATURE) && c->renderer->defaults.quadrature != ISO_QUADRATURE_MIDPOINT)
        put_option(f, "quadrature", "midpoint");
    fputs(" -o setting.exr", f);
    if (fclose(f) == 0)
        return text;
    free(text);
    return NULL;
}

/* "isoshade compare setting.exr DIR/reference.exr" */
static char *compare_command(const iso_chart_result *r)
{
    char *text = NULL, *path = iso_path_join(r->output, "reference.exr");
    size_t size = 0;
    FILE *f = path ? open_memstream(&text, &size) : NULL;
    if (f) {
        fputs("isoshade compare setting.exr ", f);
        iso_words_put_quoted(f, path);
        fclose(f);
    }
    free(path);
    return text;
}

/* ---- as data --------------------------------------------------------------------------- */

static json_t *case_json(const iso_chart_result *r, const iso_chart_case *c)
{
    char shading_from[64], setting[192];
    iso_chart_name_shading(c, shading_from, sizeof shading_from);
    iso_chart_describe(c, setting, sizeof setting);
    char *command = iso_chart_command(r, c);
    json_t *o = json_pack("{s:s, s:s, s:I, s:s, s:s, s:s, s:s, s:s, s:f}", "setting", setting, "renderer", c->renderer->name,
                          "level", (json_int_t)c->level, "shading_from", shading_from, "filter", iso_direction_filter_name(c->filter),
                          "estimator", iso_gradient_name(c->estimator), "tf", iso_chart_name_tf(c), "quadrature",
                          c->preintegrated ? "preintegrated" : "midpoint", "step_voxels", c->step_voxels);
    if (c->plan_error > 0)
        json_object_set_new(o, "plan_error", json_real(c->plan_error));
    json_object_update_new(o, json_pack("{s:f, s:f, s:f, s:I, s:f, s:f, s:f}", "milliseconds", 1e3 * c->took.seconds,
                                        "milliseconds_median", 1e3 * c->took.median_seconds, "milliseconds_most", 1e3 * c->took.most_seconds,
                                        "frames", (json_int_t)c->took.count, "setup_milliseconds", 1e3 * c->took.setup_seconds,
                                        "device_bytes", c->took.bytes, "stored_bytes", c->stored_bytes));
    json_object_update_new(o, iso_metrics_to_json(&c->metrics));
    json_object_set_new(o, "on_time_front", json_boolean(c->on_time_front));
    json_object_set_new(o, "on_bytes_front", json_boolean(c->on_bytes_front));
    if (c->number > 0)
        json_object_set_new(o, "number", json_integer((json_int_t)c->number));
    json_object_set_new(o, "command", json_string(command ? command : ""));
    free(command);
    return o;
}

/* Values of the axes of which not one setting was measured. */
enum { MOST_TAGS = 64, TAG_SIZE = 96 };
typedef struct tag_list {
    size_t count;
    char tags[MOST_TAGS][TAG_SIZE];
} tag_list;

static bool has_tag(const tag_list *l, const char *tag)
{
    for (size_t i = 0; i < l->count; ++i)
        if (strcmp(l->tags[i], tag) == 0)
            return true;
    return false;
}

static void add_tags(const iso_chart_case *c, const tag_list *without, tag_list *l)
{
    char tags[6][TAG_SIZE];
    iso_chart_describe_series(c, tags[0], TAG_SIZE);
    snprintf(tags[1], TAG_SIZE, "level %zu", c->level);
    snprintf(tags[2], TAG_SIZE, "step %g", c->step_voxels);
    snprintf(tags[3], TAG_SIZE, "filter %s", iso_direction_filter_name(c->filter));
    snprintf(tags[4], TAG_SIZE, "estimator %s", iso_gradient_name(c->estimator));
    snprintf(tags[5], TAG_SIZE, "%s%s", c->preintegrated ? "pre-integration" : c->level > 0 ? "TF " : "midpoints",
             !c->preintegrated && c->level > 0 ? iso_chart_name_tf(c) : "");
    for (size_t i = 0; i < 6; ++i)
        if (l->count < MOST_TAGS && !has_tag(l, tags[i]) && !(without && has_tag(without, tags[i])))
            memcpy(l->tags[l->count++], tags[i], TAG_SIZE);
}

static iso_status find_untried(const iso_chart_result *r, tag_list **untried)
{
    tag_list *lists = calloc(2, sizeof *lists);
    *untried = lists ? lists + 1 : NULL;
    for (size_t i = 0; lists && i < r->count; ++i)
        add_tags(&r->cases[i], i < r->done_count ? NULL : &lists[0], &lists[i < r->done_count ? 0 : 1]);
    return lists ? ISO_OK : ISO_E_MEMORY;
}

static void free_untried(tag_list *untried)
{
    if (untried)
        free(untried - 1);
}

static json_t *strings_json(const char (*texts)[320])
{
    json_t *o = json_object();
    for (size_t i = 0; i < iso_renderer_count(); ++i)
        if (texts[i][0])
            json_object_set_new(o, iso_renderer_at(i)->name, json_string(texts[i]));
    return o;
}

static json_t *want_json(const iso_chart_result *r)
{
    json_t *want = json_pack("{s:s, s:f}", "metric", iso_chart_metric_name(r->metric), "error", r->want);
    const char *const keys[] = {"fastest", "smallest", "best"};
    const size_t chosen[] = {r->fastest, r->smallest, r->best};
    for (int k = 0; k < 3; ++k)
        json_object_set_new(want, keys[k], chosen[k] < r->done_count ? case_json(r, &r->cases[chosen[k]]) : json_null());
    return want;
}

json_t *iso_chart_result_json(const iso_chart_result *r)
{
    json_t *root = json_pack("{s:s, s:s}", "schema", "isoshade.chart/2", "command", r->command_line), *cases = json_array(), *names = json_array();
    tag_list *untried;
    json_object_set_new(root, "options",
                        json_pack("{s:s, s:s, s:s, s:s, s:s, s:f, s:[I,I]}", "volume", r->bench->path, "scene", r->scene, "metric",
                                  iso_chart_metric_name(r->metric), "time", time_kind(r), "bytes", bytes_kind(r),
                                  "budget_seconds", r->budget_seconds, "image", (json_int_t)r->bench->view.width,
                                  (json_int_t)r->bench->view.height));
    json_object_set_new(root, "isoshade", json_string(ISO_VERSION));
    json_object_set_new(root, "versions", strings_json(r->versions));
    json_object_set_new(root, "machine", iso_machine_describe());
    json_object_set_new(root, "spent_seconds", json_real(r->spent_seconds));
    json_object_set_new(root, "reference_seconds", json_real(r->bench->reference_seconds));
    json_object_set_new(root, "skipped_count", json_integer((json_int_t)(r->count - r->done_count - r->refused_count)));
    json_object_set_new(root, "refused_count", json_integer((json_int_t)r->refused_count));
    json_object_set_new(root, "left_out", strings_json(r->left_out));
    if (find_untried(r, &untried) == ISO_OK)
        for (size_t i = 0; i < untried->count; ++i)
            json_array_append_new(names, json_string(untried->tags[i]));
    free_untried(untried);
    json_object_set_new(root, "untried", names);
    if (r->want > 0)
        json_object_set_new(root, "want", want_json(r));
    for (size_t i = 0; i < r->done_count; ++i)
        json_array_append_new(cases, case_json(r, &r->cases[i]));
    json_object_set_new(root, "cases", cases);
    return root;
}

/* ---- as a table --------------------------------------------------------------------------- */

static void put_field(FILE *f, const char *text)
{
    fputs(",\"", f);
    for (const char *c = text ? text : ""; *c; ++c)
        *c == '"' ? fputs("\"\"", f) : fputc(*c, f);
    fputc('"', f);
}

/* pareto.gp finds the columns by their names. */
static char *result_csv(const iso_chart_result *r)
{
    char *text = NULL, machine[320];
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f)
        return NULL;
    json_t *about = iso_machine_describe();
    snprintf(machine, sizeof machine, "%s; %d cores", json_string_value(json_object_get(about, "processor")),
             (int)json_integer_value(json_object_get(about, "cores")));
    json_decref(about);
    fputs("series,setting,renderer,level,shading_from,filter,estimator,tf,quadrature,step_voxels,plan_error,milliseconds,milliseconds_median,"
          "milliseconds_most,frames,setup_milliseconds,device_bytes,stored_bytes,bytes,error,rmse,max_abs,flip_mean,ssim,time_front,"
          "bytes_front,number,chosen,want,metric,time_kind,bytes_kind,width,height,volume,scene,versions,machine,command\n", f);
    for (size_t i = 0; i < r->done_count; ++i) {
        const iso_chart_case *c = &r->cases[i];
        char series[160], setting[192], shading_from[64], versions[400];
        iso_chart_describe_series(c, series, sizeof series);
        iso_chart_describe(c, setting, sizeof setting);
        iso_chart_name_shading(c, shading_from, sizeof shading_from);
        snprintf(versions, sizeof versions, "isoshade %s; %s", ISO_VERSION, r->versions[iso_renderer_index(c->renderer)]);
        char *command = iso_chart_command(r, c);
        fprintf(f, "%s,%s,%s,%zu,%s,%s,%s,%s,%s,%g,%g,", series, setting, c->renderer->name, c->level, shading_from,
                iso_direction_filter_name(c->filter), iso_gradient_name(c->estimator), iso_chart_name_tf(c),
                c->preintegrated ? "preintegrated" : "midpoint", c->step_voxels, c->plan_error);
        fprintf(f, "%.9g,%.9g,%.9g,%zu,%.6g,%.12g,%.12g,%.12g,", 1e3 * c->took.seconds, 1e3 * c->took.median_seconds,
                1e3 * c->took.most_seconds, c->took.count, 1e3 * c->took.setup_seconds, c->took.bytes, c->stored_bytes,
                bytes_of(c, r->bytes));
        fprintf(f, "%.9g,%.9g,%.9g,%.9g,%.9g,%d,%d,%zu,%d,%.6g,%s,%s,%s,%zu,%zu", iso_chart_error(c, r->metric), c->metrics.rmse,
                c->metrics.max_abs, c->metrics.flip_mean, c->metrics.ssim, c->on_time_front, c->on_bytes_front, c->number,
                (i == r->fastest ? 1 : 0) | (i == r->smallest ? 2 : 0), r->want, metrics[r->metric].summary,
                time_kind(r), bytes_kind(r), r->bench->view.width, r->bench->view.height);
        put_field(f, r->bench->path);
        put_field(f, r->scene);
        put_field(f, versions);
        put_field(f, machine);
        put_field(f, command);
        fputc('\n', f);
        free(command);
    }
    if (fclose(f) == 0)
        return text;
    free(text);
    return NULL;
}

static iso_status write_style(const iso_chart_result *r, const char *dir, iso_error *err)
{
    char *content = NULL, *path = iso_path_join(dir, "style.gp");
    size_t size = 0;
    iso_status status = path ? iso_file_read(r->style, &content, &size, err) : iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
    if (status == ISO_OK)
        status = iso_file_write(path, content, size, err);
    free(content);
    free(path);
    return status;
}

/* What commands refer to. */
static iso_status write_images(const iso_chart_result *r, const char *dir, iso_error *err)
{
    char *path = iso_path_join(dir, "reference.exr");
    const iso_image_note notes[] = {{"isoshade:command", r->command_line}, {NULL, NULL}};
    iso_status status = path ? iso_image_save_exr(&r->bench->reference, path, notes, err) : iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
    free(path);
    for (size_t i = 0; i < ISO_CHART_PALETTES && status == ISO_OK; ++i) {
        char name[64];
        snprintf(name, sizeof name, "palette-%zu.csv", iso_chart_palettes[i]);
        if (!r->bench->palettes[i].xyz)
            continue;
        path = iso_path_join(dir, name);
        status = path ? iso_palette_save_csv(&r->bench->palettes[i], path, err) : iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
        free(path);
    }
    return status;
}

iso_status iso_chart_result_write(const iso_chart_result *r, const json_t *json, iso_error *err)
{
    iso_output out;
    iso_status status = iso_output_begin_dir(&out, r->output, "chart.json", err);
    if (status != ISO_OK)
        return status;
    char *csv = result_csv(r), *path = iso_path_join(out.temp_path, "chart.json");
    if (!csv || !path)
        status = iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
    if (status == ISO_OK)
        status = iso_json_save(path, json, err);
    if (status == ISO_OK)
        status = write_images(r, out.temp_path, err);
    if (status == ISO_OK && r->style)
        status = write_style(r, out.temp_path, err);
    const char *const formats[] = {"svg", "pdf"};
    for (size_t i = 0; i < 2 && status == ISO_OK; ++i)
        status = iso_gnuplot_draw(out.temp_path, "pareto", csv, iso_pareto_gp, formats[i], err);
    if (status == ISO_OK)
        status = iso_output_commit(&out, err);
    iso_output_abandon(&out);
    free(csv);
    free(path);
    return status;
}

/* ---- as lines ------------------------------------------------------------------------------ */

static void print_chosen(const iso_chart_result *r, const char *what, size_t index)
{
    const iso_chart_case *c = &r->cases[index];
    char name[192];
    iso_chart_describe(c, name, sizeof name);
    char *command = iso_chart_command(r, c);
    printf("%s: %s (%.4g ms, %.0f bytes, %s %.3g)\n  %s\n", what, name, 1e3 * c->took.seconds, bytes_of(c, r->bytes),
           iso_chart_metric_name(r->metric), iso_chart_error(c, r->metric), command ? command : "");
    free(command);
}

static void print_want(const iso_chart_result *r)
{
    char what[96];
    const char *metric = iso_chart_metric_name(r->metric);
    if (r->fastest < r->done_count) {
        snprintf(what, sizeof what, "fastest with %s <= %.4g", metric, r->want);
        print_chosen(r, what, r->fastest);
        snprintf(what, sizeof what, "smallest with %s <= %.4g", metric, r->want);
        print_chosen(r, what, r->smallest);
    } else if (r->best < r->done_count) {
        snprintf(what, sizeof what, "none has %s <= %.4g; the nearest", metric, r->want);
        print_chosen(r, what, r->best);
    }
    char *compare = compare_command(r);
    printf("its error again: %s\n", compare ? compare : "");
    free(compare);
}

static void print_skipped(const iso_chart_result *r)
{
    tag_list *untried;
    const size_t skipped = r->count - r->done_count - r->refused_count;
    for (size_t i = 0; i < iso_renderer_count(); ++i)
        if (r->left_out[i][0])
            printf("left out: %s: %s\n", iso_renderer_at(i)->name, r->left_out[i]);
    if (r->refused_count > 0)
        printf("%zu settings could not be rendered: %s\n", r->refused_count, r->refusal);
    if (skipped == 0)
        return;
    if (r->budget_seconds > 0)
        printf("%zu of %zu settings did not fit into %g s", skipped, r->count, r->budget_seconds);
    else
        printf("%zu of %zu settings are of renderers that were left out", skipped, r->count);
    if (find_untried(r, &untried) == ISO_OK && untried->count > 0) {
        printf("; not one of: ");
        for (size_t i = 0; i < untried->count; ++i)
            printf("%s%s", i ? ", " : "", untried->tags[i]);
    }
    free_untried(untried);
    putchar('\n');
}

void iso_chart_result_print(const iso_chart_result *r)
{
    size_t most = 0, unnamed = 0;
    for (size_t i = 0; i < r->done_count; ++i) {
        most = r->cases[i].number > most ? r->cases[i].number : most;
        unnamed += r->cases[i].number == 0 && (r->cases[i].on_time_front || r->cases[i].on_bytes_front);
    }
    printf("on the front of time (t) or bytes (b)%-36s %9s %9s %12s %9s %9s\n", "", "ms", "median", "bytes", "rmse", "flip_mean");
    for (size_t k = 1; k <= most; ++k)
        for (size_t i = 0; i < r->done_count; ++i) {
            const iso_chart_case *c = &r->cases[i];
            char name[192];
            if (c->number != k)
                continue;
            iso_chart_describe(c, name, sizeof name);
            printf("%3zu %s%s %-66s %9.4g %9.4g %12.0f %9.3g %9.3g\n", k, c->on_time_front ? "t" : " ", c->on_bytes_front ? "b" : " ", name,
                   1e3 * c->took.seconds, 1e3 * c->took.median_seconds, bytes_of(c, r->bytes), c->metrics.rmse, c->metrics.flip_mean);
        }
    if (unnamed > 0)
        printf("and %zu that lower the error by less than %.0f %%: on_time_front and on_bytes_front in chart.json\n", unnamed,
               100 * (1 - NAMED_PART));
    print_skipped(r);
    if (r->want > 0)
        print_want(r);
    printf("chart: %s/pareto.svg, %.3g s\n", r->output, r->spent_seconds);
}
