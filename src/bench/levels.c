/* SPDX-License-Identifier: MIT */
/* levels.c - does a coarse level look like level 0? Each method to make and show levels, over volumes, transfer functions
 * and views, one against another.
 *
 * Level 0 with its own gradients is rendered once from each view, and so is every level by every method. Two blocks: the
 * volumes that methods were chosen by, and those that were held back from all choices. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/parallel.h"
#include "bench/bench.h"
#include "bench/level_tfs.h"
#include "bench/levels_report.h"
#include "bench/look.h"
#include "bench/surface.h"
#include "options/input.h"
#include "renderers/renderers.h"
#include "scene/subject.h"
#include "scene/views.h"

enum { MAX_VIEWS = ISO_FACE_VIEWS, MAX_LEVELS = 8, MAX_VOLUMES = 96, TF_COUNT = 5, OPAQUE = 0 };
static const char *const tf_names[TF_COUNT] = {"opaque", "shell", "soft", "two-material", "colored"};
static const iso_names tf_table = ISO_NAMES_OF_STRINGS("transfer function", tf_names);

typedef struct levels_run {
    const iso_cli *cli;
    iso_volume_input input;
    int views, size, levels, level, unshaded, quick;
    double step_voxels, budget_seconds, start_seconds;
    const char *with, *tfs, *methods, *against;
    char *held, *csv;
    bool wanted_tf[TF_COUNT];
    const iso_renderer_info *renderer;
    iso_renderers renderers;
    size_t volume_count, named_count; /* those after named_count are held back */
    const char *volumes[MAX_VOLUMES];
    size_t at; /* the volume at work */
    bool out_of_time;
    iso_level_cases cases;
} levels_run;

/* ---- pyramids: one for each pair of filters that the methods ask for ---- */

typedef struct pyramid_set {
    iso_pyramid of[ISO_SCALAR_COUNT][ISO_DIRECTION_COUNT]; /* level_count 0: not asked for */
    const iso_pyramid *first;
} pyramid_set;

/* Level 0 does not depend on the filters, so it is kept once. */
static void share_finest(const iso_pyramid *owner, iso_pyramid *p)
{
    iso_level *level = &p->levels[0];
    free(level->scalar);
    free(level->codes);
    level->scalar = owner->levels[0].scalar;
    level->codes = owner->levels[0].codes;
}

static iso_status build_one(const levels_run *run, const iso_volume *v, const iso_level_method *m, pyramid_set *set,
                            iso_error *err)
{
    iso_pyramid *p = &set->of[m->scalar][m->directions];
    if (p->level_count > 0)
        return ISO_OK;
    iso_pyramid_options build = iso_pyramid_defaults();
    build.level_count = (size_t)run->levels;
    build.scalar_filter = m->scalar;
    build.direction_filter = m->directions;
    build.threads = run->cli->threads;
    iso_status status = iso_pyramid_build(v, run->volumes[run->at], &build, p, NULL, err);
    if (status == ISO_OK && set->first)
        share_finest(set->first, p);
    else if (status == ISO_OK)
        set->first = p;
    return status;
}

static iso_status build_pyramids(const levels_run *run, pyramid_set *set, iso_error *err)
{
    iso_volume v = {0};
    iso_status status = iso_volume_input_load(run->volumes[run->at], &run->input, &v, err);
    for (size_t m = 0; m < iso_level_method_count() && status == ISO_OK; ++m)
        if (run->cases.wanted[m])
            status = build_one(run, &v, iso_level_method_at(m), set, err);
    iso_volume_destroy(&v);
    return status;
}

static void destroy_pyramids(pyramid_set *set)
{
    for (size_t s = 0; s < ISO_SCALAR_COUNT; ++s)
        for (size_t d = 0; d < ISO_DIRECTION_COUNT; ++d) {
            iso_pyramid *p = &set->of[s][d];
            if (p != set->first && p->level_count > 0) {
                p->levels[0].scalar = NULL;
                p->levels[0].codes = NULL;
            }
            iso_pyramid_destroy(p);
        }
}

/* ---- images ---- */

/* A volume under one transfer function. */
typedef struct bench_subject {
    const pyramid_set *pyramids;
    const char *tf;
    double finest_alpha;
    iso_view views[MAX_VIEWS];
    iso_image finest[MAX_VIEWS];
} bench_subject;

