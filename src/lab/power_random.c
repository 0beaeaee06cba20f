/* SPDX-License-Identifier: MIT */
/* power_random.c - measures how often validate reports a difference in a correct scene.
 *
 * Random volumes of `make`, each with a random scene or preset, go through `validate` as a user would run it. All
 * renderers are correct, so a reported difference is a false alarm. Scenes that validate refuses, because they show
 * nothing, are drawn again. */
#define _GNU_SOURCE
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/json.h"
#include "base/helper.h"
#include "base/file.h"
#include "base/parallel.h"
#include "base/process.h"
#include "base/random.h"
#include "base/temporary.h"
#include "base/words.h"
#include "lab/power.h"
#include "report/rows.h"
#include "tf/presets.h"
#include "volume/synthetic.h"

enum { MOST_WORDS = 48, WORD_BYTES = 160 };

/* A command line. */
typedef struct words {
    char text[MOST_WORDS][WORD_BYTES];
    size_t count;
} words;

static void add_word(words *w, const char *word)
{
    if (w->count < MOST_WORDS)
        snprintf(w->text[w->count++], WORD_BYTES, "%s", word);
}

/* Adds an option and its value. */
static __attribute__((format(printf, 3, 4))) void add_option(words *w, const char *name, const char *format, ...)
{
    char value[WORD_BYTES];
    va_list args;
    va_start(args, format);
    vsnprintf(value, sizeof value, format, args);
    va_end(args);
    add_word(w, name);
    add_word(w, value);
}

typedef struct sums {
    size_t valid, alarms, findings; /* findings: levels that are worse in another sample as well, no false alarms */
    size_t open, drawn;             /* open: something was not compared; drawn: with refused scenes */
    json_t *list;                   /* the alarms */
} sums;

/* ---- random scenes ---- */

static double between(iso_random *r, double lo, double hi)
{
    return lo + (hi - lo) * iso_random_unit(r);
}

/* Draws values in a fixed order that no compiler changes. */
static void draw(iso_random *r, double *values, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        values[i] = iso_random_unit(r);
}

static bool chance(iso_random *r, double of)
{
    return iso_random_unit(r) < of;
}

static json_t *random_vector(iso_random *r)
{
    json_t *v = json_array();
    for (int a = 0; a < 3; ++a)
        json_array_append_new(v, json_real(between(r, -1, 1) + (a == 0 ? 1e-3 : 0))); /* never the zero vector */
    return v;
}

static void make_words(iso_random *r, words *w)
{
    static const iso_type types[] = {ISO_U8, ISO_U16, ISO_I16, ISO_F32};
    const iso_field_kind kind = (iso_field_kind)iso_random_below(r, ISO_FIELD_COUNT);
    const iso_type type = types[iso_random_below(r, ISO_NAMES_COUNT(types))];
    add_word(w, "make");
    add_word(w, iso_field_name(kind));
    const size_t nx = 9 + iso_random_below(r, 32), ny = 9 + iso_random_below(r, 32), nz = 9 + iso_random_below(r, 32);
    add_option(w, "--size", "%zux%zux%zu", nx, ny, nz);
    const double sx = between(r, 0.3, 3), sy = between(r, 0.3, 3), sz = between(r, 0.3, 3);
    if (chance(r, 0.7))
        add_option(w, "--spacing", "%.3fx%.3fx%.3f", sx, sy, sz);
    const double x = between(r, -1, 1), y = between(r, -1, 1), angle = between(r, -180, 180);
    if (chance(r, 0.5))
        add_option(w, "--rotate", "%.3f,%.3f,1,%.2f", x, y, angle);
    add_option(w, "--type", "%s", iso_type_name(type));
    if (chance(r, 0.2))
        add_option(w, "--grain", "%.3f", between(r, 0, 0.1));
    add_option(w, "--seed", "%zu", iso_random_below(r, 100000));
}

