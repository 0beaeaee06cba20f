/* SPDX-License-Identifier: MIT */
/* plan.c - savings of a plan in every program: bytes, memory and load times, and the image difference it causes. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/parallel.h"
#include "blender/blender.h"
#include "brick/store.h"
#include "lab/lab.h"
#include "options/input.h"
#include "plan/planner.h"
#include "options/look.h"
#include "povray/povray.h"
#include "lab/vdb_read.h"

typedef struct plan_bench {
    iso_volume_input input;
    iso_cli_look look;
    char *cycles, *error_text;
    double error, step;
    int brick, levels;
    const iso_cli *cli;
} plan_bench;

/* Figures of one model in all programs. */
typedef struct entry {
    iso_vdb_stats vdb;
    double df3_bytes;
    iso_cycles_stats cycles;
    iso_image image;
} entry;

typedef enum model { FULL, MERGED, LEVELS, MODEL_COUNT } model;

typedef struct bench_state {
    const plan_bench *bench;
    const iso_pyramid *pyramid;
    iso_view *views; /* a single view */
    iso_planner planner;
    iso_planned planned;
    char *folder;
    entry entries[MODEL_COUNT];
    double cycles_rmse, cycles_max;
    double bake_seconds[2]; /* all bricks at level 0, and the plan's */
} bench_state;

static iso_status measure_vdbs(bench_state *s, iso_error *err)
{
    const iso_vdb_options options = iso_vdb_defaults();
    for (int m = 0; m < MODEL_COUNT; ++m) {
        FREED char *path = iso_path_join(s->folder, "model.vdb");
        OWNED(iso_planned_lattices) lattices = {0};
        if (m == FULL)
            NEED(iso_vdb_save(s->pyramid, 0, 1, path, &options, NULL, err));
        else
            NEED(iso_planned_lattices_create(&s->planned, m == MERGED, false, s->bench->cli->threads, &lattices, err));
        if (m != FULL)
            NEED(iso_vdb_save_lattices(lattices.items, lattices.count, NULL, path, &options, NULL, err));
        NEED(iso_vdb_measure(path, &s->entries[m].vdb, err));
    }
    return ISO_OK;
}

static iso_status measure_df3s(bench_state *s, iso_error *err)
{
    iso_povray_options o = iso_povray_defaults();
    OWNED(iso_planned_crop) crop = {0};
    FREED char *full = iso_path_join(s->folder, "full"), *planned = iso_path_join(s->folder, "planned");
    o.df3_bits = 16;
    o.planes = 0;
    iso_status status = iso_povray_export(s->pyramid, 0, s->views, full, &o, NULL, err);
    TRY(status, iso_planned_crop_create(&s->planned, &s->pyramid->levels[0], s->bench->cli->threads, &crop, err));
    const iso_pyramid cropped = {.options = s->pyramid->options, .level_count = 1, .levels = &crop.level};
    o.box = (const double(*)[3])crop.box;
    o.lattice = &crop.lattice;
    TRY(status, iso_povray_export(&cropped, 0, s->views, planned, &o, NULL, err));
    s->entries[FULL].df3_bytes = iso_povray_df3_bytes(full);
    s->entries[MERGED].df3_bytes = iso_povray_df3_bytes(planned);
    return status;
}

/* Renders the full grid and the plan's with Cycles. */
static iso_status measure_cycles(bench_state *s, const iso_progress *progress, iso_error *err)
{
    iso_view view = s->views[0];
    iso_blender_options o = iso_blender_defaults();
    OWNED(iso_planned_lattices) lattices = {0};
    const iso_node_levels *n = &s->planned.nodes;
    iso_metrics measured = {0};
    if (!s->bench->cycles)
        return ISO_OK;
    o.threads = s->bench->cli->threads;
    o.step_voxels = s->bench->step;
    o.stats = &s->entries[FULL].cycles;
    iso_status status = iso_subject_parse_image_size(s->bench->cycles, &view.width, &view.height, err);
    TRY(status, iso_cycles_render(s->pyramid, 0, &view, &o, &s->entries[FULL].image, progress, err));
    TRY(status, iso_planned_lattices_create(&s->planned, true, true, o.threads, &lattices, err));
    const iso_blender_plan plan = {.geometry = &n->geometry, .lattice = lattices.items};
    o.stats = &s->entries[LEVELS].cycles;
    TRY(status, iso_cycles_render_plan(&plan, &view, &o, &s->entries[LEVELS].image, progress, err));
    TRY(status, iso_metrics_measure(&s->entries[LEVELS].image, &s->entries[FULL].image, &measured, err));
    s->cycles_rmse = measured.rmse;
    s->cycles_max = measured.max_abs;
    return status;
}