static iso_status render(levels_run *run, const iso_pyramid *p, size_t level, const iso_view *view,
                         iso_direction_source source, iso_image *image, iso_error *err)
{
    iso_render_options opt = iso_render_defaults(run->renderer);
    const iso_progress silent = {0};
    opt.source = source;
    opt.step_voxels = run->step_voxels;
    opt.threads = run->cli->threads;
    return iso_render_with(&(iso_render_request){&run->renderers, p, level, view, &opt, &silent}, image, NULL, err);
}

/* One view of what a method shows. */
static iso_status render_shown(levels_run *run, const iso_level_method *m, const iso_level_subject *s,
                               iso_level_shown *shown, const iso_view *view, iso_image *image, iso_error *err)
{
    iso_view own = *view; /* another table, the same view */
    iso_level levels[MAX_LEVELS];
    iso_pyramid shows = *s->pyramid;
    memcpy(levels, shows.levels, shows.level_count * sizeof *levels);
    levels[s->level] = shown->level;
    shows.levels = levels;
    own.tf = shown->tf;
    own.tf_2d = shown->has_tf_2d ? &shown->tf_2d : NULL;
    return render(run, &shows, s->level, &own, m->source, image, err);
}

/* About one voxel of the level a pixel. */
static size_t box_of(const iso_pyramid *p, size_t level, const iso_view *view)
{
    const double pixel_mm = iso_view_mm_per_pixel(view, &p->levels[0].geometry);
    const double voxel_mm = iso_geometry_min_spacing_mm(&p->levels[level].geometry);
    return pixel_mm > 0 ? (size_t)fmax(1, round(voxel_mm / pixel_mm)) : 1;
}

static void add_error(iso_level_error *sum, const iso_level_error *e, double weight)
{
    sum->dssim += weight * e->dssim;
    sum->rmse += weight * e->rmse;
    sum->flip += weight * e->flip;
}

static iso_status measure_minified(const iso_image *finest, const iso_image *image, size_t box, iso_level_error *e,
                                   iso_error *err)
{
    iso_image small_finest = {0}, small = {0};
    iso_status status = iso_image_minify(finest, box, &small_finest, err);
    if (status == ISO_OK)
        status = iso_image_minify(image, box, &small, err);
    if (status == ISO_OK)
        status = iso_level_error_measure(&small_finest, &small, e, err);
    iso_image_destroy(&small_finest);
    iso_image_destroy(&small);
    return status;
}

static iso_status measure_view(const iso_image *finest, const iso_image *image, size_t box, double weight,
                               struct iso_level_result *r, iso_error *err)
{
    iso_level_error full, minified;
    iso_status status = iso_level_error_measure(finest, image, &full, err);
    minified = full;
    if (status == ISO_OK && box > 1)
        status = measure_minified(finest, image, box, &minified, err);
    if (status != ISO_OK)
        return status;
    add_error(&r->full, &full, weight);
    add_error(&r->minified, &minified, weight);
    r->alpha = fmax(r->alpha, iso_bench_largest_alpha(image));
    return ISO_OK;
}

static iso_status run_method(levels_run *run, bench_subject *b, size_t level, const iso_level_method *m,
                             iso_level_case *c, iso_error *err)
{
    const iso_pyramid *p = &b->pyramids->of[m->scalar][m->directions];
    struct iso_level_result *r = &c->results[m - iso_level_method_at(0)];
    iso_level_shown shown;
    const iso_level_subject s = {p, level, &b->views[0].tf, run->cli->threads};
    iso_status status = iso_level_show(m, &s, &shown, err);
    if (status != ISO_OK)
        return status;
    r->kept_original = m->treatment == ISO_LEVEL_TF_ADAPTED && shown.judgment.use_original;
    c->box = box_of(p, level, &b->views[0]);
    for (int i = 0; i < run->views && status == ISO_OK; ++i) {
        iso_image image = {0};
        status = render_shown(run, m, &s, &shown, &b->views[i], &image, err);
        if (status == ISO_OK)
            status = measure_view(&b->finest[i], &image, c->box, 1.0 / run->views, r, err);
        iso_image_destroy(&image);
    }
    iso_level_shown_destroy(&shown);
    return status;
}

