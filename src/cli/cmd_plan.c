/* SPDX-License-Identifier: MIT */
/* cmd_plan.c - plans the smallest model that a scene needs, and verifies it by rendering. */
#include <stdio.h>
#include <string.h>

#include "base/json.h"
#include "base/parallel.h"
#include "brick/store.h"
#include "image/image.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"
#include "options/visible.h"
#include "plan/planner.h"
#include "scene/subject.h"
#include "scene/viewpoint.h"
#include "tf/presets.h"

#define NO_MEMORY (-INFINITY) /* not a valid --memory */

typedef struct plan_arguments {
    iso_volume_input input;
    iso_cli_look look;
    char *output, *image, *full_image, *faces, *update;
    char *error_text;
    double error, memory; /* memory: NO_MEMORY if not given */
    int brick, levels, views;
} plan_arguments;

/* Differences from an older plan, and the time to bake them. */
typedef struct plan_update {
    size_t changed_count, baked_count, drawn_count;
    double scratch_seconds, update_seconds;
    bool equal;
} plan_update;

typedef struct scene_views {
    iso_view *views;
    size_t count;
} scene_views;

static void scene_views_destroy(scene_views *v)
{
    iso_planner_destroy_views(v->views, v->count);
}

/* ---- update ---------------------------------------------------------------------- */

/* Bakes the older plan, then the differences of the new one, and for comparison the new one from nothing. */
static iso_status bake_both(const iso_brick_field *older, const uint8_t *older_drawn, const iso_brick_field *newer,
                            const uint8_t *drawn, int threads, plan_update *u, iso_error *err)
{
    OWNED(iso_brick_store) store = {0}, scratch = {0};
    NEED(iso_brick_store_update(&store, older, older_drawn, threads, NULL, err));
    const double start = iso_clock_seconds();
    NEED(iso_brick_store_update(&store, newer, drawn, threads, &u->baked_count, err));
    const double middle = iso_clock_seconds();
    NEED(iso_brick_store_update(&scratch, newer, drawn, threads, &u->drawn_count, err));
    u->scratch_seconds = iso_clock_seconds() - middle;
    u->update_seconds = middle - start;
    u->equal = iso_brick_store_equal(&store, &scratch, newer->nodes);
    return u->equal ? ISO_OK : iso_fail(err, ISO_E_UNTRUSTED, "plan: the updated bricks differ from a full bake");
}

static iso_status update_from(const plan_arguments *a, const iso_planner *p, int threads, plan_update *u,
                              iso_error *err)
{
    OWNED(iso_plan_file) old = {0};
    *u = (plan_update){0};
    if (!a->update)
        return ISO_OK;
    NEED(iso_plan_file_load(a->update, &old, err));
    if (old.brick_voxels != p->nodes->brick_voxels || memcmp(old.count, p->nodes->count, sizeof old.count) != 0 ||
        old.level_count > p->nodes->level_count)
        return iso_fail(err, ISO_E_RANGE, "%s: the plan has other bricks; use the same volume, --brick and --levels",
                        a->update);
    const iso_brick_field older = {p->nodes, old.levels, p->faces}, newer = {p->nodes, p->best.levels, p->faces};
    for (size_t i = 0; i < p->plan.brick_count; ++i)
        u->changed_count += old.drawn[i] != p->best.drawn[i] || old.levels[i] != p->best.levels[i];
    return bake_both(&older, old.drawn, &newer, p->best.drawn, threads, u, err);
}

/* ---- the report ------------------------------------------------------------------ */

/* True if the image is nearly as far from the full one as an empty image is. */
static bool shows_little(const iso_planner *p)
{
    return p->blank_rmse > 0 && p->best.measured.rmse > 0.5 * p->blank_rmse;
}

