/* SPDX-License-Identifier: MIT */
/* palette.c - palettes of directions: error and time of each method, on the ellipsoid and on volumes. */
#include "lab/palette.h"
#include "options/input.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "base/file.h"
#include "base/parallel.h"
#include "base/random.h"
#include "lab/lab.h"

#define ELLIPSOID_POINTS 5000

static iso_rival_options method_options(const palette_bench *b, iso_palette_rival method, size_t directions)
{
    iso_rival_options opt = iso_rival_defaults();
    opt.method = method;
    opt.fit.directions = directions;
    opt.anneal.cycles = (size_t)b->cycles;
    opt.anneal.steps = (size_t)b->steps;
    return opt;
}

/* Returns processor time: a fit has one thread, so this is its time on an idle machine. */
static double processor_seconds(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

/* Fits to `fitted_to` and measures on `set`, which may be the same. */
static iso_status fit_and_measure(const iso_direction_set *fitted_to, const iso_direction_set *set,
                                  const iso_rival_options *opt, size_t *entries, iso_palette_error *e, double *seconds,
                                  iso_error *err)
{
    OWNED(iso_palette) p = {0};
    double start = processor_seconds();
    iso_status status = iso_rival_palette_fit(fitted_to, opt, &p, err);
    *seconds = processor_seconds() - start;
    if (status != ISO_OK)
        return status;
    *entries = p.count - 1;
    status = iso_palette_measure(set, &p, e, err);
    return status;
}

static json_t *error_row(const char *method, size_t entries, const iso_palette_error *e, double seconds)
{
    return json_pack("{s:s, s:I, s:f, s:f, s:f, s:f, s:f, s:f}", "method", method, "entries", (json_int_t)entries,
                     "norm1", e->norm1, "norm2", e->norm2, "norm2_as_printed", e->norm2_printed, "rms_deg", e->rms_deg,
                     "max_deg", e->max_deg, "fit_processor_seconds", seconds);
}

/* Sizes of Table 1: 8, 9 and 10 bits; regular subdivision has its own sizes. */
static const size_t table_sizes[3] = {254, 510, 1022};
static const size_t regular_sizes[3] = {240, 960, 3840};

static const size_t *sizes_of(iso_palette_rival m)
{
    return m == ISO_RIVAL_FACES ? regular_sizes : table_sizes;
}

typedef struct fitted_sets {
    const iso_direction_set *fitted_to, *measured_on;
    size_t count;
    const char *name;
} fitted_sets;

/* Measures one line of the table: a method at its three sizes, with means over the sets. */
static iso_status table_line(const palette_bench *b, const fitted_sets *s, iso_palette_rival method, json_t *rows,
                             iso_error *err)
{
    const size_t count = s->count;
    const char *name = iso_palette_rival_name(method);
    if (!b->cli->json)
        printf("  %-10s", name);
    for (int k = 0; k < 3; ++k) {
        iso_rival_options opt = method_options(b, method, sizes_of(method)[k]);
        iso_palette_error mean = {0};
        double seconds = INFINITY;
        size_t entries = 0;
        for (size_t i = 0; i < count; ++i) {
            iso_palette_error e;
            double once;
            NEED(fit_and_measure(&s->fitted_to[i], &s->measured_on[i], &opt, &entries, &e, &once, err));
            mean.norm1 += e.norm1 / (double)count;
            mean.rms_deg += e.rms_deg / (double)count;
            mean.max_deg = fmax(mean.max_deg, e.max_deg);
            seconds = fmin(seconds, once);
        }
        mean.norm2 = sqrt(2 * mean.norm1);
        mean.norm2_printed = sqrt(0.5 * mean.norm1);
        json_t *row = error_row(name, entries, &mean, seconds);
        json_object_set_new(row, "data", json_string(s->name));
        json_array_append_new(rows, row);
        if (!b->cli->json)
            printf("  %5zu %10.5g %8.4g %8.4g %7.3f s", entries, mean.norm1, mean.norm2, mean.norm2_printed, seconds);
    }
    if (!b->cli->json) {
        printf("\n");
        fflush(stdout);
    }
    return ISO_OK;
}

static void table_head(const palette_bench *b, const char *title)
{
    if (b->cli->json)
        return;
    printf("%s\n  %-10s", title, "method");
    for (int k = 0; k < 3; ++k)
        printf("  %5s %10s %8s %8s %9s", "size", "norm 1", "norm 2", "printed", "fit");
    printf("\n");
}

static iso_status ellipsoid_sets(const palette_bench *b, bool on_surface, iso_direction_set *sets, iso_error *err)
{
    FREED float *vectors = malloc(3 * ELLIPSOID_POINTS * sizeof *vectors);
    iso_status status = vectors ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for %d gradients", ELLIPSOID_POINTS);
    for (int i = 0; i < b->seeds && status == ISO_OK; ++i) {
        iso_ellipsoid_gradients(vectors, ELLIPSOID_POINTS, on_surface, (uint64_t)i + 1);
        status = iso_direction_set_create(&sets[i], vectors, NULL, ELLIPSOID_POINTS, err);
    }
    return status;
}

iso_status iso_palette_bench_ellipsoid(const palette_bench *b, json_t *root, iso_error *err)
{
    json_t *rows = json_array();
    iso_direction_set *sets = calloc((size_t)b->seeds, sizeof *sets);
    iso_status status = sets ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "out of memory");
    for (int on_surface = 0; on_surface < 2 && status == ISO_OK; ++on_surface) {
        char title[160];
        snprintf(title, sizeof title, "\n%d gradients of x^2 + 15 y^2 + 15 z^2, points uniform %s; mean of %d samples",
                 ELLIPSOID_POINTS, on_surface ? "on the ellipsoid" : "in the ball", b->seeds);
        status = ellipsoid_sets(b, on_surface, sets, err);
        table_head(b, title);
        for (int m = 0; m < ISO_RIVAL_COUNT && status == ISO_OK; ++m)
            status = table_line(b, &(fitted_sets){sets, sets, (size_t)b->seeds, on_surface ? "surface" : "ball"},
                                (iso_palette_rival)m, rows, err);
        for (int i = 0; i < b->seeds; ++i)
            iso_direction_set_destroy(&sets[i]);
    }
    free(sets);
    json_object_set_new(root, "ellipsoid", rows);
    return status;
}