static void print_case(const levels_run *run, const iso_level_case *c)
{
    const char *why = iso_level_case_left_out(&run->cases, c);
    if (run->cli->json)
        return;
    printf("%-24s %-12s %zu", c->volume, c->tf, c->level);
    for (size_t m = 0; m < iso_level_method_count(); ++m)
        if (run->cases.wanted[m])
            printf(" %*.4f%s", (int)fmax(7, (double)strlen(iso_level_method_at(m)->name) - 1), c->results[m].full.dssim,
                   c->results[m].kept_original ? "o" : " ");
    printf("%s%s\n", why ? " left out: " : "", why ? why : "");
    fflush(stdout);
}

static iso_status run_level(levels_run *run, bench_subject *b, size_t level, iso_error *err)
{
    iso_level_case *c = iso_level_cases_add(&run->cases);
    if (!c)
        return iso_fail(err, ISO_E_MEMORY, "no memory for a case");
    c->volume = iso_path_base(run->volumes[run->at]);
    c->tf = b->tf;
    c->level = level;
    c->held = run->at >= run->named_count;
    c->finest_alpha = b->finest_alpha;
    iso_status status = ISO_OK;
    for (size_t m = 0; m < iso_level_method_count() && status == ISO_OK; ++m)
        if (run->cases.wanted[m])
            status = run_method(run, b, level, iso_level_method_at(m), c, err);
    if (status == ISO_OK)
        print_case(run, c);
    return status;
}

/* ---- volumes ---- */

static iso_status render_finest(levels_run *run, const iso_tf *tf, bench_subject *b, iso_error *err)
{
    const iso_pyramid *p = b->pyramids->first;
    const iso_bench_look look = {(size_t)run->size, !run->unshaded, run->step_voxels};
    iso_status status = ISO_OK;
    for (int i = 0; i < run->views && status == ISO_OK; ++i) {
        status = iso_bench_view(&look, &p->levels[0], tf, iso_view_of_faces(i, run->views), &b->views[i], err);
        if (status == ISO_OK)
            status = render(run, p, 0, &b->views[i], ISO_FROM_CODES, &b->finest[i], err);
        if (status == ISO_OK)
            b->finest_alpha = fmax(b->finest_alpha, iso_bench_largest_alpha(&b->finest[i]));
    }
    return status;
}

/* The opaque ramp stands where the volume has its surface; the others are fractions of its range. */
static const char *make_tf(const iso_level *level0, int t, iso_surface_tf *points, iso_tf *tf)
{
    if (t == OPAQUE) {
        const iso_otsu_surface surface = iso_surface_find(level0);
        *tf = iso_surface_make_tf(&surface, points);
        return surface.left_out;
    }
    *tf = iso_level_tf_of(&iso_level_tf_colored);
    for (size_t i = 0; i < ISO_LEVEL_TF_COUNT; ++i)
        if (strcmp(iso_level_tfs[i].name, tf_names[t]) == 0)
            *tf = iso_level_tf_of(&iso_level_tfs[i]);
    return NULL;
}

static iso_status run_tf(levels_run *run, const pyramid_set *set, int t, iso_error *err)
{
    bench_subject b = {.pyramids = set, .tf = tf_names[t]};
    iso_surface_tf points;
    iso_tf tf;
    const char *why = make_tf(&set->first->levels[0], t, &points, &tf);
    if (why) {
        if (!run->cli->json)
            printf("%-24s %-12s left out: %s\n", iso_path_base(run->volumes[run->at]), tf_names[t], why);
        return ISO_OK;
    }
    iso_status status = render_finest(run, &tf, &b, err);
    for (size_t level = 1; level < set->first->level_count && status == ISO_OK; ++level)
        if (run->level == 0 || (size_t)run->level == level)
            status = run_level(run, &b, level, err);
    for (int i = 0; i < run->views; ++i) {
        iso_view_destroy(&b.views[i]);
        iso_image_destroy(&b.finest[i]);
    }
    return status;
}

static bool has_time(levels_run *run)
{
    run->out_of_time = run->out_of_time ||
                       (run->budget_seconds > 0 && iso_clock_seconds() - run->start_seconds > run->budget_seconds);
    return !run->out_of_time;
}

static iso_status run_volume(levels_run *run, const iso_progress *progress, iso_error *err)
{
    pyramid_set set = {0};
    iso_status status = build_pyramids(run, &set, err);
    for (int t = 0; t < TF_COUNT && status == ISO_OK; ++t) {
        if (run->wanted_tf[t] && has_time(run))
            status = run_tf(run, &set, t, err);
        iso_progress_report(progress, "levels", ((double)run->at + (t + 1.0) / TF_COUNT) / (double)run->volume_count);
    }
    destroy_pyramids(&set);
    return status;
}

