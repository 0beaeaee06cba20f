#define _GNU_SOURCE
#include "cli/chart_grid.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const size_t iso_chart_palettes[ISO_CHART_PALETTES] = {254, 1022};

/* ---- what the user asked for ------------------------------------------------- */

/* A number, or a quotient such as 1/255; *end as strtod has it. */
static double read_quotient(const char *text, char **end)
{
    double above = strtod(text, end);
    if (*end == text || **end != '/')
        return above;
    const char *rest = *end + 1;
    char *rest_end;
    double below = strtod(rest, &rest_end);
    *end = rest_end == rest ? (char *)text : rest_end;
    return above / below;
}

iso_status iso_chart_parse_error(const char *option, const char *text, double *error, iso_error *err)
{
    char *end;
    *error = read_quotient(text, &end);
    if (end == text || *end || !(*error > 0 && *error <= 1))
        return iso_fail(err, ISO_E_USAGE, "%s is \"%s\", wanted an RMSE above 0 and at most 1, such as 1/255", option, text);
    return ISO_OK;
}

/* "2,1,0.5": at most ISO_CHART_MAX_LIST numbers or quotients of lo to hi. */
static iso_status parse_numbers(const char *option, const char *text, double lo, double hi, const char *wanted, double *values,
                                size_t *count, iso_error *err)
{
    *count = 0;
    for (const char *at = text;; ++at) {
        char *end;
        double value = read_quotient(at, &end);
        if (end == at || !(value >= lo && value <= hi) || *count == ISO_CHART_MAX_LIST || (*end && *end != ','))
            return iso_fail(err, ISO_E_USAGE, "%s is \"%s\", wanted up to %d %s", option, text, ISO_CHART_MAX_LIST, wanted);
        values[(*count)++] = value;
        if (!*end)
            return ISO_OK;
        at = end;
    }
}

static iso_status take_renderer(const char *word, bool *flags, iso_error *err)
{
    iso_renderer r = ISO_WITH_GL;
    iso_status status = iso_renderer_from_name(word, &r, err);
    flags[r] = true;
    return status;
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

/* flags[0] the midpoint rule, flags[1] pre-integration */
static iso_status take_quadrature(const char *word, bool *flags, iso_error *err)
{
    bool midpoint = strcmp(word, "midpoint") == 0;
    if (!midpoint && strcmp(word, "preintegrated") != 0)
        return iso_fail(err, ISO_E_USAGE, "--quadratures has \"%s\", wanted midpoint or preintegrated", word);
    flags[!midpoint] = true;
    return ISO_OK;
}

/* "a,b,c": sets the flag of each. */
static iso_status parse_list(const char *list, iso_status (*take)(const char *, bool *, iso_error *), bool *flags, iso_error *err)
{
    char *copy = strdup(list), *rest = copy;
    iso_status status = copy ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "out of memory");
    for (char *word; status == ISO_OK && (word = strsep(&rest, ","));)
        status = take(word, flags, err);
    free(copy);
    return status;
}

iso_status iso_chart_grid_parse(const iso_chart_words *words, iso_chart_grid *g, iso_error *err)
{
    *g = (iso_chart_grid){.step_count = 0};
    for (int c = 0; c < ISO_CODE_COUNT && !words->codes; ++c)
        g->codes[c] = iso_code_describe((iso_code)c)->is_textured;
    bool quadratures[2] = {false};
    iso_status status = parse_list(words->with ? words->with : "gl", take_renderer, g->with, err);
    if (status == ISO_OK && words->codes)
        status = parse_list(words->codes, take_code, g->codes, err);
    if (status == ISO_OK)
        status = parse_list(words->filters ? words->filters : "moments", take_filter, g->filters, err);
    if (status == ISO_OK)
        status = parse_list(words->estimators ? words->estimators : "central", take_estimator, g->estimators, err);
    if (status == ISO_OK)
        status = parse_list(words->quadratures ? words->quadratures : "midpoint,preintegrated", take_quadrature, quadratures, err);
    if (status == ISO_OK)
        status = parse_numbers("--steps", words->steps ? words->steps : "2,1,0.5,0.25,0.125", 1e-3, 100,
                               "steps of 0.001 to 100 voxels, such as 2,1,0.5", g->steps, &g->step_count, err);
    const char *plans = words->plans ? words->plans : "4/255,1/255";
    if (status == ISO_OK && strcmp(plans, "none") != 0)
        status = parse_numbers("--plans", plans, 1e-6, 1, "errors of 1e-6 to 1, such as 4/255,1/255, or none", g->plans,
                               &g->plan_count, err);
    g->midpoint = quadratures[0];
    g->preintegrated = quadratures[1];
    return status;
}

/* ---- names ------------------------------------------------------------------ */

void iso_chart_name_gradients(const iso_chart_case *c, char *text, size_t size)
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

