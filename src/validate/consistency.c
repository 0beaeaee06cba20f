/* SPDX-License-Identifier: MIT */
/* consistency.c - is a coarse level shaded as the finest one is? Each way to make directions, under the original
 * TF and under the one adapted to the level, over several views, against level 0 under the original TF. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "renderers/picture_store.h"
#include "validate/measured.h"

const iso_method iso_methods[] = {
    {"on-the-fly", ISO_DIRECTION_MOMENTS, ISO_FROM_ON_THE_FLY},
    {"naive", ISO_DIRECTION_NAIVE, ISO_FROM_CODES},
    {"eq1", ISO_DIRECTION_EQ1, ISO_FROM_CODES},
    {"moments", ISO_DIRECTION_MOMENTS, ISO_FROM_CODES},
};
const size_t iso_method_count = sizeof iso_methods / sizeof *iso_methods;
static const iso_method tensor = {"tensor", ISO_DIRECTION_TENSOR, ISO_FROM_CODES};
enum { max_views = ISO_FACE_VIEWS };

iso_status iso_validate_level_view(const iso_validation *v, size_t i, iso_view *view, iso_error *err)
{
    const iso_level *level0 = &v->pyramid->levels[0];
    iso_scene scene = *v->scene; /* borrowed, but for the camera and the size */
    scene.camera_fit = true;
    scene.camera_direction = iso_view_spread((int)i, (int)v->consistency_views);
    scene.camera_up = iso_view_up(scene.camera_direction);
    scene.width = scene.height = v->consistency_size;
    return iso_scene_resolve(&scene, &level0->geometry, iso_pyramid_lo(v->pyramid), iso_pyramid_hi(v->pyramid), view,
                             err);
}

static bool shows_something(const iso_image *image)
{
    for (size_t i = 0; i < image->width * image->height; ++i)
        if (image->rgba[4 * i + 3] >= 1 / 255.0f)
            return true;
    return false;
}

iso_status iso_validate_render_level(iso_validation *v, const iso_pyramid *p, const iso_measured_level *s, size_t i,
                                     iso_image *image, iso_error *err)
{
    const iso_level_tf *own = &v->level_tfs[s->level];
    OWNED(iso_view) view = {0};
    iso_render_options opt = iso_render_defaults(iso_renderers_usual());
    opt.source = s->method->source;
    NEED(iso_validate_level_view(v, i, &view, err));
    iso_view shown = view; /* borrowed */
    if (s->use != ISO_USE_ORIGINAL)
        shown.tf = s->use == ISO_USE_SCALED ? own->scaled_table : own->table;
    if (s->use == ISO_USE_SCALED)
        shown.extinction_scale = own->extinction_scale;
    else if ((s->use == ISO_USE_ADAPTED && p == v->pyramid) || v->pyramid->levels[0].geometry.has_no_data)
        shown.extinction_scale = (uint8_t *)(uintptr_t)own->own_scale; /* borrowed */
    return iso_render_with(&(iso_render_request){&v->renderers, p, s->level, &shown, &opt, NULL}, image, NULL, err);
}

/* Adds a picture of the first view to the report. */
static iso_status add_picture(const iso_validation *v, const char *name, const iso_image *image, const char *caption,
                              iso_error *err)
{
    OWNED(iso_view) view = {0};
    NEED(iso_report_add_image(v->report, name, image, caption, err));
    NEED(iso_validate_level_view(v, 0, &view, err));
    iso_report_set_scale(v->report, name, iso_view_mm_per_pixel(&view, &v->pyramid->levels[0].geometry));
    return ISO_OK;
}

/* Data shared by all methods: the pictures of level 0, the levels made again from it, and the measurements. */
typedef struct levels_run {
    iso_image finest[max_views];
    bool late;                  /* the budget was over before all was measured */
    iso_pyramid made;           /* levels made from level 0, unless the pyramid's own are verified */
    const iso_pyramid *rebuilt; /* that, or the pyramid */
    iso_measured measured;
} levels_run;

