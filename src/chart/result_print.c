/* SPDX-License-Identifier: MIT */
/* result_print.c - the result of a chart as lines of text. */
#include "chart/result.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Prints the figures of the worst scene, and one command per scene. */
static void print_chosen(const iso_chart_result *r, const char *what, size_t index)
{
    const iso_chart_case *c = &r->cases[index];
    char name[192];
    iso_chart_describe(c, name, sizeof name);
    printf("%s: %s (%.4g ms, %.0f bytes, %s %.3g)\n", what, name, 1e3 * iso_chart_worst_seconds(r, c),
           iso_chart_bytes_of(c, r->bytes), iso_chart_metric_name(r->metric), iso_chart_worst_error(r, c));
    for (size_t i = 0; i < r->done_count; ++i) {
        if (r->cases[i].setting != c->setting)
            continue;
        FREED char *command = iso_chart_command(r, &r->cases[i]);
        printf("  %s\n", command ? command : "");
    }
}

static void print_want(const iso_chart_result *r)
{
    char what[128];
    const char *metric = iso_chart_metric_name(r->metric), *where = r->bench->scene_count > 1 ? " in each scene" : "";
    if (r->fastest < r->done_count) {
        snprintf(what, sizeof what, "fastest with %s <= %.4g%s", metric, r->want, where);
        print_chosen(r, what, r->fastest);
        snprintf(what, sizeof what, "smallest with %s <= %.4g%s", metric, r->want, where);
        print_chosen(r, what, r->smallest);
    } else if (r->best < r->done_count) {
        snprintf(what, sizeof what, "none has %s <= %.4g%s; the nearest", metric, r->want, where);
        print_chosen(r, what, r->best);
    }
    for (size_t i = 0; i < r->bench->scene_count; ++i) {
        FREED char *compare = iso_chart_compare_command(r, i);
        printf("to check its error: %s\n", compare ? compare : "");
    }
}

static void print_skipped(const iso_chart_result *r)
{
    json_auto_t *untried = iso_chart_untried(r);
    const char *value, *before = "; none measured with: ";
    json_t *unused;
    const size_t skipped = r->count - r->done_count - r->refused_count;
    if (r->bench->scene_count > 1 && skipped > 0)
        printf("settings are counted once for each of the %zu scenes\n", r->bench->scene_count);
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
    json_object_foreach (untried, value, unused) {
        printf("%s%s", before, value);
        before = ", ";
    }
    putchar('\n');
}

static void print_named(const iso_chart_result *r, const iso_chart_case *c)
{
    char name[192], flip[16] = "-", built[32] = "";
    iso_chart_describe(c, name, sizeof name);
    if (isfinite(c->metrics.flip_mean))
        snprintf(flip, sizeof flip, "%.3g", c->metrics.flip_mean);
    if (c->build_seconds > 0)
        snprintf(built, sizeof built, "  built in %.3g s", c->build_seconds);
    printf("%3zu %s%s %-66s %9.4g %9.4g %12.0f %9.3g %9s%s\n", c->number, c->on_time_front ? "t" : " ",
           c->on_bytes_front ? "b" : " ", name, 1e3 * c->took.seconds, 1e3 * c->took.median_seconds,
           iso_chart_bytes_of(c, r->bytes), c->metrics.rmse, flip, built);
}

static void print_fronts(const iso_chart_result *r, size_t scene)
{
    size_t most = 0;
    for (size_t i = 0; i < r->done_count; ++i)
        most = r->cases[i].number > most ? r->cases[i].number : most;
    for (size_t k = 1; k <= most; ++k)
        for (size_t i = 0; i < r->done_count; ++i)
            if (r->cases[i].number == k && r->cases[i].scene == scene)
                print_named(r, &r->cases[i]);
}

/* Prints the number of settings of each renderer, and of those on its own fronts; nothing if there is one renderer. */
static void print_renderers(const iso_chart_result *r)
{
    size_t tried[ISO_MAX_RENDERERS] = {0}, time[ISO_MAX_RENDERERS] = {0}, bytes[ISO_MAX_RENDERERS] = {0}, count = 0;
    for (size_t i = 0; i < r->done_count; ++i) {
        const iso_chart_case *c = &r->cases[i];
        const size_t k = iso_renderer_index(c->renderer);
        count += tried[k]++ == 0;
        time[k] += c->on_renderer_time_front;
        bytes[k] += c->on_renderer_bytes_front;
    }
    for (size_t k = 0; k < iso_renderer_count() && count > 1; ++k)
        if (tried[k] > 0)
            printf("%s alone: %zu settings, %zu on its time front, %zu on its bytes front\n", iso_renderer_at(k)->name,
                   tried[k], time[k], bytes[k]);
}

void iso_chart_result_print(const iso_chart_result *r)
{
    size_t unnamed = 0;
    for (size_t i = 0; i < r->done_count; ++i)
        unnamed += r->cases[i].number == 0 && (r->cases[i].on_time_front || r->cases[i].on_bytes_front);
    printf("on the time (t) or bytes (b) front%-39s %9s %9s %12s %9s %9s\n", "", "ms", "median", "bytes", "rmse",
           "flip_mean");
    for (size_t scene = 0; scene < r->bench->scene_count; ++scene) {
        if (r->bench->scene_count > 1)
            printf("scene %s\n", r->bench->scenes[scene].name);
        print_fronts(r, scene);
    }
    if (unnamed > 0)
        printf("%zu more improve the error by less than %.0f %%: see on_time_front and on_bytes_front in chart.json\n",
               unnamed, 100 * (1 - ISO_CHART_NAMED_PART));
    print_renderers(r);
    if (r->kept_count > 0)
        printf("%zu settings were measured in an earlier run\n", r->kept_count);
    print_skipped(r);
    if (r->want > 0)
        print_want(r);
    printf("chart: %s/pareto.svg, %s/index.html, %.3g s\n", r->output, r->output, r->spent_seconds);
}