/* The estimator is named where it is not the usual one. */
void iso_chart_describe(const iso_chart_case *c, char *text, size_t size)
{
    if (c->plan_error > 0) {
        snprintf(text, size, "%s; plan for %.2g; step %g", iso_renderer_name(c->renderer), c->plan_error, c->step_voxels);
        return;
    }
    const bool on_the_fly = c->source == ISO_FROM_ON_THE_FLY, usual = c->estimator == ISO_GRADIENT_CENTRAL;
    char gradients[64];
    iso_chart_name_gradients(c, gradients, sizeof gradients);
    snprintf(text, size, "%s; level %zu%s; %s%s%s%s%s; step %g%s", iso_renderer_name(c->renderer), c->level,
             !c->adapted                       ? ""
             : c->table == ISO_SPLIT_DEVIATION ? " TF over deviation"
             : c->table == ISO_SPLIT_GRADIENT  ? " TF over gradient"
                                               : " adapted TF", gradients, on_the_fly || c->level == 0 ? "" : " ",
             on_the_fly || c->level == 0 ? "" : iso_direction_filter_name(c->filter), on_the_fly || usual ? "" : " ",
             on_the_fly || usual ? "" : iso_gradient_name(c->estimator), c->step_voxels, c->preintegrated ? " pre-integrated" : "");
}

void iso_chart_describe_series(const iso_chart_case *c, char *text, size_t size)
{
    char gradients[64];
    iso_chart_name_gradients(c, gradients, sizeof gradients);
    snprintf(text, size, "%s: %s", iso_renderer_name(c->renderer), c->plan_error > 0 ? "plan" : gradients);
}

/* ---- the grid --------------------------------------------------------------- */

/* Scalars as stored, and for a direction 3 bytes, 3 floats, an index of whole bytes or nothing. A plan's bytes are known
 * when it is made. */
static double level_bytes(const iso_level *level, const iso_chart_case *c)
{
    double direction = c->source == ISO_FROM_ON_THE_FLY ? 0 : c->source == ISO_FROM_FLOAT ? 12 : 3;
    if (c->source == ISO_FROM_PALETTE)
        direction = iso_chart_palettes[c->palette] <= 255 ? 1 : 2;
    double second = c->table == ISO_SPLIT_NONE ? 0 : 1;
    return (double)iso_geometry_voxel_count(&level->geometry) * ((double)iso_type_bytes(level->stored_type) + direction + second);
}

/* Relative: 1 fetch of the scalar, 1 of a code, 8 to flip them, 6 more scalars on the fly; the reference and other programs are slower
 * throughout. */
static double relative_cost(const iso_level *level, const iso_chart_case *c)
{
    static const double slower[ISO_RENDERER_COUNT] = {
        [ISO_WITH_GL] = 1, [ISO_WITH_REFERENCE] = 10, [ISO_WITH_CYCLES] = 100, [ISO_WITH_POVRAY] = 100};
    const size_t *n = level->geometry.size;
    double longest = fmax((double)n[0], fmax((double)n[1], (double)n[2]));
    double fetches = c->source == ISO_FROM_ON_THE_FLY ? 7 : c->source == ISO_FROM_FLIPPED ? 9 : c->source == ISO_FROM_PALETTE ? 4 : 2;
    return longest / c->step_voxels * (fetches + (c->preintegrated || c->table != ISO_SPLIT_NONE ? 1 : 0)) * slower[c->renderer];
}

static int by_turn(const void *a, const void *b)
{
    double x = ((const iso_chart_case *)a)->turn, y = ((const iso_chart_case *)b)->turn;
    return (x > y) - (x < y);
}

static bool is_other_program(iso_renderer r) { return r == ISO_WITH_CYCLES || r == ISO_WITH_POVRAY; }

/* Does the setting differ from the others of the grid? Level 0 has one filter and no adapted TF; on the fly needs neither
 * filter, estimator nor code; other programs get decoded directions and have a quadrature of their own. */
static bool is_distinct(const iso_chart_case *c, iso_code usual_code, iso_gradient_method first_estimator,
                        iso_direction_filter first_filter)
{
    const bool on_the_fly = c->source == ISO_FROM_ON_THE_FLY;
    if (is_other_program(c->renderer) && (c->source != ISO_FROM_CODES || c->code != usual_code || c->preintegrated))
        return false;
    if ((c->level == 0 || on_the_fly) && c->filter != first_filter)
        return false;
    if (on_the_fly && c->estimator != first_estimator)
        return false;
    if (c->level == 0 && c->adapted)
        return false;
    /* tables over two values: by the first filter and estimator alone, which say what they gain */
    if (c->table != ISO_SPLIT_NONE && (c->source != ISO_FROM_CODES || c->preintegrated || c->filter != first_filter ||
                                       c->estimator != first_estimator))
        return false;
    return c->source == ISO_FROM_CODES || c->code == usual_code;
}

