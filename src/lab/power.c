/* SPDX-License-Identifier: MIT */
/* power.c - measures whether validation finds planted faults and passes correct scenes.
 *
 * Plants each named fault against the calibration. Then it runs random scenes, clean and with each fault, through every
 * gate of the agreement (power.h). All results follow from --seed. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/parallel.h"
#include "lab/lab.h"
#include "validate/calibrate.h"
#include "lab/power.h"
#include "renderers/external.h"
#include "cli/renderer_help.h"

enum { most_noise_pixels = 32 }; /* per side; more are too many together for a single test's chance of 1e-3 */

typedef struct power_options {
    char *with, *renderers, *output, *format;
    int repetitions, planted, size, limit_size, seed, quick, sensitivity, random, threads;
    bool wanted[ISO_MAX_RENDERERS];
} power_options;

typedef struct tally {
    size_t tested, rejected;
} tally;

typedef struct power_result {
    double ratio[ISO_FAULT_COUNT][ISO_MAX_RENDERERS]; /* value over limit of the fault's own check; NaN: not run */
    size_t scenes, bright;                            /* all; those with a pixel above 1 */
    size_t changed[ISO_FAULT_COUNT];                  /* scenes that the fault changes by more than their error bar */
    tally seen[ISO_FAULT_COUNT][ISO_POWER_GATE_COUNT][ISO_MAX_RENDERERS]; /* in those; ISO_FAULT_NONE: clean scenes */
    iso_power_noise noise[ISO_MAX_RENDERERS][ISO_POWER_KIND_COUNT];       /* of random renderers, with planted faults */
    json_t *wrong;                                                        /* missed faults and flagged clean scenes */
} power_result;

/* Running times for the estimate: of each scene, and of the slow gates in scenes with faults. */
typedef struct pace {
    const iso_progress *progress;
    double plain_seconds, dear_seconds;
} pace;

/* True for limits of other programs, which take seconds. */
static bool is_slow(iso_power_gate gate, const iso_renderer_info *renderer)
{
    return gate == ISO_POWER_LIMIT && iso_renderer_has(renderer, ISO_IS_PROGRAM);
}

static iso_status plant_in_calibrations(iso_renderers *r, const power_options *o, power_result *out,
                                        const iso_progress *progress, iso_error *err)
{
    iso_status status = ISO_OK;
    for (int f = ISO_FAULT_NONE + 1; f < ISO_FAULT_COUNT && status == ISO_OK; ++f)
        for (size_t w = 0; w < iso_renderer_count() && status == ISO_OK; ++w) {
            iso_calibration c;
            const iso_calibration_fault fault = iso_planted_calibration(&(iso_planted){.fault = (iso_fault)f});
            out->ratio[f][w] = NAN;
            if (!o->wanted[w])
                continue;
            iso_progress_report(progress, "faults in the calibrations", (double)(f - 1) / (ISO_FAULT_COUNT - 1));
            status = iso_calibrate_check(r, iso_renderer_at(w), &fault,
                                         iso_calibration_number(iso_fault_check((iso_fault)f)), &c, err);
            out->ratio[f][w] = c.value / c.limit;
        }
    return status;
}

/* Runs all wanted gates, either the slow or the fast ones, on a scene with one fault or ISO_FAULT_NONE. */
static iso_status run_gates(iso_renderers *r, const power_options *o, const iso_power_case *c, iso_fault fault,
                            bool slow, power_result *out, iso_error *err)
{
    const iso_planted planted = {.fault = fault};
    iso_status status = ISO_OK;
    for (int g = 0; g < ISO_POWER_GATE_COUNT; ++g)
        for (size_t w = 0; w < iso_renderer_count() && status == ISO_OK; ++w) {
            const iso_power_gate gate = (iso_power_gate)g;
            const iso_renderer_info *renderer = iso_renderer_at(w);
            tally *t = &out->seen[fault][g][w];
            bool rejected;
            if (!o->wanted[w] || !iso_power_has_gate(gate, renderer) || is_slow(gate, renderer) != slow)
                continue;
            status = iso_power_run_gate(r, c, gate, renderer, &planted, &rejected, err);
            t->tested += 1;
            t->rejected += rejected;
            if (status == ISO_OK && rejected == (fault == ISO_FAULT_NONE))
                json_array_append_new(out->wrong,
                                      json_pack("{s:s, s:s, s:s, s:I, s:s}", "fault", iso_fault_name(fault), "gate",
                                                iso_power_gate_name(gate), "renderer", renderer->name, "seed",
                                                (json_int_t)c->seed, "kind", iso_power_kind_name(c->kind)));
        }
    return status;
}

