/* cmd_plan.c - the least model that a scene needs, verified by rendering. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "cli/cli.h"
#include "cli/subject.h"
#include "compare/metrics.h"
#include "render/bricks_gl.h"
#include "render/plan.h"

typedef struct plan_arguments {
    iso_cli_input input;
    char *scene, *output, *image, *full_image, *size, *faces;
    double error, memory;
    int brick, levels;
} plan_arguments;

/* A plan with what it renders to. */
typedef struct trial {
    double predicted_rmse;
    iso_metrics measured;
    iso_gl_brick_stats stats;
    uint8_t *levels; /* owned */
    iso_image image;
} trial;

typedef struct planner {
    iso_gl *gl;
    const iso_node_levels *nodes;
    const iso_view *view;
    iso_brick_faces faces;
    iso_plan plan;
    uint8_t *wanted; /* bricks inside the view */
    iso_image full;
    iso_gl_brick_stats full_stats;
    trial best;
    int render_count;
} planner;

/* Scalar in 16 bits and a direction of three or four times 16: what bricks_gl.h's cache holds a node. */
enum { BYTES_A_NODE = 10 };

static double bytes_of(const iso_gl_brick_stats *s) { return BYTES_A_NODE * (double)s->node_count; }

static iso_status render_levels(planner *p, const uint8_t *levels, bool everything, iso_image *image,
                                iso_gl_brick_stats *stats, iso_error *err)
{
    const iso_brick_field field = {.nodes = p->nodes, .levels = levels, .faces = p->faces};
    iso_gl_brick_options opt = iso_gl_brick_defaults();
    opt.keep_hidden = everything;
    opt.wanted = everything ? NULL : p->wanted;
    ++p->render_count;
    return iso_gl_render_bricks(p->gl, &field, p->view, &opt, image, stats, err);
}

static void drop_trial(trial *t)
{
    free(t->levels);
    iso_image_destroy(&t->image);
    *t = (trial){0};
}

/* Chooses for a predicted error, renders, measures. */
static iso_status try_rmse(planner *p, double rmse, trial *t, iso_error *err)
{
    *t = (trial){0};
    t->predicted_rmse = iso_plan_choose(&p->plan, p->nodes, rmse);
    t->levels = malloc(p->plan.brick_count);
    if (!t->levels)
        return iso_fail(err, ISO_E_MEMORY, "plan: no memory for %zu bricks", p->plan.brick_count);
    memcpy(t->levels, p->plan.levels, p->plan.brick_count);
    iso_status status = render_levels(p, t->levels, false, &t->image, &t->stats, err);
    if (status == ISO_OK)
        status = iso_metrics_measure(&t->image, &p->full, &t->measured, err);
    if (status != ISO_OK)
        drop_trial(t);
    return status;
}

/* Does it meet what is asked for? */
static bool is_good(const plan_arguments *a, const trial *t)
{
    return a->memory > 0 ? bytes_of(&t->stats) <= a->memory : t->measured.rmse <= a->error;
}

/* The largest predicted error that is still good, by bisection of its logarithm. Both the measured error and the bytes
 * follow the prediction but for small steps, so the best good trial is kept, not the last one. */
static iso_status search(planner *p, const plan_arguments *a, const iso_progress *progress, iso_error *err)
{
    enum { steps = 9 };
    double low = -8, high = 0; /* decades */
    if (a->memory <= 0) { /* the prediction is about right: start around it */
        low = log10(a->error) - 2;
        high = log10(a->error) + 2;
    }
    for (int i = 0; i < steps; ++i) {
        double middle = 0.5 * (low + high);
        trial t;
        iso_status status = try_rmse(p, pow(10, middle), &t, err);
        if (status != ISO_OK)
            return status;
        bool good = is_good(a, &t), larger = good == (a->memory <= 0);
        *(larger ? &low : &high) = middle;
        bool better = !p->best.levels || (a->memory > 0 ? t.measured.rmse < p->best.measured.rmse
                                                        : t.stats.node_count < p->best.stats.node_count);
        if (good && better) {
            drop_trial(&p->best);
            p->best = t;
        } else {
            drop_trial(&t);
        }
        iso_progress_report(progress, "verify", (double)(i + 1) / steps);
    }
    if (p->best.levels)
        return ISO_OK;
    if (a->memory > 0)
        return iso_fail(err, ISO_E_RANGE, "--memory is %g bytes; the coarsest plan needs more: allow more levels", a->memory);
    return try_rmse(p, 0, &p->best, err); /* level 0 everywhere, without what does not show */
}

