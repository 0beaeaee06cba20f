/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "lab/levels_report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lab/quartiles.h"
#include "compare/ssim.h"

enum { FIGURES = ISO_LEVEL_CASE_FIGURES, MOST_LEVELS = 16, WORST = 3 };

const char *iso_level_case_left_out(const iso_level_cases *c, const iso_level_case *one)
{
    double shown = 0, error = 0;
    for (size_t m = 0; m < iso_level_method_count(); ++m)
        for (int f = 0; f < FIGURES && c->wanted[m]; ++f) {
            shown = fmax(shown, one->results[m].alpha);
            error = fmax(error, iso_level_result_figure(&one->results[m], f));
        }
    if (!(one->finest_alpha >= ISO_SSIM_FOREGROUND))
        return "level 0 shows nothing";
    if (!(shown >= ISO_SSIM_FOREGROUND))
        return "the level shows nothing under any method";
    return error < ISO_LEVELS_NO_ERROR ? "no method has an error" : NULL;
}

double iso_level_ratio(double error, double base)
{
    const double none = 1e-6;
    return (error + none) / (base + none);
}

/* ---- a method at a level ---- */

typedef struct worst_case {
    const iso_level_case *of;
    double ratio;
} worst_case;

typedef struct summary {
    size_t count, worse, much_worse, near_best;
    iso_ratios ratios[FIGURES];
    worst_case worst[WORST]; /* sorted by falling DSSIM */
} summary;

static void note_worst(summary *s, worst_case one)
{
    for (int i = 0; i < WORST; ++i)
        if (!s->worst[i].of || one.ratio > s->worst[i].ratio) {
            const worst_case moved = s->worst[i];
            s->worst[i] = one;
            one = moved;
            if (!one.of)
                return;
        }
}

/* Returns the smallest DSSIM of all wanted methods. */
static double best_of(const iso_level_cases *c, const iso_level_case *one)
{
    double best = INFINITY;
    for (size_t m = 0; m < iso_level_method_count(); ++m)
        best = c->wanted[m] ? fmin(best, iso_level_result_figure(&one->results[m], 0)) : best;
    return best;
}

static summary summarize(const iso_level_cases *c, bool held, size_t level, size_t method)
{
    summary s = {0};
    FREED double *ratios = calloc(c->count + 1, sizeof *ratios);
    for (int f = 0; ratios && f < FIGURES; ++f) {
        size_t count = 0;
        for (size_t i = 0; i < c->count; ++i) {
            const iso_level_case *one = &c->cases[i];
            if (one->held != held || one->level != level || iso_level_case_left_out(c, one))
                continue;
            const double ratio = iso_level_ratio(iso_level_result_figure(&one->results[method], f),
                                                 iso_level_result_figure(&one->results[c->against], f));
            ratios[count++] = ratio;
            if (f > 0)
                continue;
            s.worse += ratio > ISO_LEVELS_WORSE;
            s.much_worse += ratio > ISO_LEVELS_MUCH_WORSE;
            s.near_best += iso_level_ratio(iso_level_result_figure(&one->results[method], 0), best_of(c, one)) <=
                           ISO_LEVELS_WORSE;
            note_worst(&s, (worst_case){one, ratio});
        }
        s.count = count;
        s.ratios[f] = iso_ratios_summarize(ratios, count);
    }
    return s;
}

static json_t *summary_to_json(const summary *s, const iso_level_method *m)
{
    json_t *o = json_pack("{s:s, s:f, s:f, s:i, s:i, s:i}", "method", m->name, "bytes_per_voxel", m->bytes,
                          "fetches", m->fetches, "worse_count", (int)s->worse, "much_worse_count", (int)s->much_worse,
                          "near_best_count", (int)s->near_best);
    json_t *ratios = json_object(), *worst = json_array();
    for (int f = 0; f < FIGURES; ++f)
        json_object_set_new(ratios, iso_level_figure_keys[f],
                            json_pack("{s:o, s:o, s:o, s:o}", "geometric_mean",
                                      iso_json_number(s->ratios[f].geometric_mean), "median",
                                      iso_json_number(s->ratios[f].median), "lower_quartile",
                                      iso_json_number(s->ratios[f].lower), "upper_quartile",
                                      iso_json_number(s->ratios[f].upper)));
    for (int i = 0; i < WORST && s->worst[i].of; ++i)
        json_array_append_new(worst, json_pack("{s:s, s:s, s:f}", "volume", s->worst[i].of->volume, "tf",
                                               s->worst[i].of->tf, "dssim_ratio", s->worst[i].ratio));
    json_object_set_new(o, "ratios", ratios);
    json_object_set_new(o, "worst", worst);
    return o;
}