/* Plants the faults in a scene. A fault that changes the picture by less than a limit's error bar cannot be found: it
 * is left out and counted. */
static iso_status plant_in_scene(iso_renderers *r, const power_options *o, const iso_power_case *c, bool slow,
                                 power_result *out, iso_error *err)
{
    iso_status status = ISO_OK;
    for (int f = ISO_FAULT_NONE + 1; f < ISO_FAULT_COUNT && status == ISO_OK; ++f) {
        const iso_planted planted = {.fault = (iso_fault)f};
        double change = 0;
        status = iso_power_change(r, c, &planted, &change, err);
        if (!(change > iso_validate_error_bar(&c->asked)))
            continue;
        out->changed[f] += !slow;
        TRY(status, run_gates(r, o, c, planted.fault, slow, out, err));
    }
    return status;
}

static iso_status test_noise(iso_renderers *r, const power_options *o, const iso_power_case *c, power_result *out,
                             iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t w = 0; w < iso_renderer_count() && status == ISO_OK; ++w) {
        iso_power_noise n, *sum = &out->noise[w][c->kind];
        if (!o->wanted[w] || !iso_renderer_has(iso_renderer_at(w), ISO_IS_RANDOM))
            continue;
        status = iso_power_test_noise(r, c, iso_renderer_at(w), o->quick ? 8 : 16, &n, err);
        sum->tests += n.tests;
        sum->below += n.below;
        sum->groups += n.groups;
        sum->flagged += n.flagged;
        for (size_t a = 0; a < ISO_POWER_BLOCKS; ++a)
            for (size_t b = 0; b < ISO_POWER_BLOCKS; ++b) /* the worst of several scenes */
                sum->block[a][b] = fmax(sum->block[a][b], n.block[a][b]);
    }
    return status;
}

static bool wants_some(const power_options *o, unsigned traits)
{
    bool some = false;
    for (size_t w = 0; w < iso_renderer_count(); ++w)
        some = some || (o->wanted[w] && iso_renderer_has(iso_renderer_at(w), traits));
    return some;
}

static void report_progress(const pace *p, const power_options *o, int i)
{
    char stage[160];
    const int planted_left = o->planted > i ? o->planted - i : 0, planted_done = o->planted < i ? o->planted : i;
    double left = i > 0 ? p->plain_seconds / i * (o->repetitions - i) : 0;
    left += planted_done > 0 ? p->dear_seconds / planted_done * planted_left : 0;
    int n = snprintf(stage, sizeof stage, "random scene %d of %d", i + 1, o->repetitions);
    if (i > 0)
        snprintf(stage + n, sizeof stage - (size_t)n, left < 90 ? "; about %.0f s left" : "; about %.1f min left",
                 left < 90 ? left : left / 60);
    iso_progress_report(p->progress, stage, (double)i / o->repetitions);
}

static iso_status run_scene(iso_renderers *r, const power_options *o, int i, power_result *out, pace *p, iso_error *err)
{
    iso_power_case c = {.seed = (uint64_t)o->seed * 1000 + (uint64_t)i,
                        .pixels = (size_t)o->size,
                        .first_seed = 1000 * i,
                        .seeds = o->quick ? 3 : 4,
                        .threads = o->threads};
    const double start = iso_clock_seconds();
    report_progress(p, o, i);
    iso_status status = iso_power_open(r, &c, err);
    for (int slow = 0; slow < 2 && status == ISO_OK; ++slow)
        status = run_gates(r, o, &c, ISO_FAULT_NONE, slow, out, err);
    TRY(status, plant_in_scene(r, o, &c, false, out, err));
    const double plain = iso_clock_seconds();
    if (status == ISO_OK && i < o->planted && wants_some(o, ISO_IS_PROGRAM | ISO_HAS_LIMIT))
        status = plant_in_scene(r, o, &c, true, out, err);
    if (status == ISO_OK && i < o->planted && o->size <= most_noise_pixels)
        status = test_noise(r, o, &c, out, err);
    p->plain_seconds += plain - start;
    p->dear_seconds += iso_clock_seconds() - plain;
    out->scenes += 1;
    out->bright += c.brightest > 1;
    iso_power_close(&c);
    return status;
}