static void print_report(const iso_planner *p, const plan_arguments *a, const plan_update *u)
{
    const iso_plan_trial *t = &p->best;
    const double full_bytes = ISO_BYTES_A_NODE * (double)p->full_node_count;
    printf("bricks   %zu of %zu shown, of %zu voxels per side\n"
           "model    %.3g of %.3g bytes (%.1f %%)\n"
           "error    RMSE %.3g predicted, %.3g measured, largest %.3g; %zu view%s, %d renders\n",
           t->drawn_count, p->plan.brick_count, p->nodes->brick_voxels, iso_plan_trial_bytes(t), full_bytes,
           100 * iso_plan_trial_bytes(t) / full_bytes, t->predicted_rmse, t->measured.rmse, t->measured.max_abs,
           p->view_count, iso_words_plural(p->view_count), p->render_count);
    if (a->update)
        printf(
            "update   %zu bricks changed, %zu of %zu baked again, in %.2f of the time of a full bake, with the same bytes\n",
            u->changed_count, u->baked_count, u->drawn_count, u->update_seconds / u->scratch_seconds);
}

static iso_status report(const iso_planner *p, const plan_arguments *a, const plan_update *u, const iso_cli *cli,
                         iso_error *err)
{
    json_auto_t *root = iso_cli_json(cli);
    json_object_update_new(root, iso_planner_json(p, a->error));
    if (a->update)
        json_object_set_new(root, "update",
                            json_pack("{s:I, s:I, s:I, s:b}", "changed_count", (json_int_t)u->changed_count,
                                      "baked_count", (json_int_t)u->baked_count, "drawn_count",
                                      (json_int_t)u->drawn_count, "equals_from_nothing", u->equal));
    if (a->output)
        NEED(iso_json_save(a->output, root, err));
    if (shows_little(p) && !cli->quiet)
        fprintf(stderr, "isoshade plan: warning: the RMSE %.3g is near that of an empty image (%.3g); %s\n",
                p->best.measured.rmse, p->blank_rmse, a->memory == NO_MEMORY ? "lower --error" : "raise --memory");
    if (cli->json)
        iso_cli_print_json(json_incref(root));
    else
        print_report(p, a, u);
    return ISO_OK;
}

static iso_status plan_views(const plan_arguments *a, const iso_cli *cli, iso_node_levels *nodes, const iso_view *views,
                             size_t view_count, iso_error *err)
{
    iso_progress progress = iso_cli_progress(cli);
    const iso_brick_faces faces = a->faces && strcmp(a->faces, "own") == 0 ? ISO_FACES_OWN : ISO_FACES_BAKED;
    OWNED(iso_planner) p = {0};
    plan_update update;
    NEED(iso_planner_create(&p, nodes, &(iso_planner_options){views, view_count, faces, cli->threads}, &progress, err));
    NEED(iso_planner_search(&p, a->error, a->memory == NO_MEMORY ? 0 : a->memory, &progress, err));
    NEED(update_from(a, &p, cli->threads, &update, err));
    if (a->image)
        NEED(iso_image_save(&p.best.image, a->image, NULL, err));
    if (a->full_image)
        NEED(iso_image_save(&p.full[0], a->full_image, NULL, err));
    return report(&p, a, &update, cli, err);
}

static iso_status check(const plan_arguments *a, iso_error *err)
{
    NEED(iso_words_check_range("--error", a->error, 1e-6, 1, err));
    if (a->image)
        NEED(iso_image_check_name("--image", a->image, err));
    return a->full_image ? iso_image_check_name("--full-image", a->full_image, err) : ISO_OK;
}

/* Warns of the first view that shows almost nothing; other views show the same volume. */
static void warn_of_views(const iso_cli *cli, const iso_pyramid *p, const iso_view *views, size_t count)
{
    bool warned = false;
    for (size_t i = 0; i < count && !warned; ++i)
        iso_cli_warn_view(cli, p, &views[i], NULL, &warned);
}

