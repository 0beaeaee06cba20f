/* SPDX-License-Identifier: MIT */
/* shading.c - is a coarse level shaded as the finest one is? Each way to make directions, over volumes and views.
 *
 * Paper: [diaz-garcia-2017] sec. 3 and 5, Figures 3 and 15. Every figure stands beside that of gradients taken on the
 * fly from the level's own scalar. */
#define _GNU_SOURCE
#include "bench/shading.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "options/input.h"
#include "bench/shading_error.h"
#include "bench/shading_method.h"
#include "scene/subject.h"
#include "tf/adapt.h"

enum { MAX_LEVELS = 8, MAX_SUBJECTS = 96 };

/* ---- ways to make directions ---- */

static const iso_shading_method methods[] = {
    {.name = "on-the-fly", .filter = ISO_DIRECTION_MOMENTS, .source = ISO_FROM_ON_THE_FLY},
    {.name = "naive", .filter = ISO_DIRECTION_NAIVE, .source = ISO_FROM_CODES},
    {.name = "eq1", .filter = ISO_DIRECTION_EQ1, .source = ISO_FROM_CODES},
    {.name = "eq1-own", .filter = ISO_DIRECTION_EQ1, .source = ISO_FROM_CODES, .radius = 1},
    {.name = "unit", .filter = ISO_DIRECTION_MOMENTS, .source = ISO_FROM_CODES, .unit = true},
    {.name = "default", .filter = ISO_DIRECTION_MOMENTS, .source = ISO_FROM_CODES},
    {.name = "flipped", .filter = ISO_DIRECTION_MOMENTS, .source = ISO_FROM_FLIPPED},
    {.name = "tensor", .filter = ISO_DIRECTION_TENSOR, .source = ISO_FROM_CODES},
    {.name = "tensor-flip", .filter = ISO_DIRECTION_TENSOR, .source = ISO_FROM_FLIPPED},
    {.name = "fly-adapted", .filter = ISO_DIRECTION_MOMENTS, .source = ISO_FROM_ON_THE_FLY, .adapted = true},
    {.name = "def-adapted", .filter = ISO_DIRECTION_MOMENTS, .source = ISO_FROM_CODES, .adapted = true},
};
enum { METHOD_COUNT = sizeof methods / sizeof *methods, ON_THE_FLY = 0, DEFAULT = 5, FIRST_ADAPTED = 9 };

/* ---- volumes ---- */

typedef enum block { BLOCK_REAL, BLOCK_ANALYTIC, BLOCK_HELD, BLOCK_COUNT } block;
static const char *const block_names[BLOCK_COUNT] = {"volumes of the set", "analytic volumes of the set", "held back"};

typedef struct subject {
    block block;
    const char *name;
    const char *path; /* of a file; else made from */
    iso_field_kind kind;
    double noise; /* standard deviation, of normal noise added to values in [0, 1] */
} subject;

static const subject analytic[] = {
    {BLOCK_ANALYTIC, "sphere", NULL, ISO_FIELD_SPHERE, 0},
    {BLOCK_ANALYTIC, "noisy-sphere", NULL, ISO_FIELD_SPHERE, 0.01},
    {BLOCK_ANALYTIC, "marschner-lobb", NULL, ISO_FIELD_MARSCHNER_LOBB, 0},
    {BLOCK_ANALYTIC, "plate", NULL, ISO_FIELD_PLATE, 0},
    {BLOCK_ANALYTIC, "shells", NULL, ISO_FIELD_SHELLS, 0},
    {BLOCK_ANALYTIC, "tubes", NULL, ISO_FIELD_TUBES, 0},
    {BLOCK_HELD, "noisy-shells", NULL, ISO_FIELD_SHELLS, 0.05},
    {BLOCK_HELD, "vessels", NULL, ISO_FIELD_VESSELS, 0},
    {BLOCK_HELD, "balls", NULL, ISO_FIELD_BALLS, 0},
};