/* ---- results ------------------------------------------------------------------------ */

static bool is_caught(const power_result *r, int fault)
{
    for (size_t w = 0; w < iso_renderer_count(); ++w)
        if (r->ratio[fault][w] <= 1)
            return false;
    return true;
}

static json_t *gates_to_json(const tally t[ISO_POWER_GATE_COUNT][ISO_MAX_RENDERERS], const char *rejected)
{
    json_t *list = json_array();
    for (int g = 0; g < ISO_POWER_GATE_COUNT; ++g)
        for (size_t w = 0; w < iso_renderer_count(); ++w)
            if (t[g][w].tested)
                json_array_append_new(list,
                                      json_pack("{s:s, s:s, s:I, s:I}", "gate", iso_power_gate_name((iso_power_gate)g),
                                                "renderer", iso_renderer_at(w)->name, "comparisons",
                                                (json_int_t)t[g][w].tested, rejected, (json_int_t)t[g][w].rejected));
    return list;
}

static json_t *blocks_to_json(const iso_power_noise *n)
{
    json_t *list = json_array();
    for (size_t s = 0; s < ISO_POWER_BLOCKS; ++s)
        for (size_t b = 0; b < ISO_POWER_BLOCKS && n->block[s][b] > 0; ++b)
            json_array_append_new(list, json_pack("{s:I, s:I, s:f}", "seeds", (json_int_t)iso_power_block_seeds[s],
                                                  "pixels_squared", (json_int_t)iso_power_block_sides[b],
                                                  "rejected_from", n->block[s][b]));
    return list;
}

static json_t *noise_to_json(const power_result *r)
{
    json_t *list = json_array();
    for (size_t w = 0; w < iso_renderer_count(); ++w)
        for (int k = 0; k < ISO_POWER_KIND_COUNT; ++k) {
            const iso_power_noise *n = &r->noise[w][k];
            if (n->tests)
                json_array_append_new(list,
                                      json_pack("{s:s, s:s, s:I, s:I, s:I, s:I, s:o}", "renderer",
                                                iso_renderer_at(w)->name, "kind",
                                                iso_power_kind_name((iso_power_kind)k), "groups", (json_int_t)n->groups,
                                                "flagged", (json_int_t)n->flagged, "tests", (json_int_t)n->tests,
                                                "below_1e-3", (json_int_t)n->below, "blocks", blocks_to_json(n)));
        }
    return list;
}

static json_t *to_json(const power_result *r)
{
    json_t *faults = json_array();
    for (int f = ISO_FAULT_NONE + 1; f < ISO_FAULT_COUNT; ++f) {
        json_t *ratios = json_object();
        for (size_t w = 0; w < iso_renderer_count(); ++w)
            if (isfinite(r->ratio[f][w]))
                json_object_set_new(ratios, iso_renderer_at(w)->name, json_real(r->ratio[f][w]));
        json_array_append_new(faults,
                              json_pack("{s:s, s:s, s:b, s:o, s:I, s:I, s:o}", "fault", iso_fault_name((iso_fault)f),
                                        "check", iso_fault_check((iso_fault)f), "caught", is_caught(r, f),
                                        "times_the_limit", ratios, "scenes", (json_int_t)r->scenes, "scenes_changed",
                                        (json_int_t)r->changed[f], "gates", gates_to_json(r->seen[f], "rejected")));
    }
    return json_pack("{s:o, s:o, s:O, s:o, s:I, s:I}", "faults", faults, "clean",
                     gates_to_json(r->seen[ISO_FAULT_NONE], "flagged"), "wrong", r->wrong, "noise", noise_to_json(r),
                     "scenes", (json_int_t)r->scenes, "scenes_above_1", (json_int_t)r->bright);
}

