/* SPDX-License-Identifier: MIT */
/* consistency.c - compares coarse levels with level 0, with the original and with adapted TFs, over views from an
 * icosahedron's faces.
 *
 * Paper: [diaz-garcia-2016] sec. 5, Figures 8 and 9 (SSIM dissimilarity over 20 views); FLIP is measured as well. The
 * four TFs are fixed as fractions of a volume's range, the same for all volumes, so that none is fitted to a volume.
 * Each renderer has two blocks: the volumes by which methods were chosen, and those held back from all choices. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/random.h"
#include "lab/lab.h"
#include "lab/consistency_report.h"
#include "lab/weights_figures.h"
#include "lab/level_tfs.h"
#include "lab/look.h"
#include "lab/methods.h"
#include "lab/shading.h"
#include "lab/volumes.h"
#include "options/input.h"
#include "renderers/renderers.h"
#include "scene/subject.h"
#include "scene/views.h"
#include "compare/metrics.h"
#include "fit/extinction_scale.h"
#include "tf/adapt.h"
#include "volume/synthetic.h"
#include "renderers/external.h"
#include "cli/renderer_help.h"

enum { MAX_VIEWS = ISO_FACE_VIEWS, MAX_LEVELS = 8, HELD = 1 };

typedef struct case_result {
    double ssim_dissimilarity, flip, rmse;
    double alpha_max; /* largest alpha of the level's images, 0 if they are empty */
    iso_adapt_judgment judgment;
} case_result;

typedef struct bench_run {
    const iso_cli *cli;
    iso_volume_input input;
    int views, size, levels, level, shaded, quick, analytic_size, paper_setup;
    double step_voxels;
    char *held, *figures;
    const char *with, *tf_names, *methods;
    char *renderers_path;
    bool wanted[ISO_LAB_METHOD_COUNT], wanted_tf[ISO_LEVEL_TF_COUNT];
    bool wanted_renderer[ISO_MAX_RENDERERS];
    const iso_renderer_info *renderer; /* the current one */
    iso_renderers renderers;
    json_t *cases;
} bench_run;

static iso_status make_view(const bench_run *run, const iso_pyramid *p, const iso_tf *tf, int i, iso_view *view,
                            iso_error *err)
{
    const iso_lab_look look = {(size_t)run->size, run->shaded, run->step_voxels};
    return iso_lab_view(&look, &p->levels[0], tf, iso_view_of_faces(i, run->views), view, err);
}

/* The table, or the 2D table, that shows a level. */
typedef struct shown_by {
    const iso_tf_table *table;
    iso_tf_2d *tf_2d;          /* borrowed; or NULL */
    uint8_t *extinction_scale; /* borrowed; or NULL */
} shown_by;

/* A volume under one transfer function. */
typedef struct bench_case {
    int block;
    const char *volume;
    const iso_pyramid *pyramid;
    const iso_level_tf *tf;
    iso_view *views;
    const iso_image *finest; /* level 0, one image per view */
} bench_case;

static iso_status render(bench_run *run, const iso_pyramid *p, size_t level, iso_view *view, shown_by by,
                         iso_image *image, iso_error *err)
{
    iso_render_options opt = iso_render_defaults(run->renderer);
    iso_tf_table own = view->tf;
    iso_progress progress = {0};
    opt.quadrature = run->paper_setup ? ISO_QUADRATURE_PREINTEGRATED : opt.quadrature;
    opt.source = run->paper_setup ? ISO_FROM_ON_THE_FLY : opt.source;
    opt.step_voxels = run->step_voxels;
    opt.threads = run->cli->threads;
    view->tf = *by.table;
    view->tf_2d = by.tf_2d;
    view->extinction_scale = by.extinction_scale;
    iso_status status = iso_render_with(&(iso_render_request){&run->renderers, p, level, view, &opt, &progress}, image,
                                        NULL, err);
    view->tf = own;
    view->tf_2d = NULL;
    view->extinction_scale = NULL;
    return status;
}

