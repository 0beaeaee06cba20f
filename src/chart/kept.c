/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "chart/kept.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/machine.h"

static const char lines_name[] = "settings.jsonl", part_name[] = ".part.exr", schema[] = "isoshade.chart-settings/2";

/* Names of all files that a chart's folder may hold (result.h), finished or not. */
static const char *const own_names[] = {"chart.json",      lines_name,      part_name,  "reference.exr",
                                        "reference-*.exr", "palette-*.csv", "pareto.*", "style.gp",
                                        "viewer-*.html",   "index.html",    NULL};

void iso_chart_reference_name(const iso_chart_bench *b, size_t scene, char *text, size_t size)
{
    if (b->scene_count == 1)
        snprintf(text, size, "reference.exr");
    else
        snprintf(text, size, "reference-%s.exr", b->scenes[scene].name);
}

/* ---- the chart's key ---- */

/* Adds all facts on which a measurement depends. */
static iso_status complete_key(iso_key *key, const iso_chart_bench *b, iso_error *err)
{
    json_auto_t *machine = iso_machine_describe();
    const char *processor = json_string_value(json_object_get(machine, "processor"));
    iso_key_add_text(key, "the processor", processor ? processor : "");
    iso_key_add_text(key, "the first estimator", iso_gradient_name(b->first.options.gradient.method));
    return iso_key_add_surroundings(key, err);
}

/* Makes the first line of the file of measurements. */
static json_t *head_json(const iso_key *key, const iso_chart_bench *b)
{
    json_t *parts = iso_key_to_json(key);
    return parts ? json_pack("{s:s, s:b, s:o}", "schema", schema, "hasty", b->hasty, "key", parts) : NULL;
}

/* Sets *same if the chart can continue. A hasty chart has coarser references, so it does not continue a thorough
 * one. */
static iso_status check_key(const char *folder, const json_t *found, const iso_key *key, const iso_chart_bench *b,
                            bool *same, iso_error *err)
{
    char why[256];
    *same = found && (b->hasty || !json_is_true(json_object_get(found, "hasty")));
    if (!found || !iso_key_differs(key, json_object_get(found, "key"), why, sizeof why))
        return ISO_OK;
    return iso_fail(err, ISO_E_USAGE, "%s: --resume: %s; without --resume the chart begins again", folder, why);
}

/* ---- lines ---- */

static const char *renderer_of(const iso_chart_kept_file *k, const iso_chart_case *c)
{
    return k->renderers[iso_renderer_index(c->renderer)];
}

static json_t *case_line(const iso_chart_kept_file *k, const iso_chart_bench *b, const iso_chart_case *c)
{
    char setting[192];
    const iso_metrics *m = &c->metrics;
    iso_chart_describe(c, setting, sizeof setting);
    json_t *frames = json_array();
    for (size_t i = 0; i < c->took.count && i < ISO_RENDER_MAX_FRAMES; ++i)
        json_array_append_new(frames, json_real(c->took.frame_seconds[i]));
    json_t *line = json_pack("{s:s, s:s, s:s, s:o, s:f, s:f, s:f}", "scene", b->scenes[c->scene].name, "setting",
                             setting, "renderer", renderer_of(k, c), "frame_seconds", frames, "setup_seconds",
                             c->took.setup_seconds, "device_bytes", c->took.bytes, "stored_bytes", c->stored_bytes);
    if (line)
        json_object_update_new(line, iso_metrics_to_json(m));
    if (line && c->picture)
        json_object_set_new(line, "picture", json_string(c->picture));
    return line;
}

static double number_of(const json_t *line, const char *key)
{
    const json_t *value = json_object_get(line, key);
    return json_is_number(value) ? json_number_value(value) : NAN;
}

static iso_metrics metrics_of(const json_t *line)
{
    const json_t *worst = json_object_get(line, "worst_pixel");
    iso_metrics m = {.rmse = number_of(line, "rmse"),
                     .max_abs = number_of(line, "max_abs"),
                     .p99_abs = number_of(line, "p99_abs"),
                     .psnr_db = number_of(line, "psnr_db"),
                     .ssim = number_of(line, "ssim"),
                     .flip_mean = number_of(line, "flip_mean"),
                     .nonfinite_count = (size_t)fmax(number_of(line, "nonfinite_count"), 0)};
    m.psnr_db = m.rmse == 0 ? INFINITY : m.psnr_db;
    for (size_t i = 0; i < 2; ++i)
        m.worst[i] = (size_t)json_integer_value(json_array_get(worst, i));
    return m;
}

/* Reads a setting's measurements from a line. Skips lines of another version of the renderer, and damaged ones: a
 * killed process may have cut its last line. */