/* ---- assigning -------------------------------------------------------------------------- */

#define ASSIGN_COUNT 400000
#define ASSIGN_BLOCK 20000

/* Counts wrong entries, in every 50th direction: farther than the nearest by more than float rounding. */
static size_t count_wrong(const iso_palette *p, const float *v, const uint16_t *index)
{
    size_t wrong = 0;
    for (size_t i = 0; i < ASSIGN_COUNT; i += 50) {
        double best = -2, own = -2;
        for (size_t k = 1; k < p->count; ++k) {
            double dot = 0;
            for (size_t c = 0; c < 3; ++c)
                dot += (double)v[3 * i + c] * (double)p->xyz[3 * k + c];
            best = fmax(best, dot);
            own = k == index[i] ? dot : own;
        }
        wrong += !(own >= best - 4e-7);
    }
    return wrong;
}

/* Returns the shortest time of a block, since other load only adds to it. */
static double block_seconds(const iso_palette_lookup *lookup, const float *v, uint16_t *index)
{
    double least = INFINITY;
    for (int round = 0; round < 10; ++round)
        for (size_t i = 0; i < ASSIGN_COUNT; i += ASSIGN_BLOCK) {
            double start = iso_clock_seconds();
            iso_palette_assign(lookup, v + 3 * i, index + i, ASSIGN_BLOCK);
            least = fmin(least, iso_clock_seconds() - start);
        }
    return least;
}

/* Vectors to assign, and memory for their entries. */
typedef struct assigned {
    const char *name;
    const float *vectors;
    uint16_t *index;
} assigned;