/* Renders all views of one level with one table and measures them. */
static iso_status measure(bench_run *run, const bench_case *c, size_t level, shown_by by, case_result *r,
                          iso_error *err)
{
    iso_status status = ISO_OK;
    for (int i = 0; i < run->views && status == ISO_OK; ++i) {
        OWNED(iso_image) image = {0};
        iso_metrics m;
        status = render(run, c->pyramid, level, &c->views[i], by, &image, err);
        if (status != ISO_OK)
            break;
        status = iso_metrics_measure(&c->finest[i], &image, &m, err);
        r->ssim_dissimilarity += (1 - m.ssim) / run->views;
        r->flip += m.flip_mean / run->views;
        r->rmse += m.rmse / run->views;
        r->alpha_max = fmax(r->alpha_max, iso_lab_largest_alpha(&image));
    }
    return status;
}

/* Returns why a case does not count: its images are empty, or no method has an error; NULL if it counts. */
static const char *why_left_out(const bench_run *run, const bench_case *c,
                                const case_result results[ISO_LAB_METHOD_COUNT])
{
    const double nothing = 1 / 255.0, no_error = 1e-6;
    double finest = 0, shown = 0, error = 0;
    for (int i = 0; i < run->views; ++i)
        finest = fmax(finest, iso_lab_largest_alpha(&c->finest[i]));
    for (int m = 0; m < ISO_LAB_METHOD_COUNT; ++m) {
        shown = fmax(shown, results[m].alpha_max);
        error = fmax(error, fmax(results[m].ssim_dissimilarity, fmax(results[m].flip, results[m].rmse)));
    }
    if (!(finest >= nothing))
        return "level 0 shows nothing";
    if (!(shown >= nothing))
        return "the level shows nothing under any method";
    return error < no_error ? "no method has an error" : NULL;
}

static void note_case(bench_run *run, const bench_case *c, size_t level,
                      const case_result results[ISO_LAB_METHOD_COUNT])
{
    const char *why = why_left_out(run, c, results);
    for (int m = 0; m < ISO_LAB_METHOD_COUNT; ++m) {
        if (!run->wanted[m])
            continue;
        const case_result *r = &results[m];
        const char *kept = iso_lab_methods[m].options.fall_back && r->judgment.use_original ? "  original kept" : "";
        json_array_append_new(run->cases,
                              json_pack("{s:s, s:s, s:b, s:s, s:i, s:s, s:f, s:f, s:f, s:f, s:f, s:b, s:s?}",
                                        "renderer", run->renderer->name, "volume", c->volume, "held", c->block == HELD,
                                        "tf", c->tf->name, "level", (int)level, "method", iso_lab_methods[m].name,
                                        "ssim_dissimilarity", r->ssim_dissimilarity, "flip_mean", r->flip, "rmse",
                                        r->rmse, "rms_voxels_original", r->judgment.rms_original, "rms_voxels_adapted",
                                        r->judgment.rms_adapted, "fell_back", r->judgment.use_original, "left_out",
                                        why));
        if (!run->cli->json)
            printf("%-9s %-22s %-13s %zu %-19s %8.4f %8.4f %8.4f  %8.5f %8.5f%s%s%s\n", run->renderer->name, c->volume,
                   c->tf->name, level, iso_lab_methods[m].name, r->ssim_dissimilarity, r->flip, r->rmse,
                   r->judgment.rms_original, r->judgment.rms_adapted, kept, why ? "  left out: " : "", why ? why : "");
    }
    fflush(stdout);
}

static iso_status run_level(bench_run *run, const bench_case *c, size_t level, iso_error *err)
{
    const iso_pyramid *p = c->pyramid;
    const iso_view *views = c->views;
    case_result results[ISO_LAB_METHOD_COUNT] = {{0}};
    for (int m = 0; m < ISO_LAB_METHOD_COUNT; ++m) {
        OWNED(iso_tf_table) table = {0};
        if (!run->wanted[m])
            continue;
        iso_adapt_options opt = iso_lab_methods[m].options;
        opt.threads = run->cli->threads;
        NEED(iso_adapt_level(p, iso_lab_methods[m].adapt ? level : 0, &views[0].tf, &opt, &table, &results[m].judgment,
                             err));
        OWNED(iso_tf_2d) tf_2d = {0};
        if (iso_lab_methods[m].tf_2d)
            NEED(iso_adapt_tf_2d(p, level, iso_lab_methods[m].tf_2d, &views[0].tf, &opt, &tf_2d, err));
        FREED uint8_t *scale = NULL;
        if (iso_lab_methods[m].extinction_scale)
            NEED(iso_extinction_scale_level(p, level, &views[0].tf, &table, opt.threads, &scale, err));
        NEED(measure(run, c, level, (shown_by){&table, iso_lab_methods[m].tf_2d ? &tf_2d : NULL, scale}, &results[m],
                     err));
    }
    note_case(run, c, level, results);
    return ISO_OK;
}