/* Measures baking: all bricks at level 0, and the plan's. */
static iso_status measure_bake(bench_state *s, iso_error *err)
{
    const iso_node_levels *n = s->planner.nodes;
    size_t count = iso_brick_count(n);
    FREED uint8_t *zero = calloc(count, 1), *all = malloc(count);
    iso_status status = zero && all ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "isoshade-lab plan: out of memory");
    for (int k = 0; k < 2 && status == ISO_OK; ++k) {
        const iso_brick_field field = {.nodes = n, .levels = k ? s->planner.best.levels : zero};
        OWNED(iso_brick_store) store = {0};
        memset(all, 1, count);
        double start = iso_clock_seconds();
        status = iso_brick_store_update(&store, &field, k ? s->planner.best.drawn : all, s->bench->cli->threads, NULL,
                                        err);
        s->bake_seconds[k] = iso_clock_seconds() - start;
    }
    return status;
}

/* Writes a plan and reads it again, as a user does with two commands. */
static iso_status make_plan(bench_state *s, iso_node_levels *nodes, const iso_progress *progress, iso_error *err)
{
    const iso_planner_options opt = {s->views, 1, ISO_FACES_BAKED, s->bench->cli->threads};
    NEED(iso_planner_create(&s->planner, nodes, &opt, progress, err));
    NEED(iso_planner_search(&s->planner, s->bench->error, 0, progress, err));
    FREED char *path = iso_path_join(s->folder, "plan.json");
    json_auto_t *plan = iso_planner_json(&s->planner, s->bench->error);
    NEED(iso_json_save(path, plan, err));
    return iso_planned_create(path,
                              &(iso_planned_subject){&s->pyramid->levels[0], s->pyramid->options.code, &s->views[0].tf,
                                                     1},
                              s->bench->cli->threads, &s->planned, err);
}

/* ---- the table --------------------------------------------------------------------- */

static json_t *model_json(const bench_state *s, model m)
{
    const entry *e = &s->entries[m];
    json_t *o = json_pack("{s:I, s:I, s:I, s:f}", "vdb_bytes", (json_int_t)e->vdb.file_bytes, "vdb_active_voxels",
                          (json_int_t)e->vdb.active_voxels, "vdb_memory_bytes", (json_int_t)e->vdb.memory_bytes,
                          "vdb_read_seconds", e->vdb.read_seconds);
    if (e->df3_bytes > 0)
        json_object_set_new(o, "df3_bytes", json_real(e->df3_bytes));
    if (e->image.rgba)
        json_object_update_new(o,
                               json_pack("{s:f, s:f, s:f, s:f}", "cycles_memory_bytes", e->cycles.device_bytes,
                                         "cycles_load_seconds", e->cycles.load_seconds, "cycles_render_seconds",
                                         e->cycles.render_seconds, "cycles_peak_rss_bytes", e->cycles.peak_rss_bytes));
    return o;
}

static void print_row(const char *what, double scale, double full, double merged, double levels)
{
    const double values[3] = {full, merged, levels};
    printf("%-32s", what);
    for (int i = 0; i < 3; ++i)
        if (values[i] <= 0)
            printf(" %18s", "");
        else if (i == 0)
            printf(" %18.4g", values[i] * scale);
        else
            printf(" %9.4g (%4.1f %%)", values[i] * scale, 100 * values[i] / full);
    printf("\n");
}