/* Makes points with any slopes, also steep ones; the ends may be opaque. */
static json_t *random_tf(iso_random *r)
{
    const size_t tables[] = {64, 256, 1024}, count = 2 + iso_random_below(r, 5);
    json_t *points = json_array();
    double value = between(r, 0, 0.7);
    for (size_t i = 0; i < count; ++i) {
        double c[3], opacity = i == 0 || chance(r, 0.2) ? 0 : pow(between(r, 0, 1), 2);
        draw(r, c, 3);
        if (i + 1 == count && chance(r, 0.5))
            opacity = between(r, 0.05, 0.95);
        json_array_append_new(points, json_pack("{s:f, s:f, s:f, s:f, s:f}", "value", value, "r", c[0], "g", c[1], "b",
                                                c[2], "opacity", opacity));
        value += (1 - value) * (chance(r, 0.3) ? between(r, 0.005, 0.05) : between(r, 0.1, 0.6));
    }
    return json_pack("{s:s, s:s, s:i, s:s, s:I, s:o}", "schema", "isoshade.tf/1", "range", "fit",
                     "unit_distance_voxels", 1, "color_space", "linear", "table_size",
                     (json_int_t)tables[iso_random_below(r, ISO_NAMES_COUNT(tables))], "points", points);
}

static json_t *random_lights(iso_random *r)
{
    json_t *lights = json_array();
    const size_t count = 1 + iso_random_below(r, 3);
    for (size_t i = 0; i < count; ++i) {
        json_t *direction = random_vector(r);
        const bool camera = chance(r, 0.5);
        const double intensity = between(r, 0.3, 1) / (double)count;
        json_array_append_new(lights, json_pack("{s:o, s:s, s:f}", "direction", direction, "space",
                                                camera ? "camera" : "world", "intensity", intensity));
    }
    return lights;
}

static json_t *random_scene(iso_random *r)
{
    const double steps[] = {0.25, 0.5, 1};
    const bool perspective = chance(r, 0.5);
    json_t *direction = random_vector(r);
    const double margin = between(r, 0.6, 1.2);
    json_t *camera = json_pack("{s:b, s:o, s:[i,i,i], s:f, s:s}", "fit", 1, "direction", direction, "up", 0, 0, 1,
                               "margin", margin, "projection", perspective ? "perspective" : "orthographic");
    if (perspective)
        json_object_set_new(camera, "fov_y_deg", json_real(between(r, 15, 75)));
    const int width = 16 + (int)iso_random_below(r, 17), height = 16 + (int)iso_random_below(r, 17);
    const double ambient = between(r, 0.1, 0.6), specular = chance(r, 0.5) ? between(r, 0, 0.8) : 0;
    json_t *lights = random_lights(r), *tf = random_tf(r);
    double background[3];
    draw(r, background, 3);
    const double power = between(r, 1, 60), step = steps[iso_random_below(r, ISO_NAMES_COUNT(steps))];
    return json_pack("{s:s, s:{s:i, s:i}, s:o, s:o, s:{s:f, s:f, s:f, s:f}, s:[f,f,f], s:f, s:o}", "schema",
                     "isoshade.scene/1", "image", "width", width, "height", height, "camera", camera, "lights", lights,
                     "shading", "ambient", ambient, "diffuse", 1 - ambient, "specular", specular, "power", power,
                     "background", background[0], background[1], background[2], "step_voxels", step, "tf", tf);
}

static void validate_words(iso_random *r, const char *with, words *w)
{
    char view_size[16];
    snprintf(view_size, sizeof view_size, "%zu", 24 + iso_random_below(r, 17));
    add_word(w, "validate");
    add_word(w, "v.nrrd");
    add_option(w, "--scene", "s.scene.json");
    if (chance(r, 0.4))
        add_option(w, "--tf", "%s",
                   iso_names_name(&iso_tf_preset_names, iso_random_below(r, iso_tf_preset_names.count)));
    add_word(w, "--quick");
    add_option(w, "--levels", "%zu", 1 + iso_random_below(r, 3));
    add_option(w, "--with", "%s", with);
    add_option(w, "--level-size", "%s", view_size);
    add_option(w, "-o", "report");
}

/* ---- validate's answer ---- */

static bool is_flagged(const json_t *row)
{
    return json_object_get(row, "verdict") &&
           iso_verdict_doubt(iso_row_verdict(row)) >= iso_verdict_doubt(ISO_VERDICT_REFUSED);
}

