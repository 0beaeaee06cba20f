/* SPDX-License-Identifier: MIT */
/* The grid of a chart: what it holds, what it leaves out, and in which order a budget meets it. */
#include <stdlib.h>
#include <string.h>

#include "chart/grid.h"
#include "tests/pyramids.h"

typedef struct grid {
    iso_chart_grid axes;
    iso_pyramid pyramid;
    iso_chart_case *cases;
    size_t count;
} grid;

/* with: renderers, or NULL. */
static grid make(const char *with, bool is_volume)
{
    iso_chart_words words = ISO_CHART_DEFAULT_WORDS;
    words.with = with;
    grid g = {.count = 0};
    OWNED(iso_volume) v = noise(12, 10, 9);
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = 2;
    opt.keep_float = is_volume;
    assert_ok(iso_chart_grid_parse(&words, &g.axes, &err));
    assert_ok(iso_pyramid_build(&v, "grid", &opt, &g.pyramid, NULL, &err));
    assert_ok(iso_chart_grid_cases(&g.axes, &g.pyramid, is_volume, 1, &g.cases, &g.count, &err));
    return g;
}

static void release(grid *g)
{
    iso_chart_cases_free(g->cases, g->count);
    iso_pyramid_destroy(&g->pyramid);
}

/* Does the order hold what the header promises? 0: yes. */
static size_t count_out_of_order(const iso_chart_case *cases, size_t count)
{
    size_t wrong = 0;
    for (size_t i = 1; i < count; ++i) {
        const iso_chart_case *a = &cases[i - 1], *b = &cases[i];
        wrong += a->turn > b->turn;
        wrong += a->turn == b->turn && a->needs_pyramid == b->needs_pyramid &&
                 a->estimator == b->estimator && a->filter == b->filter &&
                 iso_renderer_has(a->renderer, ISO_IS_PROGRAM) == iso_renderer_has(b->renderer, ISO_IS_PROGRAM) &&
                 a->relative_cost > b->relative_cost;
    }
    return wrong;
}

TEST(usual_settings_come_first_and_cheap_ones_before_others)
{
    grid g = make(NULL, true);
    const size_t usual = g.pyramid.level_count * 5; /* the steps that are powers of two and at most 2 */
    for (size_t i = 0; i < g.count; ++i) {
        assert_int_equal(g.cases[i].turn == 0, i < usual);
        assert_true(g.cases[i].turn > 0 || g.cases[i].departures == 0);
    }
    assert_int_equal(count_out_of_order(g.cases, g.count), 0);
    /* planted fault: two settings of different costs exchanged */
    iso_chart_case first = g.cases[0];
    g.cases[0] = g.cases[usual - 1];
    g.cases[usual - 1] = first;
    assert_true(count_out_of_order(g.cases, g.count) > 0);
    release(&g);
}

static int by_name(const void *a, const void *b)
{
    return strcmp(a, b);
}

TEST(every_axis_has_each_of_its_values_and_no_setting_comes_twice)
{
    grid g = make("gl,reference,povray,cycles", true);
    size_t renderers = 0, sources = 0, transfer_functions = 0, filters = 0, estimators = 0, codes = 0, plans = 0,
           preintegrated = 0;
    char(*names)[192] = malloc(g.count * sizeof *names);
    assert_non_null(names);
    for (size_t i = 0; i < g.count; ++i) {
        const iso_chart_case *c = &g.cases[i];
        renderers |= 1u << iso_renderer_index(c->renderer);
        sources |= 1u << c->source;
        transfer_functions |= 1u << (c->second + (c->adapted ? 0 : 8));
        filters |= 1u << c->filter;
        estimators |= 1u << c->estimator;
        codes |= c->source == ISO_FROM_CODES ? 1u << c->code : 0;
        plans += c->plan_error > 0;
        preintegrated += c->preintegrated;
        iso_chart_describe(c, names[i], sizeof *names);
    }
    qsort(names, g.count, sizeof *names, by_name);
    for (size_t i = 1; i < g.count; ++i)
        assert_string_not_equal(names[i - 1], names[i]);
    free(names);
    assert_int_equal(__builtin_popcountl(renderers), 4);
    assert_int_equal(sources, 1u << ISO_FROM_CODES | 1u << ISO_FROM_FLOAT | 1u << ISO_FROM_FLIPPED |
                                  1u << ISO_FROM_ON_THE_FLY | 1u << ISO_FROM_PALETTE);
    assert_int_equal(transfer_functions, 1u << (ISO_SECOND_VALUE_NONE + 8) | 1u << ISO_SECOND_VALUE_NONE |
                                             1u << ISO_SECOND_VALUE_DEVIATION | 1u << ISO_SECOND_VALUE_GRADIENT);
    assert_int_equal(__builtin_popcountl(filters), 3);
    assert_int_equal(__builtin_popcountl(estimators), 2);
    for (int c = 0; c < ISO_CODE_COUNT; ++c) /* all that a texture filters are in the default */
        assert_int_equal((codes >> c) & 1u, iso_code_describe((iso_code)c)->is_textured);
    assert_int_equal(plans, g.axes.plan_count * g.axes.step_count);
    assert_true(preintegrated > 0);
    release(&g);
}

TEST(a_pyramid_on_disk_is_what_it_is)
{
    grid g = make("gl", false);
    for (size_t i = 0; i < g.count; ++i) {
        const iso_chart_case *c = &g.cases[i];
        assert_int_equal(c->filter, g.pyramid.options.direction_filter);
        assert_int_equal(c->estimator, g.pyramid.options.gradient.method);
        assert_true(c->plan_error > 0 || c->source != ISO_FROM_FLOAT);
        assert_int_equal(c->code, g.pyramid.options.code);
    }
    assert_true(g.count > 0);
    release(&g);
}

TEST(other_programs_alone_are_equals)
{
    grid g = make("povray,cycles", true);
    for (size_t i = 0; i < g.count; ++i)
        assert_int_equal(g.cases[i].turn == 0, i < (size_t)2 * g.pyramid.level_count * 5);
    release(&g);
}

TEST_MAIN(NULL, NULL)