static json_t *to_json(const planner *p, const plan_arguments *a)
{
    size_t by_level[ISO_BRICK_MAX_LEVELS] = {0};
    const trial *t = &p->best;
    json_t *levels = json_array(), *counts = json_array();
    for (size_t i = 0; i < p->plan.brick_count; ++i) {
        by_level[t->levels[i]] += p->plan.footprints[i] > 0 && p->plan.shown[i];
        json_array_append_new(levels, json_integer(p->plan.footprints[i] > 0 && p->plan.shown[i] ? t->levels[i] : -1));
    }
    for (size_t l = 0; l < p->plan.level_count; ++l)
        json_array_append_new(counts, json_integer((json_int_t)by_level[l]));
    return json_pack("{s:f, s:f, s:f, s:f, s:f, s:I, s:I, s:I, s:f, s:f, s:f, s:i, s:o, s:[iii], s:i, s:o}", "error",
                     a->error, "predicted_rmse", t->predicted_rmse, "measured_rmse", t->measured.rmse, "measured_max_abs",
                     t->measured.max_abs, "measured_p99_abs", t->measured.p99_abs, "brick_count",
                     (json_int_t)p->plan.brick_count, "shown_count", (json_int_t)t->stats.shown_count, "voxel_count",
                     (json_int_t)t->stats.node_count, "bytes", bytes_of(&t->stats), "full_bytes", bytes_of(&p->full_stats),
                     "bytes_part", bytes_of(&t->stats) / bytes_of(&p->full_stats), "renders", p->render_count,
                     "bricks_by_level", counts, "bricks", (int)p->nodes->count[0], (int)p->nodes->count[1],
                     (int)p->nodes->count[2], "brick_voxels", (int)p->nodes->brick_voxels, "levels", levels);
}

static iso_status report(const planner *p, const plan_arguments *a, const iso_cli *cli, iso_error *err)
{
    json_t *plan = to_json(p, a), *root = iso_cli_json(cli);
    const trial *t = &p->best;
    json_object_update(root, plan);
    json_decref(plan);
    iso_status status = a->output ? iso_json_save(a->output, root, err) : ISO_OK;
    if (status == ISO_OK && cli->json) {
        iso_cli_print_json(root);
        return ISO_OK;
    }
    json_decref(root);
    if (status == ISO_OK)
        printf("bricks   %zu of %zu shown, of %zu voxels a side\n"
               "model    %.3g of %.3g bytes (%.1f %%)\n"
               "error    RMSE %.3g predicted, %.3g measured, largest %.3g; %d renders\n",
               t->stats.shown_count, p->plan.brick_count, p->nodes->brick_voxels, bytes_of(&t->stats),
               bytes_of(&p->full_stats), 100 * bytes_of(&t->stats) / bytes_of(&p->full_stats), t->predicted_rmse,
               t->measured.rmse, t->measured.max_abs, p->render_count);
    return status;
}

static iso_status save_images(const planner *p, const plan_arguments *a, iso_error *err)
{
    iso_status status = ISO_OK;
    if (a->image)
        status = iso_path_ends_with(a->image, ".png") ? iso_image_save_png(&p->best.image, a->image, 1, err)
                                                      : iso_image_save_exr(&p->best.image, a->image, NULL, err);
    if (status == ISO_OK && a->full_image)
        status = iso_path_ends_with(a->full_image, ".png") ? iso_image_save_png(&p->full, a->full_image, 1, err)
                                                           : iso_image_save_exr(&p->full, a->full_image, NULL, err);
    return status;
}

static iso_status plan_nodes(const plan_arguments *a, const iso_cli *cli, const iso_node_levels *nodes,
                             const iso_view *view, iso_error *err)
{
    iso_progress progress = iso_cli_progress(cli);
    planner p = {.nodes = nodes, .view = view,
                 .faces = a->faces && strcmp(a->faces, "own") == 0 ? ISO_FACES_OWN : ISO_FACES_BAKED};
    iso_status status = iso_gl_create(&p.gl, NULL, err);
    if (status == ISO_OK)
        status = iso_plan_create(&p.plan, nodes, view, cli->threads, &progress, err);
    if (status == ISO_OK && !(p.wanted = malloc(p.plan.brick_count)))
        status = iso_fail(err, ISO_E_MEMORY, "plan: no memory for %zu bricks", p.plan.brick_count);
    for (size_t i = 0; status == ISO_OK && i < p.plan.brick_count; ++i)
        p.wanted[i] = p.plan.footprints[i] > 0;
    if (status == ISO_OK) /* levels are still all 0 */
        status = render_levels(&p, p.plan.levels, true, &p.full, &p.full_stats, err);
    if (status == ISO_OK)
        status = search(&p, a, &progress, err);
    if (status == ISO_OK)
        status = save_images(&p, a, err);
    if (status == ISO_OK)
        status = report(&p, a, cli, err);
    drop_trial(&p.best);
    iso_image_destroy(&p.full);
    free(p.wanted);
    iso_plan_destroy(&p.plan);
    iso_gl_destroy(p.gl);
    return status;
}

