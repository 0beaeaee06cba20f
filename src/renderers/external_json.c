/* SPDX-License-Identifier: MIT */
/* external_json.c - parses renderers.json, the rows of a user in the table of renderers. */
#define _GNU_SOURCE
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "base/words.h"
#include "renderers/external.h"

/* A row, until the process ends. Its texts belong to `json`. */
typedef struct row {
    iso_renderer_info info;
    iso_external external;
    iso_lock_step lock_step;
    json_t *json;
    char *folder; /* of the file, absolute */
    char *file;
} row;

typedef enum tier { TIER_SAMPLES, TIER_LIMIT, TIER_BITS } tier;
static const char *const tier_names[] = {"samples", "limit", "8 bits", NULL};

/* Features of scenes that a row may claim. */
static const struct {
    const char *word;
    unsigned trait;
} abilities[] = {{"lights", ISO_HAS_LIGHTS},
                 {"orthographic", ISO_HAS_ORTHOGRAPHIC},
                 {"clip planes", ISO_HAS_CLIP_PLANES},
                 {"labels", ISO_HAS_LABELS}};

/* The limits of the OpenGL ray caster, which computes in float at the same samples. */
static const iso_sample_error usual_smooth = {.rmse = 1e-6, .max_abs = 2e-5},
                              usual_sharp = {.rmse = 5e-6, .max_abs = 2e-4};
static const char usual_why[] = "the same samples, in the program's own arithmetic (its row states no limits)";
static const char bits_why[] = "half a step of its integers (its row states no limits)";
/* Largest limit: calibrations of integers use it as well, and must detect a fault of 0.1. */
static const double most_limit = 0.05;

static void fail(iso_json_reader *r, iso_status status, const char *key, const char *what)
{
    TRY(r->status, iso_fail(r->err, status, "%s: \"%s\" %s", r->path, key, what));
}

/* ---- command lines ---- */

/* Makes a path from the file's folder: for the program if it has a slash, for another word if it names a file there. */
static const char *resolve(const row *to, const char *word, bool is_first)
{
    char *path = word[0] == '/' ? strdup(word) : iso_path_join(to->folder, word);
    const bool is_path = path &&
                         (is_first ? strchr(word, '/') != NULL : iso_path_exists(path) && !iso_path_is_dir(path));
    if (is_path)
        return path;
    free(path);
    return strdup(word);
}

static const char *const *get_words(iso_json_reader *r, const row *to, const char *key, bool required)
{
    const json_t *list = iso_json_get_array(r, to->json, key, required);
    const size_t count = json_array_size(list);
    if (r->status != ISO_OK || !list)
        return NULL;
    const char **words = calloc(count + 1, sizeof *words);
    for (size_t i = 0; i < count && words && r->status == ISO_OK; ++i) { /* no gap: the list ends with the first NULL */
        const char *word = json_string_value(json_array_get(list, i));
        if (!word || !word[0] || iso_words_has_control(word))
            fail(r, ISO_E_FORMAT, key, "is not a list of words");
        else
            words[i] = resolve(to, word, i == 0);
    }
    if (count == 0)
        fail(r, ISO_E_FORMAT, key, "is empty; give a program and its arguments");
    if (!words)
        fail(r, ISO_E_MEMORY, key, "does not fit into memory");
    return words;
}

static unsigned get_abilities(iso_json_reader *r, const row *to)
{
    enum { count = sizeof abilities / sizeof *abilities };
    const json_t *list = iso_json_get_array(r, to->json, "can", false);
    unsigned traits = 0;
    for (size_t i = 0; i < json_array_size(list); ++i) {
        const char *word = json_string_value(json_array_get(list, i));
        size_t k = 0;
        while (k < count && (!word || strcmp(abilities[k].word, word) != 0))
            ++k;
        if (k == count)
            fail(r, ISO_E_FORMAT, "can", "has an unknown word; choose from lights, orthographic, clip planes, labels");
        else
            traits |= abilities[k].trait;
    }
    return traits;
}

