/* bench_consistency.c - does a coarse level look like level 0? The original TF
 * against adapted ones, over views from an icosahedron's faces.
 *
 * Paper: adaptive-tf-2016 sec. 5, Figures 8 and 9 (SSIM dissimilarity over 20
 * views); FLIP stands beside it. Four TFs, fixed as fractions of a volume's
 * range, the same for every volume: nothing is fitted to one. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "cli/bench.h"
#include "cli/bench_shading.h"
#include "cli/input.h"
#include "cli/subject.h"
#include "cli/views.h"
#include "compare/metrics.h"
#include "render/raycaster.h"
#include "tf/adapt.h"

enum { MAX_VIEWS = ISO_FACE_VIEWS, MAX_LEVELS = 8 };

typedef struct bench_tf {
    const char *name;
    size_t point_count;
    iso_tf_point points[9];
} bench_tf;

/* Opacities are for one level-0 voxel. */
static const bench_tf tfs[] = {
    {"surface", 4, {{0, {0.9, 0.7, 0.4}, 0}, {0.3, {0.9, 0.7, 0.4}, 0}, {0.4, {1, 0.9, 0.8}, 0.8}, {1, {1, 0.9, 0.8}, 0.8}}},
    {"soft", 4, {{0, {0.1, 0.2, 0.6}, 0}, {0.1, {0.1, 0.3, 0.7}, 0}, {0.5, {0.8, 0.6, 0.2}, 0.05}, {1, {1, 0.9, 0.6}, 0.2}}},
    {"two-material", 7, {{0, {0.7, 0.2, 0.1}, 0}, {0.15, {0.7, 0.2, 0.1}, 0}, {0.22, {0.7, 0.2, 0.1}, 0.06}, {0.38, {0.7, 0.2, 0.1}, 0.06},
                         {0.45, {0.2, 0.5, 0.9}, 0}, {0.55, {0.2, 0.6, 0.9}, 0.6}, {1, {0.3, 0.7, 1}, 0.6}}},
    {"shell", 5, {{0, {0.2, 0.8, 0.5}, 0}, {0.4, {0.2, 0.8, 0.5}, 0}, {0.45, {0.3, 0.9, 0.5}, 0.5}, {0.5, {0.8, 0.8, 0.2}, 0}, {1, {0.8, 0.8, 0.2}, 0}}},
};
enum { TF_COUNT = sizeof tfs / sizeof *tfs };

typedef struct bench_method {
    const char *name;
    bool adapt;
    iso_adapt_options options;
    iso_joint_split classes; /* a table over value and class, or 0 */
} bench_method;

static const bench_method all_methods[] = {
    {"original", false, {.bits = 8}, 0},
    {"paper", true, {.weight = ISO_WEIGHT_GAUSS, .average = ISO_AVERAGE_RGBA, .bits = 8}, 0},
    {"paper-constant", true, {.weight = ISO_WEIGHT_FLAT, .window = 2.5, .average = ISO_AVERAGE_RGBA, .bits = 8}, 0},
    {"opacity-gauss", true, {.weight = ISO_WEIGHT_GAUSS, .average = ISO_AVERAGE_OPACITY, .bits = 8}, 0},
    {"opacity-flat", true, {.weight = ISO_WEIGHT_FLAT, .average = ISO_AVERAGE_OPACITY, .bits = 8}, 0},
    {"extinction-flat", true, {.weight = ISO_WEIGHT_FLAT, .average = ISO_AVERAGE_EXTINCTION, .bits = 8}, 0},
    {"transmittance-flat", true, {.weight = ISO_WEIGHT_FLAT, .average = ISO_AVERAGE_TRANSMITTANCE, .bits = 8}, 0},
    {"default", true, {.weight = ISO_WEIGHT_FLAT, .average = ISO_AVERAGE_OPACITY, .bits = 8, .fall_back = true}, 0},
    {"classes", true, {.weight = ISO_WEIGHT_FLAT, .average = ISO_AVERAGE_OPACITY, .bits = 8}, ISO_SPLIT_DEVIATION},
    {"gradient-classes", true, {.weight = ISO_WEIGHT_FLAT, .average = ISO_AVERAGE_OPACITY, .bits = 8}, ISO_SPLIT_GRADIENT},
};
enum { METHOD_COUNT = sizeof all_methods / sizeof *all_methods };

typedef struct case_result {
    double ssim_dissimilarity, flip, rmse;
    iso_adapt_judgement judgement;
} case_result;