static iso_status run_tf(bench_run *run, int block, const char *volume, const iso_pyramid *p, const iso_level_tf *tf,
                         iso_error *err)
{
    const iso_tf own = iso_level_tf_of(tf);
    iso_view views[MAX_VIEWS] = {{0}};
    iso_image finest[MAX_VIEWS] = {{0}};
    iso_status status = ISO_OK;
    for (int i = 0; i < run->views && status == ISO_OK; ++i) {
        status = make_view(run, p, &own, i, &views[i], err);
        if (status == ISO_OK)
            status = render(run, p, 0, &views[i], (shown_by){&views[i].tf, NULL, NULL}, &finest[i], err);
    }
    for (size_t level = 1; level < p->level_count && status == ISO_OK; ++level)
        if (run->level == 0 || (size_t)run->level == level)
            status = run_level(run, &(bench_case){block, volume, p, tf, views, finest}, level, err);
    for (int i = 0; i < run->views; ++i) {
        iso_view_destroy(&views[i]);
        iso_image_destroy(&finest[i]);
    }
    return status;
}

static iso_status run_pyramid(bench_run *run, int block, const char *name, const iso_pyramid *p, iso_error *err)
{
    for (size_t r = 0; r < iso_renderer_count(); ++r)
        for (int t = 0; run->wanted_renderer[r] && t < ISO_LEVEL_TF_COUNT; ++t) {
            run->renderer = iso_renderer_at(r);
            if (run->wanted_tf[t])
                NEED(run_tf(run, block, name, p, &iso_level_tfs[t], err));
        }
    return ISO_OK;
}

static iso_pyramid_options pyramid_options(const bench_run *run)
{
    iso_pyramid_options build = iso_pyramid_defaults();
    build.level_count = (size_t)(run->level > 0 ? run->level + 1 : run->levels);
    build.scalar_filter = run->paper_setup ? ISO_SCALAR_GAUSS : ISO_SCALAR_MEAN;
    build.threads = run->cli->threads;
    return build;
}

static iso_status run_volume(bench_run *run, int block, const char *path, iso_error *err)
{
    iso_progress progress = iso_cli_progress(run->cli);
    iso_pyramid_options build = pyramid_options(run);
    OWNED(iso_pyramid) p = {0};
    NEED(iso_subject_load_pyramid(path, &run->input, &build, &progress, &p, err));
    return run_pyramid(run, block, iso_path_base(path), &p, err);
}

/* Adds normal noise of a twentieth of the range: the sum of twelve numbers in [0, 1) less 6 has a deviation of 1. */
static void add_noise(iso_volume *v, uint64_t seed)
{
    iso_random random = {seed};
    uint8_t *data = v->data;
    for (size_t i = 0; i < iso_geometry_voxel_count(&v->geometry); ++i) {
        double normal = -6;
        for (int k = 0; k < 12; ++k)
            normal += iso_random_unit(&random);
        data[i] = (uint8_t)lrint(fmin(fmax((double)data[i] + 0.05 * 255 * normal, 0), 255));
    }
}

/* Measures analytic volumes with noise, in the block of volumes held back. */
static iso_status run_analytic(bench_run *run, iso_error *err)
{
    static const iso_field_kind kinds[] = {ISO_FIELD_SHELLS, ISO_FIELD_MARSCHNER_LOBB, ISO_FIELD_NOISE};
    const size_t n = (size_t)run->analytic_size;
    iso_pyramid_options build = pyramid_options(run);
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds && n > 0; ++i) {
        iso_field field = {.kind = kinds[i],
                           .seed = 1,
                           .geometry = iso_geometry_axis_aligned((size_t[]){n, n, n}, (double[]){1, 1, 1})};
        OWNED(iso_volume) v = {0};
        OWNED(iso_pyramid) p = {0};
        char name[64];
        snprintf(name, sizeof name, "%s+noise", iso_field_name(kinds[i]));
        NEED(iso_field_sample(&field, ISO_U8, &v, err));
        add_noise(&v, i + 1);
        NEED(iso_pyramid_build(&v, name, &build, &p, NULL, err));
        NEED(run_pyramid(run, HELD, name, &p, err));
    }
    return ISO_OK;
}