/* Checks a name, which is part of command lines and of file names. */
static void check_name(iso_json_reader *r, const char *name)
{
    static const char good[] = "abcdefghijklmnopqrstuvwxyz0123456789-_.";
    const size_t length = name ? strlen(name) : 0;
    if (r->status == ISO_OK &&
        (length == 0 || length > 24 || strspn(name, good) != length || name[0] == '-' || name[0] == '.'))
        fail(r, ISO_E_FORMAT, "name",
             "must have 1 to 24 letters (a-z), digits, - _ or ., and begin with a letter or digit");
}

static bool is_color(const char *text)
{
    return strlen(text) == 7 && text[0] == '#' && strspn(text + 1, "0123456789abcdefABCDEF") == 6;
}

/* ---- limits ---- */

/* Reads "limits": {"rmse", "max_abs", "sharp_rmse", "sharp_max_abs"}; without the last two they equal the first two. */
static void get_limits(iso_json_reader *r, row *to)
{
    static const char *const keys[] = {"rmse", "max_abs", "sharp_rmse", "sharp_max_abs", NULL};
    const json_t *limits = iso_json_get_object(r, to->json, "limits", false);
    iso_lock_step *lock = &to->lock_step;
    iso_json_get_string(r, to->json, "why", limits != NULL, &lock->why);
    if (r->status != ISO_OK || !limits)
        return;
    iso_json_only_keys(r, limits, "\"limits\"", keys);
    iso_json_get_number(r, limits, "rmse", true, 0, most_limit, &lock->smooth.rmse);
    iso_json_get_number(r, limits, "max_abs", true, 0, most_limit, &lock->smooth.max_abs);
    lock->sharp = lock->smooth;
    iso_json_get_number(r, limits, "sharp_rmse", false, 0, most_limit, &lock->sharp.rmse);
    iso_json_get_number(r, limits, "sharp_max_abs", false, 0, most_limit, &lock->sharp.max_abs);
}

/* Adds half a step of 1 / (2^bits - 1) to limits: to a value, and to the image as a whole, which may be flat. */
static iso_sample_error rounded(iso_sample_error error, size_t bits)
{
    const double half_step = 0.5 / (ldexp(1, (int)bits) - 1) * (1 + 1e-6); /* for programs that round in float */
    return (iso_sample_error){.rmse = error.rmse + half_step, .max_abs = error.max_abs + half_step};
}

static void take_tier(iso_json_reader *r, row *to, tier asked)
{
    const bool has_limits = json_object_get(to->json, "limits") != NULL, in_bits = asked == TIER_BITS;
    size_t bits = in_bits ? 8 : 0;
    iso_lock_step *lock = &to->lock_step;
    *lock = (iso_lock_step){.quadrature = in_bits ? ISO_QUADRATURE_CONVERGED : ISO_QUADRATURE_MIDPOINT,
                            .float_rays = asked == TIER_SAMPLES,
                            .why = in_bits ? bits_why : usual_why};
    if (!in_bits)
        lock->smooth = usual_smooth, lock->sharp = usual_sharp;
    get_limits(r, to);
    iso_json_get_size(r, to->json, "bits", false, 8, 16, &bits);
    bool half = false;
    iso_json_get_bool(r, to->json, "half", false, &half);
    if (half && (bits || asked == TIER_LIMIT))
        fail(r, ISO_E_FORMAT, "half", "is for the tier \"samples\", without \"bits\"");
    to->info.output.half = half;
    if (asked == TIER_LIMIT && (has_limits || bits))
        fail(r, ISO_E_FORMAT, has_limits ? "limits" : "bits",
             "is not for the tier \"limit\", whose limits follow from halved steps of float pictures");
    if (asked != TIER_LIMIT && to->info.seeds)
        fail(r, ISO_E_FORMAT, "seeds", "is for the tier \"limit\", which averages over them");
    if (bits) {
        lock->smooth = rounded(lock->smooth, bits);
        lock->sharp = rounded(lock->sharp, bits);
        to->info.output = (iso_render_output){.bits = (unsigned)bits, .most = 1};
    }
    to->info.traits |= in_bits ? 0 : ISO_HAS_LIMIT;
    to->info.lock_step = asked == TIER_LIMIT ? NULL : lock;
    to->external.tier = tier_names[asked];
}