typedef struct bench_run {
    const iso_cli *cli;
    iso_cli_input input;
    int views, size, levels, shaded;
    double step_voxels;
    bool wanted[METHOD_COUNT];
    iso_gl *gl;
    json_t *cases;
    /* sums of the logarithms of error / error of the original, of METHOD_COUNT methods; FLIP, SSIM and RMSE */
    double log_ratio[METHOD_COUNT][3];
    size_t case_count, worse[METHOD_COUNT];
    double worst[METHOD_COUNT]; /* largest SSIM dissimilarity above the original's */
} bench_run;

static iso_status make_view(const bench_run *run, const iso_pyramid *p, const iso_tf *tf, int i, iso_view *view, iso_error *err)
{
    iso_vec3 direction = iso_view_of_faces(i, run->views);
    const iso_level *level0 = &p->levels[0];
    const iso_scene scene = {.path = "bench", .width = (size_t)run->size, .height = (size_t)run->size, .camera_fit = true,
                             .orthographic = true, .camera_direction = direction,
                             .camera_up = iso_view_up(direction), .margin = 1,
                             .light_count = 1, .lights = {{.direction = {0.3, 0.5, 0.8}, .in_camera_space = true, .intensity = 1}},
                             .shading = {.ambient = run->shaded ? 0.3 : 1, .diffuse = run->shaded ? 0.7 : 0, .power = 1},
                             .step_voxels = run->step_voxels, .tf = *tf};
    return iso_scene_resolve(&scene, &level0->geometry, level0->min, level0->max, view, err);
}

static iso_status render(const bench_run *run, const iso_pyramid *p, size_t level, iso_view *view, const iso_tf_table *table,
                         iso_class_tables *classes, iso_image *image, iso_error *err)
{
    iso_gl_options opt = iso_gl_defaults();
    iso_tf_table own = view->tf;
    view->tf = *table;
    view->classes = classes; /* lent */
    iso_status status = iso_gl_render(run->gl, &p->levels[level], p->options.code, view, &opt, image, NULL, err);
    view->tf = own;
    view->classes = NULL;
    return status;
}

/* All views of one level with one table. */
static iso_status measure(const bench_run *run, const iso_pyramid *p, size_t level, iso_view *views, const iso_image *finest,
                          const iso_tf_table *table, iso_class_tables *classes, case_result *r, iso_error *err)
{
    iso_status status = ISO_OK;
    for (int i = 0; i < run->views && status == ISO_OK; ++i) {
        iso_image image;
        iso_metrics m;
        status = render(run, p, level, &views[i], table, classes, &image, err);
        if (status != ISO_OK)
            break;
        status = iso_metrics_measure(&finest[i], &image, &m, err);
        r->ssim_dissimilarity += (1 - m.ssim) / run->views;
        r->flip += m.flip_mean / run->views;
        r->rmse += m.rmse / run->views;
        iso_image_destroy(&image);
    }
    return status;
}

static void note_case(bench_run *run, const char *volume, const char *tf, size_t level, const case_result results[METHOD_COUNT])
{
    ++run->case_count;
    for (int m = 0; m < METHOD_COUNT; ++m) {
        if (!run->wanted[m])
            continue;
        const case_result *r = &results[m], *o = &results[0];
        const double floor_error = 1e-6; /* both perfect: a ratio of 1 */
        run->log_ratio[m][0] += log((r->ssim_dissimilarity + floor_error) / (o->ssim_dissimilarity + floor_error));
        run->log_ratio[m][1] += log((r->flip + floor_error) / (o->flip + floor_error));
        run->log_ratio[m][2] += log((r->rmse + floor_error) / (o->rmse + floor_error));
        double above = r->ssim_dissimilarity - o->ssim_dissimilarity;
        run->worse[m] += above > 0.005;
        run->worst[m] = fmax(run->worst[m], above);
        json_array_append_new(run->cases, json_pack("{s:s, s:s, s:i, s:s, s:f, s:f, s:f, s:f, s:f, s:b}", "volume", volume, "tf", tf,
                                                    "level", (int)level, "method", all_methods[m].name, "ssim_dissimilarity",
                                                    r->ssim_dissimilarity, "flip_mean", r->flip, "rmse", r->rmse, "rms_voxels_original",
                                                    r->judgement.rms_original, "rms_voxels_adapted", r->judgement.rms_adapted,
                                                    "fell_back", r->judgement.use_original));
        if (!run->cli->json)
            printf("%-16s %-13s %zu %-19s %8.4f %8.4f %8.4f  %8.5f %8.5f%s\n", volume, tf, level, all_methods[m].name,
                   r->ssim_dissimilarity, r->flip, r->rmse, r->judgement.rms_original, r->judgement.rms_adapted,
                   all_methods[m].options.fall_back && r->judgement.use_original ? "  original kept" : "");
    }
    fflush(stdout);
}