/* True if time is left for the pictures of one more view. */
static bool may_draw(const iso_validation *v, levels_run *run)
{
    run->late = run->late || iso_validate_is_out_of_time(v);
    return !run->late;
}

/* Draws this rank's share of a level's views into the store: ranks that drew all views in the same order would wait for
 * each other at each. */
static iso_status draw_share(iso_validation *v, levels_run *run, const iso_pyramid *p, const iso_measured_level *views,
                             iso_error *err)
{
    const iso_picture_share share = iso_picture_store_share(v->renderers.store, v->consistency_views);
    for (size_t i = share.first; i < share.end && may_draw(v, run); ++i) {
        OWNED(iso_image) image = {0};
        NEED(iso_validate_render_level(v, p, views, i, &image, err));
    }
    return ISO_OK;
}

/* Measures the figures of all views, and adds the picture row->image of the first. */
static iso_status measure_images(iso_validation *v, levels_run *run, const iso_pyramid *p, iso_report_consistency *row,
                                 iso_measured_level *views, iso_error *err)
{
    iso_status status = draw_share(v, run, p, views, err);
    row->ssim_dissimilarity_mean = row->flip_mean = row->rmse_mean = 0;
    for (size_t i = 0; i < v->consistency_views && status == ISO_OK && may_draw(v, run); ++i) {
        OWNED(iso_image) image = {0};
        iso_metrics metrics;
        status = iso_validate_render_level(v, p, views, i, &image, err);
        TRY(status, iso_metrics_measure(&run->finest[i], &image, &metrics, err));
        if (status == ISO_OK && i == 0 && row->image)
            status = add_picture(v, row->image, &image,
                                 row->scaled    ? "extinction scale"
                                 : row->adapted ? "adapted TF"
                                                : row->method,
                                 err);
        if (status == ISO_OK) {
            row->ssim_dissimilarity_mean += (1 - metrics.ssim) / (double)v->consistency_views;
            row->flip_mean += metrics.flip_mean / (double)v->consistency_views;
            row->rmse_mean += metrics.rmse / (double)v->consistency_views;
            views->figures[ISO_LEVEL_SSIM][i] = 1 - metrics.ssim;
            views->figures[ISO_LEVEL_FLIP][i] = metrics.flip_mean;
            views->figures[ISO_LEVEL_RMSE][i] = metrics.rmse;
        }
    }
    return status;
}

/* Keeps a row, and its measurements in all of its views. */
static iso_status keep(iso_validation *v, levels_run *run, iso_report_consistency *row, const iso_measured_level *views,
                       iso_error *err)
{
    iso_measured *all = &run->measured;
    if (run->late)
        return ISO_OK;
    if (all->count == all->room)
        return iso_fail(err, ISO_E_RANGE, "more than %zu rows of levels", all->room);
    all->levels[all->count++] = *views;
    row->by_view.ssim_dissimilarity = views->figures[ISO_LEVEL_SSIM];
    row->by_view.flip = views->figures[ISO_LEVEL_FLIP];
    row->by_view.rmse = views->figures[ISO_LEVEL_RMSE];
    return iso_report_add_consistency(v->report, row, err);
}

/* Adds the row of the level's own TF after that of the original one: directions are the same. If adapting is refused,
 * images are the same, too. */
static iso_status measure_adapted(iso_validation *v, levels_run *run, const iso_pyramid *p, iso_report_consistency row,
                                  iso_measured_level views, iso_error *err)
{
    const iso_adapt_judgment *judgment = &v->level_tfs[row.level].judgment;
    char name[64], why[224];
    row.adapted = true;
    views.use = ISO_USE_ADAPTED;
    if (judgment->use_original) {
        if (judgment->seen)
            snprintf(why, sizeof why,
                     "in small views the adapted TF has 1-SSIM %.3g and RMSE %.3g, the original one %.3g and %.3g; it "
                     "draws a ghost of %.3g %%",
                     judgment->seen_adapted.ssim_dissimilarity, judgment->seen_adapted.rmse,
                     judgment->seen_original.ssim_dissimilarity, judgment->seen_original.rmse,
                     100 * judgment->seen_adapted.ghost);
        else
            snprintf(why, sizeof why,
                     "adapted, the TF would be %.3g off at the voxels (RMS), and the original is %.3g off",
                     judgment->rms_adapted, judgment->rms_original);
        row.original_kept = why;
    } else {
        snprintf(name, sizeof name, "consistency-%s-adapted-level-%zu", row.method, row.level);
        row.image = name;
        NEED(measure_images(v, run, p, &row, &views, err));
    }
    return keep(v, run, &row, &views, err);
}

