/* SPDX-License-Identifier: MIT */
/* all.c - measures all headline figures in one run, repeated, against their peers and against another program. */
#define _GNU_SOURCE
#include <jansson.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/embed.h"
#include "base/file.h"
#include "base/json.h"
#include "base/machine.h"
#include "base/order.h"
#include "base/parallel.h"
#include "base/process.h"
#include "base/status.h"
#include "bench/bench.h"
#include "report/page.h"

/* ---- headlines ---- */

/* The project's headline figures, each with the command that measures it, its bar and its peer. */

/* A number in a command's JSON answer, or the ratio of two. Each has a path: keys separated by dots. For a list,
 * brackets select the first object with all their values, as in cases[tf=dense,loop=plain].milliseconds. "process"
 * holds the command's own seconds, processor_seconds and peak_bytes. */
typedef struct iso_headline {
    const char *name, *sentence;
    const char *command[2];    /* words separated by spaces; [1] is small and quick */
    const char *figure, *over; /* over: the divisor's path; NULL: no ratio */
    const char *unit, *peer;
    bool lower_is_better;
    double bar; /* NaN: no bar */
} iso_headline;

/* Commands run in a new folder with volume.nrrd: thin shells in empty space, 512^3 bytes or (quick) 48^3. */
#define BUILD \
    { \
        "bench build --size 512 --runs 3 --files .", "bench build --size 48 --levels 2 --runs 1 --files ." \
    }
#define RENDER \
    { \
        "bench render --size 256 --image 512 --runs 3 --processor-time", "bench render --size 32 --image 32 --runs 1" \
    }
#define BRICKS \
    { \
        "bench render --size 256 --image 512 --runs 3 --bricks 8 --processor-time", \
            "bench render --size 32 --image 32 --runs 1 --bricks 8" \
    }
#define CAST \
    { \
        "bench cast --size 256 --image 512", "bench cast --size 32 --image 32" \
    }
#define EXPORT(to, name) \
    { \
        "export volume.nrrd --to " to " -o " name, "export volume.nrrd --to " to " -o " name \
    }

/* Commands that a person waits for: of a packed brain of 301 x 370 x 316 bytes, from Debian's mricron-data. */
#define BRAIN "/usr/share/mricron/templates/ch2better.nii.gz"
#define FOR_BRAIN(verb, options) \
    { \
        verb " " BRAIN " " options, verb " volume.nrrd " options \
    }
#define FIRST FOR_BRAIN("render", "-o first.png")
#define FIRST_512 \
    { \
        "render volume.nrrd -o first.png --size 512", "render volume.nrrd -o first.png --size 64" \
    }
#define PLAN FOR_BRAIN("plan", "--error 1/255")