static void print_calibrations(const power_options *o, const power_result *r)
{
    printf("Value of the fault's own calibration check, as a multiple of its limit\n%-50s %-18s", "planted fault",
           "check");
    for (size_t w = 0; w < iso_renderer_count(); ++w)
        if (o->wanted[w])
            printf(" %10s", iso_renderer_at(w)->name);
    printf("\n");
    for (int f = ISO_FAULT_NONE + 1; f < ISO_FAULT_COUNT; ++f) {
        printf("%-50s %-18s", iso_fault_name((iso_fault)f), iso_fault_check((iso_fault)f));
        for (size_t w = 0; w < iso_renderer_count(); ++w)
            if (o->wanted[w])
                printf(" %9.3gx", r->ratio[f][w]);
        printf("%s\n", is_caught(r, f) ? "" : "  NOT CAUGHT");
    }
}

/* Prints a row of the scenes' table: a fault, or with ISO_FAULT_NONE the heading. */
static void print_scene_row(const power_options *o, const power_result *r, int fault)
{
    for (int g = 0; g < ISO_POWER_GATE_COUNT; ++g)
        for (size_t w = 0; w < iso_renderer_count(); ++w) {
            const tally *t = &r->seen[fault][g][w];
            char cell[48];
            if (!o->wanted[w] || !iso_power_has_gate((iso_power_gate)g, iso_renderer_at(w)))
                continue;
            if (fault == ISO_FAULT_NONE)
                snprintf(cell, sizeof cell, "%s %s", iso_renderer_at(w)->name, iso_power_gate_name((iso_power_gate)g));
            else
                snprintf(cell, sizeof cell, "%zu of %zu", t->rejected, t->tested);
            printf(" %16s", t->tested || fault == ISO_FAULT_NONE ? cell : "-");
        }
}

static void print_blocks(const iso_power_noise *n)
{
    for (size_t s = 0; s < ISO_POWER_BLOCKS; ++s)
        if (n->block[s][0] > 0) {
            printf("    with %zu seeds, too bright blocks are rejected", iso_power_block_seeds[s]);
            for (size_t b = 0; b < ISO_POWER_BLOCKS; ++b)
                printf("%s %.2g (%zu x %zu pixels)", b ? "," : " from", n->block[s][b], iso_power_block_sides[b],
                       iso_power_block_sides[b]);
            printf(" on\n");
        }
}

static void print_noise(const power_result *r)
{
    for (size_t w = 0; w < iso_renderer_count(); ++w)
        for (int k = 0; k < ISO_POWER_KIND_COUNT; ++k) {
            const iso_power_noise *n = &r->noise[w][k];
            if (n->tests)
                printf("%s, %s scenes: %zu of %zu groups of seeds flagged by chance; without the step's tolerance\n"
                       "    %.2g of the noisy pixels would be below a chance of 1e-3\n",
                       iso_renderer_at(w)->name, iso_power_kind_name((iso_power_kind)k), n->flagged, n->groups,
                       (double)n->below / (double)n->tests);
            print_blocks(n);
        }
}

static void print_scenes(const power_options *o, const power_result *r)
{
    printf(
        "\n%zu random scenes, %zu of them with highlights above 1: rejected, of those that the fault changes by more\n"
        "than the scene's bar (RMSE 1/2550, sharp 1/255); smaller changes are too small to find\n%-50s %9s",
        r->scenes, r->bright, "planted fault", "too small");
    print_scene_row(o, r, ISO_FAULT_NONE);
    printf("\n");
    for (int f = ISO_FAULT_NONE + 1; f < ISO_FAULT_COUNT; ++f) {
        printf("%-50s %9zu", iso_fault_name((iso_fault)f), r->scenes - r->changed[f]);
        print_scene_row(o, r, f);
        printf("\n");
    }
    printf("\n");
    for (int g = 0; g < ISO_POWER_GATE_COUNT; ++g)
        for (size_t w = 0; w < iso_renderer_count(); ++w) {
            const tally *t = &r->seen[ISO_FAULT_NONE][g][w];
            if (t->tested)
                printf("clean scenes, %s %s: %zu of %zu flagged%s", iso_renderer_at(w)->name,
                       iso_power_gate_name((iso_power_gate)g), t->rejected, t->tested, t->rejected ? "\n" : "");
            if (t->tested && !t->rejected)
                printf(" (a rate below %.2g %%, at 95 %% confidence)\n", 100 * iso_power_rate_bound(0, t->tested));
        }
    print_noise(r);
    size_t i;
    json_t *wrong;
    json_array_foreach (r->wrong, i, wrong)
        printf("WRONG: %s, %s of %s, scene %lld (%s)\n", json_string_value(json_object_get(wrong, "fault")),
               json_string_value(json_object_get(wrong, "gate")), json_string_value(json_object_get(wrong, "renderer")),
               (long long)json_integer_value(json_object_get(wrong, "seed")),
               json_string_value(json_object_get(wrong, "kind")));
}