static void print_table(const bench_state *s)
{
    const entry *f = &s->entries[FULL], *m = &s->entries[MERGED], *l = &s->entries[LEVELS];
    const iso_plan_trial *t = &s->planner.best;
    printf("%zu of %zu bricks of %d; RMSE %.3g predicted, %.3g measured, largest %.3g\n", t->drawn_count,
           s->planner.plan.brick_count, s->bench->brick, t->predicted_rmse, t->measured.rmse, t->measured.max_abs);
    printf("%-32s %18s %18s %18s\n", "", "full", "plan, merged", "plan, levels");
    print_row("isoshade: cache, MB", 1e-6, ISO_BYTES_A_NODE * (double)s->planner.full_node_count, 0,
              iso_plan_trial_bytes(t));
    print_row("isoshade: baking, s", 1, s->bake_seconds[0], 0, s->bake_seconds[1]);
    print_row("OpenVDB: file, MB", 1e-6, (double)f->vdb.file_bytes, (double)m->vdb.file_bytes,
              (double)l->vdb.file_bytes);
    print_row("OpenVDB: active values, million", 1e-6, (double)f->vdb.active_voxels, (double)m->vdb.active_voxels,
              (double)l->vdb.active_voxels);
    print_row("OpenVDB: memory, MB", 1e-6, (double)f->vdb.memory_bytes, (double)m->vdb.memory_bytes,
              (double)l->vdb.memory_bytes);
    print_row("OpenVDB: reading, s", 1, f->vdb.read_seconds, m->vdb.read_seconds, l->vdb.read_seconds);
    print_row("POV-Ray: DF3 files, MB", 1e-6, f->df3_bytes, m->df3_bytes, 0);
    if (!s->bench->cycles)
        return;
    print_row("Cycles: its memory, MB", 1e-6, f->cycles.device_bytes, 0, l->cycles.device_bytes);
    print_row("Cycles: process's peak, MB", 1e-6, f->cycles.peak_rss_bytes, 0, l->cycles.peak_rss_bytes);
    print_row("Cycles: loading, s", 1, f->cycles.load_seconds, 0, l->cycles.load_seconds);
    print_row("Cycles: picture, s", 1, f->cycles.render_seconds, 0, l->cycles.render_seconds);
    printf("Cycles: RMSE between them %.3g, largest difference %.3g\n", s->cycles_rmse, s->cycles_max);
}

static void report(const bench_state *s)
{
    static const char *const names[MODEL_COUNT] = {"full", "merged", "levels"};
    const iso_plan_trial *t = &s->planner.best;
    if (!s->bench->cli->json) {
        print_table(s);
        return;
    }
    json_t *root = iso_cli_json(s->bench->cli);
    const double full = ISO_BYTES_A_NODE * (double)s->planner.full_node_count;
    json_object_update_new(root, json_pack("{s:f, s:f, s:f, s:f, s:f, s:f, s:f}", "measured_rmse", t->measured.rmse,
                                           "bytes", iso_plan_trial_bytes(t), "full_bytes", full, "bytes_part",
                                           iso_plan_trial_bytes(t) / full, "full_bake_seconds", s->bake_seconds[0],
                                           "bake_seconds", s->bake_seconds[1], "peak_rss_bytes", iso_peak_rss_bytes()));
    for (int m = 0; m < MODEL_COUNT; ++m)
        json_object_set_new(root, names[m], model_json(s, (model)m));
    if (s->bench->cycles)
        json_object_update_new(root,
                               json_pack("{s:f, s:f}", "cycles_rmse", s->cycles_rmse, "cycles_max_abs", s->cycles_max));
    iso_cli_print_json(root);
}

/* ---- the command ------------------------------------------------------------------- */