static void take_line(const json_t *line, const char *renderer, iso_chart_case *c)
{
    const char *drawn_by = json_string_value(json_object_get(line, "renderer"));
    double frames[ISO_RENDER_MAX_FRAMES];
    const json_t *list = json_object_get(line, "frame_seconds");
    size_t count = 0;
    for (size_t i = 0; i < json_array_size(list) && count < ISO_RENDER_MAX_FRAMES; ++i)
        frames[count++] = json_number_value(json_array_get(list, i));
    if (count == 0 || !drawn_by || !*drawn_by || strcmp(drawn_by, renderer) != 0 ||
        !json_is_number(json_object_get(line, "device_bytes")))
        return;
    iso_render_stats_sum_up(&c->took, frames, count);
    c->took.setup_seconds = number_of(line, "setup_seconds");
    c->took.bytes = number_of(line, "device_bytes");
    c->stored_bytes = number_of(line, "stored_bytes");
    c->metrics = metrics_of(line);
    free(c->picture);
    const char *picture = json_string_value(json_object_get(line, "picture"));
    c->picture = picture ? strdup(picture) : NULL;
    c->done = c->kept = true;
}

typedef struct case_key {
    char text[340];
    iso_chart_case *of;
} case_key;

static int by_text(const void *a, const void *b)
{
    return strcmp(((const case_key *)a)->text, ((const case_key *)b)->text);
}

static iso_status take_lines(const iso_chart_kept_file *k, const iso_chart_bench *b, iso_chart_case *cases,
                             size_t count, iso_error *err)
{
    case_key wanted;
    FREED case_key *keys = malloc((count + 1) * sizeof *keys);
    char setting[192];
    FREED char *text = NULL;
    size_t size = 0;
    NEED_MEMORY(keys, err, "chart: no memory for %zu settings", count);
    for (size_t i = 0; i < count; ++i) {
        iso_chart_describe(&cases[i], setting, sizeof setting);
        snprintf(keys[i].text, sizeof keys[i].text, "%s; %s", b->scenes[cases[i].scene].name, setting);
        keys[i].of = &cases[i];
    }
    qsort(keys, count, sizeof *keys, by_text);
    while (getline(&text, &size, k->lines) > 0) {
        json_auto_t *line = json_loads(text, 0, NULL);
        const char *scene = json_string_value(json_object_get(line, "scene")),
                   *of = json_string_value(json_object_get(line, "setting"));
        snprintf(wanted.text, sizeof wanted.text, "%s; %s", scene ? scene : "", of ? of : "");
        const case_key *found = scene && of ? bsearch(&wanted, keys, count, sizeof *keys, by_text) : NULL;
        if (found)
            take_line(line, renderer_of(k, found->of), found->of);
    }
    return ISO_OK;
}

/* ---- the folder ---- */

/* Reads the first line; NULL if there is none of this schema. */
static json_t *read_head(const char *dir)
{
    FREED char *path = iso_path_join(dir, lines_name), *text = NULL;
    size_t size = 0;
    FILE *f = path ? fopen(path, "r") : NULL;
    json_t *first = f && getline(&text, &size, f) > 0 ? json_loads(text, 0, NULL) : NULL;
    const char *found = json_string_value(json_object_get(first, "schema"));
    if (!found || strcmp(found, schema) != 0) {
        json_decref(first);
        first = NULL;
    }
    if (f)
        fclose(f);
    return first;
}

static iso_status copy_file(const char *from, const char *to, const char *name, iso_error *err)
{
    FREED char *source = iso_path_join(from, name), *target = iso_path_join(to, name), *bytes = NULL;
    size_t size = 0;
    NEED_MEMORY(source && target, err, "chart: out of memory");
    if (!iso_path_exists(source))
        return ISO_OK;
    NEED(iso_file_read(source, &bytes, &size, err));
    return iso_file_write(target, bytes, size, err);
}

/* Copies the files of a finished chart, if there is no interrupted one. */
static iso_status copy_finished(iso_chart_kept_file *k, const iso_chart_bench *b, iso_error *err)
{
    iso_status status = copy_file(k->output.final_path, k->output.temp_path, lines_name, err);
    for (size_t i = 0; i < b->scene_count && status == ISO_OK; ++i) {
        char name[192];
        iso_chart_reference_name(b, i, name, sizeof name);
        status = copy_file(k->output.final_path, k->output.temp_path, name, err);
    }
    return status;
}