static iso_status run_level(bench_run *run, const char *volume, const iso_pyramid *p, size_t level, const bench_tf *tf,
                            iso_view *views, const iso_image *finest, iso_error *err)
{
    case_result results[METHOD_COUNT] = {{0}};
    iso_status status = ISO_OK;
    for (int m = 0; m < METHOD_COUNT && status == ISO_OK; ++m) {
        iso_tf_table table = {0};
        if (!run->wanted[m])
            continue;
        iso_adapt_options opt = all_methods[m].options;
        opt.threads = run->cli->threads;
        status = iso_adapt_level(p, NULL, all_methods[m].adapt ? level : 0, &views[0].tf, &opt, &table, &results[m].judgement, err);
        iso_class_tables classes = {0};
        if (status == ISO_OK && all_methods[m].classes)
            status = iso_adapt_classes(p, NULL, level, all_methods[m].classes, &views[0].tf, &opt, &classes, err);
        if (status == ISO_OK)
            status = measure(run, p, level, views, finest, &table, all_methods[m].classes ? &classes : NULL, &results[m], err);
        iso_class_tables_destroy(&classes);
        iso_tf_table_destroy(&table);
    }
    if (status == ISO_OK)
        note_case(run, volume, tf->name, level, results);
    return status;
}

static iso_status run_tf(bench_run *run, const char *volume, const iso_pyramid *p, const bench_tf *tf, iso_error *err)
{
    iso_tf own = {.point_count = tf->point_count, .points = (iso_tf_point *)tf->points, .fit_range = true, .unit_distance = 1,
                  .unit_is_voxels = true, .table_size = 256};
    iso_view views[MAX_VIEWS] = {{0}};
    iso_image finest[MAX_VIEWS] = {{0}};
    iso_status status = ISO_OK;
    for (int i = 0; i < run->views && status == ISO_OK; ++i) {
        status = make_view(run, p, &own, i, &views[i], err);
        if (status == ISO_OK)
            status = render(run, p, 0, &views[i], &views[i].tf, NULL, &finest[i], err);
    }
    for (size_t level = 1; level < p->level_count && status == ISO_OK; ++level)
        status = run_level(run, volume, p, level, tf, views, finest, err);
    for (int i = 0; i < run->views; ++i) {
        iso_view_destroy(&views[i]);
        iso_image_destroy(&finest[i]);
    }
    return status;
}

static iso_status run_volume(bench_run *run, const char *path, iso_error *err)
{
    iso_progress progress = iso_cli_progress(run->cli);
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_pyramid p;
    build.level_count = (size_t)run->levels;
    build.threads = run->cli->threads;
    iso_status status = iso_cli_load_pyramid(path, &run->input, &build, &progress, &p, err);
    for (int t = 0; t < TF_COUNT && status == ISO_OK; ++t)
        status = run_tf(run, iso_path_base(path), &p, &tfs[t], err);
    iso_pyramid_destroy(&p);
    return status;
}

static void report(bench_run *run)
{
    json_t *root = iso_cli_json(run->cli), *methods = json_array();
    json_object_update_new(json_object_get(root, "options"), json_pack("{s:i, s:i, s:i, s:b, s:f}", "views", run->views, "size", run->size,
                                                                       "levels", run->levels, "shaded", run->shaded, "step_voxels",
                                                                       run->step_voxels));
    double n = run->case_count > 0 ? (double)run->case_count : 1;
    if (!run->cli->json)
        printf("\n%zu cases; geometric means of error / error of the original TF\n%-19s %8s %8s %8s   worse by .005   worst\n",
               run->case_count, "method", "SSIM", "FLIP", "RMSE");
    for (int m = 0; m < METHOD_COUNT; ++m) {
        if (!run->wanted[m])
            continue;
        double mean[3];
        for (int i = 0; i < 3; ++i)
            mean[i] = exp(run->log_ratio[m][i] / n);
        json_array_append_new(methods, json_pack("{s:s, s:f, s:f, s:f, s:i, s:f}", "method", all_methods[m].name, "ssim_ratio", mean[0],
                                                 "flip_ratio", mean[1], "rmse_ratio", mean[2], "worse_count", (int)run->worse[m],
                                                 "worst_ssim_difference", run->worst[m]));
        if (!run->cli->json)
            printf("%-19s %8.3f %8.3f %8.3f   %13zu   %.4f\n", all_methods[m].name, mean[0], mean[1], mean[2], run->worse[m], run->worst[m]);
    }
    json_object_set_new(root, "case_count", json_integer((json_int_t)run->case_count));
    json_object_set_new(root, "methods", methods);
    json_object_set(root, "cases", run->cases);
    if (run->cli->json)
        iso_cli_print_json(root);
    else
        json_decref(root);
}

