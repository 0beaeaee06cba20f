/* SPDX-License-Identifier: MIT */
/* power_sensitivity.c - finds the smallest error of a renderer that validation rejects.
 *
 * For each deviation (faults.h) and each gate it bisects octaves: the found amount is rejected, and 1/sqrt(2) of it
 * passes. If pictures of two sizes are compared, it bisects down to eighths. Scenes are random, with transfer functions
 * that are not sharp, whose bars are 1/2550. Amounts differ from scene to scene, which the chart shows as a span. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/embed.h"
#include "base/file.h"
#include "base/json.h"
#include "base/parallel.h"
#include "validate/calibrate.h"
#include "lab/frame_cache.h"
#include "lab/power.h"
#include "report/gnuplot.h"

ISO_EMBED(iso_sensitivity_gp, "src/lab/sensitivity.gp");

enum { most_scenes = 64 };

/* A tested calibration or gate. cost: its running time, for the estimate. */
typedef struct probe {
    char name[64];
    const iso_renderer_info *renderer;
    bool is_calibration;
    iso_power_gate gate;
    bool few; /* with opt->limit_pixels */
    double cost;
} probe;

enum { most_probes = 1 + (ISO_POWER_GATE_COUNT + 1) * ISO_MAX_RENDERERS };

/* Smallest rejected amounts, one per scene; a calibration has one. INFINITY: none was rejected; count 0: not run. */
typedef struct threshold {
    size_t count;
    double amount[most_scenes];
} threshold;

typedef struct study {
    iso_renderers *renderers;
    const iso_sensitivity_options *opt;
    const iso_progress *progress;
    double start, done, all; /* seconds; costs */
    size_t probe_count;
    probe probes[most_probes]; /* of the wanted renderers */
    threshold found[ISO_DEVIATION_COUNT][most_probes];
} study;

/* Lists the probes. A calibration's limit is at least 15 times any renderer's own error there (test_calibrate), so that
 * the amounts are nearly equal for all of them: only the reference is tested. */
static void list_probes(study *s)
{
    s->probes[s->probe_count++] =
        (probe){.name = "calibration", .renderer = iso_renderers_reference(), .is_calibration = true, .cost = 1};
    for (int g = 0; g < ISO_POWER_GATE_COUNT; ++g)
        for (size_t w = 0; w < iso_renderer_count(); ++w) {
            const iso_renderer_info *renderer = iso_renderer_at(w);
            const iso_power_gate gate = (iso_power_gate)g;
            if (!s->opt->wanted[w] || !iso_power_has_gate(gate, renderer))
                continue;
            probe *p = &s->probes[s->probe_count++];
            *p = (probe){.renderer = renderer, .gate = gate, .cost = gate == ISO_POWER_LIMIT ? 12 : 4};
            snprintf(p->name, sizeof p->name, "%.40s %s", renderer->name, iso_power_gate_name(gate));
            if (gate != ISO_POWER_LIMIT || !s->opt->limit_pixels)
                continue;
            probe *few = &s->probes[s->probe_count++];
            *few = *p;
            few->few = true;
            snprintf(few->name, sizeof few->name, "%.30s %s of %d px", renderer->name, iso_power_gate_name(gate),
                     s->opt->limit_pixels);
        }
}

/* True if the scene is rendered again for each amount, which is fast within this process. Another program renders it
 * once, and the reference's scene deviates the other way. */
static bool renders_each_amount(const probe *p)
{
    return !iso_renderer_has(p->renderer, ISO_IS_PROGRAM);
}

static iso_status ask(study *s, const iso_power_case *c, const probe *p, iso_deviation d, double amount, bool *rejected,
                      iso_error *err)
{
    const iso_planted planted = {.deviation = d, .amount = amount};
    iso_calibration result;
    if (!p->is_calibration && renders_each_amount(p))
        return iso_power_run_gate(s->renderers, c, p->gate, p->renderer, &planted, rejected, err);
    if (!p->is_calibration)
        return iso_power_run_deviation_gate(s->renderers, c, p->gate, p->renderer,
                                            &(iso_planted){.deviation = d, .amount = amount}, rejected, err);
    const iso_calibration_fault fault = iso_planted_calibration(&planted);
    iso_status status = iso_calibrate_check(s->renderers, p->renderer, &fault,
                                            iso_calibration_number(iso_deviation_check(d)), &result, err);
    *rejected = status == ISO_OK && !result.passed;
    return status;
}