/* ---- a row ---- */

enum { MOST_SEEDS = 32 }; /* of an extrapolated limit (compare/extrapolation.h) */

static void get_numbers(iso_json_reader *r, row *to)
{
    size_t samples = 0;
    iso_renderer_info *info = &to->info;
    iso_json_get_size(r, to->json, "seeds", false, 0, MOST_SEEDS, &info->seeds);
    iso_json_get_size(r, to->json, "samples", false, 0, 1 << 20, &samples);
    iso_json_get_number(r, to->json, "step_voxels", false, 1.0 / 4096, 64, &info->defaults.step_voxels);
    iso_json_get_number(r, to->json, "timeout_seconds", false, 0.001, 1e9, &to->external.timeout_seconds);
    bool has_sandbox = true;
    iso_json_get_bool(r, to->json, "sandbox", false, &has_sandbox);
    to->external.has_all_rights = !has_sandbox;
    info->defaults.samples = (int)samples;
    if (info->seeds)
        info->traits |= ISO_IS_RANDOM | ISO_READS_SEED;
    if (samples)
        info->traits |= ISO_READS_SAMPLES;
}

static iso_status read_row(row *to, size_t number, iso_error *err)
{
    static const char *const keys[] = {"name",    "title", "command",     "version",
                                       "package", "tier",  "can",         "seeds",
                                       "samples", "bits",  "half",        "limits",
                                       "why",     "color", "step_voxels", "timeout_seconds",
                                       "sandbox", NULL};
    static const char *const colors[] = {"#cc79a7", "#56b4e9", "#e69f00", "#8c6d31", "#7b4173", "#637939"};
    char where[1100];
    const char *name = json_string_value(json_object_get(to->json, "name"));
    snprintf(where, sizeof where, "%.900s: renderer %zu%s%.100s", to->file, number + 1, name ? ", " : "",
             name ? name : "");
    iso_json_reader r = {.path = where, .err = err};
    int asked = TIER_SAMPLES;
    to->info = (iso_renderer_info){.color = colors[number % (sizeof colors / sizeof *colors)],
                                   .traits = ISO_EXTERNAL_TRAITS | ISO_IS_OF_A_USER,
                                   .defaults = {.source = ISO_FROM_CODES},
                                   .sample_seconds = 4e-7,
                                   .found_in = to->file,
                                   .data = &to->external,
                                   ISO_EXTERNAL_CALLBACKS};
    if (!json_is_object(to->json))
        return iso_fail(err, ISO_E_FORMAT, "%s: must be an object", where);
    iso_json_only_keys(&r, to->json, "a renderer", keys);
    iso_json_get_string(&r, to->json, "name", true, &to->info.name);
    check_name(&r, to->info.name);
    to->info.title = to->info.stages[0] = to->info.name;
    iso_json_get_string(&r, to->json, "title", false, &to->info.title);
    iso_json_get_string(&r, to->json, "color", false, &to->info.color);
    if (!is_color(to->info.color))
        fail(&r, ISO_E_FORMAT, "color", "is not like \"#cc79a7\"");
    iso_json_get_string(&r, to->json, "package", false, &to->external.package);
    iso_json_get_word(&r, to->json, "tier", true, tier_names, &asked);
    to->info.traits |= get_abilities(&r, to);
    get_numbers(&r, to);
    take_tier(&r, to, (tier)asked);
    if (r.status == ISO_OK)
        to->external.command = get_words(&r, to, "command", true);
    if (r.status == ISO_OK)
        to->external.version = get_words(&r, to, "version", false);
    return r.status;
}

static void destroy_words(const char *const *words)
{
    for (size_t i = 0; words && words[i]; ++i)
        free((char *)words[i]);
    free((void *)words);
}

/* Frees a row that was refused; the table keeps the others until the process ends. */
static void destroy_row(row *r)
{
    destroy_words(r->external.command);
    destroy_words(r->external.version);
    json_decref(r->json);
    free(r->file);
    free(r->folder);
    free(r);
}

