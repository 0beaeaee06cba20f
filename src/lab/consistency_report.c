/* SPDX-License-Identifier: MIT */
#include "lab/consistency_report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lab/quartiles.h"

enum { METRICS = 3 };
static const struct {
    const char *key, *ratio;
} metrics[METRICS] = {{"ssim_dissimilarity", "ssim_ratio"}, {"flip_mean", "flip_ratio"}, {"rmse", "rmse_ratio"}};

static const char *text_of(const json_t *c, const char *key)
{
    const char *s = json_string_value(json_object_get(c, key));
    return s ? s : "";
}

static double number_of(const json_t *c, const char *key)
{
    return json_number_value(json_object_get(c, key));
}

/* Cases of a renderer: those held back, or all others. */
typedef struct block {
    const json_t *cases;
    const char *renderer;
    bool held;
} block;

static bool is_in(const block *b, const json_t *c)
{
    return strcmp(text_of(c, "renderer"), b->renderer) == 0 && json_is_true(json_object_get(c, "held")) == b->held;
}

static bool is_original(const json_t *c)
{
    return strcmp(text_of(c, "method"), "original") == 0;
}

typedef struct summary {
    size_t case_count;
    iso_ratios ratios[METRICS];
    size_t worse;
    double worst; /* the largest 1 - SSIM above the original's */
} summary;

/* Summarizes a method at a level (0: all levels). */
static summary summarize(const block *b, const char *method, json_int_t level)
{
    const double floor_error = 1e-6; /* two perfect methods have a ratio of 1 */
    const size_t most = json_array_size(b->cases);
    double *ratios[METRICS] = {NULL};
    const json_t *original = NULL;
    json_t *c;
    size_t i, count = 0;
    summary s = {0};
    for (int k = 0; k < METRICS; ++k)
        ratios[k] = calloc(most + 1, sizeof **ratios);
    json_array_foreach (b->cases, i, c) {
        original = is_original(c) ? c : original;
        if (!is_in(b, c) || strcmp(text_of(c, "method"), method) != 0 || text_of(c, "left_out")[0] ||
            (level > 0 && json_integer_value(json_object_get(c, "level")) != level))
            continue;
        for (int k = 0; k < METRICS && ratios[k]; ++k)
            ratios[k][count] = (number_of(c, metrics[k].key) + floor_error) /
                               (number_of(original, metrics[k].key) + floor_error);
        ++count;
        const double above = number_of(c, metrics[0].key) - number_of(original, metrics[0].key);
        s.worse += above > ISO_CONSISTENCY_WORSE;
        s.worst = fmax(s.worst, above);
    }
    s.case_count = count;
    for (int k = 0; k < METRICS; ++k) {
        s.ratios[k] = iso_ratios_summarize(ratios[k], ratios[k] ? count : 0);
        free(ratios[k]);
    }
    return s;
}

static json_t *summary_to_json(const summary *s, const char *method, json_int_t level)
{
    json_t *o = json_pack("{s:I, s:s}", "level", level, "method", method);
    for (int k = 0; k < METRICS; ++k) {
        char key[64];
        const iso_ratios *r = &s->ratios[k];
        json_object_set_new(o, metrics[k].ratio, iso_json_number(r->geometric_mean));
        snprintf(key, sizeof key, "%s_median", metrics[k].ratio);
        json_object_set_new(o, key, iso_json_number(r->median));
        snprintf(key, sizeof key, "%s_lower_quartile", metrics[k].ratio);
        json_object_set_new(o, key, iso_json_number(r->lower));
        snprintf(key, sizeof key, "%s_upper_quartile", metrics[k].ratio);
        json_object_set_new(o, key, iso_json_number(r->upper));
    }
    return o;
}

static void print_summary(const summary *s, const char *method, json_int_t level)
{
    char name[64];
    snprintf(name, sizeof name, level > 0 ? "  level %lld %s" : "%.0lld%s", (long long)level, method);
    printf("%-26s %8.3f %8.3f %8.3f ", name, s->ratios[0].geometric_mean, s->ratios[1].geometric_mean,
           s->ratios[2].geometric_mean);
    for (int k = 0; k < METRICS; ++k)
        printf("  %.3f (%.3f-%.3f)", s->ratios[k].median, s->ratios[k].lower, s->ratios[k].upper);
    if (level == 0)
        printf("   %zu worse, worst %.4f", s->worse, s->worst);
    printf("\n");
}

/* Lists the methods in order, each once. */
static json_t *methods_of(const block *b)
{
    json_t *names = json_object(), *c;
    size_t i;
    json_array_foreach (b->cases, i, c)
        if (is_in(b, c))
            json_object_set_new(names, text_of(c, "method"), json_true());
    return names;
}

/* Counts the cases left out, by reason. */
static json_t *left_out_of(const block *b, size_t *count)
{
    json_t *reasons = json_object(), *c;
    size_t i;
    *count = 0;
    json_array_foreach (b->cases, i, c) {
        const char *why = text_of(c, "left_out");
        if (!is_in(b, c) || !is_original(c) || !why[0])
            continue;
        json_object_set_new(reasons, why, json_integer(json_integer_value(json_object_get(reasons, why)) + 1));
        ++*count;
    }
    return reasons;
}

static json_t *report_block(const block *b, bool print)
{
    size_t left_out;
    const char *name = b->held ? "held back" : "given volumes", *method, *why;
    json_t *reasons = left_out_of(b, &left_out), *means = json_array(), *behind = json_array();
    json_auto_t *methods = methods_of(b);
    json_t *unused, *times;
    const size_t counted = summarize(b, "original", 0).case_count;
    if (print) {
        printf("\n%s, %s: %zu cases; error / error of the original TF: geometric means, medians (quartiles)\n"
               "%-26s %8s %8s %8s   %-20s %-20s %-20s worse by .005, worst\n",
               b->renderer, name, counted, "method", "SSIM", "FLIP", "RMSE", "SSIM", "FLIP", "RMSE");
        json_object_foreach (reasons, why, times)
            printf("left out: %lld cases, %s\n", (long long)json_integer_value(times), why);
    }
    for (json_int_t level = 0; level < 16; ++level) {
        if (level > 0 && summarize(b, "original", level).case_count == 0)
            continue;
        json_object_foreach (methods, method, unused) {
            const summary s = summarize(b, method, level);
            json_array_append_new(means, summary_to_json(&s, method, level));
            if (level == 0)
                json_array_append_new(behind, json_pack("{s:s, s:i, s:f}", "method", method, "worse_count",
                                                        (int)s.worse, "worst_ssim_difference", s.worst));
            if (print)
                print_summary(&s, method, level);
        }
    }
    return json_pack("{s:s, s:s, s:i, s:i, s:o, s:o, s:o}", "renderer", b->renderer, "block", name, "case_count",
                     (int)counted, "left_out_count", (int)left_out, "left_out", reasons, "means", means, "behind",
                     behind);
}

json_t *iso_consistency_report(const json_t *cases, bool print)
{
    json_t *blocks = json_array(), *seen = json_object(), *c;
    size_t i;
    json_array_foreach (cases, i, c) {
        const block b = {cases, text_of(c, "renderer"), json_is_true(json_object_get(c, "held"))};
        char key[64];
        snprintf(key, sizeof key, "%.40s %d", b.renderer, b.held);
        if (!json_object_get(seen, key))
            json_array_append_new(blocks, report_block(&b, print));
        json_object_set_new(seen, key, json_true());
    }
    json_decref(seen);
    return blocks;
}
