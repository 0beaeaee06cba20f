/* SPDX-License-Identifier: MIT */
#include "chart/result.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/names.h"
#include "base/provenance.h"
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
    NEED(iso_names_find(&metric_names, name, &row, err));
    *m = (iso_chart_metric)row;
    return ISO_OK;
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

const char *iso_chart_scene_title(const iso_chart_result *r, size_t scene)
{
    const char *path = r->bench->scenes[scene].path;
    return path ? iso_provenance_name(path) : "first picture";
}

/* ---- all scenes together ---- */

static double error_of(const iso_chart_result *r, const iso_chart_case *c)
{
    return iso_chart_error(c, r->metric);
}
static double seconds_of(const iso_chart_result *r, const iso_chart_case *c)
{
    (void)r;
    return c->took.seconds;
}
static double bytes_of(const iso_chart_result *r, const iso_chart_case *c)
{
    return iso_chart_bytes_of(c, r->bytes);
}

/* Returns the largest value over all scenes. Measured cases come first, in the order of the grid: the scenes of a
 * setting are neighbors. */
static double worst(const iso_chart_result *r, const iso_chart_case *c,
                    double (*of)(const iso_chart_result *, const iso_chart_case *))
{
    double most = 0;
    size_t found = 0;
    for (const iso_chart_case *o = r->cases; o < r->cases + r->count && found < r->bench->scene_count; ++o)
        if (o->done && o->setting == c->setting) {
            const double value = of(r, o);
            most = isfinite(value) ? fmax(most, value) : NAN;
            ++found;
            if (isnan(most))
                break;
        }
    return found == r->bench->scene_count ? most : NAN;
}

double iso_chart_worst_error(const iso_chart_result *r, const iso_chart_case *c)
{
    return worst(r, c, error_of);
}
double iso_chart_worst_seconds(const iso_chart_result *r, const iso_chart_case *c)
{
    return worst(r, c, seconds_of);
}

/* ---- fronts ---- */

/* Numbers the named settings of a scene on either front, by falling error, from number + 1. keys: two per setting. The
 * smallest setting within the wanted error is named too: it is the fastest of its size, so it may lie above the
 * front. */
static size_t number_fronts(iso_chart_result *r, size_t scene, size_t number, double *keys)
{
    size_t count = 0;
    for (size_t i = 0; i < r->done_count; ++i) {
        const iso_chart_case *c = &r->cases[i];
        if (c->scene == scene && (c->on_time_front || c->on_bytes_front || i == r->smallest)) {
            keys[2 * count] = error_of(r, c);
            keys[2 * count++ + 1] = (double)i;
        }
    }
    qsort(keys, count, 2 * sizeof *keys, by_falling_error);
    double last[2] = {INFINITY, INFINITY};
    for (size_t k = 0; k < count; ++k) {
        const size_t i = (size_t)keys[2 * k + 1];
        const double error = keys[2 * k];
        iso_chart_case *c = &r->cases[i];
        const bool on[2] = {c->on_time_front, c->on_bytes_front};
        bool named = i == r->fastest || i == r->smallest;
        for (int f = 0; f < 2; ++f)
            named = named || (on[f] && !(error > ISO_CHART_NAMED_PART * last[f]));
        c->number = named ? ++number : 0;
        for (int f = 0; f < 2 && named; ++f)
            last[f] = on[f] ? error : last[f];
    }
    return number;
}

/* Drops all but the fastest of equal bytes and errors: plans for several errors may be identical. */
static void drop_ties(iso_chart_result *r)
{
    for (size_t i = 0; i < r->done_count; ++i)
        for (size_t j = 0; j < r->done_count && r->cases[i].on_bytes_front; ++j) {
            const iso_chart_case *a = &r->cases[i], *b = &r->cases[j];
            if (j != i && b->on_bytes_front && b->scene == a->scene && bytes_of(r, b) == bytes_of(r, a) &&
                error_of(r, b) == error_of(r, a) &&
                (b->took.seconds < a->took.seconds || (b->took.seconds == a->took.seconds && j < i)))
                r->cases[i].on_bytes_front = false;
        }
}

/* Scratch arrays for all settings. */
typedef struct front_arrays {
    double *cost, *error, *keys;
    bool *front;
    size_t *at; /* index of the case */
} front_arrays;

