/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "chart/grid.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/words.h"

const size_t iso_chart_palettes[ISO_CHART_PALETTES] = {254, 1022};

char *iso_chart_default_codes(char *text, size_t size)
{
    const iso_code usual = iso_pyramid_defaults().code;
    size_t length = (size_t)snprintf(text, size, "%s", iso_code_describe(usual)->name);
    for (int c = 0; c < ISO_CODE_COUNT && length < size; ++c)
        if ((iso_code)c != usual && iso_code_describe((iso_code)c)->is_textured)
            length += (size_t)snprintf(text + length, size - length, ",%s", iso_code_describe((iso_code)c)->name);
    return text;
}

/* ---- the user's lists -------------------------------------------------------- */

/* An option with a list of numbers from lo to hi. */
typedef struct number_list {
    const char *option, *wanted; /* for error messages */
    double lo, hi;
} number_list;

static const number_list steps = {"--steps", "steps of 0.001 to 100 voxels, such as 2,1,0.5", 1e-3, 100};
static const number_list errors = {"--plans", "errors of 1e-6 to 1, such as 4/255,1/255, or none", 1e-6, 1};

/* Parses "2,1,0.5": at most ISO_CHART_MAX_LIST numbers or quotients. */
static iso_status parse_numbers(const number_list *list, const char *text, double *values, size_t *count,
                                iso_error *err)
{
    *count = 0;
    for (const char *at = text;; ++at) {
        char *end;
        double value = iso_words_read_quotient(at, &end);
        if (end == at || !(value >= list->lo && value <= list->hi) || *count == ISO_CHART_MAX_LIST ||
            (*end && *end != ','))
            return iso_fail(err, ISO_E_USAGE, "%s is \"%s\", must be up to %d %s", list->option, text,
                            ISO_CHART_MAX_LIST, list->wanted);
        values[(*count)++] = value;
        if (!*end)
            return ISO_OK;
        at = end;
    }
}

static iso_status take_renderer(const char *word, bool *flags, iso_error *err)
{
    const iso_renderer_info *r;
    NEED(iso_renderer_from_name(word, &r, err));
    flags[iso_renderer_index(r)] = true;
    return ISO_OK;
}

static iso_status take_code(const char *word, bool *flags, iso_error *err)
{
    iso_code code = ISO_CODE_FIT;
    iso_status status = iso_code_from_name(word, &code, err);
    if (status == ISO_OK && !iso_code_describe(code)->is_textured)
        return iso_fail(err, ISO_E_USAGE, "--codes: a texture cannot filter \"%s\"", word);
    flags[code] = true;
    return status;
}

static iso_status take_filter(const char *word, bool *flags, iso_error *err)
{
    iso_direction_filter filter = ISO_DIRECTION_MOMENTS;
    iso_status status = iso_direction_filter_from_name(word, &filter, err);
    if (status == ISO_OK && filter == ISO_DIRECTION_AUTO)
        return iso_fail(err, ISO_E_USAGE, "--filters: auto chooses among filters; list the filters to compare");
    flags[filter] = true;
    return status;
}

static iso_status take_estimator(const char *word, bool *flags, iso_error *err)
{
    iso_gradient_method method = ISO_GRADIENT_CENTRAL;
    iso_status status = iso_gradient_from_name(word, &method, err);
    flags[method] = true;
    return status;
}

/* Sets flags[0] for the midpoint rule, flags[1] for pre-integration. */
static iso_status take_quadrature(const char *word, bool *flags, iso_error *err)
{
    bool midpoint = strcmp(word, "midpoint") == 0;
    if (!midpoint && strcmp(word, "preintegrated") != 0)
        return iso_fail(err, ISO_E_USAGE, "--quadratures has \"%s\", must be midpoint or preintegrated", word);
    flags[!midpoint] = true;
    return ISO_OK;
}

/* Sets flags[0] for the scene's transfer function, flags[1] for the level's own, flags[2] for the level's 2D ones. */
static iso_status take_tf(const char *word, bool *flags, iso_error *err)
{
    static const char *const names[] = {"original", "adapted", "tf-2d"};
    for (size_t i = 0; i < 3; ++i)
        if (strcmp(word, names[i]) == 0) {
            flags[i] = true;
            return ISO_OK;
        }
    return iso_fail(err, ISO_E_USAGE, "--tfs has \"%s\", must be original, adapted or tf-2d", word);
}