static iso_status verdict(const power_result *r, iso_error *err)
{
    for (int f = ISO_FAULT_NONE + 1; f < ISO_FAULT_COUNT; ++f)
        if (!is_caught(r, f))
            return iso_fail(err, ISO_E_DIFFERS, "isoshade-lab power: \"%s\" is not caught",
                            iso_fault_name((iso_fault)f));
    if (json_array_size(r->wrong) == 0)
        return ISO_OK;
    const json_t *first = json_array_get(r->wrong, 0);
    return iso_fail(err, ISO_E_DIFFERS,
                    "isoshade-lab power: %zu wrong answers, the first for \"%s\" by the %s of %s on scene %lld",
                    json_array_size(r->wrong), json_string_value(json_object_get(first, "fault")),
                    json_string_value(json_object_get(first, "gate")),
                    json_string_value(json_object_get(first, "renderer")),
                    (long long)json_integer_value(json_object_get(first, "seed")));
}

/* ---- the command ------------------------------------------------------------------------ */

static iso_status check(power_options *o, iso_error *err)
{
    /* -1: not given */
    o->repetitions = o->repetitions >= 0 ? o->repetitions : o->sensitivity ? 3 : o->quick ? 4 : 20;
    o->planted = o->planted >= 0 ? o->planted : o->quick ? 1 : 4;
    o->size = o->size >= 0 ? o->size : o->quick ? 12 : 16; /* an RMSE hardly depends on it */
    iso_status status = iso_words_check_range("--repetitions", o->repetitions, o->sensitivity ? 1 : 0, 1000, err);
    TRY(status, iso_words_check_range("--planted", o->planted, 0, 1000, err));
    TRY(status, iso_words_check_range("--size", o->size, 8, 1024, err));
    if (status == ISO_OK && o->random)
        status = iso_words_check_range("--random", o->random, 1, 100000, err);
    if (status == ISO_OK && o->random && o->sensitivity)
        status = iso_fail(err, ISO_E_USAGE, "--random and --sensitivity exclude each other");
    if (status == ISO_OK && o->limit_size)
        status = iso_words_check_range("--limit-size", o->limit_size, 8, o->size - 1, err);
    if (status == ISO_OK && o->limit_size && !o->sensitivity)
        status = iso_fail(err, ISO_E_USAGE, "--limit-size needs --sensitivity");
    TRY(status, iso_words_check_range("--seed", o->seed, 0, 1e6, err));
    if (status == ISO_OK && o->output && !o->sensitivity)
        status = iso_fail(err, ISO_E_USAGE, "-o needs --sensitivity: it writes its chart");
    TRY(status, iso_renderers_load(o->renderers, err));
    return status == ISO_OK ? iso_renderers_from_list(o->with, o->wanted, err) : status;
}

static iso_status bench(const iso_cli *cli, const power_options *o, iso_renderers *renderers, iso_error *err)
{
    iso_progress progress = iso_cli_progress(cli);
    power_result result = {.wrong = json_array()};
    pace p = {.progress = &progress};
    iso_status status = plant_in_calibrations(renderers, o, &result, &progress, err);
    for (int i = 0; i < o->repetitions && status == ISO_OK; ++i)
        status = run_scene(renderers, o, i, &result, &p, err);
    if (status == ISO_OK && cli->json) {
        json_t *root = iso_cli_json(cli);
        json_object_update_new(root, to_json(&result));
        iso_cli_print_json(root);
    } else if (status == ISO_OK) {
        print_calibrations(o, &result);
        print_scenes(o, &result);
    }
    TRY(status, verdict(&result, err));
    json_decref(result.wrong);
    return status;
}