static iso_status assign_case(const palette_bench *b, const iso_direction_set *set, const assigned *to,
                              size_t directions, json_t *rows, iso_error *err)
{
    const char *what = to->name;
    iso_rival_options opt = method_options(b, ISO_RIVAL_KMEANSPP, directions);
    OWNED(iso_palette) p = {0};
    iso_palette_lookup *lookup;
    NEED(iso_rival_palette_fit(set, &opt, &p, err));
    double start = iso_clock_seconds();
    iso_status status = iso_palette_lookup_create(&p, &lookup, err);
    double build = iso_clock_seconds() - start;
    if (status == ISO_OK) {
        double rate = 1e-6 * ASSIGN_BLOCK / block_seconds(lookup, to->vectors, to->index);
        size_t wrong = count_wrong(&p, to->vectors, to->index);
        json_array_append_new(rows, json_pack("{s:s, s:I, s:f, s:f, s:I, s:I}", "data", what, "entries",
                                              (json_int_t)directions, "million_per_second", rate, "lookup_seconds",
                                              build, "lookup_bytes", (json_int_t)iso_palette_lookup_bytes(lookup),
                                              "wrong_count", (json_int_t)wrong));
        if (!b->cli->json)
            printf("  %-10s %5zu %8.1f million per second; lookup built in %.4f s, %.2f MB; wrong: %zu of %d\n", what,
                   directions, rate, build, 1e-6 * (double)iso_palette_lookup_bytes(lookup), wrong, ASSIGN_COUNT / 50);
    }
    iso_palette_lookup_destroy(lookup);
    return status;
}

iso_status iso_palette_bench_assign(const palette_bench *b, json_t *root, iso_error *err)
{
    json_t *rows = json_array();
    float *v = malloc(3 * ASSIGN_COUNT * sizeof *v);
    uint16_t *index = malloc(ASSIGN_COUNT * sizeof *index);
    iso_direction_set set = {0};
    iso_random random = {9};
    iso_status status = v && index ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for %d directions", ASSIGN_COUNT);
    if (!b->cli->json)
        printf("\nNearest entry, exact, one thread\n");
    for (int uniform = 0; uniform < 2 && status == ISO_OK; ++uniform) {
        iso_ellipsoid_gradients(v, ASSIGN_COUNT, false, 1);
        for (size_t i = 0; uniform && i < ASSIGN_COUNT; ++i) {
            double z = 2 * iso_random_unit(&random) - 1, a = 2 * acos(-1) * iso_random_unit(&random);
            v[3 * i] = (float)(sqrt(1 - z * z) * cos(a));
            v[3 * i + 1] = (float)(sqrt(1 - z * z) * sin(a));
            v[3 * i + 2] = (float)z;
        }
        status = iso_direction_set_create(&set, v, NULL, ELLIPSOID_POINTS, err);
        for (int k = 0; k < 3 && status == ISO_OK; ++k)
            status = assign_case(b, &set, &(assigned){uniform ? "uniform" : "ellipsoid", v, index}, table_sizes[k],
                                 rows, err);
        iso_direction_set_destroy(&set);
    }
    free(v);
    free(index);
    json_object_set_new(root, "assign", rows);
    return status;
}

/* ---- volumes ------------------------------------------------------------------------------ */

iso_status iso_palette_bench_sample(const palette_bench *b, const char *path, iso_direction_set *set, double *seconds,
                                    iso_error *err)
{
    iso_gradient_options gradient = iso_gradient_defaults();
    iso_direction_pool *pool;
    iso_volume_source *source = NULL;
    double start = iso_clock_seconds();
    gradient.threads = b->cli->threads;
    NEED(iso_direction_pool_create(&pool, b->cli->threads, err));
    iso_status status = iso_volume_input_open(path, &b->input, &source, err);
    TRY(status, iso_palette_sample_source(pool, source, &gradient, NULL, NULL, err));
    TRY(status, iso_direction_pool_finish(pool, set, err));
    iso_source_close(source);
    iso_direction_pool_destroy(pool);
    *seconds = iso_clock_seconds() - start;
    return status;
}

/* Annealing assigns again at each move, so it gets the bundles of a coarser grid, as the paper pre-quantized its foot:
 * 6 * 48^2 cells of 1.9 degrees. All methods are measured on the finer bundles. */
#define ANNEAL_CELLS 48

iso_status iso_palette_bench_volume(const palette_bench *b, const char *path, json_t *rows, iso_error *err)
{
    static const iso_palette_rival methods[] = {ISO_RIVAL_KMEANS, ISO_RIVAL_KMEANSPP, ISO_RIVAL_ANNEAL, ISO_RIVAL_FACES,
                                                ISO_RIVAL_FIBONACCI};
    const char *name = iso_path_base(path);
    OWNED(iso_direction_set) set = {0}, coarse = {0};
    double seconds;
    NEED(iso_palette_bench_sample(b, path, &set, &seconds, err));
    iso_status status = iso_direction_set_coarsen(&set, ANNEAL_CELLS, &coarse, err);
    char title[256];
    snprintf(title, sizeof title, "\n%s: %zu bundles of gradients, read and pooled in %.3f s", name, set.count,
             seconds);
    table_head(b, title);
    for (size_t m = 0; m < sizeof methods / sizeof *methods && status == ISO_OK; ++m)
        status = table_line(b, &(fitted_sets){methods[m] == ISO_RIVAL_ANNEAL ? &coarse : &set, &set, 1, name},
                            methods[m], rows, err);
    json_t *first = json_array_get(rows, json_array_size(rows) - 3 * sizeof methods / sizeof *methods);
    if (status == ISO_OK && first)
        json_object_set_new(first, "read_seconds", json_real(seconds));
    return status;
}