static bool has_scaled_row(const iso_validation *v, const levels_run *run, const iso_method *m)
{
    return v->scales != ISO_SCALES_NONE && m == run->measured.own;
}

/* Measures the row of the export with extinction scales, with the pyramid's own directions only. */
static iso_status measure_scaled(iso_validation *v, levels_run *run, const iso_pyramid *p, iso_report_consistency row,
                                 iso_measured_level views, iso_error *err)
{
    char name[64];
    if (!has_scaled_row(v, run, views.method))
        return ISO_OK;
    row.adapted = v->scales == ISO_SCALES_ADAPTED;
    row.scaled = true;
    views.use = ISO_USE_SCALED;
    snprintf(name, sizeof name, "consistency-%s-scaled-level-%zu", row.method, row.level);
    row.image = name;
    const iso_status status = measure_images(v, run, p, &row, &views, err);
    return status == ISO_OK ? keep(v, run, &row, &views, err) : status;
}

/* Begins a part of the progress, which has about one for each method and level. */
static void begin_part(const iso_validation *v, const char *what, size_t level)
{
    char part[64];
    snprintf(part, sizeof part, "consistency: %s, level %zu", what, level);
    iso_progress_report(v->progress, part, 0);
    iso_progress_line_add(v->line, 1 / (double)(v->pyramid->level_count * iso_method_count));
}

static iso_status measure_level(iso_validation *v, levels_run *run, const iso_pyramid *p, size_t level,
                                const iso_method *m, iso_error *err)
{
    char name[64];
    iso_measured_level views = {.level = level, .method = m};
    iso_level_angles angles = {NAN, NAN};
    iso_report_consistency row = {.level = level,
                                  .views = v->consistency_views,
                                  .method = m->name,
                                  .image = name,
                                  .reference_image = "consistency-level-0"};
    snprintf(name, sizeof name, "consistency-%s-level-%zu", m->name, level);
    begin_part(v, m->name, level);
    iso_status status = measure_images(v, run, p, &row, &views, err);
    if (status == ISO_OK && !run->late)
        status = iso_validate_angles(v, p, level, m->source, &angles, err);
    row.gradient_angle_mean_deg = views.angle_deg = angles.mean;
    row.gradient_angle_p95_deg = angles.p95;
    TRY(status, keep(v, run, &row, &views, err));
    TRY(status, measure_adapted(v, run, p, row, views, err));
    return status == ISO_OK ? measure_scaled(v, run, p, row, views, err) : status;
}

iso_status iso_validate_build_with(const iso_validation *v, iso_direction_filter filter, iso_pyramid *p, iso_error *err)
{
    const iso_level *level0 = &v->pyramid->levels[0];
    const iso_volume borrowed = {.geometry = level0->geometry, .type = ISO_F32, .data = level0->scalar};
    iso_pyramid_options opt = v->pyramid->options;
    opt.direction_filter = filter;
    opt.level_count = v->pyramid->level_count;
    opt.keep_float = opt.keep_magnitude = false;
    opt.threads = v->threads;
    iso_status status = iso_pyramid_build(&borrowed, v->pyramid->source, &opt, p, NULL, err);
    if (status == ISO_OK) /* so that renderers keep the same texture of it */
        p->levels[0].stored_type = level0->stored_type;
    return status;
}

/* Gradients on the fly are those of the levels made from level 0: an error of a stored level is not excused because
 * another method shows it as well. */
