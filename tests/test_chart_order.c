/* SPDX-License-Identifier: MIT */
/* The order in which a chart tries its settings, under a clock and errors that are made up: a small budget has the
 * front, and a large one everything. */
#include <math.h>
#include <stdlib.h>

#include "chart/grid.h"
#include "chart/order.h"
#include "chart/pareto.h"
#include "tests/pyramids.h"

/* What a volume might give: a level has an error of its own, lower under its own transfer function, to which the step
 * adds by its square; a frame takes what the grid says. */
static double made_error(const void *user, const iso_chart_case *c)
{
    (void)user;
    const double level = (double)c->level, floor_error = c->level == 0 ? 1e-4 : 0.03 * level * (c->adapted ? 0.7 : 1);
    const double code = c->source == ISO_FROM_CODES || c->source == ISO_FROM_FLOAT ? 0 : 0.002;
    return hypot(floor_error + code, 0.005 * pow(2, level) * c->step_voxels * c->step_voxels);
}
static double made_seconds(const void *user, const iso_chart_case *c)
{
    (void)user;
    return 1e-3 * c->relative_cost;
}

typedef struct fake_clock {
    double now, end;
} fake_clock;

static bool fits(const void *user, const iso_chart_case *c)
{
    const fake_clock *clock = user;
    return clock->now + made_seconds(NULL, c) <= clock->end;
}

static bool always(const void *user, const iso_chart_case *c)
{
    (void)user;
    (void)c;
    return true;
}

static void take(iso_chart_case *c, fake_clock *clock)
{
    c->done = true;
    c->took.seconds = made_seconds(NULL, c);
    clock->now += c->took.seconds;
}

static size_t try_in_order(iso_chart_case *cases, size_t count, fake_clock *clock)
{
    const iso_chart_outlook outlook = {made_error, made_seconds, fits, clock};
    size_t tried = 0;
    for (size_t i; (i = iso_chart_next(cases, count, &outlook)) < count; ++tried)
        take(&cases[i], clock);
    return tried;
}

/* The planted fault: as they stand in the grid's list of combinations, by renderer and level. */
static void try_as_listed(iso_chart_case *cases, size_t count, fake_clock *clock)
{
    for (size_t level = 0; level < 3; ++level)
        for (size_t i = 0; i < count; ++i)
            if (cases[i].level == level && fits(clock, &cases[i]))
                take(&cases[i], clock);
}

/* Points of the front, equal ones once. */
static size_t count_front(const iso_chart_case *cases, size_t count)
{
    FREED double *cost = calloc(count, sizeof *cost), *error = calloc(count, sizeof *error);
    FREED bool *front = calloc(count, sizeof *front);
    size_t n = 0, found = 0;
    for (size_t i = 0; i < count; ++i)
        if (cases[i].done) {
            cost[n] = cases[i].took.seconds;
            error[n++] = made_error(NULL, &cases[i]);
        }
    iso_pareto_front(cost, error, n, front);
    for (size_t i = 0; i < n; ++i) {
        bool first = front[i]; /* of equal ones */
        for (size_t j = 0; j < i; ++j)
            first = first && !(cost[j] == cost[i] && error[j] == error[i]);
        found += first;
    }
    return found;
}

typedef struct grid {
    iso_chart_case *cases;
    size_t count;
} grid;

static grid make(size_t scenes)
{
    grid g = {.count = 0};
    iso_chart_grid axes;
    iso_chart_words words = ISO_CHART_DEFAULT_WORDS;
    words.with = "gl";
    OWNED(iso_pyramid) pyramid = {0};
    OWNED(iso_volume) v = noise(40, 30, 20);
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = 3;
    opt.keep_float = true;
    assert_ok(iso_chart_grid_parse(&words, &axes, &err));
    assert_ok(iso_pyramid_build(&v, "grid", &opt, &pyramid, NULL, &err));
    assert_ok(iso_chart_grid_cases(&axes, &pyramid, true, scenes, &g.cases, &g.count, &err));
    return g;
}

/* A budget of 40 of the grid's frames of 4000 finds at least 10 points of the front; those of the list do not. */
TEST(a_small_budget_has_the_front)
{
    grid g = make(1);
    double all = 0;
    for (size_t i = 0; i < g.count; ++i)
        all += made_seconds(NULL, &g.cases[i]);
    fake_clock clock = {0, all * 40 / (double)g.count};
    const size_t tried = try_in_order(g.cases, g.count, &clock);
    assert_true(tried > 20 && tried < 200);
    assert_true(count_front(g.cases, g.count) >= 10);
    for (size_t i = 0; i < g.count; ++i)
        g.cases[i].done = g.cases[i].put_off = false;
    clock = (fake_clock){0, clock.end};
    try_as_listed(g.cases, g.count, &clock);
    assert_true(count_front(g.cases, g.count) < 10);
    iso_chart_cases_free(g.cases, g.count);
}

/* Level 2 is at its floor from a step of a voxel on: its finer steps come after all that matters, but they do come. */
TEST(what_cannot_matter_comes_last_and_everything_comes_once)
{
    grid g = make(2);
    const iso_chart_outlook outlook = {made_error, made_seconds, always, NULL};
    fake_clock clock = {0, INFINITY};
    size_t tried = 0, put_off = 0, late = 0;
    double last_fine = 0;
    for (size_t i; (i = iso_chart_next(g.cases, g.count, &outlook)) < g.count; ++tried) {
        assert_false(g.cases[i].done);
        put_off += g.cases[i].put_off;
        late += put_off > 0 && !g.cases[i].put_off;
        if (g.cases[i].level == 2 && g.cases[i].turn == 0 && g.cases[i].step_voxels == 0.125)
            last_fine = (double)tried;
        take(&g.cases[i], &clock);
    }
    assert_int_equal(tried, g.count);
    assert_true(put_off > g.count / 4);
    assert_int_equal(late, 0);
    assert_true(last_fine > 0.5 * (double)g.count);
    iso_chart_cases_free(g.cases, g.count);
}

/* Each setting stands there for every scene, one after the other, so that no scene waits for another. */
TEST(scenes_take_turns)
{
    grid g = make(3);
    for (size_t i = 0; i < g.count; ++i) {
        assert_int_equal(g.cases[i].scene, i % 3);
        assert_int_equal(g.cases[i].setting, i / 3);
        assert_true(g.cases[i].step_voxels == g.cases[i - i % 3].step_voxels);
    }
    iso_chart_cases_free(g.cases, g.count);
}

TEST_MAIN(NULL, NULL)
