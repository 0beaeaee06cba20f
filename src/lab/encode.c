/* SPDX-License-Identifier: MIT */
/* encode.c - direction codes: speed, holes, errors at voxels and between them; the tables and the figure of
 * [diaz-garcia-2017] sections 4 and 5. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "base/file.h"
#include "base/json.h"
#include "base/random.h"
#include "lab/lab.h"
#include "options/input.h"
#include "lab/encode.h"
#include "lab/codes/code_error.h"
#include "lab/codes/code_hole.h"
#include "encode/encode_kernel.h"
#include "lab/codes/encode_exact.h"

/* Returns this thread's time, which other programs do not affect. */
static double thread_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

enum { TIMED = 16384 }; /* directions: they and their codes fit into the second-level cache */

typedef struct timing_buffers {
    float directions[3 * TIMED], decoded[3 * TIMED];
    uint8_t bytes[6 * TIMED];
} timing_buffers;

static void random_directions(float *directions, size_t count)
{
    uint64_t state = 20170613;
    for (size_t i = 0; i < 3 * count; ++i)
        directions[i] = (float)(2 * iso_xorshift_unit(&state) - 1);
    for (size_t i = 0; i < count; ++i) {
        float *d = directions + 3 * i, length = sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        for (int a = 0; a < 3; ++a)
            d[a] /= length;
    }
}

/* Returns millions per second: the best of at least five runs and 50 ms. Slow codes encode fewer directions. */
static double encode_rate(const iso_scheme *scheme, timing_buffers *b)
{
    double best = 0, start = thread_seconds();
    size_t n = TIMED / 16;
    for (int run = 0; run < 5 || thread_seconds() - start < 0.05; ++run) {
        double before = thread_seconds();
        iso_scheme_encode(scheme, b->directions, b->bytes, n);
        double seconds = thread_seconds() - before;
        best = fmax(best, 1e-6 * (double)n / seconds);
        n = run == 0 && seconds < 1e-3 ? TIMED : n;
    }
    return best;
}

static double decode_rate(iso_code code, timing_buffers *b)
{
    double best = 0, start = thread_seconds();
    iso_code_encode(code, b->directions, b->bytes, TIMED);
    for (int run = 0; run < 5 || thread_seconds() - start < 0.02; ++run) {
        double before = thread_seconds();
        iso_code_decode_all(code, b->bytes, b->decoded, TIMED);
        best = fmax(best, 1e-6 * TIMED / (thread_seconds() - before));
    }
    return best;
}

/* ---- schemes ---- */

static const double apart_deg[] = {5, 15, 30, 60};
enum { APART_COUNT = sizeof apart_deg / sizeof apart_deg[0], APART_15 = 1 };

typedef struct scheme_result {
    double encode_rate, decode_rate;
    iso_hole hole;
    const char *hole_how;
    iso_code_error at_voxels, between[APART_COUNT];
} scheme_result;

static iso_status measure_scheme(const iso_scheme *scheme, size_t count, timing_buffers *b, scheme_result *r,
                                 iso_error *err)
{
    iso_code_error_options opt = iso_code_error_defaults();
    opt.count = count;
    r->encode_rate = encode_rate(scheme, b);
    r->decode_rate = decode_rate(scheme->code, b);
    iso_status status = iso_code_hole(scheme->code, 1e-5, &r->hole, &r->hole_how, err);
    TRY(status, iso_code_error_measure(scheme, &opt, &r->at_voxels, err));
    for (int i = 0; i < APART_COUNT && status == ISO_OK; ++i) {
        opt.apart_deg = apart_deg[i];
        status = iso_code_error_measure(scheme, &opt, &r->between[i], err);
    }
    return status;
}

static json_t *error_to_json(const iso_code_error *e, double apart)
{
    return json_pack("{s:f, s:f, s:f}", "apart_deg", apart, "mean_error_deg", e->mean_deg, "max_error_deg", e->max_deg);
}