static iso_status begin_lines(iso_chart_kept_file *k, const json_t *head, iso_error *err)
{
    char *path = iso_path_join(k->output.temp_path, lines_name);
    k->lines = path ? fopen(path, k->resumed ? "a+" : "w") : NULL;
    if (!k->lines) {
        free(path);
        return iso_fail(err, ISO_E_IO, "%s: cannot be written: %s", k->output.final_path, strerror(errno));
    }
    free(path);
    if (k->resumed) /* the last line of a killed process may lack its end */
        fputc('\n', k->lines);
    else {
        json_dumpf(head, k->lines, JSON_COMPACT);
        fputc('\n', k->lines);
    }
    if (fflush(k->lines) != 0)
        return iso_fail(err, ISO_E_IO, "%s: cannot be written", k->output.final_path);
    k->begun = k->resumed ? 0 : ftell(k->lines);
    return ISO_OK;
}

iso_status iso_chart_kept_open(iso_chart_kept_file *k, const char *folder, bool resume, iso_key *key,
                               const iso_chart_bench *b, iso_error *err)
{
    *k = (iso_chart_kept_file){.lines = NULL};
    bool partial = false;
    json_auto_t *head = NULL, *found = NULL;
    NEED(complete_key(key, b, err));
    if (!(head = head_json(key, b)))
        return iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
    NEED(iso_output_resume_dir(&k->output, folder, own_names, resume, &partial, err));
    if (resume && !partial)
        NEED(copy_finished(k, b, err));
    if (resume) {
        found = read_head(k->output.temp_path);
        const iso_status status = check_key(folder, found, key, b, &k->resumed, err);
        if (status != ISO_OK && partial) /* keeps the existing chart; only the copy of a finished one goes */
            iso_output_keep(&k->output);
        else if (status != ISO_OK)
            iso_output_abandon(&k->output);
        NEED(status);
    }
    return begin_lines(k, head, err);
}

iso_status iso_chart_kept_take(iso_chart_kept_file *k, iso_chart_bench *b, iso_chart_case *cases, size_t count,
                               iso_error *err)
{
    if (!k->resumed)
        return ISO_OK;
    for (size_t i = 0; i < b->scene_count; ++i) {
        char name[192];
        iso_chart_reference_name(b, i, name, sizeof name);
        FREED char *path = iso_path_join(k->output.temp_path, name);
        if (path && iso_path_exists(path))
            NEED(iso_image_load_exr(path, &b->scenes[i].reference, err));
    }
    rewind(k->lines);
    NEED(take_lines(k, b, cases, count, err));
    fseek(k->lines, 0, SEEK_END);
    /* drop settings of a scene without its reference, and those that lack a metric which this run shows */
    for (size_t i = 0; i < count; ++i) {
        iso_chart_case *c = &cases[i];
        const bool whole = !b->needs_visual || isfinite(c->metrics.ssim);
        c->done = c->kept = c->done && whole && b->scenes[c->scene].reference.rgba;
        if (cases[i].done)
            iso_chart_bench_learn(b, &cases[i]);
    }
    return ISO_OK;
}

iso_status iso_chart_kept_put_reference(iso_chart_kept_file *k, const iso_chart_bench *b, size_t scene, iso_error *err)
{
    char name[192];
    iso_chart_reference_name(b, scene, name, sizeof name);
    FREED char *path = iso_path_join(k->output.temp_path, name), *part = iso_path_join(k->output.temp_path, part_name);
    NEED(path && part ? iso_image_save_exr(&b->scenes[scene].reference, part, NULL, err)
                      : iso_fail(err, ISO_E_MEMORY, "chart: out of memory"));
    if (rename(part, path) != 0)
        return iso_fail(err, ISO_E_IO, "%s: cannot be written: %s", name, strerror(errno));
    return ISO_OK;
}

iso_status iso_chart_kept_put(iso_chart_kept_file *k, const iso_chart_bench *b, const iso_chart_case *c, iso_error *err)
{
    json_auto_t *line = case_line(k, b, c);
    FREED char *text = line ? json_dumps(line, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    if (!text || !(fprintf(k->lines, "%s\n", text) > 0) || fflush(k->lines) != 0)
        return iso_fail(err, ISO_E_IO, "%s: cannot be written: %s", lines_name, strerror(errno));
    return ISO_OK;
}

iso_status iso_chart_kept_commit(iso_chart_kept_file *k, iso_error *err)
{
    const bool bad = ferror(k->lines);
    if (fclose(k->lines) != 0 || bad) {
        k->lines = NULL;
        return iso_fail(err, ISO_E_IO, "%s: %s cannot be written", k->output.final_path, lines_name);
    }
    k->lines = NULL;
    const iso_status status = iso_output_commit(&k->output, err);
    iso_output_abandon(&k->output); /* the previous content */
    return status;
}

void iso_chart_kept_close(iso_chart_kept_file *k)
{
    const long written = k->lines ? ftell(k->lines) : 0;
    if (k->lines)
        fclose(k->lines);
    k->lines = NULL;
    if (written > k->begun)
        iso_output_keep(&k->output);
    else
        iso_output_abandon(&k->output);
}