/* Parses "a,b,c" and sets the flag of each word. */
static iso_status parse_list(const char *list, iso_status (*take)(const char *, bool *, iso_error *), bool *flags,
                             iso_error *err)
{
    FREED char *copy = strdup(list);
    NEED_MEMORY(copy, err, "out of memory");
    for (char *word, *rest = copy; (word = strsep(&rest, ","));)
        NEED(take(word, flags, err));
    return ISO_OK;
}

/* Copies the first word of a list that has been parsed. */
static const char *first_word(const char *list, char word[64])
{
    snprintf(word, 64, "%.*s", (int)strcspn(list, ","), list);
    return word;
}

const char *iso_chart_default_renderers(char *text, size_t size)
{
    return iso_renderers_by_default(ISO_HAS_LIMIT, text, size);
}

iso_status iso_chart_grid_parse(const iso_chart_words *words, iso_chart_grid *g, iso_error *err)
{
    *g = (iso_chart_grid){.step_count = 0};
    bool quadratures[2] = {false}, tfs[3] = {false};
    char word[64], with[256], all_codes[256];
    const char *filters = words->filters, *estimators = words->estimators,
               *codes = words->codes ? words->codes : iso_chart_default_codes(all_codes, sizeof all_codes),
               *plans = words->plans;
    const struct {
        const char *list;
        iso_status (*take)(const char *, bool *, iso_error *);
        bool *flags;
    } lists[] = {{words->with ? words->with : iso_chart_default_renderers(with, sizeof with), take_renderer, g->with},
                 {codes, take_code, g->codes},
                 {filters, take_filter, g->filters},
                 {estimators, take_estimator, g->estimators},
                 {words->quadratures, take_quadrature, quadratures},
                 {words->tfs, take_tf, tfs}};
    iso_status status = ISO_OK;
    for (size_t i = 0; i < sizeof lists / sizeof *lists && status == ISO_OK; ++i)
        status = parse_list(lists[i].list, lists[i].take, lists[i].flags, err);
    TRY(status, iso_direction_filter_from_name(first_word(filters, word), &g->first_filter, err));
    TRY(status, iso_gradient_from_name(first_word(estimators, word), &g->first_estimator, err));
    TRY(status, iso_code_from_name(first_word(codes, word), &g->first_code, err));
    TRY(status, parse_numbers(&steps, words->steps, g->steps, &g->step_count, err));
    if (status == ISO_OK && strcmp(plans, "none") != 0)
        status = parse_numbers(&errors, plans, g->plans, &g->plan_count, err);
    for (size_t r = 0; r < iso_renderer_count() && !words->with; ++r)
        g->optional[r] = g->with[r];
    g->midpoint = quadratures[0];
    g->preintegrated = quadratures[1];
    g->original = tfs[0];
    g->adapted = tfs[1];
    g->tf_2d = tfs[2];
    return status;
}

/* ---- names ------------------------------------------------------------------ */

void iso_chart_name_shading(const iso_chart_case *c, char *text, size_t size)
{
    if (c->plan_error > 0)
        snprintf(text, size, "bricks");
    else if (c->source == ISO_FROM_CODES)
        snprintf(text, size, "%s", iso_code_describe(c->code)->name);
    else if (c->source == ISO_FROM_PALETTE)
        snprintf(text, size, "palette-%zu", iso_chart_palettes[c->palette]);
    else
        snprintf(text, size, "%s", iso_direction_source_name(c->source));
}

const char *iso_chart_name_tf(const iso_chart_case *c)
{
    return c->second == ISO_SECOND_VALUE_DEVIATION  ? "deviation"
           : c->second == ISO_SECOND_VALUE_GRADIENT ? "gradient"
           : c->adapted                             ? "adapted"
                                                    : "original";
}

/* Names the estimator only if it is not the usual one. */
void iso_chart_describe(const iso_chart_case *c, char *text, size_t size)
{
    if (c->plan_error > 0) {
        snprintf(text, size, "%s; plan for %.2g; step %g", c->renderer->name, c->plan_error, c->step_voxels);
        return;
    }
    const bool on_the_fly = c->source == ISO_FROM_ON_THE_FLY, usual = c->estimator == ISO_GRADIENT_CENTRAL;
    char shading_from[64];
    iso_chart_name_shading(c, shading_from, sizeof shading_from);
    snprintf(text, size, "%s; level %zu%s; %s%s%s%s%s; step %g%s", c->renderer->name, c->level,
             !c->adapted                               ? ""
             : c->second == ISO_SECOND_VALUE_DEVIATION ? " 2D TF (deviation)"
             : c->second == ISO_SECOND_VALUE_GRADIENT  ? " 2D TF (gradient)"
                                                       : " adapted TF",
             shading_from, on_the_fly || c->level == 0 ? "" : " ",
             on_the_fly || c->level == 0 ? "" : iso_direction_filter_name(c->filter), on_the_fly || usual ? "" : " ",
             on_the_fly || usual ? "" : iso_gradient_name(c->estimator), c->step_voxels,
             c->preintegrated ? " pre-integrated" : "");
}