static void print_summary(const summary *s, const iso_level_method *m)
{
    const iso_ratios *r = s->ratios;
    printf("%-20s %5.3f  %5.3f (%.3f-%.3f) %3zu %3zu %4zu  %5.3f %5.3f  %5.3f %5.3f %5.3f  %4g %3g ", m->name,
           r[0].geometric_mean, r[0].median, r[0].lower, r[0].upper, s->worse, s->much_worse, s->near_best,
           r[1].geometric_mean, r[2].geometric_mean, r[3].geometric_mean, r[4].geometric_mean, r[5].geometric_mean, m->bytes, m->fetches);
    for (int i = 0; i < WORST && s->worst[i].of && s->worst[i].ratio > ISO_LEVELS_WORSE; ++i)
        printf("%s %s %s %.2f", i ? "," : "", s->worst[i].of->volume, s->worst[i].of->tf, s->worst[i].ratio);
    printf("\n");
}

static void print_heading(const iso_level_cases *c, bool held, size_t level, size_t count)
{
    printf(
        "\n%s, level %zu: %zu cases; errors / those of \"%s\": geometric means; for DSSIM also median and quartiles"
        "\n%-20s %5s  %-20s %3s %3s %4s  %5s %5s  %17s  %4s %3s  worst by DSSIM\n%-20s %5s  %-20s %3s %3s %4s  %5s %5s  "
        "%5s %5s %5s\n",
        held ? "held back" : "named", level, count, iso_level_method_at(c->against)->name, "", "", "", ">2%", ">5%",
        "near", "", "", "minified", "B", "", "method", "DSSIM", "median", "", "", "best", "RMSE", "FLIP", "DSSIM",
        "RMSE", "FLIP");
}

/* ---- a block ---- */

static json_t *report_level(const iso_level_cases *c, bool held, size_t level, bool print)
{
    json_t *rows = json_array();
    const size_t count = summarize(c, held, level, c->against).count;
    if (print && count > 0)
        print_heading(c, held, level, count);
    for (size_t m = 0; m < iso_level_method_count() && count > 0; ++m) {
        if (!c->wanted[m])
            continue;
        const summary s = summarize(c, held, level, m);
        json_array_append_new(rows, summary_to_json(&s, iso_level_method_at(m)));
        if (print)
            print_summary(&s, iso_level_method_at(m));
    }
    return json_pack("{s:i, s:i, s:o}", "level", (int)level, "case_count", (int)count, "methods", rows);
}

/* ---- all levels ---- */

static bool is_same_pair(const iso_level_case *a, const iso_level_case *b)
{
    return a->held == b->held && strcmp(a->volume, b->volume) == 0 && strcmp(a->tf, b->tf) == 0;
}

/* Returns the mean logarithm of a method's DSSIM over the base's, over the levels of a volume and transfer function. */
static double mean_of_levels(const iso_level_cases *c, size_t first, size_t method, size_t *levels)
{
    const iso_level_case *own = &c->cases[first];
    double sum = 0;
    *levels = 0;
    for (size_t i = first; i < c->count; ++i) {
        const iso_level_case *one = &c->cases[i];
        if (!is_same_pair(own, one) || iso_level_case_left_out(c, one))
            continue;
        sum += log(iso_level_ratio(iso_level_result_figure(&one->results[method], 0), iso_level_result_figure(&one->results[c->against], 0)));
        ++*levels;
    }
    return *levels > 0 ? sum / (double)*levels : 0;
}

static bool is_first_of_pair(const iso_level_cases *c, size_t at)
{
    for (size_t i = 0; i < at; ++i)
        if (is_same_pair(&c->cases[i], &c->cases[at]))
            return false;
    return true;
}

