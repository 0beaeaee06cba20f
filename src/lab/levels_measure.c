/* SPDX-License-Identifier: MIT */
#include "lab/levels_run.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/parallel.h"
#include "lab/level_tfs.h"
#include "lab/look.h"
#include "lab/surface.h"
#include "lab/volumes.h"
#include "plan/level_gate.h"
#include "scene/subject.h"

enum { OPAQUE = 0 };
const char *const iso_levels_tf_names[ISO_LEVELS_TF_COUNT] = {"opaque", "shell", "soft", "two-material", "colored"};

static const iso_levels_edit edits[] = {
    {"none", 0, 1}, {"threshold-5", -0.05, 1}, {"threshold+5", 0.05, 1}, {"opacity/2", 0, 0.5}, {"opacity*2", 0, 2}};
const iso_names iso_levels_edit_names = ISO_NAMES_OF_NAMES("edit", edits);

iso_status iso_levels_edit_from_name(const char *name, const iso_levels_edit **edit, iso_error *err)
{
    size_t row;
    const iso_status status = iso_names_find(&iso_levels_edit_names, name, &row, err);
    *edit = &edits[status == ISO_OK ? row : 0];
    return status;
}

/* ---- pyramids: one per pair of filters of the methods ---- */

typedef struct pyramid_set {
    iso_pyramid of[ISO_SCALAR_COUNT][ISO_DIRECTION_COUNT]; /* level_count 0: not needed */
    const iso_pyramid *first;
} pyramid_set;

/* Stores level 0 only once, since it does not depend on the filters. */
static void share_finest(const iso_pyramid *owner, iso_pyramid *p)
{
    iso_level *level = &p->levels[0];
    free(level->scalar);
    free(level->codes);
    level->scalar = owner->levels[0].scalar;
    level->codes = owner->levels[0].codes;
}

static iso_status build_one(const iso_levels_run *run, const iso_volume *v, const iso_level_method *m, pyramid_set *set,
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

static iso_status build_pyramids(const iso_levels_run *run, const iso_volume *v, pyramid_set *set, iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t m = 0; m < iso_level_method_count() && status == ISO_OK; ++m)
        if (run->cases.wanted[m])
            status = build_one(run, v, iso_level_method_at(m), set, err);
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

/* ---- cases ---- */

/* Returns the key of a case of the current volume. */
static iso_level_case case_like(const iso_levels_run *run, const char *tf, size_t level)
{
    return (iso_level_case){.volume = iso_path_base(run->volumes[run->at]),
                            .tf = tf,
                            .level = level,
                            .held = run->at >= run->named_count};
}

/* Finds a case of earlier runs; NULL: not measured. */
static iso_level_case *find_had(const iso_levels_run *run, const iso_level_case *like)
{
    iso_level_case *one = iso_level_cases_find(&run->cases, like);
    return one && one < run->cases.cases + run->had_count ? one : NULL;
}

static bool is_wanted_level(const iso_levels_run *run, size_t level)
{
    return run->level == 0 || (size_t)run->level == level;
}

/* True if earlier runs measured everything of the current volume under a transfer function. */
static bool has_tf(const iso_levels_run *run, int t)
{
    for (size_t level = 1; level < (size_t)run->levels; ++level) {
        const iso_level_case like = case_like(run, iso_levels_tf_names[t], level), *had = find_had(run, &like);
        for (size_t m = 0; m < iso_level_method_count() && is_wanted_level(run, level); ++m)
            if (run->cases.wanted[m] && !(had && had->results[m].measured))
                return false;
    }
    return true;
}

/* Checks that a table's volume of this name has the same size: otherwise it is another volume. */
static iso_status check_size(const iso_levels_run *run, const iso_volume *v, iso_error *err)
{
    for (size_t i = 0; i < run->had_count; ++i) {
        const iso_level_case *one = &run->cases.cases[i];
        const size_t *had = one->size, *size = v->geometry.size;
        if (strcmp(one->volume, iso_path_base(run->volumes[run->at])) == 0 && memcmp(had, size, sizeof one->size) != 0)
            return iso_fail(err, ISO_E_USAGE, "--have: %s has %zux%zux%zu voxels in the table, but %zux%zux%zu now",
                            one->volume, had[0], had[1], had[2], size[0], size[1], size[2]);
    }
    return ISO_OK;
}

/* ---- measuring ---- */

/* A volume under one transfer function. */
typedef struct bench_subject {
    const pyramid_set *pyramids;
    const char *tf;
    double finest_alpha;
    iso_tf_table before; /* an edit; owned by its user */
    iso_view views[ISO_LEVELS_MAX_VIEWS];
    iso_image finest[ISO_LEVELS_MAX_VIEWS];
} bench_subject;

static iso_status render(iso_levels_run *run, const iso_pyramid *p, size_t level, const iso_view *view,
                         iso_direction_source source, iso_image *image, iso_error *err)
{
    iso_render_options opt = iso_render_defaults(run->renderer);
    const iso_progress silent = {0};
    run->frame_seconds = 0;
    opt.source = source;
    opt.step_voxels = run->step_voxels;
    opt.threads = run->cli->threads;
    return iso_render_with(&(iso_render_request){&run->renderers, p, level, view, &opt, &silent}, image,
                           &run->frame_seconds, err);
}

/* Renders a rival with the samples of the ray caster. */
static iso_status render_rival(const iso_levels_run *run, const iso_level_subject *s, const iso_level_shown *shown,
                               const iso_view *view, iso_image *image, iso_error *err)
{
    iso_reference_options opt = iso_reference_defaults();
    opt.quadrature = ISO_QUADRATURE_MIDPOINT;
    opt.step_voxels = run->step_voxels;
    opt.emitter = &shown->rival.emitter;
    opt.threads = s->threads;
    return iso_reference_render(&shown->level, s->pyramid->options.code, view, &opt, image, NULL, err);
}

/* Renders one view of a method's level. */
static iso_status render_shown(iso_levels_run *run, const iso_level_method *m, const iso_level_subject *s,
                               iso_level_shown *shown, const iso_view *view, iso_image *image, iso_error *err)
{
    iso_view own = *view; /* the same view with another table */
    iso_level levels[ISO_LEVELS_MAX_LEVELS];
    iso_pyramid shows = *s->pyramid;
    memcpy(levels, shows.levels, shows.level_count * sizeof *levels);
    levels[s->level] = shown->level;
    shows.levels = levels;
    own.tf = shown->tf;
    own.tf_2d = shown->has_tf_2d ? &shown->tf_2d : NULL;
    own.extinction_scale = shown->extinction_scale;
    if (shown->rival.emitter.emit)
        return render_rival(run, s, shown, &own, image, err);
    return render(run, &shows, s->level, &own, m->source, image, err);
}

/* Returns the pixels per voxel of the level, along an edge. */
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
    TRY(status, iso_image_minify(image, box, &small, err));
    TRY(status, iso_level_error_measure(&small_finest, &small, e, err));
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
    r->alpha = fmax(r->alpha, iso_lab_largest_alpha(image));
    return ISO_OK;
}