typedef struct result {
    bool done;
    iso_shading_error error[METHOD_COUNT], floor;
    bool has_floor;
} result;

typedef struct shading_run {
    const iso_cli *cli;
    iso_volume_input input;
    int views, size, levels, analytic_size, adapted, floor, quick;
    double surface;
    char *held, *csv;
    iso_gl *gl;
    size_t subject_count;
    subject subjects[MAX_SUBJECTS];
    double surfaces[MAX_SUBJECTS]; /* where the TF put them, of the range */
    result *results;               /* [subject][level] */
} shading_run;

static result *result_of(const shading_run *run, size_t at, size_t level)
{
    return &run->results[at * MAX_LEVELS + level];
}

static iso_status load_subject(const shading_run *run, const subject *s, iso_volume *v, iso_field *field,
                               iso_error *err)
{
    if (s->path)
        return iso_volume_input_load(s->path, &run->input, v, err);
    return iso_shading_sample(s->kind, (size_t)run->analytic_size, s->noise, field, v, err);
}

/* ---- measuring ---- */

static iso_status measure_level(const shading_run *run, const iso_shading_subject *s, const iso_pyramid *p, size_t k,
                                int m, result *r, iso_error *err)
{
    iso_tf_table table = {0};
    iso_adapt_options opt = iso_adapt_defaults();
    opt.threads = run->cli->threads;
    iso_status status = ISO_OK;
    if (methods[m].adapted)
        status = iso_adapt_level(p, NULL, k, &s->views[0].tf, &opt, &table, NULL, err);
    if (status == ISO_OK)
        status = iso_shading_measure(s,
                                     &(iso_shading_shown){&p->levels[k], k, p->options.code, methods[m].source,
                                                          methods[m].adapted ? &table : NULL, 0},
                                     &r->error[m], err);
    iso_tf_table_destroy(&table);
    return status;
}

static iso_status measure_method(const shading_run *run, const iso_shading_subject *s, const iso_volume *v, size_t at,
                                 int m, iso_error *err)
{
    iso_pyramid p = {0};
    iso_status status = iso_shading_build(&methods[m], v, run->subjects[at].name, (size_t)run->levels,
                                          run->cli->threads, &p, err);
    for (size_t k = 1; k < p.level_count && status == ISO_OK; ++k)
        status = measure_level(run, s, &p, k, m, result_of(run, at, k), err);
    iso_pyramid_destroy(&p);
    return status;
}

static int wins(const shading_run *run, const result *r, int m)
{
    int count = 0;
    for (int i = 0; i < run->views; ++i)
        count += r->error[m].dssim[i] < r->error[ON_THE_FLY].dssim[i];
    return count;
}

/* What level 0's own directions would give: everywhere with --floor, else where the default lost. */
static iso_status measure_floors(const shading_run *run, const iso_shading_subject *s, const iso_pyramid *p, size_t at,
                                 iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t k = 1; k < p->level_count && status == ISO_OK; ++k) {
        result *r = result_of(run, at, k);
        r->done = true;
        r->has_floor = run->floor || wins(run, r, DEFAULT) < run->views;
        if (r->has_floor)
            status = iso_shading_floor(s, &p->levels[0], &p->levels[k], k, p->options.code, &r->floor, err);
    }
    return status;
}

static int method_end(const shading_run *run)
{
    return run->adapted ? METHOD_COUNT : FIRST_ADAPTED;
}

static void print_subject(const shading_run *run, size_t at)
{
    for (size_t k = 1; k < MAX_LEVELS && !run->cli->json; ++k) {
        const result *r = result_of(run, at, k);
        if (!r->done)
            continue;
        printf("%-26s %zu", run->subjects[at].name, k);
        for (int m = 0; m < method_end(run); ++m)
            printf(" %11.4f", r->error[m].dssim_mean);
        printf("  surface %.2f", run->surfaces[at]);
        if (r->has_floor)
            printf("  floor %.4f", r->floor.dssim_mean);
        printf("\n%-26s  ", "");
        for (int m = 0; m < method_end(run); ++m)
            printf(isfinite(r->error[m].truth_mean_deg) ? " %6.1f/%4.1f" : " %6.1f     ", r->error[m].angle_mean_deg,
                   r->error[m].truth_mean_deg);
        printf("  better: %d of %d\n", wins(run, r, DEFAULT), run->views);
    }
    fflush(stdout);
}