/* Estimates from the RMSE, which is about a quarter of the largest difference. */
static double guess_of_lock_step(const iso_lock_step *lock)
{
    return lock->smooth.rmse > 0 ? lock->smooth.rmse : lock->smooth.max_abs / 4;
}

/* Estimates the first amount: images change in proportion to small amounts, and the gates' limits are known. */
static iso_status guess(study *s, const iso_power_case *c, const probe *p, iso_deviation d, double *amount,
                        iso_error *err)
{
    const double small = iso_deviation_most(d) / 128;
    const iso_planted planted = {.deviation = d, .amount = small};
    double change = 0, wanted;
    iso_calibration result;
    iso_status status;
    if (p->is_calibration) {
        const iso_calibration_fault fault = iso_planted_calibration(&planted);
        status = iso_calibrate_check(s->renderers, p->renderer, &fault, iso_calibration_number(iso_deviation_check(d)),
                                     &result, err);
        change = result.value;
        wanted = result.limit;
    } else {
        status = iso_power_change(s->renderers, c, &planted, &change, err);
        wanted = p->gate == ISO_POWER_LIMIT ? 0.5 * iso_validate_error_bar(&c->asked)
                                            : guess_of_lock_step(p->renderer->lock_step);
    }
    *amount = fmin(change > 0 ? small * wanted / change : iso_deviation_most(d), iso_deviation_most(d));
    return status;
}

/* Brackets by factors of 2, then bisects the octave. */
static iso_status find_smallest(study *s, const iso_power_case *c, const probe *p, iso_deviation d, double *smallest,
                                iso_error *err)
{
    const double most = iso_deviation_most(d), least = 1e-9 * most;
    double x = most, passed = 0, rejected = INFINITY;
    iso_status status = guess(s, c, p, d, &x, err);
    while (status == ISO_OK && !(passed > 0 && isfinite(rejected))) {
        bool is_rejected;
        status = ask(s, c, p, d, x, &is_rejected, err);
        if (is_rejected)
            rejected = x;
        else
            passed = x;
        if ((!is_rejected && x >= most) || (is_rejected && x <= least))
            break;
        x = is_rejected ? x / 2 : fmin(2 * x, most);
    }
    for (int i = 0; i < s->opt->halvings && status == ISO_OK && passed > 0 && isfinite(rejected); ++i) {
        bool is_rejected;
        x = sqrt(passed * rejected);
        status = ask(s, c, p, d, x, &is_rejected, err);
        *(is_rejected ? &rejected : &passed) = x;
    }
    *smallest = rejected;
    return status;
}

static void report_progress(study *s, const probe *p, int scene)
{
    char stage[160];
    const double left = (iso_clock_seconds() - s->start) / s->done * (s->all - s->done);
    int n = p->is_calibration ? snprintf(stage, sizeof stage, "%s", p->name)
                              : snprintf(stage, sizeof stage, "scene %d of %d, %s", scene + 1, s->opt->scenes, p->name);
    if (s->done > 0)
        snprintf(stage + n, sizeof stage - (size_t)n, left < 90 ? "; about %.0f s left" : "; about %.1f min left",
                 left < 90 ? left : left / 60);
    iso_progress_report(s->progress, stage, s->done / s->all);
}

/* Runs one probe with all deviations. c NULL: a calibration. */
static iso_status run_probe(study *s, const iso_power_case *c, size_t index, int scene, iso_error *err)
{
    const probe *p = &s->probes[index];
    iso_status status = ISO_OK;
    report_progress(s, p, scene);
    for (int d = ISO_DEVIATION_NONE + 1; d < ISO_DEVIATION_COUNT && status == ISO_OK; ++d) {
        threshold *t = &s->found[d][index];
        status = find_smallest(s, c, p, (iso_deviation)d, &t->amount[t->count], err);
        t->count += status == ISO_OK;
    }
    s->done += p->cost;
    return status;
}