static iso_status plan(const plan_arguments *a, const iso_cli *cli, iso_error *err)
{
    const iso_cli_stage stages[] = {{"pyramid", 1}, {"plan", 3}, {"verify", 3}};
    iso_progress progress = iso_cli_progress(cli);
    iso_cli_expect(cli, stages, sizeof stages / sizeof *stages);
    iso_pyramid_options build = iso_pyramid_defaults();
    OWNED(iso_pyramid) pyramid = {0};
    OWNED(scene_views) views = {0};
    OWNED(iso_node_levels) nodes = {0};
    iso_subject_look look;
    build.level_count = 1;
    build.threads = cli->threads;
    NEED(check(a, err));
    NEED(iso_cli_look_take(&a->look, cli->threads, &look, err));
    NEED(iso_planner_check_views(&look, err));
    NEED(iso_subject_begin_pyramid(cli->arguments[0], &a->input, &build, &progress, &pyramid, err));
    NEED(iso_planner_check_pyramid(&pyramid, cli->arguments[0], err));
    NEED(iso_planner_load_views(&look, (size_t)a->views, &pyramid, &views.views, &views.count, err));
    warn_of_views(cli, &pyramid, views.views, views.count);
    NEED(iso_node_levels_begin(&nodes, &pyramid.levels[0], (size_t)a->brick, (size_t)a->levels, cli->threads, err));
    return plan_views(a, cli, &nodes, views.views, views.count, err);
}

static const iso_option options[] = {
    ISO_OPTIONS_OF(plan_arguments, look, iso_look_rows),
    {"views", 0, "number of views per scene, turned around its up axis", "N", ISO_IN(plan_arguments, views),
     .flags = ISO_SHOWN, .least = 1, .most = 360},
    {"error", 0, "largest allowed RMSE of each image (1/255)", "1/255", ISO_IN(plan_arguments, error_text)},
    {"memory", 0, "instead of --error: limit of the bytes of all bricks", "BYTES", ISO_IN(plan_arguments, memory),
     .least = 1, .most = 1e15},
    {"brick", 0, "voxels per side of a brick, a power of two", "N", ISO_IN(plan_arguments, brick), .flags = ISO_SHOWN,
     .least = 2, .most = ISO_BRICK_MOST_VOXELS},
    {"levels", 0, "number of levels, including level 0", "N", ISO_IN(plan_arguments, levels), .flags = ISO_SHOWN,
     .least = 1, .most = ISO_BRICK_MAX_LEVELS},
    {"faces", 0, "baked (default), or own: with seams, for comparison", "baked|own", ISO_IN(plan_arguments, faces),
     .flags = ISO_ONE_OF},
    {"update", 0, "count and time the changes from this older plan", "OLD.json", ISO_IN(plan_arguments, update)},
    {"output", 'o', "plan file to write", "PLAN.json", ISO_IN(plan_arguments, output)},
    {"image", 0, "also render the plan, as .exr or .png", "FILE", ISO_IN(plan_arguments, image)},
    {"full-image", 0, "also render the full model, as .exr or .png", "FILE", ISO_IN(plan_arguments, full_image)},
    ISO_OPTIONS_OF(plan_arguments, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    plan_arguments *a = values;
    if (a->error_text)
        NEED(iso_words_parse_error("--error", a->error_text, &a->error, err));
    return plan(a, cli, err);
}

const iso_command iso_command_plan = {
    .name = "plan",
    .summary = "plan the smallest model that a scene needs: bricks omitted, coarse or fine; verify it by rendering",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "VOLUME|PYRAMID.iso [--scene SCENE.scene.json] [--error E | --memory BYTES] [options]",
    .details =
        "Bricks that are invisible in all scenes or outside all views are omitted; every other brick gets the coarsest\n"
        "level that the image allows, and all are drawn without seams. The error is predicted, then measured with OpenGL\n"
        "against all bricks at level 0. `isoshade export --plan` writes the planned volume. --scene may name several, separated\n"
        "by commas: the plan holds for all.",
    .common = "output scene tf view size error memory levels brick image threads",
    .examples =
        "  isoshade make shells --size 70x65x60 -o shells.nrrd\n"
        "  isoshade plan shells.nrrd --tf simulation --view front --size 64 --brick 16 --levels 3 -o first.plan.json\n"
        "  isoshade plan shells.nrrd --scene refscenes/shells.scene.json --size 96 --brick 16 --levels 3 -o shells.plan.json\n",
    .lists = (const iso_names *const[]){&iso_tf_preset_names, &iso_viewpoint_names, NULL},
    ISO_COMMAND_OPTIONS(plan_arguments, options, .error = 1.0 / 255, .memory = NO_MEMORY, .brick = 16, .levels = 4,
                        .views = 1),
    .run = run,
};