/* ---- the benchmark ----------------------------------------------------------------------------- */

static iso_status run_parts(const palette_bench *b, json_t *root, iso_error *err)
{
    size_t count = b->cli->argument_count;
    iso_status status = ISO_OK;
    if (b->tessellation)
        return iso_palette_bench_tessellation(b, err);
    if (count == 0) {
        status = iso_palette_bench_ellipsoid(b, root, err);
        return status == ISO_OK ? iso_palette_bench_assign(b, root, err) : status;
    }
    json_t *volumes = json_array(), *images = json_array();
    for (size_t i = 0; i < count && status == ISO_OK; ++i) {
        status = iso_palette_bench_volume(b, b->cli->arguments[i], volumes, err);
        if (status == ISO_OK && !b->no_images)
            status = iso_palette_bench_images(b, b->cli->arguments[i], images, err);
    }
    json_object_set_new(root, "volumes", volumes);
    json_object_set_new(root, "images", images);
    return status;
}

static const iso_option options[] = {
    {"seeds", 0, "use N samples of the ellipsoid", "N",
     ISO_IN(palette_bench, seeds), .flags = ISO_SHOWN, .least = 1, .most = 1000},
    {"cycles", 0, "set CYCLE_NR of annealing", "N", ISO_IN(palette_bench, cycles), .flags = ISO_SHOWN, .most = 1e6},
    {"steps", 0, "set STEP_NR of annealing", "N", ISO_IN(palette_bench, steps), .flags = ISO_SHOWN, .most = 1e8},
    {"tessellation", 0, "draw only the ellipsoid's tessellation (Figure 9)", "FILE.svg",
     ISO_IN(palette_bench, tessellation)},
    {"entries", 0, "triangles of --tessellation", "N", ISO_IN(palette_bench, entries), .flags = ISO_SHOWN, .least = 1,
     .most = ISO_PALETTE_MAX},
    ISO_OPTIONS_OF(palette_bench, look, iso_look_rows),
    {"no-images", 0, "volumes: print only the table", NULL, ISO_IN(palette_bench, no_images)},
    ISO_OPTIONS_OF(palette_bench, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    palette_bench *b = values;
    b->cli = cli;
    iso_status status = iso_cli_look_check(&b->look, cli->threads, &b->shown, err);
    json_t *root = iso_cli_json(cli);
    json_object_update_new(json_object_get(root, "options"),
                           json_pack("{s:i, s:i, s:i}", "seeds", b->seeds, "cycles", b->cycles, "steps", b->steps));
    TRY(status, run_parts(b, root, err));
    if (status == ISO_OK && cli->json)
        iso_cli_print_json(root);
    else
        json_decref(root);
    return status;
}

const iso_command iso_lab_palette = {
    .name = "palette",
    .summary = "palettes of directions: error and time of each method, assigning, images",
    .max_arguments = 1000,
    .usage = "[VOLUME ...] [options]",
    .details =
        "Without a volume: the ellipsoid of [bremer-2001], and the speed of assigning. With volumes: their table,\n"
        "and images from palettes and from codes, compared with those from float directions. A fit is timed in\n"
        "processor seconds.",
    .examples = "  isoshade-lab palette --seeds 1 --steps 500\n"
                "  isoshade-lab palette --tessellation figure9.svg --entries 120 --cycles 20 --steps 100\n"
                "  isoshade make marschner-lobb --size 40x56x33 -o v.nrrd\n"
                "  isoshade-lab palette v.nrrd --steps 200 --size 64\n",
    ISO_COMMAND_OPTIONS(palette_bench, options, .cycles = 100, .steps = 10000, .seeds = 3, .entries = 510),
    .run = run,
};