static const iso_headline headlines[] = {
    {"first-picture", "a first picture of a brain", FIRST, "process.seconds", NULL, "s", NULL, true, 0.9},
    {"first-peak", "memory of the same", FIRST, "process.peak_bytes", NULL, "bytes", NULL, true, 1.76e8},
    {"first-picture-512", "a first picture of 512 x 512 x 512 bytes", FIRST_512, "process.seconds", NULL, "s", NULL,
     true, 1.5},
    {"first-peak-512", "memory of the same", FIRST_512, "process.peak_bytes", NULL, "bytes", NULL, true, 6e8},
    {"suggest", "a transfer function for the brain", FOR_BRAIN("tf suggest", "-o first.tf.json"), "process.seconds",
     NULL, "s", NULL, true, 0.6},
    {"view", "a page that draws the brain", FOR_BRAIN("view", "-o first.html"), "process.seconds", NULL, "s", NULL,
     true, 1.5},
    {"scenes", "a contact sheet of the brain", FOR_BRAIN("scenes", "-o scenes.png"), "process.seconds", NULL, "s", NULL,
     true, 2},
    {"plan", "a plan for the brain", PLAN, "process.seconds", NULL, "s", NULL, true, 5},
    {"plan-peak", "memory of the same", PLAN, "process.peak_bytes", NULL, "bytes", NULL, true, 3e8},
    {"build-memory", "building a pyramid with shading directions, in memory", BUILD, "ratio_to_memcpy", NULL, "times",
     "memcpy of the same bytes, same run", true, 6},
    {"build-files", "the same from a file to files", BUILD, "to_files.ratio_to_disk", NULL, "times",
     "reading and writing the same bytes, same run, until the disk has them", true, 1.25},
    {"gradients", "central differences to float vectors", BUILD, "gradients_to_float.ratio_to_memcpy", NULL, "times",
     "memcpy of the same bytes, same run", true, 2},
    {"build-peak", "memory of the build, in memory and to files", BUILD, "process.peak_bytes", NULL, "bytes", NULL,
     true, NAN},
    {"codes-dense", "stored directions against differences on the fly, dense TF", RENDER,
     "cases[tf=dense,gradients=on-the-fly,loop=auto].milliseconds",
     "cases[tf=dense,gradients=codes,loop=auto].milliseconds", "times faster", "differences on the fly, same run",
     false, 1.8},
    {"codes-sparse", "the same with a sparse TF", RENDER,
     "cases[tf=sparse,gradients=on-the-fly,loop=auto].milliseconds",
     "cases[tf=sparse,gradients=codes,loop=auto].milliseconds", "times faster", "differences on the fly, same run",
     false, 1.4},
    {"empty-space", "empty space left out, sparse TF, shaded", RENDER,
     "cases[tf=sparse,gradients=codes,loop=plain].milliseconds",
     "cases[tf=sparse,gradients=codes,loop=skipping].milliseconds", "times faster",
     "the loop that takes every sample, same run", false, 10},
    {"loop-dense", "the loop chosen for a dense TF", RENDER, "cases[tf=dense,gradients=codes,loop=auto].milliseconds",
     "cases[tf=dense,gradients=codes,loop=plain].milliseconds", "times", "the loop that takes every sample, same run",
     true, 1.05},
    {"cpu-dense", "the CPU ray caster, dense TF, shaded, processor time", CAST,
     "cases[tf=dense,gradients=codes].processor_ratio", NULL, "times faster", "the OpenGL one by software, same run",
     false, 1.5},
    {"cpu-sparse", "the same with a sparse TF", CAST, "cases[tf=sparse,gradients=codes].processor_ratio", NULL,
     "times faster", "the OpenGL one by software, same run", false, 1.5},
    {"bricks", "bricks of two levels without seams, dense TF, not lit", BRICKS,
     "cases[renderer=gl,texture=bricks-baked,gradients=none].milliseconds",
     "cases[renderer=gl,texture=uniform,gradients=none].milliseconds", "times", "one texture, same run", true, 1.1},
    {"cpu-bricks", "the same by the CPU ray caster", BRICKS,
     "cases[renderer=cpu,texture=bricks-baked,gradients=none].milliseconds",
     "cases[renderer=cpu,texture=uniform,gradients=none].milliseconds", "times", "the whole volume, same run", true,
     1.1},
    {"vdb-seconds", "a volume to OpenVDB, processor time", EXPORT("vdb", "volume.vdb"), "process.processor_seconds",
     NULL, "s", NULL, true, 12},
    {"vdb-peak", "memory of the same", EXPORT("vdb", "volume.vdb"), "process.peak_bytes", NULL, "bytes", NULL, true,
     8e8},
    {"blend-seconds", "a volume to a .blend file, processor time with Blender's", EXPORT("blender", "volume.blend"),
     "process.processor_seconds", NULL, "s", NULL, true, 12},
    {"blend-peak", "memory of the same, the larger of both programs", EXPORT("blender", "volume.blend"),
     "process.peak_bytes", NULL, "bytes", NULL, true, 8e8},
    {"df3-seconds", "a volume to a scene of POV-Ray, processor time", EXPORT("povray", "povray"),
     "process.processor_seconds", NULL, "s", NULL, true, 12},
    {"df3-peak", "memory of the same", EXPORT("povray", "povray"), "process.peak_bytes", NULL, "bytes", NULL, true,
     8e8},
};
enum { HEADLINES = sizeof headlines / sizeof *headlines };

