/* SPDX-License-Identifier: MIT */
#include "chart/result.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/names.h"
#include "chart/pareto.h"

static const struct {
    const char *name, *summary;
} metrics[] = {{"rmse", "RMSE"}, {"flip", "mean FLIP"}, {"ssim", "1 - SSIM"}};
static const iso_names metric_names = ISO_NAMES_OF_ROWS("--metric", metrics);

const char *iso_chart_metric_name(iso_chart_metric m)
{
    return metrics[m].name;
}
const char *iso_chart_metric_title(iso_chart_metric m)
{
    return metrics[m].summary;
}

iso_status iso_chart_metric_from_name(const char *name, iso_chart_metric *m, iso_error *err)
{
    size_t row = 0;
    const iso_status status = iso_names_find(&metric_names, name, &row, err);
    if (status == ISO_OK)
        *m = (iso_chart_metric)row;
    return status;
}

double iso_chart_error(const iso_chart_case *c, iso_chart_metric m)
{
    return m == ISO_CHART_FLIP ? c->metrics.flip_mean : m == ISO_CHART_SSIM ? 1 - c->metrics.ssim : c->metrics.rmse;
}

double iso_chart_bytes_of(const iso_chart_case *c, iso_chart_bytes b)
{
    return b == ISO_CHART_STORED ? c->stored_bytes : c->took.bytes;
}

const char *iso_chart_bytes_kind(const iso_chart_result *r)
{
    return r->bytes == ISO_CHART_STORED ? "stored" : "device";
}
const char *iso_chart_time_kind(const iso_chart_result *r)
{
    return r->bench->processor_time ? "processor" : "clock";
}

static int by_falling_error(const void *a, const void *b)
{
    const double *x = a, *y = b; /* error, index */
    return x[0] != y[0] ? (x[0] < y[0]) - (x[0] > y[0]) : (x[1] > y[1]) - (x[1] < y[1]);
}

/* keys: two numbers a setting. The smallest with the wanted error is the fastest of its bytes, and so may stand above the
 * front, on which the most exact of its bytes is. Numbers those that are named on either front from 1, by falling error. */
static void number_fronts(iso_chart_result *r, const double *error, double *keys)
{
    size_t count = 0, number = 0;
    for (size_t i = 0; i < r->done_count; ++i)
        if (r->cases[i].on_time_front || r->cases[i].on_bytes_front || i == r->smallest) {
            keys[2 * count] = error[i];
            keys[2 * count++ + 1] = (double)i;
        }
    qsort(keys, count, 2 * sizeof *keys, by_falling_error);
    double last[2] = {INFINITY, INFINITY};
    for (size_t k = 0; k < count; ++k) {
        const size_t i = (size_t)keys[2 * k + 1];
        iso_chart_case *c = &r->cases[i];
        const bool on[2] = {c->on_time_front, c->on_bytes_front};
        bool named = i == r->fastest || i == r->smallest;
        for (int f = 0; f < 2; ++f)
            named = named || (on[f] && !(error[i] > ISO_CHART_NAMED_PART * last[f]));
        c->number = named ? ++number : 0;
        for (int f = 0; f < 2 && named; ++f)
            last[f] = on[f] ? error[i] : last[f];
    }
}

/* Plans for several errors may come out as one: of equal bytes and errors the fastest is enough. */
static void drop_ties(iso_chart_result *r, const double *bytes, const double *error, const double *seconds)
{
    for (size_t i = 0; i < r->done_count; ++i)
        for (size_t j = 0; j < r->done_count && r->cases[i].on_bytes_front; ++j)
            if (j != i && r->cases[j].on_bytes_front && bytes[j] == bytes[i] && error[j] == error[i] &&
                (seconds[j] < seconds[i] || (seconds[j] == seconds[i] && j < i)))
                r->cases[i].on_bytes_front = false;
}

/* Keeps the order among those that are done, and among the others. */
static iso_status move_done_first(iso_chart_result *r, iso_error *err)
{
    iso_chart_case *skipped = malloc((r->count + 1) * sizeof *skipped);
    size_t done = 0, left = 0;
    if (!skipped)
        return iso_fail(err, ISO_E_MEMORY, "chart: no memory for %zu settings", r->count);
    for (size_t i = 0; i < r->count; ++i) {
        if (r->cases[i].done)
            r->cases[done++] = r->cases[i];
        else
            skipped[left++] = r->cases[i];
    }
    memcpy(r->cases + done, skipped, left * sizeof *skipped);
    r->done_count = done;
    free(skipped);
    return ISO_OK;
}

iso_status iso_chart_result_sort(iso_chart_result *r, iso_error *err)
{
    iso_status status = move_done_first(r, err);
    const size_t n = r->done_count;
    double *seconds = calloc(5 * n + 1, sizeof *seconds), *bytes = seconds + n, *error = bytes + n, *keys = error + n;
    bool *front = calloc(n + 1, sizeof *front);
    if (status == ISO_OK && (!seconds || !front))
        status = iso_fail(err, ISO_E_MEMORY, "chart: no memory for %zu settings", n);
    r->fastest = r->smallest = r->best = n;
    if (status == ISO_OK) {
        for (size_t i = 0; i < n; ++i) {
            seconds[i] = r->cases[i].took.seconds;
            bytes[i] = iso_chart_bytes_of(&r->cases[i], r->bytes);
            error[i] = iso_chart_error(&r->cases[i], r->metric);
        }
        iso_pareto_front(seconds, error, n, front);
        for (size_t i = 0; i < n; ++i)
            r->cases[i].on_time_front = front[i];
        iso_pareto_front(bytes, error, n, front);
        for (size_t i = 0; i < n; ++i)
            r->cases[i].on_bytes_front = front[i];
        drop_ties(r, bytes, error, seconds);
        if (r->want > 0) {
            r->fastest = iso_pareto_choose(seconds, error, error, n, r->want);
            r->smallest = iso_pareto_choose(bytes, seconds, error, n, r->want);
        }
        r->best = iso_pareto_choose(error, seconds, error, n, INFINITY);
        number_fronts(r, error, keys);
    }
    free(seconds);
    free(front);
    return status;
}