static json_t *scheme_to_json(const iso_scheme *scheme, const scheme_result *r)
{
    json_t *between = json_array();
    for (int i = 0; i < APART_COUNT; ++i)
        json_array_append_new(between, error_to_json(&r->between[i], apart_deg[i]));
    return json_pack("{s:s, s:s, s:i, s:f, s:f, s:f, s:s, s:f, s:f, s:f, s:f, s:o}", "name", scheme->name, "code",
                     iso_code_describe(scheme->code)->name, "bytes", (int)iso_code_describe(scheme->code)->bytes,
                     "encode_million_per_second", r->encode_rate, "decode_million_per_second", r->decode_rate,
                     "hole_deg", r->hole.radius_deg, "hole_how", r->hole_how, "max_error_deg", r->at_voxels.max_deg,
                     "mean_error_deg", r->at_voxels.mean_deg, "filtered_mean_error_deg", r->between[APART_15].mean_deg,
                     "filtered_max_error_deg", r->between[APART_15].max_deg, "filtered", between);
}

static void print_scheme(const iso_scheme *scheme, const scheme_result *r)
{
    printf("%-16s %2d %7.1f %7.1f  %7.4f %-7s %7.4f %7.4f ", scheme->name, (int)iso_code_describe(scheme->code)->bytes,
           r->encode_rate, r->decode_rate, r->hole.radius_deg, r->hole_how, r->at_voxels.mean_deg,
           r->at_voxels.max_deg);
    for (int i = 0; i < APART_COUNT; ++i)
        printf(" %7.3f %7.2f", r->between[i].mean_deg, r->between[i].max_deg);
    putchar('\n');
    fflush(stdout);
}

static void print_scheme_head(void)
{
    printf(
        "Millions of directions per second of one thread; errors in degrees. hole: the largest angle to the nearest\n"
        "code. At voxels, and filtered between two voxels whose directions are 5, 15, 30 and 60 degrees apart.\n\n"
        "%-16s %2s %7s %7s  %7s %-7s %7s %7s ",
        "scheme", "B", "encode", "decode", "hole", "", "mean", "max");
    for (int i = 0; i < APART_COUNT; ++i)
        printf("  %2g mean     max", apart_deg[i]);
    putchar('\n');
}

/* Every code with its own encoder, then other encoders of the same codes. */
static const iso_scheme more_schemes[] = {
    {"fit exact", ISO_CODE_FIT, iso_encode_fit_exact, NULL},
    {"region48 exact", ISO_CODE_REGION48, iso_encode_region48_exact, NULL},
};

static const size_t table_sizes[] = {32, 64, 128}; /* the paper's */
enum {
    MORE_COUNT = sizeof more_schemes / sizeof more_schemes[0],
    TABLE_COUNT = sizeof table_sizes / sizeof table_sizes[0],
    SCHEME_MAX = ISO_CODE_COUNT + MORE_COUNT + TABLE_COUNT
};

static iso_status bench_schemes(size_t count, bool text, const iso_paper_table tables[], json_t *root, iso_error *err)
{
    static const char *const table_names[] = {"region48 T 32", "region48 T 64", "region48 T 128"};
    iso_scheme schemes[SCHEME_MAX];
    size_t n = 0;
    for (int c = 0; c < ISO_CODE_COUNT; ++c)
        schemes[n++] = (iso_scheme){iso_code_describe((iso_code)c)->name, (iso_code)c, NULL, NULL};
    for (int i = 0; i < MORE_COUNT; ++i)
        schemes[n++] = more_schemes[i];
    for (int i = 0; i < TABLE_COUNT; ++i)
        schemes[n++] = (iso_scheme){table_names[i], ISO_CODE_REGION48, NULL, &tables[i]};

    FREED timing_buffers *b = malloc(sizeof *b);
    NEED_MEMORY(b, err, "no memory for %d directions", (int)TIMED);
    random_directions(b->directions, TIMED);
    json_t *list = json_array();
    json_object_set_new(root, "schemes", list);
    if (text)
        print_scheme_head();
    for (size_t i = 0; i < n; ++i) {
        scheme_result r;
        NEED(measure_scheme(&schemes[i], i < ISO_CODE_COUNT ? count : count / 4, b, &r, err));
        json_array_append_new(list, scheme_to_json(&schemes[i], &r));
        if (text)
            print_scheme(&schemes[i], &r);
    }
    return ISO_OK;
}

/* ---- Table 3: generating the tables of T ---- */