static iso_status run_subject(shading_run *run, size_t at, iso_error *err)
{
    const subject *u = &run->subjects[at];
    iso_volume v = {0};
    iso_field field;
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_pyramid p = {0};
    iso_shading_subject s = {0};
    const iso_shading_look look = {.view_count = run->views, .image_size = (size_t)run->size, .surface = run->surface};
    iso_progress progress = iso_cli_progress(run->cli);
    char stage[64];
    snprintf(stage, sizeof stage, "%zu of %zu: %s", at + 1, run->subject_count, u->name);
    iso_progress_report(&progress, stage, 0);
    build.level_count = (size_t)run->levels;
    build.threads = run->cli->threads;
    iso_status status = load_subject(run, u, &v, &field, err);
    if (status == ISO_OK)
        status = iso_pyramid_build(&v, u->name, &build, &p, NULL, err);
    if (status == ISO_OK)
        status = iso_shading_begin(&s, run->gl, &p.levels[0], build.code, u->path ? NULL : &field, &look, err);
    for (int m = 0; m < method_end(run) && status == ISO_OK; ++m) {
        status = measure_method(run, &s, &v, at, m, err);
        iso_progress_report(&progress, stage, (m + 1.0) / (method_end(run) + 1));
    }
    if (status == ISO_OK)
        status = measure_floors(run, &s, &p, at, err);
    run->surfaces[at] = s.surface;
    if (status == ISO_OK)
        print_subject(run, at);
    iso_progress_report(&progress, stage, 1);
    iso_shading_end(&s);
    iso_pyramid_destroy(&p);
    iso_volume_destroy(&v);
    return status;
}

/* ---- the report ---- */

typedef struct summary {
    size_t images, better, levels_better, cases;
    double ratio, angle, truth; /* geometric mean of DSSIM / that on the fly; means of angles */
    size_t truth_cases;
} summary;

static summary summarise(const shading_run *run, block b, size_t k, int m)
{
    summary s = {0};
    double log_ratio = 0;
    for (size_t at = 0; at < run->subject_count; ++at) {
        const result *r = result_of(run, at, k);
        if (run->subjects[at].block != b || !r->done)
            continue;
        const double floor_error = 1e-7; /* both perfect: a ratio of 1 */
        log_ratio += log((r->error[m].dssim_mean + floor_error) / (r->error[ON_THE_FLY].dssim_mean + floor_error));
        s.images += (size_t)run->views;
        s.better += (size_t)wins(run, r, m);
        s.levels_better += r->error[m].dssim_mean < r->error[ON_THE_FLY].dssim_mean;
        ++s.cases;
        s.angle += r->error[m].angle_mean_deg;
        s.truth_cases += isfinite(r->error[m].truth_mean_deg);
        s.truth += isfinite(r->error[m].truth_mean_deg) ? r->error[m].truth_mean_deg : 0;
    }
    s.ratio = s.cases > 0 ? exp(log_ratio / (double)s.cases) : NAN;
    s.angle /= (double)s.cases;
    s.truth /= (double)s.truth_cases;
    return s;
}