/* True if any row reports a problem; the first such row goes to text. */
bool iso_power_is_alarm(const json_t *report, char *text, size_t size)
{
    const char *section;
    json_t *rows, *row;
    size_t i;
    json_object_foreach ((json_t *)report, section, rows)
        json_array_foreach (rows, i, row) {
            if (!is_flagged(row))
                continue;
            const char *name = iso_row_text(row, "b")[0] ? iso_row_text(row, "b") : iso_row_text(row, "check");
            snprintf(text, size, "%s %s, level %lld", section, name,
                     (long long)json_integer_value(json_object_get(row, "level")));
            return true;
        }
    return false;
}

/* True if the part of a level's row is there and not held. */
static bool is_unheld(const json_t *row, const char *part)
{
    return json_is_false(json_object_get(json_object_get(row, part), "held"));
}

bool iso_power_is_finding(const json_t *report)
{
    const char *section;
    json_t *rows, *row, *figure;
    size_t i, k, found = 0;
    json_object_foreach ((json_t *)report, section, rows)
        json_array_foreach (rows, i, row) {
            if (!is_flagged(row))
                continue;
            if (strcmp(section, "levels") != 0 || !json_is_false(json_object_get(row, "simple_held")) ||
                is_unheld(row, "stored") || is_unheld(row, "bound") || is_unheld(row, "extinction_scale"))
                return false;
            json_array_foreach (json_object_get(row, "figures"), k, figure)
                if (json_is_false(json_object_get(figure, "held")))
                    return false;
            ++found;
        }
    return found > 0;
}

static iso_status run_words(const words *w, const char *folder, int *exit_code, iso_error *err)
{
    const char *argv[MOST_WORDS + 5];
    char *program = iso_helper_find("isoshade");
    if (!program)
        return iso_fail(err, ISO_E_PROGRAM, "isoshade-lab power: isoshade is missing; install it next to isoshade-lab");
    size_t count = 0;
    argv[count++] = program;
    for (size_t i = 0; i < w->count; ++i)
        argv[count++] = w->text[i];
    argv[count++] = "--threads", argv[count++] = "1", argv[count++] = "-q"; /* scenes run in parallel */
    argv[count] = NULL;
    iso_process_outcome outcome = {.exit_code = -1};
    iso_error why = {""};
    const iso_status status = iso_process_run(
        argv, &(iso_process_options){.directory = folder, .sandbox = {.kind = ISO_SANDBOX_NONE}, .outcome = &outcome},
        &why);
    *exit_code = outcome.exit_code;
    free(program);
    return status == ISO_OK || outcome.exit_code > 0 ? ISO_OK
                                                     : iso_fail(err, status, "isoshade-lab power: %s", why.text);
}

/* Returns the command line as text, "make noise --size ...". */
static json_t *line_of(const words *w)
{
    char line[MOST_WORDS * WORD_BYTES] = "";
    for (size_t i = 0; i < w->count; ++i)
        snprintf(line + strlen(line), sizeof line - strlen(line), "%s%s", i ? " " : "", w->text[i]);
    return json_string(line);
}

/* Result of one scene. */
typedef struct outcome {
    bool is_valid, is_open; /* validate accepted it; something was not compared */
    bool is_finding;        /* the alarm is of levels, and holds in the other sample */
    json_t *alarm;          /* or NULL */
} outcome;

/* Judges the levels by another sample: the volume is turned, so that all views and lights differ, and 20 views of 64
 * pixels are drawn. *holds: True if pictures alone put a level behind the simple way there, too. */
static iso_status ask_again(const char *folder, const words *made, const words *validated, bool *holds, iso_error *err)
{
    FREED words *make = malloc(2 * sizeof *make);
    words *validate = make + 1;
    json_auto_t *report = NULL;
    FREED char *result = iso_path_join(folder, "again/report.json");
    int code = 0;
    iso_status status = make && result ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "isoshade-lab power: out of memory");
    if (status == ISO_OK) {
        *make = *made;
        *validate = *validated;
        add_option(make, "--rotate", "2,1,-3,77"); /* the last of two options counts */
        add_option(validate, "--level-views", "20");
        add_option(validate, "--level-size", "64");
        add_option(validate, "-o", "again");
        status = run_words(make, folder, &code, err);
    }
    TRY(status, run_words(validate, folder, &code, err));
    if (code == ISO_E_DIFFERS)
        TRY(status, iso_json_load(result, &report, err));
    *holds = report && iso_power_is_finding(report);
    return status;
}