void iso_chart_describe_series(const iso_chart_case *c, char *text, size_t size)
{
    char shading_from[64];
    iso_chart_name_shading(c, shading_from, sizeof shading_from);
    snprintf(text, size, "%s: %s", c->renderer->name, c->plan_error > 0 ? "plan" : shading_from);
}

/* ---- the grid --------------------------------------------------------------- */

/* Returns the bytes in files: scalars as stored, directions, the extinction scale, and the second value of a 2D transfer
 * function. A direction takes 3 bytes, 3 floats, an index of whole bytes, or nothing. */
static double stored_bytes(const iso_level *level, const iso_chart_case *c)
{
    double direction = c->source == ISO_FROM_ON_THE_FLY ? 0 : c->source == ISO_FROM_FLOAT ? 12 : 3;
    if (c->source == ISO_FROM_PALETTE)
        direction = iso_chart_palettes[c->palette] <= 255 ? 1 : 2;
    const double second = c->second == ISO_SECOND_VALUE_NONE ? 0 : 1,
                 scale = level->scale && !level->geometry.has_no_data ? 1 : 0; /* a share of data is in no file */
    return (double)iso_geometry_voxel_count(&level->geometry) *
           ((double)iso_type_bytes(level->stored_type) + direction + second + scale);
}

/* Estimates the cost of a ray by its fetches. Per sample: 1 scalar, 1 code, 8 to flip codes, 6 more scalars on the fly.
 * sample_seconds covers renderers that are slower in every sample. */
static double relative_cost(const iso_level *level, const iso_chart_case *c)
{
    const size_t *n = level->geometry.size;
    double longest = fmax((double)n[0], fmax((double)n[1], (double)n[2]));
    double fetches = c->source == ISO_FROM_ON_THE_FLY ? 7
                     : c->source == ISO_FROM_FLIPPED  ? 9
                     : c->source == ISO_FROM_PALETTE  ? 4
                                                      : 2;
    return longest / c->step_voxels * (fetches + (c->preintegrated || c->second != ISO_SECOND_VALUE_NONE ? 1 : 0)) *
           c->renderer->sample_seconds;
}

/* The usual choices, from which departures count. */
typedef struct usual_choice {
    const iso_renderer_info *renderer;
    iso_code code;
    iso_gradient_method estimator;
    iso_direction_filter filter;
    double step_voxels; /* middle of the list */
} usual_choice;

static size_t count_departures(const iso_chart_case *c, const usual_choice *usual)
{
    size_t n = (size_t)c->adapted + (c->second != ISO_SECOND_VALUE_NONE) + c->preintegrated +
               (c->filter != usual->filter) + (c->estimator != usual->estimator) + (c->plan_error > 0);
    if (iso_renderer_has(usual->renderer, ISO_IS_PROGRAM)) /* only other programs were requested: they are equals */
        n += !iso_renderer_has(c->renderer, ISO_IS_PROGRAM);
    else if (iso_renderer_has(c->renderer, ISO_IS_PROGRAM))
        n += c->level == 0 && c->step_voxels == usual->step_voxels ? 1 : 2;
    else
        n += c->renderer != usual->renderer;
    if (c->plan_error > 0)
        return n;
    n += c->source == ISO_FROM_FLOAT || c->source == ISO_FROM_ON_THE_FLY;
    n += c->source == ISO_FROM_FLIPPED || c->source == ISO_FROM_PALETTE || c->code != usual->code ? 2 : 0;
    return n;
}

static bool is_power_of_two(double x)
{
    int exponent;
    return frexp(x, &exponent) == 0.5;
}

/* Returns the rank of a case in the order of measuring. An adapted transfer function comes before other departures: at
 * no cost it brings a coarse level nearer to level 0. A step between or above the usual ones comes later: it only makes
 * an existing front denser. */
static size_t turn_of(const iso_chart_case *c)
{
    const bool own_tf = c->adapted && c->second == ISO_SECOND_VALUE_NONE;
    return 2 * c->departures - own_tf + (!is_power_of_two(c->step_voxels) || c->step_voxels > 2);
}

/* Sorts by turn. Within a turn: the first pyramid before others, which must be built; our own renderers before other
 * programs; one pyramid after another, as not all fit in memory; cheap settings first. */