static iso_status run_all(bench_state *s, iso_node_levels *nodes, iso_error *err)
{
    iso_progress progress = iso_cli_progress(s->bench->cli);
    s->folder = iso_make_temp_dir();
    iso_status status = s->folder ? ISO_OK : iso_temp_dir_fail(err);
    TRY(status, make_plan(s, nodes, &progress, err));
    TRY(status, measure_bake(s, err));
    TRY(status, measure_vdbs(s, err));
    TRY(status, measure_df3s(s, err));
    TRY(status, measure_cycles(s, &progress, err));
    if (status == ISO_OK)
        report(s);
    for (int m = 0; m < MODEL_COUNT; ++m)
        iso_image_destroy(&s->entries[m].image);
    if (s->folder)
        iso_remove_tree(s->folder);
    free(s->folder);
    iso_planned_destroy(&s->planned);
    iso_planner_destroy(&s->planner);
    return status;
}

static iso_status bench(const plan_bench *b, iso_error *err)
{
    iso_progress progress = iso_cli_progress(b->cli);
    iso_pyramid_options build = iso_pyramid_defaults();
    OWNED(iso_pyramid) pyramid = {0};
    iso_node_levels nodes = {0};
    bench_state s = {.bench = b, .pyramid = &pyramid};
    iso_subject_look look;
    size_t view_count = 0;
    build.level_count = 1;
    build.threads = b->cli->threads;
    iso_status status = iso_words_check_range("--error", b->error, 1e-6, 1, err);
    TRY(status, iso_cli_look_check(&b->look, b->cli->threads, &look, err));
    TRY(status, iso_subject_load_pyramid(b->cli->arguments[0], &b->input, &build, &progress, &pyramid, err));
    TRY(status, iso_planner_load_views(&look, 1, &pyramid, &s.views, &view_count, err));
    if (status == ISO_OK && view_count != 1)
        status = iso_fail(err, ISO_E_USAGE, "isoshade-lab plan: needs exactly one scene");
    TRY(status, iso_node_levels_create(&nodes, &pyramid.levels[0], (size_t)b->brick, (size_t)b->levels, true,
                                       b->cli->threads, err));
    TRY(status, iso_node_levels_round(&nodes, b->cli->threads, err));
    TRY(status, run_all(&s, &nodes, err));
    iso_node_levels_destroy(&nodes);
    iso_planner_destroy_views(s.views, view_count);
    return status;
}

static const iso_option options[] = {
    ISO_OPTIONS_OF(plan_bench, look, iso_look_rows),
    {"error", 0, "limit the image's RMSE (1/255)", "1/255", ISO_IN(plan_bench, error_text)},
    {"brick", 0, "use bricks of N voxels per side", "N", ISO_IN(plan_bench, brick), .flags = ISO_SHOWN},
    {"levels", 0, "use N levels, counting level 0", "N", ISO_IN(plan_bench, levels), .flags = ISO_SHOWN, .least = 1,
     .most = ISO_BRICK_MAX_LEVELS},
    {"cycles", 0, "also render both with Cycles, at this size", "WxH", ISO_IN(plan_bench, cycles)},
    {"step", 0, "set the step of Cycles, in voxels of level 0", "STEP", ISO_IN(plan_bench, step), .flags = ISO_SHOWN,
     .least = 1e-3, .most = 16},
    ISO_OPTIONS_OF(plan_bench, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    plan_bench *b = values;
    b->cli = cli;
    iso_status status = b->error_text ? iso_words_parse_error("--error", b->error_text, &b->error, err) : ISO_OK;
    return status == ISO_OK ? bench(b, err) : status;
}

const iso_command iso_lab_plan = {
    .name = "plan",
    .summary = "a plan against the full model: bytes, memory, load times in each program, image difference",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "VOLUME|PYRAMID.iso [--scene SCENE.scene.json] [options]",
    .details =
        "Compares a full level with its plan: OpenVDB as one merged grid and as one grid per level, and cropped DF3\n"
        "files. With --cycles also Blender's memory and the RMSE between its two pictures.",
    .examples = "  isoshade make shells --size 48 -o shells.nrrd\n"
                "  isoshade-lab plan shells.nrrd --scene refscenes/shells.scene.json --size 96 --levels 3\n",
    ISO_COMMAND_OPTIONS(plan_bench, options, .error = 1.0 / 255, .brick = 8, .levels = 4, .step = 0.25),
    .run = run,
};