static json_t *describe(size_t number, const words *make, const words *validate, const json_t *scene,
                        const json_t *report, const char *what)
{
    return json_pack("{s:I, s:s, s:o, s:o, s:O, s:s, s:s}", "number", (json_int_t)number, "row", what, "make",
                     line_of(make), "validate", line_of(validate), "scene", scene, "sentence",
                     iso_row_text(report, "sentence"), "levels_sentence", iso_row_text(report, "levels_sentence"));
}

static iso_status run_scene(const iso_power_random_options *o, const char *base, size_t number, outcome *out,
                            iso_error *err)
{
    iso_random r = {.state = (uint64_t)o->seed * 1000003u + number};
    FREED words *make = calloc(2, sizeof *make);
    words *validate = make + 1;
    char name[32], what[400];
    snprintf(name, sizeof name, "%zu", number);
    FREED char *folder = iso_path_join(base, name), *path = folder ? iso_path_join(folder, "s.scene.json") : NULL,
               *result = folder ? iso_path_join(folder, "report/report.json") : NULL;
    json_auto_t *scene = random_scene(&r), *report = NULL;
    int code = 0;
    iso_status status = make && path && result && scene
                            ? ISO_OK
                            : iso_fail(err, ISO_E_MEMORY, "isoshade-lab power: out of memory");
    if (status == ISO_OK && mkdir(folder, 0777) != 0)
        status = iso_fail(err, ISO_E_IO, "%s: cannot be created", folder);
    TRY(status, iso_json_save(path, scene, err));
    if (status == ISO_OK) {
        make_words(&r, make);
        validate_words(&r, o->with, validate);
        add_option(make, "-o", "v.nrrd");
        status = run_words(make, folder, &code, err);
    }
    if (status == ISO_OK && code != 0)
        status = iso_fail(err, ISO_E_PROGRAM, "isoshade-lab power: scene %zu: make ended with %d", number, code);
    TRY(status, run_words(validate, folder, &code, err));
    if (status == ISO_OK && code != ISO_OK && code != ISO_E_DIFFERS && code != ISO_E_RANGE)
        status = iso_fail(err, ISO_E_PROGRAM, "isoshade-lab power: scene %zu: validate ended with %d", number, code);
    if (status == ISO_OK && code != ISO_E_RANGE && (status = iso_json_load(result, &report, err)) == ISO_OK) {
        out->is_valid = true;
        out->is_open = code != ISO_OK;
        if (iso_power_is_alarm(report, what, sizeof what))
            out->alarm = describe(number, make, validate, scene, report, what);
        if (out->alarm && iso_power_is_finding(report))
            status = ask_again(folder, make, validate, &out->is_finding, err);
    }
    if (folder)
        iso_remove_tree(folder);
    return status;
}

/* Runs the remaining scenes in parallel. */
static iso_status run_round(const iso_power_random_options *o, const char *folder, const iso_progress *progress,
                            sums *s, iso_error *err)
{
    const size_t count = (size_t)o->scenes - s->valid, first = s->drawn;
    outcome *all = calloc(count, sizeof *all);
    iso_status status = all ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "isoshade-lab power: out of memory");
    size_t done = 0;
#pragma omp parallel for schedule(dynamic) num_threads(iso_threads(o->threads))
    for (size_t i = 0; i < count; ++i) {
        iso_error why = {""};
        const iso_status one = status == ISO_OK ? run_scene(o, folder, first + i, &all[i], &why) : ISO_OK;
#pragma omp critical(iso_power_random)
        {
            if (one != ISO_OK && status == ISO_OK)
                status = iso_fail(err, one, "%s", why.text);
            iso_progress_report(progress, "random scenes", (double)(s->valid + ++done) / (o->scenes + 1));
        }
    }
    s->drawn += count;
    for (size_t i = 0; all && i < count; ++i) {
        s->valid += all[i].is_valid;
        s->alarms += all[i].alarm && !all[i].is_finding;
        s->findings += all[i].is_finding;
        s->open += all[i].is_open && !all[i].alarm;
        if (all[i].alarm)
            json_array_append_new(s->list, all[i].alarm);
    }
    free(all);
    return status;
}