static void report_block(const shading_run *run, block b, json_t *rows)
{
    if (summarise(run, b, 1, DEFAULT).cases == 0)
        return;
    if (!run->cli->json)
        printf(
            "\n%s, levels 1 to %d: geometric mean of DSSIM / that on the fly; mean angle to G0; to the truth; better than on the\n"
            "fly of all volumes at all levels (means of the views), of all views\n",
            block_names[b], run->levels - 1);
    for (int m = 0; m < method_end(run); ++m) {
        size_t better = 0, images = 0, levels_better = 0, cases = 0;
        char ratios[128] = "", angles[128] = "", truths[128] = "";
        for (size_t k = 1; k < (size_t)run->levels; ++k) {
            const summary s = summarise(run, b, k, m);
            snprintf(ratios + strlen(ratios), sizeof ratios - strlen(ratios), " %6.3f", s.ratio);
            snprintf(angles + strlen(angles), sizeof angles - strlen(angles), " %5.1f", s.angle);
            if (isfinite(s.truth))
                snprintf(truths + strlen(truths), sizeof truths - strlen(truths), " %5.1f", s.truth);
            better += s.better;
            images += s.images;
            levels_better += s.levels_better;
            cases += s.cases;
            json_array_append_new(rows,
                                  json_pack("{s:s, s:s, s:i, s:o, s:o, s:o, s:i, s:i, s:i, s:i}", "block",
                                            block_names[b], "method", methods[m].name, "level", (int)k, "dssim_ratio",
                                            iso_json_number(s.ratio), "gradient_angle_mean_deg",
                                            iso_json_number(s.angle), "truth_angle_mean_deg", iso_json_number(s.truth),
                                            "images", (int)s.images, "images_better", (int)s.better, "volumes",
                                            (int)s.cases, "volumes_better", (int)s.levels_better));
        }
        if (!run->cli->json)
            printf("%-12s %s  | %s  | %-18s  | %zu of %zu, %zu of %zu\n", methods[m].name, ratios, angles, truths,
                   levels_better, cases, better, images);
    }
}

/* Why the default lost. Below half of its full length a direction stands for children that disagree by 45 degrees. */
static const char *cause_of(const result *r, int view)
{
    const double fly = r->error[ON_THE_FLY].dssim[view];
    if (fly >= 0.49)
        return "nothing is left of the surface at this level";
    if (r->floor.dssim[view] >= fly)
        return "the scalar: level 0's own directions are no better";
    return r->error[DEFAULT].length_mean < 0.5 ? "directions that cancel within a voxel" : "the directions";
}

static void report_exceptions(const shading_run *run, json_t *rows)
{
    size_t count = 0;
    for (size_t at = 0; at < run->subject_count; ++at)
        for (size_t k = 1; k < (size_t)run->levels; ++k) {
            const result *r = result_of(run, at, k);
            for (int i = 0; r->done && i < run->views; ++i) {
                const double fly = r->error[ON_THE_FLY].dssim[i], own = r->error[DEFAULT].dssim[i],
                             least = r->floor.dssim[i];
                if (own < fly)
                    continue;
                const char *cause = cause_of(r, i);
                if (!run->cli->json)
                    printf("%s%s, level %zu, view %d: %.5f, on the fly %.5f, floor %.5f, mean length %.2f: %s\n",
                           count++ ? "" : "\nnot better than on the fly:\n", run->subjects[at].name, k, i, own, fly,
                           least, r->error[DEFAULT].length_mean, cause);
                json_array_append_new(rows,
                                      json_pack("{s:s, s:i, s:o, s:i, s:f, s:f, s:f, s:s}", "volume",
                                                run->subjects[at].name, "level", (int)k, "length_mean",
                                                iso_json_number(r->error[DEFAULT].length_mean), "view", i, "dssim", own,
                                                "dssim_on_the_fly", fly, "dssim_floor", least, "cause", cause));
            }
        }
}