static iso_status run_method(iso_levels_run *run, bench_subject *b, size_t level, const iso_level_method *m,
                             iso_level_case *c, iso_error *err)
{
    const iso_pyramid *p = &b->pyramids->of[m->scalar][m->directions];
    struct iso_level_result *r = &c->results[m - iso_level_method_at(0)];
    iso_level_shown shown;
    const iso_level_subject s = {p, level, &b->views[0].tf, &b->before, run->cli->threads};
    iso_status status = iso_level_show(m, &s, &shown, err);
    if (status != ISO_OK)
        return status;
    r->measured = true;
    r->kept_original = m->treatment == ISO_LEVEL_TF_ADAPTED && shown.judgment.use_original;
    c->box = box_of(p, level, &b->views[0]);
    for (int i = 0; i < run->views && status == ISO_OK; ++i) {
        iso_image image = {0};
        status = render_shown(run, m, &s, &shown, &b->views[i], &image, err);
        r->seconds = i == 0 || run->frame_seconds < r->seconds ? run->frame_seconds : r->seconds;
        TRY(status, measure_view(&b->finest[i], &image, c->box, 1.0 / run->views, r, err));
        iso_image_destroy(&image);
    }
    iso_level_shown_destroy(&shown);
    return status;
}

static void print_case(const iso_levels_run *run, const iso_level_case *c)
{
    const char *why = iso_level_case_left_out(&run->cases, c);
    if (run->cli->json || run->silent)
        return;
    printf("%-24s %-12s %zu", c->volume, c->tf, c->level);
    for (size_t m = 0; m < iso_level_method_count(); ++m)
        if (run->cases.wanted[m])
            printf(" %*.4f%s", (int)fmax(7, (double)strlen(iso_level_method_at(m)->name) - 1), c->results[m].full.dssim,
                   c->results[m].kept_original ? "o" : " ");
    printf("%s%s\n", why ? " left out: " : "", why ? why : "");
    fflush(stdout);
}

static iso_status run_level(iso_levels_run *run, bench_subject *b, size_t level, iso_error *err)
{
    const iso_level_case like = case_like(run, b->tf, level);
    iso_level_case *c = find_had(run, &like);
    if (!c) {
        c = iso_level_cases_add(&run->cases);
        NEED_MEMORY(c, err, "no memory for a case");
        *c = like;
        memcpy(c->size, b->pyramids->first->levels[0].geometry.size, sizeof c->size);
    }
    c->finest_alpha = b->finest_alpha;
    iso_status status = ISO_OK;
    for (size_t m = 0; m < iso_level_method_count() && status == ISO_OK; ++m)
        if (run->cases.wanted[m] && !c->results[m].measured)
            status = run_method(run, b, level, iso_level_method_at(m), c, err);
    if (status == ISO_OK)
        print_case(run, c);
    return status;
}