iso_level_nearness iso_level_cases_nearness(const iso_level_cases *c, bool held, size_t method)
{
    iso_level_nearness n = {0};
    double loss = 0;
    for (size_t i = 0; i < c->count; ++i) {
        const iso_level_case *one = &c->cases[i];
        size_t levels;
        if (one->held != held || !is_first_of_pair(c, i))
            continue;
        const double own = mean_of_levels(c, i, method, &levels);
        if (levels == 0)
            continue;
        double best = own;
        for (size_t m = 0; m < iso_level_method_count(); ++m)
            best = c->wanted[m] ? fmin(best, mean_of_levels(c, i, m, &levels)) : best;
        n.pairs += 1;
        n.near_best += own <= best + log(ISO_LEVELS_WORSE);
        loss += own - best;
    }
    n.over_best = n.pairs > 0 ? exp(loss / (double)n.pairs) : 1;
    return n;
}

/* Reports how often each method is the best or near it. */
static json_t *report_nearness(const iso_level_cases *c, bool held, bool print)
{
    json_t *rows = json_array();
    if (print)
        printf("\n%s, all levels of a volume and TF together: methods within 2 %% of the best one, and DSSIM over the "
               "best one's\n",
               held ? "held back" : "named");
    for (size_t m = 0; m < iso_level_method_count(); ++m) {
        if (!c->wanted[m])
            continue;
        const iso_level_nearness n = iso_level_cases_nearness(c, held, m);
        const char *name = iso_level_method_at(m)->name;
        json_array_append_new(rows, json_pack("{s:s, s:i, s:i, s:f}", "method", name, "pair_count", (int)n.pairs,
                                              "near_best_count", (int)n.near_best, "over_best", n.over_best));
        if (print)
            printf("%-20s %3zu of %zu  %.3f\n", name, n.near_best, n.pairs, n.over_best);
    }
    return rows;
}

/* Counts the cases that each reason leaves out. */
static json_t *count_left_out(const iso_level_cases *c, bool held)
{
    json_t *reasons = json_object();
    for (size_t i = 0; i < c->count; ++i) {
        const char *why = iso_level_case_left_out(c, &c->cases[i]);
        if (c->cases[i].held == held && why)
            json_object_set_new(reasons, why, json_integer(json_integer_value(json_object_get(reasons, why)) + 1));
    }
    return reasons;
}

static bool has_level(const iso_level_cases *c, bool held, size_t level)
{
    for (size_t i = 0; i < c->count; ++i)
        if (c->cases[i].held == held && c->cases[i].level == level)
            return true;
    return false;
}

static json_t *report_block(const iso_level_cases *c, bool held, bool print)
{
    json_t *levels = json_array(), *reasons = count_left_out(c, held), *times;
    const char *why;
    for (size_t level = 1; level < MOST_LEVELS; ++level)
        if (has_level(c, held, level))
            json_array_append_new(levels, report_level(c, held, level, print));
    if (print)
        json_object_foreach(reasons, why, times) printf("left out, %s: %lld cases, %s\n", held ? "held back" : "named",
                                                        (long long)json_integer_value(times), why);
    return json_pack("{s:s, s:o, s:o, s:o}", "block", held ? "held back" : "named", "left_out", reasons, "levels",
                     levels, "all_levels", report_nearness(c, held, print));
}

json_t *iso_levels_report(const iso_level_cases *c, bool print)
{
    json_t *blocks = json_array();
    for (int held = 0; held < 2; ++held)
        for (size_t i = 0; i < c->count; ++i)
            if (c->cases[i].held == (held == 1)) {
                json_array_append_new(blocks, report_block(c, held == 1, print));
                break;
            }
    return blocks;
}

/* ---- cases ---- */

json_t *iso_level_cases_to_json(const iso_level_cases *c)
{
    json_t *all = json_array();
    for (size_t i = 0; i < c->count; ++i)
        for (size_t m = 0; m < iso_level_method_count(); ++m) {
            const iso_level_case *one = &c->cases[i];
            if (!c->wanted[m])
                continue;
            json_t *o = json_pack("{s:s, s:b, s:s, s:i, s:s, s:i, s:b, s:s?}", "volume", one->volume, "held", one->held,
                                  "tf", one->tf, "level", (int)one->level, "method", iso_level_method_at(m)->name,
                                  "box_pixels", (int)one->box, "kept_original", one->results[m].kept_original,
                                  "left_out", iso_level_case_left_out(c, one));
            for (int f = 0; f < FIGURES; ++f)
                json_object_set_new(o, iso_level_figure_keys[f], iso_json_number(iso_level_result_figure(&one->results[m], f)));
            json_array_append_new(all, o);
        }
    return all;
}