static const iso_option options[] = {
    {"repetitions", 0, "run N random scenes (20; 4 with --quick, 3 with --sensitivity)", "N",
     ISO_IN(power_options, repetitions)},
    {"planted", 0, "plant faults for other programs' limits in N scenes (4; 1)", "N", ISO_IN(power_options, planted)},
    {"with", 0, "test these renderers against the reference (%s)", "LIST", ISO_IN(power_options, with),
     ISO_NAMES_USUAL(ISO_HAS_LIMIT)},
    ISO_CLI_RENDERERS_OPTION(power_options, renderers),
    {"size", 0, "render scenes of N x N pixels (16; 12 with --quick)", "N", ISO_IN(power_options, size)},
    {"limit-size", 0, "with --sensitivity: also measure limits with N x N pixels", "N",
     ISO_IN(power_options, limit_size)},
    {"seed", 0, "set the seed of the scenes", "N", ISO_IN(power_options, seed), .flags = ISO_SHOWN},
    {"quick", 0, "use fewer and smaller scenes and three seeds", NULL, ISO_IN(power_options, quick)},
    {"random", 0, "run N random scenes and volumes through validate instead, count false alarms", "N",
     ISO_IN(power_options, random), .flags = ISO_NOT_ZERO},
    {"sensitivity", 0, "find the smallest amount of each deviation that each gate rejects", NULL,
     ISO_IN(power_options, sensitivity)},
    {"output", 'o', "with --sensitivity: write the chart and its data", "DIR", ISO_IN(power_options, output)},
    {"format", 0, "write the chart as svg or pdf", "svg|pdf", ISO_IN(power_options, format),
     .flags = ISO_SHOWN | ISO_ONE_OF},
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    power_options *o = values;
    iso_renderers renderers = {0};
    NEED(check(o, err));
    o->threads = cli->threads;
    iso_sensitivity_options s = {.scenes = o->repetitions,
                                 .pixels = o->size,
                                 .limit_pixels = o->limit_size,
                                 .halvings = o->limit_size ? 3 : 1,
                                 .seed = o->seed,
                                 .threads = o->threads,
                                 .output = o->output,
                                 .format = o->format};
    memcpy(s.wanted, o->wanted, sizeof s.wanted);
    const iso_power_random_options random = {.with = o->with ? o->with : "gl,cpu",
                                             .scenes = o->random,
                                             .seed = o->seed,
                                             .threads = o->threads};
    iso_status status = o->random        ? iso_power_random(&random, cli, err)
                        : o->sensitivity ? iso_power_sensitivity(&renderers, &s, cli, err)
                                         : bench(cli, o, &renderers, err);
    iso_renderers_end(&renderers);
    return status;
}

const iso_command iso_lab_power = {
    .name = "power",
    .summary =
        "which planted faults validation finds, how often it flags clean scenes, and the smallest faults it finds",
    .usage = "[options]",
    .details =
        "Plants each fault into the calibration of each renderer, and prints the value of the fault's own check as a\n"
        "multiple of its limit. Then it runs random scenes, smooth, bright (highlights above 1), sharp and lit in\n"
        "turn. It counts the clean ones that each gate of validate flags, and those in which the gate finds each\n"
        "fault, among the scenes that the fault changes by more than their error bar.\n"
        "--sensitivity finds the smallest deviation that each gate rejects, such as a shifted volume or a turned\n"
        "light. --random runs volumes of make, 9 to 40 voxels along an edge, with random transfer functions and\n"
        "presets, views, lights and levels, through validate --quick; there --with is gl,cpu. Exit code 1: a fault\n"
        "was not found, or a clean scene was flagged.",
    .examples = "  isoshade-lab power --with gl --repetitions 2 --size 16\n"
                "  isoshade-lab power --random 2\n"
                "  isoshade-lab power --with gl --sensitivity --repetitions 1 --size 12 -o sensitivity\n",
    ISO_COMMAND_OPTIONS(power_options, options, .repetitions = -1, .planted = -1, .size = -1, .seed = 1001,
                        .format = "svg"),
    .run = run,
};