static void report(bench_run *run)
{
    json_t *root = iso_cli_json(run->cli), *blocks = iso_consistency_report(run->cases, !run->cli->json);
    json_object_update_new(json_object_get(root, "options"),
                           json_pack("{s:i, s:i, s:i, s:b, s:f, s:b}", "views", run->views, "size", run->size, "levels",
                                     run->levels, "shaded", run->shaded, "step_voxels", run->step_voxels, "paper_setup",
                                     run->paper_setup));
    json_object_set_new(root, "blocks", blocks);
    json_object_set(root, "cases", run->cases);
    if (run->cli->json)
        iso_cli_print_json(root);
    else
        json_decref(root);
}

static iso_status choose_tfs(bench_run *run, iso_error *err)
{
    for (const char *at = run->tf_names; *at;) {
        size_t length = strcspn(at, ",");
        bool known = false;
        for (int t = 0; t < ISO_LEVEL_TF_COUNT; ++t)
            if (strlen(iso_level_tfs[t].name) == length && strncmp(at, iso_level_tfs[t].name, length) == 0)
                run->wanted_tf[t] = known = true;
        if (!known)
            return iso_fail(err, ISO_E_USAGE, "--tfs: unknown \"%.*s\"; surface, soft, two-material or shell",
                            (int)length, at);
        at += length + (at[length] == ',');
    }
    return ISO_OK;
}

static iso_status choose_renderers(bench_run *run, iso_error *err)
{
    for (const char *at = run->with; *at;) {
        size_t length = strcspn(at, ",");
        char name[32];
        const iso_renderer_info *r;
        snprintf(name, sizeof name, "%.*s", (int)length, at);
        if (iso_renderer_from_name(name, &r, err) != ISO_OK)
            return iso_fail_in(err, ISO_E_USAGE, "--with");
        run->wanted_renderer[iso_renderer_index(r)] = true;
        at += length + (at[length] == ',');
    }
    return ISO_OK;
}

static iso_status check_options(bench_run *run, const char *methods, iso_error *err)
{
    NEED(iso_lab_check_pictures(&(iso_lab_pictures){run->views, MAX_VIEWS, run->size, run->levels, MAX_LEVELS}, err));
    if (run->analytic_size != 0)
        NEED(iso_words_check_range("--analytic", run->analytic_size, 16, 512, err));
    NEED(iso_lab_choose_methods(methods, run->wanted, err));
    NEED(choose_tfs(run, err));
    return choose_renderers(run, err);
}

static void apply_presets(bench_run *run)
{
    if (run->quick)
        run->views = 2, run->size = 96, run->analytic_size = run->analytic_size ? 48 : 0;
    if (run->paper_setup)
        run->views = MAX_VIEWS, run->step_voxels = 1, run->shaded = 1;
}

static iso_status run_all(bench_run *run, const char *methods, iso_error *err)
{
    apply_presets(run);
    iso_status status = check_options(run, methods, err);
    run->cases = json_array();
    if (status == ISO_OK && !run->cli->json)
        printf("%-9s %-22s %-13s k %-19s %8s %8s %8s  voxels: original, adapted\n", "renderer", "volume", "tf",
               "method", "1-SSIM", "FLIP", "RMSE");
    for (size_t i = 0; i < run->cli->argument_count && status == ISO_OK; ++i)
        status = run_volume(run, 0, run->cli->arguments[i], err);
    for (char *at = run->held; at && *at && status == ISO_OK;) {
        char *comma = strchr(at, ','), *next = comma ? comma + 1 : NULL;
        if (comma)
            *comma = 0;
        status = run_volume(run, HELD, at, err);
        at = next;
    }
    TRY(status, run_analytic(run, err));
    if (status == ISO_OK)
        report(run);
    if (status == ISO_OK && run->figures)
        status = iso_lab_figures(run->cases, run->figures, err);
    json_decref(run->cases);
    iso_renderers_end(&run->renderers);
    return status;
}

