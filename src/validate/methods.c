/* SPDX-License-Identifier: MIT */
/* methods.c - checks that the renderers agree for each way to make directions and for each kind of TF.
 *
 * Every level is compared with each way to make directions, under the original TF and, if adapting changes it, under
 * the adapted one. The pyramid's own directions are also compared with extinction scales and 2D transfer functions.
 * Renderers are compared by the same samples if those are known, otherwise by their limits. Exports carry directions,
 * so that programs have no gradients on the fly. The quick run keeps to the renderers of this process. */
#include <stdio.h>
#include <stdlib.h>

#include "fit/extinction_scale.h"
#include "tf/level_look.h"
#include "validate/validate.h"

iso_status iso_validate_adapt(iso_validation *v, iso_error *err)
{
    iso_adapt_options opt = iso_adapt_defaults();
    iso_small_views_fine level_0 = {0};
    iso_status status = ISO_OK;
    iso_progress_report(v->progress, "adaptation", 0);
    opt.threads = v->threads;
    opt.fall_back = true;
    opt.level_0 = &level_0;
    v->level_tfs = calloc(v->pyramid->level_count, sizeof *v->level_tfs);
    NEED_MEMORY(v->level_tfs, err, "no memory for the transfer functions of %zu levels", v->pyramid->level_count);
    for (size_t level = 0; level < v->pyramid->level_count && status == ISO_OK; ++level) {
        iso_level_tf *own = &v->level_tfs[level];
        status = iso_adapt_level(v->pyramid, level, &v->view->tf, &opt, &own->table, &own->judgment, err);
        own->own_scale = iso_level_own_scale(v->pyramid, level, &v->view->tf);
    }
    iso_small_views_fine_destroy(&level_0);
    return status;
}

static void forget_tf(iso_level_tf *own)
{
    iso_tf_table_destroy(&own->table);
    iso_tf_table_destroy(&own->scaled_table);
    free(own->extinction_scale);
}

void iso_validate_forget_tfs(iso_validation *v)
{
    for (size_t level = 0; v->level_tfs && level < v->pyramid->level_count; ++level)
        forget_tf(&v->level_tfs[level]);
    free(v->level_tfs);
    v->level_tfs = NULL;
}

/* Which transfer function a row is under: its name in the row, in files, and on the command line. */
typedef struct used_tf {
    const char *name, *file, *options;
} used_tf;
static const used_tf original_tf = {"", "", ""}, adapted_tf = {", adapted TF", "adapted-", " --adapt"},
                     deviation_tf = {", 2D TF (deviation)", "deviation-", " --adapt --tf-2d deviation"},
                     scaled_tf = {", extinction scale", "scaled-", " --adapt --extinction-scale"},
                     gradient_tf = {", 2D TF (gradient)", "gradient-", " --adapt --tf-2d gradient"};

/* Validates one row's kind: a copy of v with another pyramid, view and name. */
static iso_status compare(iso_validation *v, const iso_pyramid *p, const iso_method *m, size_t level, iso_view *view,
                          const used_tf *tf, iso_error *err)
{
    char variant[64], prefix[96], build[64] = "", render[96];
    const bool own = m->filter == v->pyramid->options.direction_filter || m->source != ISO_FROM_CODES;
    iso_validation w = *v;
    snprintf(variant, sizeof variant, "%s%s", m->name, tf->name);
    snprintf(prefix, sizeof prefix, "%.50s%s-%s", v->image_prefix, m->name, tf->file);
    if (!own)
        snprintf(build, sizeof build, "--direction-filter %s", iso_direction_filter_name(m->filter));
    snprintf(render, sizeof render, "%s%s", m->source == ISO_FROM_ON_THE_FLY ? " --shading-from on-the-fly" : "",
             tf->options);
    w.pyramid = p, w.view = view, w.source = m->source;
    w.variant = variant, w.image_prefix = prefix, w.build_options = build, w.render_options = render;
    iso_status status = iso_validate_variant(&w, level, err);
    v->renderers = w.renderers; /* the context is made at first use */
    return status;
}