/* ---- paths to numbers ---- */

/* True if the object has key=value; value is a string or an integer. */
static bool has_value(const json_t *object, const char *key, const char *value)
{
    const json_t *found = json_object_get(object, key);
    char number[32];
    if (json_is_integer(found)) {
        snprintf(number, sizeof number, "%lld", (long long)json_integer_value(found));
        return strcmp(number, value) == 0;
    }
    return json_is_string(found) && strcmp(json_string_value(found), value) == 0;
}

/* Finds the first object of the list with all of "key=value,key=value". Cuts the text up. */
static const json_t *choose(const json_t *list, char *conditions)
{
    size_t i;
    const json_t *object;
    char *keys[8], *values[8];
    size_t count = 0;
    for (char *one; count < 8 && (one = strsep(&conditions, ","));) {
        keys[count] = strsep(&one, "=");
        values[count++] = one ? one : "";
    }
    json_array_foreach (list, i, object) {
        bool all = true;
        for (size_t k = 0; k < count; ++k)
            all = all && has_value(object, keys[k], values[k]);
        if (all)
            return object;
    }
    return NULL;
}

static const json_t *follow(const json_t *answer, const char *way)
{
    char *copy = strdup(way), *rest = copy;
    const json_t *at = copy ? answer : NULL;
    for (char *part; at && (part = strsep(&rest, "."));) {
        char *bracket = strchr(part, '[');
        if (bracket) {
            *bracket++ = 0;
            bracket[strcspn(bracket, "]")] = 0;
        }
        at = json_object_get(at, part);
        if (bracket)
            at = choose(at, bracket);
    }
    free(copy);
    return at;
}

static iso_status read_number(const iso_headline *h, const json_t *answer, const char *way, double *value,
                              iso_error *err)
{
    const json_t *found = follow(answer, way);
    if (!json_is_number(found))
        return iso_fail(err, ISO_E_FORMAT, "%s: no number at %s in the command's answer", h->name, way);
    *value = json_number_value(found);
    return ISO_OK;
}

/* Computes the figure. ISO_E_FORMAT: no number at a path, or a division by zero. */
static iso_status headline_value(const iso_headline *h, const json_t *answer, double *value, iso_error *err)
{
    double over = 1;
    iso_status status = read_number(h, answer, h->figure, value, err);
    if (status == ISO_OK && h->over)
        status = read_number(h, answer, h->over, &over, err);
    if (status == ISO_OK && !(over > 0))
        status = iso_fail(err, ISO_E_FORMAT, "%s: %s is %g", h->name, h->over, over);
    *value /= over;
    return status;
}

enum { MOST_REPEATS = 99, MOST_WORDS = 64, OURS = 0, OTHER = 1 };

typedef struct all_bench {
    const iso_cli *cli;
    const char *programs[2]; /* OTHER: the program of --beside, or NULL */
    const char *folder;      /* working folder of the commands */
    char **only;             /* names, ends with NULL; NULL for all */
    int quick, repeats;
    double *values[2]; /* [headline * repeats + repeat]; NaN: not measured */
    char **causes[2];  /* why a headline has no figure, or NULL */
} all_bench;

/* ---- one command ---- */

/* Splits words into argv (cuts words up) and appends threads; threads "": the command's own default. */
static void split(char *words, const char *program, const char *threads, const char *argv[MOST_WORDS])
{
    size_t count = 0;
    argv[count++] = program;
    for (char *word; count + 5 < MOST_WORDS && (word = strsep(&words, " "));)
        argv[count++] = word;
    argv[count++] = "--json";
    argv[count++] = "-q";
    if (threads[0])
        argv[count++] = threads;
    argv[count] = NULL;
}