/* Returns the i-th seed whose transfer function is not sharp. */
static uint64_t seed_of(const study *s, int i)
{
    uint64_t seed = (uint64_t)s->opt->seed * 1000;
    for (;; ++seed)
        if (seed % ISO_POWER_KIND_COUNT != ISO_POWER_SHARP && i-- == 0)
            return seed;
}

/* Runs the probes of a scene: those of small pictures (few), or all others. */
static iso_status run_scene(study *s, int i, bool few, iso_error *err)
{
    iso_power_case c = {.seed = seed_of(s, i),
                        .pixels = (size_t)(few ? s->opt->limit_pixels : s->opt->pixels),
                        .seeds = 4,
                        .first_seed = 1000 * i,
                        .threads = s->opt->threads};
    iso_frame_cache cache = {0};
    iso_status status = iso_power_open(s->renderers, &c, err);
    for (size_t p = 0; p < s->probe_count && status == ISO_OK; ++p) {
        iso_frame_cache_use(s->renderers, renders_each_amount(&s->probes[p]) ? NULL : &cache);
        if (!s->probes[p].is_calibration && s->probes[p].few == few)
            status = run_probe(s, &c, p, i, err);
        iso_frame_cache_use(s->renderers, NULL);
    }
    iso_frame_cache_clear(&cache);
    iso_power_close(&c);
    return status;
}

static iso_status run_study(study *s, iso_error *err)
{
    list_probes(s);
    for (size_t p = 0; p < s->probe_count; ++p)
        s->all += s->probes[p].cost * (s->probes[p].is_calibration ? 1 : s->opt->scenes);
    s->start = iso_clock_seconds();
    for (size_t p = 0; p < s->probe_count; ++p)
        if (s->probes[p].is_calibration)
            NEED(run_probe(s, NULL, p, 0, err));
    for (int i = 0; i < s->opt->scenes; ++i) {
        NEED(run_scene(s, i, false, err));
        if (s->opt->limit_pixels)
            NEED(run_scene(s, i, true, err));
    }
    return ISO_OK;
}

/* ---- results ------------------------------------------------------------------------ */

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void sort_all(study *s)
{
    for (int d = 0; d < ISO_DEVIATION_COUNT; ++d)
        for (size_t p = 0; p < s->probe_count; ++p)
            qsort(s->found[d][p].amount, s->found[d][p].count, sizeof(double), by_value);
}

static double median(const threshold *t)
{
    return t->amount[t->count / 2];
} /* of an even number, the upper median */

static void print_table(const study *s)
{
    printf(
        "The smallest amount that is rejected: median of %d scenes whose transfer functions are not sharp, %d x %d pixels\n%-52s",
        s->opt->scenes, s->opt->pixels, s->opt->pixels, "deviation");
    for (size_t p = 0; p < s->probe_count; ++p)
        printf(" %18s", s->probes[p].name);
    printf("\n");
    for (int d = ISO_DEVIATION_NONE + 1; d < ISO_DEVIATION_COUNT; ++d) {
        char label[80];
        snprintf(label, sizeof label, "%s (%s)", iso_deviation_name((iso_deviation)d),
                 iso_deviation_unit((iso_deviation)d));
        printf("%-52s", label);
        for (size_t p = 0; p < s->probe_count; ++p) {
            const threshold *t = &s->found[d][p];
            if (t->count && isfinite(median(t)))
                printf(" %18.2g", median(t));
            else if (t->count)
                printf("       more than %2.0f", iso_deviation_most((iso_deviation)d));
        }
        printf("\n");
    }
}

/* Largest factor by which the median smallest amount grows with smaller pictures; 0: nothing was compared. */
typedef struct growth {
    double factor;
    int deviation;
    const probe *whole;
} growth;

static growth largest_growth(const study *s)
{
    growth g = {.factor = 0};
    for (size_t p = 1; p < s->probe_count; ++p)
        for (int d = ISO_DEVIATION_NONE + 1; d < ISO_DEVIATION_COUNT && s->probes[p].few; ++d) {
            const threshold *whole = &s->found[d][p - 1], *few = &s->found[d][p];
            if (!whole->count || !few->count || !isfinite(median(whole)))
                continue;
            const double factor = median(few) / median(whole);
            if (factor > g.factor)
                g = (growth){factor, d, &s->probes[p - 1]};
        }
    return g;
}