static iso_status plan(const plan_arguments *a, const iso_cli *cli, iso_error *err)
{
    iso_progress progress = iso_cli_progress(cli);
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_pyramid pyramid = {0};
    iso_node_levels nodes = {0};
    iso_view view = {0};
    build.level_count = 1;
    build.threads = cli->threads;
    iso_status status = iso_cli_check_range("--error", a->error, 1e-6, 1, err);
    if (status == ISO_OK)
        status = iso_cli_check_range("--memory", a->memory, 0, 1e15, err);
    if (status == ISO_OK)
        status = iso_cli_check_range("--levels", a->levels, 1, ISO_BRICK_MAX_LEVELS, err);
    if (status == ISO_OK && a->faces && strcmp(a->faces, "own") != 0 && strcmp(a->faces, "baked") != 0)
        status = iso_fail(err, ISO_E_USAGE, "--faces is \"%s\", wanted baked or own", a->faces);
    if (status == ISO_OK)
        status = iso_cli_load_pyramid(cli->arguments[0], &a->input, &build, &progress, &pyramid, err);
    if (status == ISO_OK)
        status = iso_cli_load_view(a->scene, &pyramid, a->size, &view, err);
    if (status == ISO_OK)
        status = iso_node_levels_create(&nodes, &pyramid.levels[0], (size_t)a->brick, (size_t)a->levels, true,
                                        cli->threads, err);
    if (status == ISO_OK) {
        iso_node_levels_round(&nodes);
        status = plan_nodes(a, cli, &nodes, &view, err);
    }
    iso_node_levels_destroy(&nodes);
    iso_view_destroy(&view);
    iso_pyramid_destroy(&pyramid);
    return status;
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    plan_arguments a = {.error = 1.0 / 255, .brick = 32, .levels = 4};
    iso_cli_input_defaults(&a.input);
    struct poptOption options[] = {
        {"scene", 0, POPT_ARG_STRING, &a.scene, 0, "camera, lights, shading and transfer function", "SCENE.scene.json"},
        {"error", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &a.error, 0, "RMSE of the image that is allowed", "E"},
        {"memory", 0, POPT_ARG_DOUBLE, &a.memory, 0, "instead: bytes that the bricks may take", "BYTES"},
        {"brick", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &a.brick, 0, "voxels a side: 16, 32 or 64", "N"},
        {"levels", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &a.levels, 0, "with level 0", "N"},
        {"faces", 0, POPT_ARG_STRING, &a.faces, 0, "baked (default), or own: with seams, for comparison", "FACES"},
        {"size", 0, POPT_ARG_STRING, &a.size, 0, "image size instead of the scene's", "WxH"},
        {"output", 'o', POPT_ARG_STRING, &a.output, 0, "the plan, with the level of each brick", "PLAN.json"},
        {"image", 0, POPT_ARG_STRING, &a.image, 0, "the plan rendered, .exr or .png", "FILE"},
        {"full-image", 0, POPT_ARG_STRING, &a.full_image, 0, "the full model rendered, .exr or .png", "FILE"},
        ISO_CLI_INPUT_OPTIONS(&a.input),
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, 1, 1, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = plan(&a, &cli, err);
    iso_cli_end(&cli);
    char *texts[] = {a.scene, a.faces, a.size, a.output, a.image, a.full_image};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i)
        free(texts[i]);
    return status;
}

const iso_command iso_command_plan = {
    .name = "plan",
    .summary = "the least model that a scene needs: bricks left out, coarse and fine, verified by rendering",
    .usage = "VOLUME|PYRAMID.iso --scene SCENE.scene.json [--error E | --memory BYTES] [options]",
    .details = "Bricks that the TF does not show or that lie outside the view are left out; each other one gets the coarsest level\n"
               "that the image allows, and all are drawn without seams. The error is predicted, then measured with OpenGL\n"
               "against all bricks at level 0.",
    .examples = "  isoshade make shells --size 70x65x60 -o shells.nrrd\n"
                "  isoshade plan shells.nrrd --scene refscenes/shells.scene.json --size 96 --brick 16 --levels 3 -o shells.plan.json\n",
    .run = run,
};