/* Runs "isoshade COMMAND --json" and returns its answer, with time and memory of the process. */
static iso_status run_json_command(const all_bench *b, const char *program, const char *command, json_t **answer,
                                   iso_error *err)
{
    const char *argv[MOST_WORDS];
    char *words = strdup(command), threads[32] = "";
    char *bytes = NULL;
    size_t size = 0;
    iso_process_outcome took = {0};
    FILE *output = open_memstream(&bytes, &size);
    const iso_process_options options = {.directory = b->folder,
                                         .sandbox = {.kind = ISO_SANDBOX_NONE},
                                         .output = output,
                                         .outcome = &took};
    iso_status status = ISO_OK;
    if (b->cli->threads > 0)
        snprintf(threads, sizeof threads, "--threads=%d", b->cli->threads);
    if (words && output) {
        split(words, program, threads, argv);
        status = iso_process_run(argv, &options, err);
    }
    if (!words || !output || fclose(output) != 0)
        status = iso_fail(err, ISO_E_MEMORY, "out of memory");
    TRY(status, iso_json_parse(command, bytes, size, answer, err));
    if (status == ISO_OK)
        json_object_set_new(*answer, "process",
                            json_pack("{s:f, s:f, s:f}", "seconds", took.seconds, "processor_seconds",
                                      took.processor_seconds, "peak_bytes", took.peak_bytes));
    free(bytes);
    free(words);
    return status;
}

/* ---- all of them ---- */

static const char *command_of(const all_bench *b, size_t headline)
{
    return headlines[headline].command[b->quick ? 1 : 0];
}

static bool is_requested(const all_bench *b, size_t headline)
{
    for (char **name = b->only; name && *name; ++name)
        if (strcmp(*name, headlines[headline].name) == 0)
            return true;
    return !b->only;
}

/* True if this is the first requested headline of its command: one run answers all headlines of a command. */
static bool is_first(const all_bench *b, size_t headline)
{
    if (!is_requested(b, headline))
        return false;
    for (size_t i = 0; i < headline; ++i)
        if (is_requested(b, i) && strcmp(command_of(b, i), command_of(b, headline)) == 0)
            return false;
    return true;
}

static void note_cause(char **causes, size_t headline, const iso_error *why)
{
    if (!causes[headline])
        causes[headline] = strdup(why->text);
}

/* Measures a headline. On failure it has no figure but a cause, and the others go on. */
static void measure(all_bench *b, size_t headline, int repeat, int which)
{
    json_auto_t *answer = NULL;
    iso_error why = {0};
    const iso_status status = run_json_command(b, b->programs[which], command_of(b, headline), &answer, &why);
    for (size_t i = headline; i < HEADLINES; ++i) {
        double *value = &b->values[which][i * (size_t)b->repeats + (size_t)repeat];
        if (!is_requested(b, i) || strcmp(command_of(b, i), command_of(b, headline)) != 0)
            continue;
        if (status != ISO_OK || headline_value(&headlines[i], answer, value, &why) != ISO_OK) {
            *value = NAN;
            note_cause(b->causes[which], i, &why);
        }
    }
}

/* Alternates which program runs first in each round, so that other load affects both. */
static iso_status measure_all(all_bench *b, iso_error *err)
{
    const iso_progress progress = iso_cli_progress(b->cli);
    size_t total = 0, done = 0;
    for (size_t i = 0; i < HEADLINES; ++i)
        total += is_first(b, i) ? (size_t)b->repeats : 0;
    for (int repeat = 0; repeat < b->repeats; ++repeat)
        for (size_t i = 0; i < HEADLINES; ++i) {
            if (!is_first(b, i))
                continue;
            for (int turn = 0; turn < 2; ++turn) {
                const int which = (turn + repeat) % 2;
                if (b->programs[which])
                    measure(b, i, repeat, which);
            }
            if (iso_process_was_stopped())
                return iso_fail(err, ISO_E_PROGRAM, "stopped by a signal");
            iso_progress_report(&progress, "measure", (double)++done / (double)total);
        }
    return ISO_OK;
}