static void print_growth(const study *s)
{
    const growth g = largest_growth(s);
    if (g.factor > 0)
        printf("With %d instead of %d pixels along an edge of the limits' pictures the smallest amount grows by a "
               "factor of at most %.2f: %s by the %s\n",
               s->opt->limit_pixels, s->opt->pixels, g.factor, iso_deviation_name((iso_deviation)g.deviation),
               g.whole->name);
}

static void print_json(const study *s, const iso_cli *cli)
{
    json_t *root = iso_cli_json(cli), *list = json_array();
    for (int d = ISO_DEVIATION_NONE + 1; d < ISO_DEVIATION_COUNT; ++d)
        for (size_t p = 0; p < s->probe_count; ++p) {
            const threshold *t = &s->found[d][p];
            if (!t->count)
                continue;
            json_t *amounts = json_array();
            for (size_t i = 0; i < t->count; ++i)
                json_array_append_new(amounts, iso_json_number(t->amount[i]));
            json_array_append_new(list,
                                  json_pack("{s:s, s:s, s:s, s:o, s:o}", "deviation",
                                            iso_deviation_name((iso_deviation)d), "unit",
                                            iso_deviation_unit((iso_deviation)d), "gate", s->probes[p].name,
                                            "smallest_rejected", iso_json_number(median(t)), "of_each_scene", amounts));
        }
    json_object_set_new(root, "sensitivity", list);
    if (s->opt->limit_pixels)
        json_object_set_new(root, "largest_growth", iso_json_number(largest_growth(s).factor));
    iso_cli_print_json(root);
}

/* Draws a chart. Columns: deviation with its unit, gate, least, median, largest, color of the gate's renderer. */
static iso_status draw(const study *s, iso_error *err)
{
    FREED char *csv = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&csv, &size);
    NEED_MEMORY(f, err, "isoshade-lab power: no memory for the chart's data");
    fprintf(f, "deviation,gate,least,median,largest,color\n");
    for (int d = ISO_DEVIATION_NONE + 1; d < ISO_DEVIATION_COUNT; ++d)
        for (size_t p = 0; p < s->probe_count; ++p) {
            const threshold *t = &s->found[d][p];
            if (!t->count || !isfinite(median(t)))
                continue;
            const double last = t->amount[t->count - 1];
            fprintf(f, "\"%s (%s)\",%s,%.6g,%.6g,%.6g,%s\n", iso_deviation_name((iso_deviation)d),
                    iso_deviation_unit((iso_deviation)d), s->probes[p].name, t->amount[0], median(t),
                    isfinite(last) ? last : iso_deviation_most((iso_deviation)d), s->probes[p].renderer->color);
        }
    fclose(f);
    iso_output out = {0};
    iso_status status = iso_output_begin_dir(&out, s->opt->output, "sensitivity.csv", err);
    TRY(status, iso_gnuplot_draw(out.temp_path, "sensitivity", csv, iso_sensitivity_gp, s->opt->format, err));
    TRY(status, iso_output_commit(&out, err));
    iso_output_abandon(&out);
    return status;
}

iso_status iso_power_sensitivity(iso_renderers *r, const iso_sensitivity_options *opt, const iso_cli *cli,
                                 iso_error *err)
{
    iso_progress progress = iso_cli_progress(cli);
    if (opt->scenes > most_scenes)
        return iso_fail(err, ISO_E_USAGE, "--repetitions is %d, at most %d with --sensitivity", opt->scenes,
                        most_scenes);
    FREED study *s = calloc(1, sizeof *s);
    NEED_MEMORY(s, err, "isoshade-lab power: no memory");
    s->renderers = r, s->opt = opt, s->progress = &progress;
    iso_status status = run_study(s, err);
    sort_all(s);
    if (status == ISO_OK && opt->output)
        status = draw(s, err);
    if (status == ISO_OK && cli->json)
        print_json(s, cli);
    else if (status == ISO_OK) {
        print_table(s);
        print_growth(s);
    }
    return status;
}