typedef struct front_of {
    size_t scene;
    const iso_renderer_info *renderer; /* NULL: all */
    double (*cost)(const iso_chart_result *, const iso_chart_case *);
    size_t flag; /* offsetof a bool of iso_chart_case */
} front_of;

static void mark_front(iso_chart_result *r, const front_of *f, front_arrays *a)
{
    size_t n = 0;
    for (size_t i = 0; i < r->done_count; ++i) {
        const iso_chart_case *c = &r->cases[i];
        if (c->scene != f->scene || (f->renderer && c->renderer != f->renderer))
            continue;
        a->cost[n] = f->cost(r, c);
        a->error[n] = error_of(r, c);
        a->at[n++] = i;
    }
    iso_pareto_front(a->cost, a->error, n, a->front);
    for (size_t i = 0; i < n; ++i)
        *(bool *)((char *)&r->cases[a->at[i]] + f->flag) = a->front[i];
}

static void mark_fronts(iso_chart_result *r, front_arrays *a)
{
    for (size_t scene = 0; scene < r->bench->scene_count; ++scene) {
        mark_front(r, &(front_of){scene, NULL, seconds_of, offsetof(iso_chart_case, on_time_front)}, a);
        mark_front(r, &(front_of){scene, NULL, bytes_of, offsetof(iso_chart_case, on_bytes_front)}, a);
        for (size_t i = 0; i < iso_renderer_count(); ++i) {
            const iso_renderer_info *renderer = iso_renderer_at(i);
            mark_front(r, &(front_of){scene, renderer, seconds_of, offsetof(iso_chart_case, on_renderer_time_front)}, a);
            mark_front(r, &(front_of){scene, renderer, bytes_of, offsetof(iso_chart_case, on_renderer_bytes_front)}, a);
        }
    }
    drop_ties(r);
}

/* Chooses by the worst scene of each setting; its case of the first scene represents it. */
static void choose(iso_chart_result *r, front_arrays *a)
{
    double *const seconds = a->keys, *const bytes = a->cost;
    for (size_t i = 0; i < r->done_count; ++i) {
        const iso_chart_case *c = &r->cases[i];
        a->error[i] = c->scene == 0 ? worst(r, c, error_of) : NAN;
        seconds[i] = c->scene == 0 ? worst(r, c, seconds_of) : NAN;
        bytes[i] = c->scene == 0 ? worst(r, c, bytes_of) : NAN;
    }
    if (r->want > 0) {
        r->fastest = iso_pareto_choose(seconds, a->error, a->error, r->done_count, r->want);
        r->smallest = iso_pareto_choose(bytes, seconds, a->error, r->done_count, r->want);
    }
    r->best = iso_pareto_choose(a->error, seconds, a->error, r->done_count, INFINITY);
}

/* Moves measured settings to the front; keeps the order within both groups. */
static iso_status move_done_first(iso_chart_result *r, iso_error *err)
{
    FREED iso_chart_case *skipped = malloc((r->count + 1) * sizeof *skipped);
    size_t done = 0, left = 0;
    NEED_MEMORY(skipped, err, "chart: no memory for %zu settings", r->count);
    for (size_t i = 0; i < r->count; ++i)
        if (r->cases[i].done)
            r->cases[done++] = r->cases[i];
        else
            skipped[left++] = r->cases[i];
    memcpy(r->cases + done, skipped, left * sizeof *skipped);
    r->done_count = done;
    return ISO_OK;
}

iso_status iso_chart_result_sort(iso_chart_result *r, iso_error *err)
{
    iso_status status = move_done_first(r, err);
    const size_t n = r->done_count;
    front_arrays a = {calloc(n + 1, sizeof *a.cost), calloc(n + 1, sizeof *a.error), calloc(2 * n + 1, sizeof *a.keys),
                      calloc(n + 1, sizeof *a.front), calloc(n + 1, sizeof *a.at)};
    if (status == ISO_OK && (!a.cost || !a.error || !a.keys || !a.front || !a.at))
        status = iso_fail(err, ISO_E_MEMORY, "chart: no memory for %zu settings", n);
    r->fastest = r->smallest = r->best = n;
    if (status == ISO_OK) {
        mark_fronts(r, &a);
        choose(r, &a);
        size_t number = 0;
        for (size_t scene = 0; scene < r->bench->scene_count; ++scene)
            number = number_fronts(r, scene, number, a.keys);
    }
    free(a.cost);
    free(a.error);
    free(a.keys);
    free(a.front);
    free(a.at);
    return status;
}