/* ---- results ---- */

static double median_of(const double *values, int count)
{
    double sorted[MOST_REPEATS];
    for (int i = 0; i < count; ++i) {
        if (isnan(values[i]))
            return NAN;
        sorted[i] = values[i];
    }
    qsort(sorted, (size_t)count, sizeof *sorted, iso_order_doubles);
    return 0.5 * (sorted[(count - 1) / 2] + sorted[count / 2]);
}

static bool meets(const iso_headline *h, double value)
{
    return h->lower_is_better ? value <= h->bar : value >= h->bar;
}

static json_t *headline_to_json(const all_bench *b, size_t i, int which)
{
    const iso_headline *h = &headlines[i];
    const double *values = b->values[which] + i * (size_t)b->repeats, median = median_of(values, b->repeats);
    json_t *row = json_pack("{s:s, s:s, s:s, s:s, s:s?, s:b}", "name", h->name, "sentence", h->sentence, "command",
                            command_of(b, i), "unit", h->unit, "peer", h->peer, "lower_is_better", h->lower_is_better);
    json_t *list = json_array();
    for (int r = 0; r < b->repeats; ++r)
        json_array_append_new(list, iso_json_number(values[r]));
    json_object_set_new(row, "values", list);
    json_object_set_new(row, "median", iso_json_number(median));
    json_object_set_new(row, "bar", iso_json_number(h->bar));
    /* Bars hold for full sizes only. */
    json_object_set_new(row, "met",
                        isnan(h->bar) || isnan(median) || b->quick ? json_null() : json_boolean(meets(h, median)));
    if (isnan(median) && b->causes[which][i])
        json_object_set_new(row, "cause", json_string(b->causes[which][i]));
    return row;
}

static json_t *to_json(const all_bench *b, int which, const char *session)
{
    json_t *root = iso_cli_json(b->cli), *rows = json_array();
    json_object_set_new(json_object_get(root, "options"), "quick", json_boolean(b->quick));
    json_object_set_new(json_object_get(root, "options"), "repeat", json_integer(b->repeats));
    json_object_set_new(root, "program", json_string(which == OURS ? "isoshade" : iso_path_base(b->programs[which])));
    json_object_set_new(root, "session", json_string(session));
    json_object_set_new(root, "machine", iso_machine_describe());
    json_object_set_new(root, "threads", json_integer(iso_threads(b->cli->threads)));
    for (size_t i = 0; i < HEADLINES; ++i)
        if (is_requested(b, i))
            json_array_append_new(rows, headline_to_json(b, i, which));
    json_object_set_new(root, "headlines", rows);
    return root;
}

/* Prints a row. other_cause: why the other program has no figure, or NULL. Bars do not apply with --quick. */
static void print_row(const json_t *row, const char *other_cause, bool quick)
{
    char value[32] = "-", bar[32] = "";
    const json_t *median = json_object_get(row, "median"), *limit = json_object_get(row, "bar"),
                 *met = json_object_get(row, "met"), *cause = json_object_get(row, "cause");
    if (json_is_number(median))
        snprintf(value, sizeof value, "%.4g", json_number_value(median));
    if (json_is_number(limit) && !quick)
        snprintf(bar, sizeof bar, "%s %.4g",
                 json_is_true(json_object_get(row, "lower_is_better")) ? "<=" : ">=", json_number_value(limit));
    printf("%-17s %9s %-16s %-10s %-7s %s\n", json_string_value(json_object_get(row, "name")), value,
           json_string_value(json_object_get(row, "unit")), bar,
           json_is_true(met)    ? "met"
           : json_is_false(met) ? "missed"
                                : "",
           json_string_value(json_object_get(row, "sentence")));
    if (cause)
        printf("%-17s %s\n", "", json_string_value(cause));
    if (other_cause)
        printf("%-17s beside: %s\n", "", other_cause);
}