static iso_status bench_tables(bool text, iso_paper_table tables[], json_t *root, iso_error *err)
{
    static const double paper_seconds[] = {0.55, 1.59, 6.17};
    json_t *list = json_array();
    json_object_set_new(root, "table3", list);
    if (text)
        printf("Table 3: seconds to compute the table of T (paper)\n");
    for (int i = 0; i < TABLE_COUNT; ++i) {
        double start = thread_seconds();
        NEED(iso_paper_table_create(table_sizes[i], &tables[i], err));
        double seconds = thread_seconds() - start;
        json_array_append_new(list, json_pack("{s:i, s:f, s:f}", "size", (int)table_sizes[i], "seconds", seconds,
                                              "paper_seconds", paper_seconds[i]));
        if (text)
            printf("  %3zu^3 %10.4f  (%.2f)\n", table_sizes[i], seconds, paper_seconds[i]);
    }
    return ISO_OK;
}

static iso_status bench(const iso_cli *cli, size_t count, const char *chart_dir, json_t *root, iso_error *err)
{
    const bool text = !cli->json;
    iso_paper_table tables[TABLE_COUNT] = {{0}};
    iso_status status = bench_tables(text, tables, root, err);
    TRY(status, iso_lab_encode_holes(text, chart_dir, root, err));
    TRY(status, iso_lab_encode_convexity(text, root, err));
    TRY(status, iso_lab_encode_stiffness(text, count / 4, root, err));
    TRY(status, iso_lab_encode_coherence(text, count, root, err));
    TRY(status, bench_schemes(count, text, tables, root, err));
    for (int i = 0; i < TABLE_COUNT; ++i)
        iso_paper_table_destroy(&tables[i]);
    return status;
}

typedef struct encode_options {
    int count, levels;
    char *chart_dir;
    iso_cli_look asked;
    iso_volume_input input;
} encode_options;

static const iso_option options[] = {
    {"count", 0, "average N random probes", "N", ISO_IN(encode_options, count), .flags = ISO_SHOWN, .least = 100,
     .most = 1e8},
    {"chart", 0, "draw Figure 10 into this existing folder", "DIR", ISO_IN(encode_options, chart_dir)},
    ISO_OPTIONS_OF(encode_options, asked, iso_look_rows),
    {"levels", 0, "use N levels of the volumes, counting the finest", "N", ISO_IN(encode_options, levels),
     .flags = ISO_SHOWN, .least = 1, .most = 8},
    ISO_OPTIONS_OF(encode_options, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    const encode_options *o = values;
    iso_subject_look look;
    iso_status status = iso_cli_look_check(&o->asked, cli->threads, &look, err);
    if (status == ISO_OK && o->chart_dir && !iso_path_exists(o->chart_dir)) /* fails before the work */
        status = iso_fail(err, ISO_E_IO, "%s: folder does not exist; create it first", o->chart_dir);
    if (status != ISO_OK)
        return status;
    json_t *root = iso_cli_json(cli);
    json_object_set_new(json_object_get(root, "options"), "count", json_integer(o->count));
    const iso_image_bench images = {&o->input, &look, (size_t)o->levels};
    status = cli->argument_count > 0 ? iso_lab_encode_images(cli, &images, root, err)
                                     : bench(cli, (size_t)o->count, o->chart_dir, root, err);
    if (status == ISO_OK && cli->json)
        iso_cli_print_json(root);
    else
        json_decref(root);
    return status;
}

const iso_command iso_lab_encode = {
    .name = "encode",
    .summary = "direction codes: speed, holes, errors at voxels and between them",
    .max_arguments = 64,
    .usage = "[options] [VOLUME... [--scene SCENE.scene.json]]",
    .details =
        "Holes marked as such are exact to 1e-5 degrees. Largest errors are found by climbing from random probes,\n"
        "and are attained. Rates count the time of one thread only. With volumes, it measures each code's error in\n"
        "their images instead.",
    .examples = "  isoshade-lab encode --count 20000\n"
                "  isoshade-lab encode --json\n"
                "  isoshade make marschner-lobb --size 32 -o small.nrrd\n"
                "  isoshade-lab encode small.nrrd --scene refscenes/marschner-lobb.scene.json --size 48\n",
    ISO_COMMAND_OPTIONS(encode_options, options, .count = 100000, .levels = 3),
    .run = run,
};