/* Is the setting asked for, and does the pyramid hold what it needs? */
static bool is_wanted(const iso_chart_grid *g, const iso_pyramid *p, const iso_chart_case *c)
{
    const bool other_program = is_other_program(c->renderer);
    if (!g->with[c->renderer] || c->level >= p->level_count)
        return false;
    if (c->source == ISO_FROM_CODES && !g->codes[c->code] && !other_program)
        return false;
    if (!(c->preintegrated ? g->preintegrated : g->midpoint || other_program))
        return false;
    if (p->levels[c->level].directions)
        return true;
    return c->source != ISO_FROM_FLOAT && (c->source != ISO_FROM_CODES || c->code == p->options.code);
}

/* The i-th of all combinations, whether sensible or not. */
static iso_chart_case combination(const iso_chart_grid *g, size_t levels, size_t i)
{
    static const struct {
        iso_direction_source source;
        size_t palette;
    } sources[] = {{ISO_FROM_CODES, 0}, {ISO_FROM_FLOAT, 0}, {ISO_FROM_FLIPPED, 0}, {ISO_FROM_ON_THE_FLY, 0},
                 {ISO_FROM_PALETTE, 0}, {ISO_FROM_PALETTE, 1}};
    const size_t source_count = sizeof sources / sizeof *sources;
    iso_chart_case c = {.metrics = {.rmse = NAN}};
    c.step_voxels = g->steps[i % g->step_count], i /= g->step_count;
    c.preintegrated = i % 2, i /= 2;
    c.code = (iso_code)(i % ISO_CODE_COUNT), i /= ISO_CODE_COUNT;
    c.source = sources[i % source_count].source, c.palette = sources[i % source_count].palette;
    i /= source_count;
    c.filter = (iso_direction_filter)(i % ISO_DIRECTION_COUNT), i /= ISO_DIRECTION_COUNT;
    c.estimator = (iso_gradient_method)(i % ISO_GRADIENT_COUNT), i /= ISO_GRADIENT_COUNT;
    static const iso_joint_split tables[] = {ISO_SPLIT_NONE, ISO_SPLIT_NONE, ISO_SPLIT_DEVIATION, ISO_SPLIT_GRADIENT};
    c.adapted = i % 4 > 0, c.table = tables[i % 4], i /= 4;
    c.level = i % levels, i /= levels;
    c.renderer = i < ISO_RENDERER_COUNT ? (iso_renderer)i : ISO_RENDERER_COUNT; /* the count: no more */
    return c;
}

static void add_plans(const iso_chart_grid *g, const iso_level *level0, iso_chart_case *cases, size_t *count)
{
    for (size_t i = 0; i < g->plan_count && g->with[ISO_WITH_GL]; ++i)
        for (size_t k = 0; k < g->step_count; ++k) {
            iso_chart_case c = {.renderer = ISO_WITH_GL, .source = ISO_FROM_FLOAT, .table = ISO_SPLIT_NONE, .metrics = {.rmse = NAN}};
            c.plan_error = g->plans[i];
            c.step_voxels = g->steps[k];
            c.relative_cost = c.turn = relative_cost(level0, &c);
            cases[(*count)++] = c;
        }
}

iso_status iso_chart_grid_cases(const iso_chart_grid *g, iso_chart_pyramids pyramids, iso_gradient_method first_estimator,
                                iso_direction_filter first_filter, iso_chart_case **cases, size_t *count, iso_error *err)
{
    const iso_pyramid *first = &pyramids[first_estimator][first_filter];
    *cases = NULL;
    for (int pass = 0; pass < 2; ++pass) { /* counts, then fills */
        *count = 0;
        for (size_t i = 0;; ++i) {
            iso_chart_case c = combination(g, first->level_count, i);
            if (c.renderer == ISO_RENDERER_COUNT)
                break;
            const iso_pyramid *p = &pyramids[c.estimator][c.filter];
            if (!is_wanted(g, p, &c) || !is_distinct(&c, first->options.code, first_estimator, first_filter))
                continue;
            c.relative_cost = relative_cost(&p->levels[c.level], &c);
            c.turn = c.relative_cost * (c.code == first->options.code && c.source != ISO_FROM_PALETTE ? 1 : 8);
            c.bytes = level_bytes(&p->levels[c.level], &c);
            if (pass == 1)
                (*cases)[*count] = c;
            ++*count;
        }
        if (pass == 0)
            *cases = malloc((*count + (size_t)ISO_CHART_MAX_LIST * ISO_CHART_MAX_LIST) * sizeof **cases);
        if (!*cases)
            return iso_fail(err, ISO_E_MEMORY, "chart: no memory for %zu settings", *count);
    }
    add_plans(g, &first->levels[0], *cases, count);
    qsort(*cases, *count, sizeof **cases, by_turn);
    return ISO_OK;
}