static json_t *cases_to_json(const shading_run *run)
{
    json_t *cases = json_array();
    for (size_t at = 0; at < run->subject_count; ++at)
        for (size_t k = 1; k < (size_t)run->levels; ++k)
            for (int m = 0; m < method_end(run) && result_of(run, at, k)->done; ++m) {
                const iso_shading_error *e = &result_of(run, at, k)->error[m];
                json_array_append_new(cases, json_pack("{s:s, s:f, s:s, s:i, s:s, s:f, s:o, s:o, s:o, s:o}", "volume",
                                                       run->subjects[at].name, "surface", run->surfaces[at], "block",
                                                       block_names[run->subjects[at].block], "level", (int)k, "method",
                                                       methods[m].name, "dssim_mean", e->dssim_mean, "dssim",
                                                       iso_json_numbers(e->dssim, (size_t)run->views),
                                                       "gradient_angle_mean_deg", iso_json_number(e->angle_mean_deg),
                                                       "gradient_angle_p95_deg", iso_json_number(e->angle_p95_deg),
                                                       "truth_angle_mean_deg", iso_json_number(e->truth_mean_deg)));
            }
    return cases;
}

static iso_status write_csv(const shading_run *run, iso_error *err)
{
    char *text = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size);
    if (!memory)
        return iso_fail(err, ISO_E_MEMORY, "no memory for the table");
    fprintf(memory,
            "block,volume,level,method,dssim_mean,gradient_angle_mean_deg,gradient_angle_p95_deg,truth_angle_mean_deg");
    for (int i = 0; i < run->views; ++i)
        fprintf(memory, ",dssim_%d", i);
    for (size_t at = 0; at < run->subject_count; ++at)
        for (size_t k = 1; k < (size_t)run->levels; ++k)
            for (int m = 0; m < method_end(run) && result_of(run, at, k)->done; ++m) {
                const iso_shading_error *e = &result_of(run, at, k)->error[m];
                fprintf(memory, "\n%s,%s,%zu,%s,%.6f,%.3f,%.3f,%.3f", block_names[run->subjects[at].block],
                        run->subjects[at].name, k, methods[m].name, e->dssim_mean, e->angle_mean_deg, e->angle_p95_deg,
                        e->truth_mean_deg);
                for (int i = 0; i < run->views; ++i)
                    fprintf(memory, ",%.6f", e->dssim[i]);
            }
    fputc('\n', memory);
    fclose(memory);
    iso_status status = iso_file_write(run->csv, text, size, err);
    free(text);
    return status;
}

static void report(const shading_run *run)
{
    json_t *root = iso_cli_json(run->cli), *summaries = json_array(), *exceptions = json_array();
    json_object_update_new(json_object_get(root, "options"),
                           json_pack("{s:i, s:i, s:i, s:i}", "views", run->views, "size", run->size, "levels",
                                     run->levels, "analytic_size", run->analytic_size));
    for (int b = 0; b < BLOCK_COUNT; ++b)
        report_block(run, (block)b, summaries);
    report_exceptions(run, exceptions);
    json_object_set_new(root, "summary", summaries);
    json_object_set_new(root, "exceptions", exceptions);
    json_object_set_new(root, "cases", cases_to_json(run));
    if (run->cli->json)
        iso_cli_print_json(root);
    else
        json_decref(root);
}

/* ---- the command ---- */

static void add_file(shading_run *run, block b, const char *path)
{
    if (run->subject_count < MAX_SUBJECTS)
        run->subjects[run->subject_count++] = (subject){.block = b, .name = iso_path_base(path), .path = path};
}

/* Files named, files held back (commas between them, cut here), analytic fields. */
static void list_subjects(shading_run *run)
{
    for (size_t i = 0; i < run->cli->argument_count; ++i)
        add_file(run, BLOCK_REAL, run->cli->arguments[i]);
    for (size_t i = 0; i < sizeof analytic / sizeof *analytic; ++i)
        run->subjects[run->subject_count++] = analytic[i];
    for (char *at = run->held; at && *at;) {
        char *comma = strchr(at, ',');
        if (comma)
            *comma = 0;
        if (*at)
            add_file(run, BLOCK_HELD, at);
        at = comma ? comma + 1 : NULL;
    }
}