static iso_status measure_method(iso_validation *v, levels_run *run, const iso_method *m, iso_error *err)
{
    OWNED(iso_pyramid) other = {0};
    const iso_pyramid *p = m == run->measured.own ? v->pyramid : m->source == ISO_FROM_CODES ? &other : run->rebuilt;
    run->late = run->late || iso_validate_is_out_of_time(v);
    if (p == &other && !run->late)
        NEED(iso_validate_build_with(v, m->filter, &other, err));
    for (size_t level = 1; level < v->pyramid->level_count && !run->late; ++level)
        NEED(measure_level(v, run, p, level, m, err));
    return ISO_OK;
}

/* Measures the methods of the table, and `own` if none of them has the pyramid's filter. */
static iso_status measure_methods(iso_validation *v, levels_run *run, const iso_method *own, iso_error *err)
{
    iso_measured *all = &run->measured;
    all->own = own;
    for (size_t i = 0; i < iso_method_count; ++i) {
        const iso_method *m = &iso_methods[i];
        if (m->source == ISO_FROM_ON_THE_FLY)
            all->on_the_fly = m;
        else if (m->filter == own->filter)
            all->own = m;
    }
    all->room = 3 * (iso_method_count + 2) * v->pyramid->level_count;
    all->levels = calloc(all->room, sizeof *all->levels);
    NEED_MEMORY(all->levels, err, "no memory for %zu rows of levels", all->room);
    for (size_t i = 0; i < iso_method_count; ++i)
        NEED(measure_method(v, run, &iso_methods[i], err));
    if (all->own == own)
        NEED(measure_method(v, run, own, err));
    /* Reports the figures that auto chose by, so that a wrong choice shows. */
    return own->filter == ISO_DIRECTION_AUTO ? measure_method(v, run, &tensor, err) : ISO_OK;
}

/* ---- levels that the views leave open ---- */

/* Measures the default and the simple way again, in twenty views. */
static iso_status measure_more(iso_validation *v, levels_run *run, size_t level, iso_error *err)
{
    iso_measured *all = &run->measured;
    const iso_level_tf_use use = iso_measured_own_use(v, level);
    const iso_method *methods[2] = {all->own, all->on_the_fly};
    iso_status status = ISO_OK;
    begin_part(v, "more views", level);
    for (int i = 0; i < 2 && status == ISO_OK; ++i) {
        iso_measured_level *views = &all->more[all->more_count + (size_t)i];
        iso_report_consistency row = {.level = level, .method = methods[i]->name};
        *views = (iso_measured_level){.level = level, .method = methods[i], .use = i == 0 ? use : ISO_USE_ORIGINAL};
        status = measure_images(v, run, i == 0 ? v->pyramid : run->rebuilt, &row, views, err);
    }
    all->more_count += run->late ? 0 : 2;
    return status;
}

/* True if a level needs more views to be judged. The quick run only confirms failures. */
static bool is_open(const iso_validation *v, const iso_measured *all, size_t level)
{
    const iso_measured_level *own = iso_measured_find(all, level, all->own, iso_measured_own_use(v, level)),
                             *simple = iso_measured_find(all, level, all->on_the_fly, ISO_USE_ORIGINAL);
    return all->shown && ((!v->quick && iso_measured_is_open(own, simple, v->consistency_views)) ||
                          iso_measured_is_behind(own, simple, v->consistency_views));
}

const iso_method iso_method_stored = {"stored", ISO_DIRECTION_MOMENTS, ISO_FROM_CODES};

static iso_status render_finest(iso_validation *v, levels_run *run, const char *what, iso_error *err)
{
    const iso_measured_level stored = {.method = &iso_method_stored};
    begin_part(v, what, 0);
    iso_status status = draw_share(v, run, v->pyramid, &stored, err);
    for (size_t i = 0; i < v->consistency_views && status == ISO_OK && may_draw(v, run); ++i)
        status = iso_validate_render_level(v, v->pyramid, &stored, i, &run->finest[i], err);
    return status;
}