/* ---- the command ---- */

static iso_status choose(levels_run *run, iso_error *err)
{
    size_t t;
    iso_status status = iso_level_methods_choose(run->methods, run->cases.wanted, err);
    if (status != ISO_OK)
        return iso_fail_in(err, ISO_E_USAGE, "--methods");
    if (iso_names_find(&iso_level_method_names, run->against, &run->cases.against, err) != ISO_OK)
        return iso_fail_in(err, ISO_E_USAGE, "--against");
    if (iso_renderer_from_name(run->with, &run->renderer, err) != ISO_OK)
        return iso_fail_in(err, ISO_E_USAGE, "--with");
    run->cases.wanted[run->cases.against] = true;
    for (const char *at = run->tfs; *at;) {
        char name[32];
        const size_t length = strcspn(at, ",");
        snprintf(name, sizeof name, "%.*s", (int)length, at);
        if (iso_names_find(&tf_table, name, &t, err) != ISO_OK)
            return iso_fail_in(err, ISO_E_USAGE, "--tfs");
        run->wanted_tf[t] = true;
        at += length + (at[length] == ',');
    }
    return ISO_OK;
}

/* Volumes named, then those held back: commas between them, cut here. */
static iso_status list_volumes(levels_run *run, iso_error *err)
{
    for (size_t i = 0; i < run->cli->argument_count && run->volume_count < MAX_VOLUMES; ++i)
        run->volumes[run->volume_count++] = run->cli->arguments[i];
    run->named_count = run->volume_count;
    for (char *at = run->held; at && *at && run->volume_count < MAX_VOLUMES;) {
        char *comma = strchr(at, ',');
        if (comma)
            *comma = 0;
        if (*at)
            run->volumes[run->volume_count++] = at;
        at = comma ? comma + 1 : NULL;
    }
    return run->volume_count > 0 ? ISO_OK : iso_fail(err, ISO_E_USAGE, "no volume named");
}