static void print_all(const all_bench *b, const json_t *ours)
{
    const json_t *row;
    size_t i, shown = 0;
    printf("%-17s %9s %-16s %-10s\n", "figure", "median", "", b->quick ? "" : "bar");
    for (i = 0; i < HEADLINES; ++i) {
        if (!is_requested(b, i))
            continue;
        row = json_array_get(json_object_get(ours, "headlines"), shown++);
        print_row(row, b->causes[OTHER][i], b->quick);
    }
}

ISO_EMBED(iso_bench_all_html, "src/bench/all.html");
ISO_EMBED(iso_bench_all_css, "src/bench/all.css");
ISO_EMBED(iso_bench_all_js, "src/bench/all.js");

static const iso_page page_of_all = {"isoshade bench all", iso_bench_all_html, {iso_bench_all_js}, iso_bench_all_css};

static json_t *sentence_of(const json_t *answer)
{
    size_t i, met = 0, judged = 0, missing = 0;
    const json_t *row;
    json_array_foreach (json_object_get(answer, "headlines"), i, row) {
        const json_t *verdict = json_object_get(row, "met");
        met += json_is_true(verdict);
        judged += json_is_boolean(verdict);
        missing += json_is_null(json_object_get(row, "median"));
    }
    if (judged == 0)
        return json_string("Measured on small data, so no bars apply");
    return json_sprintf("%zu of %zu bars are met%s", met, judged,
                        missing ? "; some figures could not be measured" : "");
}

static iso_status write_page(const char *path, const json_t *answer, iso_error *err)
{
    json_auto_t *data = json_copy((json_t *)answer), *nothing = json_object();
    json_object_set_new(data, "title", json_string("Speed and memory"));
    json_object_set_new(data, "sentence", sentence_of(answer));
    return data && nothing ? iso_page_write(path, &page_of_all, data, nothing, err)
                           : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
}

static iso_status report(const all_bench *b, const char *output, const char *page, const char *beside_output,
                         iso_error *err)
{
    char session[64];
    snprintf(session, sizeof session, "%ld-%.6f", (long)getpid(), iso_clock_seconds());
    json_auto_t *ours = to_json(b, OURS, session);
    if (output)
        NEED(iso_json_save(output, ours, err));
    if (page)
        NEED(write_page(page, ours, err));
    if (beside_output) {
        json_auto_t *other = to_json(b, OTHER, session);
        NEED(iso_json_save(beside_output, other, err));
    }
    if (b->cli->json) {
        iso_cli_print_json(json_incref(ours));
        return ISO_OK;
    }
    print_all(b, ours);
    return ISO_OK;
}

/* ---- the command ---- */

static iso_status make_volume(const all_bench *b, iso_error *err)
{
    static const char *const commands[2] = {"make shells --size 512 --type uint8 -o volume.nrrd",
                                            "make shells --size 48 --type uint8 -o volume.nrrd"};
    json_auto_t *answer = NULL;
    return run_json_command(b, b->programs[OURS], commands[b->quick ? 1 : 0], &answer, err);
}

static iso_status run_all(all_bench *b, const char *output, const char *page, const char *beside_output, iso_error *err)
{
    const size_t count = HEADLINES * (size_t)b->repeats;
    iso_status status = ISO_OK;
    for (int which = 0; which < 2; ++which) {
        b->causes[which] = calloc(HEADLINES, sizeof *b->causes[which]);
        b->values[which] = malloc(count * sizeof **b->values);
        for (size_t i = 0; b->values[which] && i < count; ++i)
            b->values[which][i] = NAN;
    }
    if (!b->causes[OURS] || !b->causes[OTHER] || !b->values[OURS] || !b->values[OTHER])
        status = iso_fail(err, ISO_E_MEMORY, "out of memory");
    TRY(status, make_volume(b, err));
    TRY(status, measure_all(b, err));
    TRY(status, report(b, output, page, beside_output, err));
    for (int which = 0; which < 2; ++which) {
        for (size_t i = 0; b->causes[which] && i < HEADLINES; ++i)
            free(b->causes[which][i]);
        free(b->causes[which]);
        free(b->values[which]);
    }
    return status;
}