/* "all", or names separated by commas; the original always runs. */
static iso_status choose_methods(bench_run *run, const char *text, iso_error *err)
{
    run->wanted[0] = true;
    for (const char *at = text; *at;) {
        size_t length = strcspn(at, ",");
        bool known = false;
        for (int m = 0; m < METHOD_COUNT; ++m)
            if (strncmp(at, "all", length) == 0 || (strlen(all_methods[m].name) == length && strncmp(at, all_methods[m].name, length) == 0))
                run->wanted[m] = known = true;
        if (!known)
            return iso_fail(err, ISO_E_USAGE, "--methods: unknown method \"%.*s\"; paper, paper-constant, opacity-gauss, opacity-flat, "
                            "extinction-flat, transmittance-flat, default, classes, gradient-classes or all", (int)length, at);
        at += length + (at[length] == ',');
    }
    return ISO_OK;
}

static iso_status run_all(bench_run *run, const char *methods, iso_error *err)
{
    iso_status status = iso_cli_check_range("--views", run->views, 1, MAX_VIEWS, err);
    if (status == ISO_OK)
        status = iso_cli_check_range("--size", run->size, 16, 4096, err);
    if (status == ISO_OK)
        status = iso_cli_check_range("--levels", run->levels, 2, MAX_LEVELS, err);
    if (status == ISO_OK)
        status = iso_cli_check_range("--step", run->step_voxels, 0.01, 4, err);
    if (status == ISO_OK)
        status = choose_methods(run, methods, err);
    if (status == ISO_OK)
        status = iso_gl_create(&run->gl, NULL, err);
    run->cases = json_array();
    if (status == ISO_OK && !run->cli->json)
        printf("%-16s %-13s k %-19s %8s %8s %8s  voxels: original, adapted\n", "volume", "tf", "method", "1-SSIM", "FLIP", "RMSE");
    for (size_t i = 0; i < run->cli->argument_count && status == ISO_OK; ++i)
        status = run_volume(run, run->cli->arguments[i], err);
    if (status == ISO_OK)
        report(run);
    json_decref(run->cases);
    iso_gl_destroy(run->gl);
    return status;
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    bench_run b = {.views = MAX_VIEWS, .size = 160, .levels = 4, .step_voxels = 0.5};
    const char *methods = "paper,default";
    iso_cli_input_defaults(&b.input);
    struct poptOption options[] = {
        {"views", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &b.views, 0, "of an icosahedron's faces, at most 20", "N"},
        {"size", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &b.size, 0, "pixels along an edge", "N"},
        {"levels", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &b.levels, 0, "with level 0", "N"},
        {"step", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &b.step_voxels, 0, "ray step in voxels of the level", "VOXELS"},
        {"methods", 0, POPT_ARG_STRING | POPT_ARGFLAG_SHOW_DEFAULT, &methods, 0, "beside the original: names with commas, or all", "NAMES"},
        {"shaded", 0, POPT_ARG_NONE, &b.shaded, 0, "with a headlight; else emission alone", NULL},
        ISO_CLI_INPUT_OPTIONS(&b.input),
        POPT_TABLEEND,
    };
    for (int i = 1; i < argc; ++i)
        if (strcmp(argv[i], "--shading") == 0)
            return iso_bench_shading(argc, argv, err);
    iso_cli cli;
    iso_cli_next next;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, 0, 64, &next, err);
    const bool no_volume = status == ISO_OK && next == ISO_CLI_RUN && cli.argument_count == 0;
    b.cli = &cli;
    if (status == ISO_OK && next == ISO_CLI_RUN && !no_volume)
        status = run_all(&b, methods, err);
    iso_cli_end(&cli);
    return no_volume ? iso_bench_shading(argc, argv, err) : status;
}

const iso_command iso_bench_consistency = {
    .name = "bench consistency",
    .summary = "coarse levels against level 0, with the original and with adapted transfer functions",
    .usage = "VOLUME... [options], or --shading [VOLUME...] [options]",
    .details = "With --shading, or without a volume, directions are judged: isoshade bench consistency --shading --help.\n"
               "Four transfer functions, fixed as fractions of a volume's range: surface, soft, two-material, shell.\n"
               "1-SSIM, FLIP and RMSE are means over the views; the summary holds geometric means over all cases.",
    .examples = "  isoshade make shells --size 48 --type uint8 -o shells.nrrd\n"
                "  isoshade bench consistency shells.nrrd --views 3 --size 64 --levels 3\n",
    .run = run,
};