/* ---- volumes ---- */

static iso_status render_finest(iso_levels_run *run, const iso_tf *tf, bench_subject *b, iso_error *err)
{
    const iso_pyramid *p = b->pyramids->first;
    const iso_lab_look look = {(size_t)run->size, !run->unshaded, run->step_voxels};
    iso_status status = ISO_OK;
    for (int i = 0; i < run->views && status == ISO_OK; ++i) {
        status = iso_lab_view(&look, &p->levels[0], tf, iso_view_of_faces(i, run->views), &b->views[i], err);
        TRY(status, render(run, p, 0, &b->views[i], ISO_FROM_CODES, &b->finest[i], err));
        if (status == ISO_OK)
            b->finest_alpha = fmax(b->finest_alpha, iso_lab_largest_alpha(&b->finest[i]));
    }
    return status;
}

/* Makes a transfer function: the opaque ramp at the volume's surface, or one of those at fractions of its range. */
static const char *make_tf(const iso_level *level0, int t, iso_surface_tf *points, iso_tf *tf)
{
    if (t == OPAQUE) {
        const iso_otsu_surface surface = iso_surface_find(level0);
        *tf = iso_surface_make_tf(&surface, points);
        return surface.left_out;
    }
    *tf = iso_level_tf_of(&iso_level_tf_colored);
    for (size_t i = 0; i < ISO_LEVEL_TF_COUNT; ++i)
        if (strcmp(iso_level_tfs[i].name, iso_levels_tf_names[t]) == 0)
            *tf = iso_level_tf_of(&iso_level_tfs[i]);
    return NULL;
}

static iso_status run_tf(iso_levels_run *run, const pyramid_set *set, const char *name, const iso_tf *tf,
                         iso_error *err)
{
    bench_subject b = {.pyramids = set, .tf = name};
    iso_tf edited = {0};
    const iso_pyramid *p = set->first;
    iso_status status = iso_gate_edit_tf(p, tf, run->edited->shift, run->edited->factor, &edited, err);
    TRY(status, iso_tf_tabulate(tf, iso_pyramid_lo(p), iso_pyramid_hi(p), &p->levels[0].geometry, &b.before, err));
    TRY(status, render_finest(run, &edited, &b, err));
    for (size_t level = 1; level < set->first->level_count && status == ISO_OK; ++level)
        if (is_wanted_level(run, level))
            status = run_level(run, &b, level, err);
    for (int i = 0; i < run->views; ++i) {
        iso_view_destroy(&b.views[i]);
        iso_image_destroy(&b.finest[i]);
    }
    iso_tf_table_destroy(&b.before);
    iso_tf_destroy(&edited);
    return status;
}

/* Measures under one of the benchmark's transfer functions. */
static iso_status run_usual_tf(iso_levels_run *run, const pyramid_set *set, int t, iso_error *err)
{
    iso_surface_tf points;
    iso_tf tf;
    const char *why = make_tf(&set->first->levels[0], t, &points, &tf);
    if (!why)
        return run_tf(run, set, iso_levels_tf_names[t], &tf, err);
    if (!run->cli->json)
        printf("%-24s %-12s left out: %s\n", iso_path_base(run->volumes[run->at]), iso_levels_tf_names[t], why);
    return ISO_OK;
}

bool iso_levels_has_time(iso_levels_run *run)
{
    run->out_of_time = run->out_of_time ||
                       (run->budget_seconds > 0 && iso_clock_seconds() - run->start_seconds > run->budget_seconds);
    return !run->out_of_time;
}

iso_status iso_levels_run_volume(iso_levels_run *run, const iso_progress *progress, iso_error *err)
{
    pyramid_set set = {0};
    iso_volume v = {0};
    iso_status status = iso_volume_input_load(run->volumes[run->at], &run->input, &v, err);
    if (status == ISO_OK && run->crop)
        status = iso_lab_crop_to_middle(&v, (size_t)run->crop, err);
    TRY(status, check_size(run, &v, err));
    if (status == ISO_OK && run->own_tf)
        status = build_pyramids(run, &v, &set, err);
    if (status == ISO_OK && run->own_tf)
        status = run_tf(run, &set, "scene", run->own_tf, err);
    for (int t = 0; t < ISO_LEVELS_TF_COUNT && status == ISO_OK; ++t) {
        if (run->wanted_tf[t] && !has_tf(run, t) && iso_levels_has_time(run)) {
            if (!set.first)
                status = build_pyramids(run, &v, &set, err);
            TRY(status, run_usual_tf(run, &set, t, err));
            if (status == ISO_OK && run->csv)
                status = iso_level_cases_write_csv(&run->cases, run->csv, err);
        }
        iso_progress_report(progress, "levels",
                            ((double)run->at + (t + 1.0) / ISO_LEVELS_TF_COUNT) / (double)run->volume_count);
    }
    destroy_pyramids(&set);
    iso_volume_destroy(&v);
    return status;
}