static iso_status replace_program(row *to, const iso_external_stand_in *instead, iso_error *err)
{
    iso_renderer_info *info = &to->info;
    info->data = instead->data;
    info->version = instead->version;
    info->render = instead->render;
    info->render_several = NULL;
    info->describe = NULL;
    info->found_in = NULL;
    info->traits |= ISO_IS_OF_PICTURES;
    info->step_count = instead->steps;
    if (instead->steps < 2)
        info->traits &= ~(unsigned)ISO_HAS_LIMIT;
    return info->lock_step || instead->steps >= 2
               ? ISO_OK
               : iso_fail(err, ISO_E_FORMAT,
                          "%s: the tier \"limit\" needs pictures at two or more steps, \"steps\" is %zu", to->file,
                          instead->steps);
}

static iso_status add_row(json_t *json, size_t number, const char *path, const char *folder,
                          const iso_external_stand_in *instead, iso_error *err)
{
    const size_t place = iso_renderer_count();
    row *to = calloc(1, sizeof *to);
    if (!to || place == ISO_MAX_RENDERERS) {
        free(to);
        return iso_fail(err, to ? ISO_E_RANGE : ISO_E_MEMORY, "%s: renderer %zu: too many renderers, at most %d", path,
                        number + 1, ISO_MAX_RENDERERS);
    }
    to->json = json_incref(json);
    to->file = strdup(path);
    to->folder = strdup(folder);
    iso_status status = to->file && to->folder ? read_row(to, number, err)
                                               : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
    if (status == ISO_OK && instead)
        status = replace_program(to, instead, err);
    if (status == ISO_OK && (status = iso_renderers_register(&to->info, err)) != ISO_OK)
        status = iso_fail_in(err, status, "%s: renderer %zu", path, number + 1);
    if (status != ISO_OK)
        destroy_row(to);
    return status;
}

static iso_status add_rows(const char *path, const char *folder, json_t *root, iso_error *err)
{
    static const char *const keys[] = {"schema", "renderers", NULL};
    iso_json_reader r = {.path = path, .err = err};
    const char *schema = "";
    iso_json_only_keys(&r, root, "the file", keys);
    iso_json_get_string(&r, root, "schema", true, &schema);
    json_t *rows = iso_json_get_array(&r, root, "renderers", true);
    NEED(r.status);
    if (strcmp(schema, "isoshade.renderers/1") != 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: \"schema\" is \"%s\", must be \"isoshade.renderers/1\"", path, schema);
    for (size_t i = 0; i < json_array_size(rows); ++i)
        NEED(add_row(json_array_get(rows, i), i, path, folder, NULL, err));
    return ISO_OK;
}

iso_status iso_external_register(json_t *json, const char *path, const char *folder,
                                 const iso_external_stand_in *instead, const iso_renderer_info **r, iso_error *err)
{
    const size_t place = iso_renderer_count();
    const iso_status status = add_row(json, place, path, folder, instead, err);
    *r = status == ISO_OK ? iso_renderer_at(place) : NULL;
    return status;
}

static iso_status load_file(const char *path, iso_error *err)
{
    json_auto_t *root = NULL;
    FREED char *absolute = realpath(path, NULL), *folder = absolute ? iso_path_dir(absolute) : NULL;
    NEED(folder ? iso_json_load(path, &root, err)
                : iso_fail(err, iso_errno_status(), "%s: cannot be read: %s", path, strerror(errno)));
    return add_rows(path, folder, root, err);
}

iso_status iso_renderers_load(const char *given, iso_error *err)
{
    const char *paths = given ? given : getenv(ISO_RENDERERS_VARIABLE);
    if (!paths || !*paths)
        return ISO_OK;
    FREED char *copy = strdup(paths);
    NEED_MEMORY(copy, err, "out of memory");
    for (char *path, *rest = copy; (path = strsep(&rest, ","));) {
        const iso_status status = load_file(path, err);
        if (status != ISO_OK)
            return given ? status : iso_fail_in(err, status, "$" ISO_RENDERERS_VARIABLE);
    }
    return ISO_OK;
}