static int by_turn(const void *a, const void *b)
{
    const iso_chart_case *x = a, *y = b;
    const double keys[][2] = {{(double)x->turn, (double)y->turn},
                              {x->needs_pyramid, y->needs_pyramid},
                              {iso_renderer_has(x->renderer, ISO_IS_PROGRAM),
                               iso_renderer_has(y->renderer, ISO_IS_PROGRAM)},
                              {x->estimator, y->estimator},
                              {x->filter, y->filter},
                              {x->relative_cost, y->relative_cost},
                              {(double)x->stored_bytes, (double)y->stored_bytes},
                              {x->code, y->code}};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i)
        if (keys[i][0] != keys[i][1])
            return keys[i][0] < keys[i][1] ? -1 : 1;
    return 0;
}

/* Repeats each setting for every scene. */
static iso_status repeat_for_scenes(size_t scene_count, iso_chart_case **cases, size_t *count, iso_error *err)
{
    iso_chart_case *all = calloc(scene_count * *count + 1, sizeof *all);
    NEED_MEMORY(all, err, "chart: no memory for %zu settings", scene_count * *count);
    for (size_t i = 0; i < scene_count * *count; ++i) {
        all[i] = (*cases)[i / scene_count];
        all[i].scene = i % scene_count;
        all[i].setting = i / scene_count;
    }
    free(*cases);
    *cases = all;
    *count *= scene_count;
    return ISO_OK;
}

void iso_chart_cases_free(iso_chart_case *cases, size_t count)
{
    for (size_t i = 0; cases && i < count; ++i)
        free(cases[i].picture);
    free(cases);
}

/* True if no other setting of the grid is the same. Level 0 has one filter and no adapted TF; gradients on the fly need
 * no filter, estimator or code; other programs get decoded directions and have their own quadrature. */
static bool is_distinct(const iso_chart_case *c, const usual_choice *usual)
{
    const bool on_the_fly = c->source == ISO_FROM_ON_THE_FLY,
               usual_pyramid = c->filter == usual->filter && c->estimator == usual->estimator;
    if (iso_renderer_has(c->renderer, ISO_IS_PROGRAM) &&
        (c->source != ISO_FROM_CODES || c->code != usual->code || c->preintegrated))
        return false;
    if ((c->level == 0 || on_the_fly) && c->filter != usual->filter)
        return false;
    if (on_the_fly && c->estimator != usual->estimator)
        return false;
    if (c->level == 0 && c->adapted)
        return false;
    /* 2D transfer functions: with the usual directions only, which suffice to show their gain */
    if (c->second != ISO_SECOND_VALUE_NONE &&
        (c->source != ISO_FROM_CODES || c->code != usual->code || c->preintegrated || !usual_pyramid))
        return false;
    return c->source == ISO_FROM_CODES || c->code == usual->code;
}

/* True if the setting was requested and can be made. A pyramid on disk has fixed levels; without floats, also its
 * code. */
static bool is_wanted(const iso_chart_grid *g, const iso_pyramid *first, bool is_volume, const usual_choice *usual,
                      const iso_chart_case *c)
{
    const bool other_program = iso_renderer_has(c->renderer, ISO_IS_PROGRAM),
               has_floats = is_volume || first->levels[c->level].directions;
    if (!g->with[iso_renderer_index(c->renderer)])
        return false;
    if (is_volume ? !g->filters[c->filter] || !g->estimators[c->estimator]
                  : c->filter != usual->filter || c->estimator != usual->estimator)
        return false;
    if (c->source == ISO_FROM_CODES && !g->codes[c->code] && !other_program)
        return false;
    if (!(c->preintegrated ? g->preintegrated : g->midpoint || other_program))
        return false;
    if (c->level > 0 && !(c->second != ISO_SECOND_VALUE_NONE ? g->tf_2d : c->adapted ? g->adapted : g->original))
        return false;
    return has_floats || (c->source != ISO_FROM_FLOAT && (c->source != ISO_FROM_CODES || c->code == usual->code));
}