static iso_status check_names(char *const *names, iso_error *err)
{
    for (; names && *names; ++names) {
        const iso_headline *found = NULL;
        for (size_t i = 0; i < HEADLINES && !found; ++i)
            found = strcmp(*names, headlines[i].name) == 0 ? &headlines[i] : NULL;
        if (!found)
            return iso_fail(err, ISO_E_USAGE,
                            "--only %s: no figure of that name; bench all --quick --repeat 1 lists them", *names);
    }
    return ISO_OK;
}

/* Splits "PROGRAM,FILE.json" at its last comma. */
static iso_status split_beside(char *beside, char **program, const char **file, iso_error *err)
{
    char *comma = strrchr(beside, ',');
    if (!comma || comma == beside || !comma[1])
        return iso_fail(err, ISO_E_USAGE, "--beside %s: must be PROGRAM,FILE.json", beside);
    *comma = 0;
    *file = comma + 1;
    return iso_process_find_named("--beside", beside, program, err);
}

static char **split_names(char *names)
{
    char **list = calloc(HEADLINES + 2, sizeof *list);
    size_t count = 0;
    for (char *one; list && count <= HEADLINES && (one = strsep(&names, ","));)
        list[count++] = one;
    return list;
}

typedef struct all_options {
    all_bench bench;
    char *only, *output, *page, *beside;
} all_options;

static const iso_option options[] = {
    {"only", 0, "measure only these figures (all)", "NAME,...", ISO_IN(all_options, only)},
    {"repeat", 0, "run each command N times", "N", ISO_IN(all_options, bench.repeats), .flags = ISO_SHOWN, .least = 1,
     .most = MOST_REPEATS},
    {"quick", 0, "use small volumes and pictures, to try it out; no bars", NULL, ISO_IN(all_options, bench.quick)},
    {"beside", 0, "run another isoshade in turn, write its figures to FILE.json", "PROGRAM,FILE.json",
     ISO_IN(all_options, beside)},
    {"output", 'o', "write the figures, for bench compare", "FILE.json", ISO_IN(all_options, output)},
    {"page", 0, "write the figures as a page", "FILE.html", ISO_IN(all_options, page)},
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    all_options *o = values;
    all_bench *b = &o->bench;
    char own[4096];
    FREED char *other = NULL, *folder = NULL;
    const char *beside_output = NULL;
    iso_status status = ISO_OK;
    b->cli = cli;
    if (o->only) {
        b->only = split_names(o->only);
        status = b->only ? check_names(b->only, err) : iso_fail(err, ISO_E_MEMORY, "out of memory");
    }
    if (status == ISO_OK && o->beside)
        status = split_beside(o->beside, &other, &beside_output, err);
    if (status == ISO_OK) {
        const ssize_t n = readlink("/proc/self/exe", own, sizeof own - 1);
        own[n > 0 ? n : 0] = 0;
        folder = iso_make_temp_dir();
        b->programs[OURS] = own;
        b->programs[OTHER] = other;
        b->folder = folder;
        status = folder && n > 0 ? run_all(b, o->output, o->page, beside_output, err) : iso_temp_dir_fail(err);
    }
    if (folder)
        iso_remove_tree(folder);
    free(b->only);
    return status;
}

const iso_command iso_bench_all = {
    .name = "bench all",
    .summary = "all headline figures, each with its bar and its peer; for bench compare",
    .usage = "[options]",
    .details = "Each command runs in a process of its own, --repeat times; the median counts. Both parts of a ratio\n"
               "come from one run. If a figure cannot be measured, its cause is listed and the others go on. A\n"
               "missed bar does not change the exit code. --threads is passed to each command.",
    .examples = "  isoshade bench all --quick --repeat 1 --only build-memory\n",
    ISO_COMMAND_OPTIONS(all_options, options, .bench = {.repeats = 5}),
    .run = run,
};