static const iso_option options[] = {
    {"views", 0, "use N views from an icosahedron's faces, at most 20", "N", ISO_IN(bench_run, views),
     .flags = ISO_SHOWN},
    {"size", 0, "render N x N pixels", "N", ISO_IN(bench_run, size), .flags = ISO_SHOWN},
    {"levels", 0, "use N levels, counting level 0", "N", ISO_IN(bench_run, levels), .flags = ISO_SHOWN},
    {"step", 0, "set the ray step in voxels of the level", "VOXELS", ISO_IN(bench_run, step_voxels), .flags = ISO_SHOWN,
     .least = 0.01, .most = 4},
    {"methods", 0, "compare the original with these methods, or all", "NAMES", ISO_IN(bench_run, methods),
     .flags = ISO_SHOWN},
    {"tfs", 0, "use only these transfer functions", "NAMES", ISO_IN(bench_run, tf_names), .flags = ISO_SHOWN},
    {"level", 0, "measure only this level", "K", ISO_IN(bench_run, level), .most = MAX_LEVELS - 1},
    {"with", 0, "render with some of %s, each against its own level 0", "LIST", ISO_IN(bench_run, with),
     .flags = ISO_SHOWN, ISO_NAMES_RENDERERS(0)},
    ISO_CLI_RENDERERS_OPTION(bench_run, renderers_path),
    {"held", 0, "report these volumes in a separate block", "FILE,FILE", ISO_IN(bench_run, held)},
    {"analytic", 0, "hold back shells, marschner-lobb and noise of this size, with 5 % noise", "N",
     ISO_IN(bench_run, analytic_size)},
    {"shaded", 0, "shade with a headlight (emission only)", NULL, ISO_IN(bench_run, shaded)},
    {"paper-setup", 0, "Gaussian pyramid, 20 views, pre-integration, on-the-fly gradients, one-voxel steps", NULL,
     ISO_IN(bench_run, paper_setup)},
    {"quick", 0, "use two views of 96 pixels, analytic volumes of 48^3", NULL, ISO_IN(bench_run, quick)},
    {"figures", 0, "draw Figures 8 and 9 of the paper into this folder", "DIR", ISO_IN(bench_run, figures)},
    ISO_OPTIONS_OF(bench_run, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    bench_run *b = values;
    b->cli = cli;
    if (cli->argument_count == 0 && !b->held && !b->analytic_size)
        return iso_command_run(&iso_lab_shading, cli->argc, cli->argv, err);
    const iso_status status = iso_renderers_load(b->renderers_path, err);
    return status == ISO_OK ? run_all(b, b->methods, err) : status;
}

/* Runs one of two parts, which have options of their own. */
static iso_status run_part(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    for (int i = 1; i < argc; ++i)
        if (strcmp(argv[i], "--shading") == 0)
            return iso_command_run(&iso_lab_shading, argc, argv, err);
    return iso_command_parse_and_run(self, argc, argv, err);
}

const iso_command iso_lab_consistency = {
    .name = "consistency",
    .summary = "coarse levels against level 0, with the original and with adapted transfer functions",
    .max_arguments = 64,
    .usage = "VOLUME... [options], or --shading [options]",
    .details =
        "With --shading, or without a volume, it measures directions, with options of its own (consistency --shading\n"
        "--help).\n"
        "Four transfer functions, fixed as fractions of a volume's range: surface, soft, two-material, shell.\n"
        "1-SSIM, FLIP and RMSE are means over the views. The summary has geometric means, medians and quartiles over\n"
        "all cases. Some cases are left out and counted: level 0 shows nothing, no method shows anything (no pixel\n"
        "has an alpha of 1/255), or no method has an error. Volumes of --held and --analytic form a separate block:\n"
        "no choice was made by them.",
    .examples =
        "  isoshade make shells --size 48 --type uint8 -o shells.nrrd\n"
        "  isoshade-lab consistency shells.nrrd --views 3 --size 64 --levels 3\n"
        "  isoshade-lab consistency shells.nrrd --with gl,povray --size 48 --views 1 --level 1 --tfs soft --methods default\n",
    ISO_COMMAND_OPTIONS(bench_run, options, .views = 8, .size = 128, .levels = 4, .step_voxels = 0.5, .with = "gl",
                        .tf_names = "surface,soft,two-material,shell", .methods = "paper,default"),
    .run = run,
    .run_words = run_part,
};