/* Decodes the i-th combination of all axes, sensible or not. */
static iso_chart_case combination(const iso_chart_grid *g, size_t levels, size_t i)
{
    static const struct {
        iso_direction_source source;
        size_t palette;
    } sources[] = {{ISO_FROM_CODES, 0},      {ISO_FROM_FLOAT, 0},   {ISO_FROM_FLIPPED, 0},
                   {ISO_FROM_ON_THE_FLY, 0}, {ISO_FROM_PALETTE, 0}, {ISO_FROM_PALETTE, 1}};
    const size_t source_count = sizeof sources / sizeof *sources;
    iso_chart_case c = {.metrics = {.rmse = NAN}};
    c.step_voxels = g->steps[i % g->step_count], i /= g->step_count;
    c.preintegrated = i % 2, i /= 2;
    c.code = (iso_code)(i % ISO_CODE_COUNT), i /= ISO_CODE_COUNT;
    c.source = sources[i % source_count].source, c.palette = sources[i % source_count].palette;
    i /= source_count;
    c.filter = (iso_direction_filter)(i % ISO_DIRECTION_COUNT), i /= ISO_DIRECTION_COUNT;
    c.estimator = (iso_gradient_method)(i % ISO_GRADIENT_COUNT), i /= ISO_GRADIENT_COUNT;
    static const iso_second_value second[] = {ISO_SECOND_VALUE_NONE, ISO_SECOND_VALUE_NONE, ISO_SECOND_VALUE_DEVIATION,
                                              ISO_SECOND_VALUE_GRADIENT};
    c.adapted = i % 4 > 0, c.second = second[i % 4], i /= 4;
    c.level = i % levels, i /= levels;
    c.renderer = i < iso_renderer_count() ? iso_renderer_at(i) : NULL; /* NULL: past the end */
    return c;
}

/* NULL: none. */
static const iso_renderer_info *wanted_with_bricks(const iso_chart_grid *g)
{
    for (size_t r = 0; r < iso_renderer_count(); ++r)
        if (g->with[r] && iso_renderer_has(iso_renderer_at(r), ISO_HAS_BRICKS))
            return iso_renderer_at(r);
    return NULL;
}

/* Adds plans: nodes of level 0 in bricks. Their bytes are known after they are made. */
static void add_plans(const iso_chart_grid *g, const iso_level *level0, const usual_choice *usual,
                      iso_chart_case *cases, size_t *count)
{
    const iso_renderer_info *renderer = wanted_with_bricks(g);
    for (size_t i = 0; i < g->plan_count && renderer; ++i)
        for (size_t k = 0; k < g->step_count; ++k) {
            iso_chart_case c = {.renderer = renderer,
                                .source = ISO_FROM_FLOAT,
                                .second = ISO_SECOND_VALUE_NONE,
                                .metrics = {.rmse = NAN},
                                .estimator = usual->estimator,
                                .filter = usual->filter,
                                .code = usual->code};
            c.plan_error = g->plans[i];
            c.step_voxels = g->steps[k];
            c.voxel_count = iso_geometry_voxel_count(&level0->geometry);
            c.relative_cost = relative_cost(level0, &c);
            c.departures = count_departures(&c, usual);
            c.turn = turn_of(&c);
            cases[(*count)++] = c;
        }
}

iso_status iso_chart_grid_cases(const iso_chart_grid *g, const iso_pyramid *first, bool is_volume, size_t scene_count,
                                iso_chart_case **cases, size_t *count, iso_error *err)
{
    usual_choice usual = {.renderer = iso_renderers_usual(),
                          .code = first->options.code,
                          .estimator = first->options.gradient.method,
                          .filter = first->options.direction_filter,
                          .step_voxels = g->steps[g->step_count / 2]};
    for (size_t r = 0; r < iso_renderer_count() && !g->with[iso_renderer_index(usual.renderer)]; ++r)
        usual.renderer = iso_renderer_at(r);
    *cases = NULL;
    for (int pass = 0; pass < 2; ++pass) { /* counts, then fills */
        *count = 0;
        for (size_t i = 0;; ++i) {
            iso_chart_case c = combination(g, first->level_count, i);
            if (!c.renderer)
                break;
            if (!is_wanted(g, first, is_volume, &usual, &c) || !is_distinct(&c, &usual))
                continue;
            const iso_level *level = &first->levels[c.level];
            c.voxel_count = iso_geometry_voxel_count(&level->geometry);
            c.relative_cost = relative_cost(level, &c);
            c.departures = count_departures(&c, &usual);
            c.turn = turn_of(&c);
            c.needs_pyramid = c.filter != usual.filter || c.estimator != usual.estimator;
            c.stored_bytes = stored_bytes(level, &c);
            c.build_seconds = level->build_seconds;
            if (pass == 1)
                (*cases)[*count] = c;
            ++*count;
        }
        if (pass == 0)
            *cases = malloc((*count + (size_t)ISO_CHART_MAX_LIST * ISO_CHART_MAX_LIST) * sizeof **cases);
        NEED_MEMORY(*cases, err, "chart: no memory for %zu settings", *count);
    }
    add_plans(g, &first->levels[0], &usual, *cases, count);
    qsort(*cases, *count, sizeof **cases, by_turn);
    return repeat_for_scenes(scene_count, cases, count, err);
}