static iso_status check_options(levels_run *run, iso_error *err)
{
    iso_status status = iso_words_check_range("--views", run->views, 1, MAX_VIEWS, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--size", run->size, 16, 4096, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--levels", run->levels, 2, MAX_LEVELS, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--level", run->level, 0, run->levels - 1, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--step", run->step_voxels, 0.01, 4, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--budget", run->budget_seconds, 0, 1e6, err);
    if (status == ISO_OK)
        status = choose(run, err);
    return status == ISO_OK ? list_volumes(run, err) : status;
}

static void report(const levels_run *run)
{
    json_t *root = iso_cli_json(run->cli);
    if (!run->cli->json && run->out_of_time)
        printf("\nout of time: not all volumes and transfer functions were measured\n");
    json_object_update_new(json_object_get(root, "options"),
                           json_pack("{s:i, s:i, s:i, s:b, s:f, s:s}", "views", run->views, "size", run->size, "levels",
                                     run->levels, "shaded", !run->unshaded, "step_voxels", run->step_voxels, "with",
                                     run->renderer->name));
    json_object_set_new(root, "against", json_string(iso_level_method_at(run->cases.against)->name));
    json_object_set_new(root, "complete", json_boolean(!run->out_of_time));
    json_object_set_new(root, "blocks", iso_levels_report(&run->cases, !run->cli->json));
    json_object_set_new(root, "cases", iso_level_cases_to_json(&run->cases));
    if (run->cli->json)
        iso_cli_print_json(root);
    else
        json_decref(root);
}

static iso_status run_all(levels_run *run, iso_error *err)
{
    if (run->quick) {
        run->views = run->views < 2 ? run->views : 2;
        run->size = run->size < 96 ? run->size : 96;
    }
    const iso_progress progress = iso_cli_progress(run->cli);
    iso_status status = check_options(run, err);
    run->start_seconds = iso_clock_seconds();
    iso_cli_expect(run->cli, &(iso_cli_stage){"levels", 1}, 1);
    if (status == ISO_OK && !run->cli->json) {
        printf("DSSIM; o: the original TF was kept\n%-24s %-12s k", "volume", "tf");
        for (size_t m = 0; m < iso_level_method_count(); ++m)
            if (run->cases.wanted[m])
                printf(" %8s", iso_level_method_at(m)->name);
        printf("\n");
    }
    for (run->at = 0; run->at < run->volume_count && status == ISO_OK; ++run->at)
        if (has_time(run))
            status = run_volume(run, &progress, err);
    if (status == ISO_OK && run->csv)
        status = iso_level_cases_write_csv(&run->cases, run->csv, err);
    if (status == ISO_OK)
        report(run);
    iso_level_cases_destroy(&run->cases);
    iso_renderers_end(&run->renderers);
    return status;
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    levels_run r = {.views = MAX_VIEWS,
                    .size = 192,
                    .levels = 4,
                    .step_voxels = 0.5,
                    .with = iso_renderers_usual()->name,
                    .tfs = "opaque,shell,soft,two-material,colored",
                    .methods = "all",
                    .against = "default"};
    char renderers[256];
    iso_renderers_with(ISO_READS_SOURCE | ISO_HAS_2D_TFS, ", ", " or ", renderers, sizeof renderers);
    iso_volume_input_defaults(&r.input);
    struct poptOption options[] = {
        {"held", 0, POPT_ARG_STRING, &r.held, 0, "volumes that no choice was made by: a block of their own",
         "FILE,FILE"},
        {"methods", 0, POPT_ARG_STRING | POPT_ARGFLAG_SHOW_DEFAULT, &r.methods, 0, "names with commas, or all",
         "NAMES"},
        {"against", 0, POPT_ARG_STRING | POPT_ARGFLAG_SHOW_DEFAULT, &r.against, 0,
         "the method that the others' errors are divided by", "NAME"},
        {"tfs", 0, POPT_ARG_STRING | POPT_ARGFLAG_SHOW_DEFAULT, &r.tfs, 0, "transfer functions, names with commas",
         "NAMES"},
        {"views", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &r.views, 0, "of an icosahedron's faces, at most 20",
         "N"},
        {"size", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &r.size, 0, "pixels along an edge", "N"},
        {"levels", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &r.levels, 0, "with level 0", "N"},
        {"level", 0, POPT_ARG_INT, &r.level, 0, "this level alone", "K"},
        {"step", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &r.step_voxels, 0, "ray step in voxels of the level",
         "VOXELS"},
        {"unshaded", 0, POPT_ARG_NONE, &r.unshaded, 0, "emission alone, without a light", NULL},
        {"with", 0, POPT_ARG_STRING | POPT_ARGFLAG_SHOW_DEFAULT, &r.with, 0, renderers, "RENDERER"},
        {"quick", 0, POPT_ARG_NONE, &r.quick, 0, "two views of 96 pixels", NULL},
        {"budget", 0, POPT_ARG_DOUBLE, &r.budget_seconds, 0, "begins no transfer function after so many seconds",
         "SECONDS"},
        {"csv", 0, POPT_ARG_STRING, &r.csv, 0, "all cases as a table", "FILE"},
        ISO_CLI_INPUT_OPTIONS(&r.input),
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, &next, err);
    r.cli = &cli;
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = run_all(&r, err);
    iso_cli_end(&cli);
    free(r.held);
    free(r.csv);
    return status;
}

static const iso_names *const lists[] = {&iso_level_method_names, NULL};

const iso_command iso_bench_levels = {
    .name = "bench levels",
    .summary = "methods to make and show coarse levels against level 0, one against another",
    .max_arguments = 64,
    .usage = "VOLUME... [--held VOLUME,...] [options]",
    .details =
        "Each method's image of a level against that of level 0 with its own gradients, under five transfer functions: an\n"
        "opaque ramp at the surface between the volume's two classes [otsu-1979], and four that are fractions of its range.\n"
        "Errors, means over the views: DSSIM = (1 - SSIM) / 2, RMSE and FLIP over what either image shows; and minified, where\n"
        "both images are averaged so that a pixel is about one voxel of the level. The tables hold their ratios to one method's,\n"
        "in two blocks: the volumes named, and those of --held. Left out and counted: what shows nothing, what no method errs in.",
    .lists = lists,
    .examples = "  isoshade make shells --size 48 --type uint8 -o shells.nrrd\n"
                "  isoshade bench levels shells.nrrd --quick --levels 3 --methods default,original,on-the-fly\n",
    .run = run,
};