/* Compares with a 2D transfer function. */
static iso_status compare_tf_2d(iso_validation *v, const iso_pyramid *p, const iso_method *m, size_t level,
                                iso_view *view, iso_second_value second, iso_error *err)
{
    iso_adapt_options opt = iso_adapt_defaults();
    iso_tf_2d tf_2d, *own = view->tf_2d;
    opt.threads = v->threads;
    NEED(iso_adapt_tf_2d(p, level, second, &v->view->tf, &opt, &tf_2d, err));
    view->tf_2d = &tf_2d;
    iso_status status = compare(v, p, m, level, view,
                                second == ISO_SECOND_VALUE_GRADIENT ? &gradient_tf : &deviation_tf, err);
    view->tf_2d = own;
    iso_tf_2d_destroy(&tf_2d);
    return status;
}

/* Compares with an extinction scale, always with the adapted transfer function: small views ignore extinction
 * scales. */
static iso_status compare_scaled(iso_validation *v, const iso_pyramid *p, const iso_method *m, size_t level,
                                 const iso_view *small, iso_error *err)
{
    iso_adapt_options opt = iso_adapt_defaults();
    iso_view view = *small; /* borrowed, except for the parts made here */
    opt.threads = v->threads;
    opt.fall_back = false;
    NEED(iso_adapt_level(p, level, &v->view->tf, &opt, &view.tf, NULL, err));
    iso_status status = iso_extinction_scale_level(p, level, &v->view->tf, &view.tf, v->threads, &view.extinction_scale,
                                                   err);
    TRY(status, compare(v, p, m, level, &view, &scaled_tf, err));
    free(view.extinction_scale);
    iso_tf_table_destroy(&view.tf);
    return status;
}

/* A way to make directions, and the pyramid that was made so. */
typedef struct made_pyramid {
    const iso_method *method;
    const iso_pyramid *pyramid;
} made_pyramid;

static iso_status all_tfs(iso_validation *v, size_t level, void *user, iso_error *err)
{
    const made_pyramid *made = user;
    const iso_pyramid *p = made->pyramid;
    const iso_method *m = made->method;
    const bool covered = p == v->pyramid && m->source == ISO_FROM_CODES; /* by the agreement itself */
    const bool has_share = p->levels[level].geometry.has_no_data; /* the own scale, for any transfer function */
    iso_view view = iso_validate_small_view(v->view, ISO_VALIDATE_METHOD_PIXELS);
    iso_status status = ISO_OK;
    uint8_t *own_scale = (uint8_t *)(uintptr_t)v->level_tfs[level].own_scale; /* borrowed, as the table */
    view.extinction_scale = has_share ? own_scale : NULL;
    if (!covered)
        status = compare(v, p, m, level, &view, &original_tf, err);
    view.tf = v->level_tfs[level].table;
    view.extinction_scale = p == v->pyramid || has_share ? own_scale : NULL;
    if (status == ISO_OK && !v->level_tfs[level].judgment.use_original)
        status = compare(v, p, m, level, &view, &adapted_tf, err);
    view.extinction_scale = has_share ? own_scale : NULL;
    if (status == ISO_OK && covered && level > 0 && !has_share)
        status = compare_scaled(v, p, m, level, &view, err);
    const bool has_2d = covered && level > 0 && !p->levels[0].labels; /* labels have no second value */
    for (int second = ISO_SECOND_VALUE_DEVIATION;
         second <= ISO_SECOND_VALUE_GRADIENT && status == ISO_OK && has_2d; ++second)
        status = compare_tf_2d(v, p, m, level, &view, (iso_second_value)second, err);
    iso_progress_line_add(v->line, 1 / (double)p->level_count);
    return status;
}

iso_status iso_validate_methods(iso_validation *v, iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t i = 0; i < iso_method_count && status == ISO_OK; ++i) {
        const iso_method *m = &iso_methods[i];
        OWNED(iso_pyramid) own = {0};
        const iso_pyramid *p = v->pyramid;
        iso_progress_report(v->progress, m->name, 0);
        if (iso_validate_is_out_of_time(v)) {
            status = iso_validate_stage_left_out(v, m->name, err);
            continue;
        }
        if (m->source == ISO_FROM_CODES && m->filter != v->pyramid->options.direction_filter) {
            status = iso_validate_build_with(v, m->filter, &own, err);
            p = &own;
        }
        if (status == ISO_OK)
            status = iso_validate_each(v, p->level_count, all_tfs, &(made_pyramid){m, p}, err);
    }
    return status;
}