static iso_status run_all(shading_run *run, iso_error *err)
{
    if (run->quick) {
        run->views = run->views < 2 ? run->views : 2;
        run->size = run->size < 96 ? run->size : 96;
        run->analytic_size = run->analytic_size < 48 ? run->analytic_size : 48;
    }
    iso_status status = iso_words_check_range("--views", run->views, 1, ISO_DIAGONAL_VIEWS, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--size", run->size, 16, 4096, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--levels", run->levels, 2, MAX_LEVELS, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--analytic", run->analytic_size, 16, 512, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--surface", run->surface, 0, 1, err);
    list_subjects(run);
    run->results = calloc(run->subject_count * MAX_LEVELS, sizeof *run->results);
    if (status == ISO_OK && !run->results)
        status = iso_fail(err, ISO_E_MEMORY, "no memory for %zu volumes' results", run->subject_count);
    if (status == ISO_OK)
        status = iso_gl_create(&run->gl, NULL, err);
    if (status == ISO_OK && !run->cli->json) {
        printf(
            "DSSIM; below it angles to G0 and to the truth, degrees; how many images the default has better than on the fly\n%-26s k",
            "volume");
        for (int m = 0; m < method_end(run); ++m)
            printf(" %11s", methods[m].name);
        printf("\n");
    }
    for (size_t at = 0; at < run->subject_count && status == ISO_OK; ++at)
        status = run_subject(run, at, err);
    if (status == ISO_OK && run->csv)
        status = write_csv(run, err);
    if (status == ISO_OK)
        report(run);
    free(run->results);
    iso_gl_destroy(run->gl);
    return status;
}

static const iso_command command = {
    .name = "bench consistency",
    .summary = "shading at coarse levels against level 0, with each kind of directions",
    .max_arguments = 64,
    .usage = "--shading [VOLUME...] [options]",
    .details =
        "One surface-like transfer function, the same at all levels and for all volumes. Errors are DSSIM over what either image\n"
        "shows, against level 0 with its own directions. Beside the volumes named, six analytic ones stand; three more, and\n"
        "those of --held, are held back: nothing was chosen by them.",
    .examples = "  isoshade make shells --size 48 --type uint8 -o shells.nrrd\n"
                "  isoshade bench consistency --shading shells.nrrd --quick --levels 3\n",
};

iso_status iso_bench_shading(int argc, const char **argv, iso_error *err)
{
    shading_run run = {.views = ISO_DIAGONAL_VIEWS, .size = 160, .levels = 4, .analytic_size = 96};
    int shading = 1;
    iso_volume_input_defaults(&run.input);
    struct poptOption options[] = {
        {"shading", 0, POPT_ARG_NONE, &shading, 0, "directions (this); implied where no volume is named", NULL},
        {"held", 0, POPT_ARG_STRING, &run.held, 0, "volumes that stand in a block of their own", "FILE,FILE"},
        {"views", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &run.views, 0,
         "along an icosahedron's diagonals, at most 6", "N"},
        {"size", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &run.size, 0, "pixels along an edge", "N"},
        {"levels", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &run.levels, 0, "with level 0", "N"},
        {"surface", 0, POPT_ARG_DOUBLE, &run.surface, 0,
         "a fraction of the range; else between each volume's two classes [otsu-1979]", "FRACTION"},
        {"analytic", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &run.analytic_size, 0,
         "voxels along an edge of the analytic volumes", "N"},
        {"adapted", 0, POPT_ARG_NONE, &run.adapted, 0, "also with each level's own transfer function", NULL},
        {"floor", 0, POPT_ARG_NONE, &run.floor, 0,
         "also with level 0's directions at every level; else only where the default lost", NULL},
        {"quick", 0, POPT_ARG_NONE, &run.quick, 0, "two views of 96 pixels, analytic volumes of 48^3", NULL},
        {"csv", 0, POPT_ARG_STRING, &run.csv, 0, "all figures as a table", "FILE"},
        ISO_CLI_INPUT_OPTIONS(&run.input),
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    iso_status status = iso_cli_parse(&cli, &command, argc, argv, options, &next, err);
    run.cli = &cli;
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = run_all(&run, err);
    iso_cli_end(&cli);
    free(run.held);
    free(run.csv);
    return status;
}
