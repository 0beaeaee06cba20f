/* SPDX-License-Identifier: MIT */
/* result_print.c - what a chart found, in lines for people. */
#include "chart/untried.h"

#include <stdio.h>
#include <stdlib.h>

static void print_chosen(const iso_chart_result *r, const char *what, size_t index)
{
    const iso_chart_case *c = &r->cases[index];
    char name[192];
    iso_chart_describe(c, name, sizeof name);
    char *command = iso_chart_command(r, c);
    printf("%s: %s (%.4g ms, %.0f bytes, %s %.3g)\n  %s\n", what, name, 1e3 * c->took.seconds,
           iso_chart_bytes_of(c, r->bytes), iso_chart_metric_name(r->metric), iso_chart_error(c, r->metric),
           command ? command : "");
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
    char *compare = iso_chart_compare_command(r);
    printf("its error again: %s\n", compare ? compare : "");
    free(compare);
}

static void print_skipped(const iso_chart_result *r)
{
    iso_chart_tags *untried;
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
    if (iso_chart_find_untried(r, &untried) == ISO_OK && untried->count > 0) {
        printf("; not one of: ");
        for (size_t i = 0; i < untried->count; ++i)
            printf("%s%s", i ? ", " : "", untried->tags[i]);
    }
    iso_chart_free_untried(untried);
    putchar('\n');
}

void iso_chart_result_print(const iso_chart_result *r)
{
    size_t most = 0, unnamed = 0;
    for (size_t i = 0; i < r->done_count; ++i) {
        most = r->cases[i].number > most ? r->cases[i].number : most;
        unnamed += r->cases[i].number == 0 && (r->cases[i].on_time_front || r->cases[i].on_bytes_front);
    }
    printf("on the front of time (t) or bytes (b)%-36s %9s %9s %12s %9s %9s\n", "", "ms", "median", "bytes", "rmse",
           "flip_mean");
    for (size_t k = 1; k <= most; ++k)
        for (size_t i = 0; i < r->done_count; ++i) {
            const iso_chart_case *c = &r->cases[i];
            char name[192];
            if (c->number != k)
                continue;
            iso_chart_describe(c, name, sizeof name);
            printf("%3zu %s%s %-66s %9.4g %9.4g %12.0f %9.3g %9.3g\n", k, c->on_time_front ? "t" : " ",
                   c->on_bytes_front ? "b" : " ", name, 1e3 * c->took.seconds, 1e3 * c->took.median_seconds,
                   iso_chart_bytes_of(c, r->bytes), c->metrics.rmse, c->metrics.flip_mean);
        }
    if (unnamed > 0)
        printf("and %zu that lower the error by less than %.0f %%: on_time_front and on_bytes_front in chart.json\n",
               unnamed, 100 * (1 - ISO_CHART_NAMED_PART));
    print_skipped(r);
    if (r->want > 0)
        print_want(r);
    printf("chart: %s/pareto.svg, %.3g s\n", r->output, r->spent_seconds);
}