static void forget_finest(iso_image *finest)
{
    for (size_t i = 0; i < max_views; ++i)
        iso_image_destroy(&finest[i]);
}

/* Measures open levels in more views. If the budget ends before that, levels are judged by the views so far, and the
 * report states it. */
static iso_status measure_open_levels(iso_validation *v, levels_run *run, iso_error *err)
{
    const size_t views = v->consistency_views, levels = v->pyramid->level_count;
    iso_measured *all = &run->measured;
    iso_status status = ISO_OK;
    bool *open = calloc(levels, sizeof *open), any = false;
    all->more = calloc(2 * levels, sizeof *all->more);
    if (!open || !all->more)
        status = iso_fail(err, ISO_E_MEMORY, "no memory for %zu levels", levels);
    for (size_t level = 1; level < levels && status == ISO_OK; ++level)
        any |= open[level] = is_open(v, all, level);
    if (any) {
        forget_finest(run->finest);
        v->consistency_views = ISO_FACE_VIEWS;
        status = render_finest(v, run, "more views", err);
    }
    for (size_t level = 1; level < levels && status == ISO_OK && !run->late; ++level)
        if (open[level])
            status = measure_more(v, run, level, err);
    if (status == ISO_OK && run->late)
        status = iso_validate_stage_left_out(v, "more views of levels", err);
    run->late = false;
    v->consistency_views = views;
    free(open);
    return status;
}

/* True if the one renderer that draws all views is wanted and not refused. */
static bool is_possible(const iso_validation *v)
{
    const size_t usual = iso_renderer_index(iso_renderers_usual());
    return v->refused[usual].status == ISO_OK && v->wanted[usual];
}

/* Reports why the views cannot be drawn. Nothing is missing if there is one level alone, or if the renderer was not asked
 * for. */
static iso_status not_possible(const iso_validation *v, iso_error *err)
{
    const iso_renderer_info *usual = iso_renderers_usual();
    const char *lacks = v->refused[iso_renderer_index(usual)].why;
    char why[700];
    snprintf(why, sizeof why, "the views of all levels are drawn by %s: %s", usual->name, lacks);
    return v->pyramid->level_count < 2 || !lacks[0] ? ISO_OK : iso_validate_stage_not_run(v, "consistency", why, err);
}

iso_status iso_validate_consistency(iso_validation *v, iso_error *err)
{
    const iso_direction_filter filter = v->pyramid->options.direction_filter;
    const iso_method own = {iso_direction_filter_name(filter), filter, ISO_FROM_CODES};
    levels_run run = {0};
    iso_status status = ISO_OK;
    if (!is_possible(v))
        return not_possible(v, err);
    if (iso_validate_is_out_of_time(v))
        return iso_validate_stage_left_out(v, "consistency", err);
    status = render_finest(v, &run, "views", err);
    for (size_t i = 0; i < v->consistency_views && status == ISO_OK && !run.late; ++i)
        run.measured.shown = run.measured.shown || shows_something(&run.finest[i]);
    if (status == ISO_OK && !run.late)
        status = add_picture(v, "consistency-level-0", &run.finest[0], "level 0", err);
    run.rebuilt = v->is_as_made ? v->pyramid : &run.made;
    if (status == ISO_OK && !run.late && !v->is_as_made)
        status = iso_validate_build_with(v, filter, &run.made, err);
    TRY(status, measure_methods(v, &run, &own, err));
    if (status == ISO_OK && !run.late && v->may_add_views && v->consistency_views < ISO_FACE_VIEWS)
        status = measure_open_levels(v, &run, err);
    if (status == ISO_OK && run.late)
        status = iso_validate_stage_left_out(v, "consistency", err);
    else if (status == ISO_OK)
        iso_progress_report(v->progress, "consistency: verdict", 0);
    if (status == ISO_OK && !run.late)
        status = iso_validate_judge_levels(v, &run.measured, run.rebuilt, err);
    forget_finest(run.finest);
    iso_pyramid_destroy(&run.made);
    free(run.measured.more);
    free(run.measured.levels);
    return status;
}