/* ---- results ---- */

double iso_power_rate_bound(size_t alarms, size_t tested)
{
    double lo = 0, hi = 1;
    for (int i = 0; i < 60 && alarms < tested; ++i) {
        const double p = 0.5 * (lo + hi);
        double term = pow(1 - p, (double)tested), sum = term; /* for 0, 1 ... alarms */
        for (size_t k = 1; k <= alarms; ++k) {
            term *= (double)(tested - k + 1) / (double)k * p / (1 - p);
            sum += term;
        }
        *(sum > 0.05 ? &lo : &hi) = p;
    }
    return hi;
}

static void print_sums(const iso_power_random_options *o, const sums *s)
{
    size_t i;
    json_t *alarm;
    json_array_foreach (s->list, i, alarm) {
        FREED char *scene = iso_json_text(json_object_get(alarm, "scene"), JSON_COMPACT);
        printf("scene %lld: %s\n    %s\n    %s\n    %s\n    %s\n    s.scene.json: %s\n",
               (long long)json_integer_value(json_object_get(alarm, "number")), iso_row_text(alarm, "row"),
               iso_row_text(alarm, "sentence"), iso_row_text(alarm, "levels_sentence"), iso_row_text(alarm, "make"),
               iso_row_text(alarm, "validate"), scene ? scene : "");
    }
    printf("%zu random scenes by %s, seed %d: %zu false alarm%s (a rate below %.2g %%, at 95 %% confidence)\n",
           s->valid, o->with, o->seed, s->alarms, iso_words_plural(s->alarms),
           100 * iso_power_rate_bound(s->alarms, s->valid));
    printf("in %zu a level is worse than the simple way, in other views as well\n", s->findings);
    printf("in %zu of them something was not compared; %zu more show too little and were refused\n", s->open,
           s->drawn - s->valid);
}

static void print_json(const iso_cli *cli, const iso_power_random_options *o, const sums *s)
{
    json_t *root = iso_cli_json(cli);
    json_object_update_new(root,
                           json_pack("{s:i, s:s, s:I, s:I, s:f, s:I, s:I, s:I, s:O}", "seed", o->seed, "with", o->with,
                                     "scenes", (json_int_t)s->valid, "false_alarms", (json_int_t)s->alarms,
                                     "rate_bound", iso_power_rate_bound(s->alarms, s->valid), "worse_levels",
                                     (json_int_t)s->findings, "not_compared", (json_int_t)s->open, "refused",
                                     (json_int_t)(s->drawn - s->valid), "alarms", s->list));
    iso_cli_print_json(root);
}

iso_status iso_power_random(const iso_power_random_options *o, const iso_cli *cli, iso_error *err)
{
    const iso_progress progress = iso_cli_progress(cli);
    sums s = {.list = json_array()};
    FREED char *folder = iso_make_temp_dir();
    iso_status status = folder && s.list ? ISO_OK : iso_temp_dir_fail(err);
    /* One thread per scene: threads that wait for each other in small pictures cost more processor time. */
    setenv("OMP_WAIT_POLICY", "passive", 0);
    setenv("LP_NUM_THREADS", "0", 0);
    while (s.valid < (size_t)o->scenes && status == ISO_OK)
        status = run_round(o, folder, &progress, &s, err);
    if (status == ISO_OK && cli->json)
        print_json(cli, o, &s);
    else if (status == ISO_OK)
        print_sums(o, &s);
    if (folder)
        iso_remove_tree(folder);
    json_decref(s.list);
    return status != ISO_OK || s.alarms == 0
               ? status
               : iso_fail(err, ISO_E_DIFFERS, "isoshade-lab power: %zu of %zu right scenes were flagged", s.alarms,
                          s.valid);
}
