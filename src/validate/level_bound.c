/* SPDX-License-Identifier: MIT */
/* level_bound.c - the bound of a level's RMSE (render/image_bound.h) next to the RMSE measured in the same views. The
 * bound is independent of the pictures: if the measured figure is above it, one of the two is wrong. */
#include <math.h>

#include "render/image_bound.h"
#include "validate/measured.h"

/* The bound's work for a level, in points of the volume: a view or more, as many as fit. */
static const double points_at_most = 1 << 23;
/* Steps are short enough if the RMSE changes by less than this, a tenth of the margin of a verdict. */
static const double step_change = 1e-4, finest_step_voxels = 1.0 / 256;

static size_t count_views(const iso_validation *v)
{
    const double voxels = (double)iso_geometry_voxel_count(&v->pyramid->levels[0].geometry);
    const double fit = floor(points_at_most / (voxels * (double)iso_image_bound_points(voxels)));
    return fit < 1 ? 1 : fit < (double)v->consistency_views ? (size_t)fit : v->consistency_views;
}

/* Reports progress of the verdicts on all coarse levels; `done` of the views of this level's bound are finished. */
static void report_progress(const iso_validation *v, size_t level, double done)
{
    iso_progress_report(v->progress, "consistency: verdict",
                        ((double)level - 1 + done) / ((double)v->pyramid->level_count - 1));
}

static iso_status bound_view(const iso_validation *v, size_t level, bool adapted, size_t number, double *rmse,
                             iso_error *err)
{
    OWNED(iso_view) view = {0};
    NEED(iso_validate_level_view(v, number, &view, err));
    const iso_image_bound_input in = {.fine = &v->pyramid->levels[0],
                                      .coarse = &v->pyramid->levels[level],
                                      .level = level,
                                      .code = v->pyramid->options.code,
                                      .source = ISO_FROM_CODES,
                                      .view = &view,
                                      .coarse_tf = adapted ? &v->level_tfs[level].table : &view.tf,
                                      .threads = v->threads,
                                      .deadline = v->deadline};
    return iso_image_bound_rmse(&in, rmse, err);
}

/* Draws level 0 and the level in view i, and measures the RMSE. */
static iso_status measure_view(iso_validation *v, const iso_measured_level *own, size_t i, double *rmse, iso_error *err)
{
    OWNED(iso_image) fine = {0}, coarse = {0};
    iso_metrics metrics = {0};
    iso_status status = iso_validate_render_level(v, v->pyramid, &(iso_measured_level){.method = &iso_method_stored}, i,
                                                  &fine, err);
    TRY(status, iso_validate_render_level(v, v->pyramid, own, i, &coarse, err));
    TRY(status, iso_metrics_measure(&fine, &coarse, &metrics, err));
    *rmse = metrics.rmse;
    return status;
}

/* Measures the RMSE with ever smaller steps: the bound is one of exact integrals along the rays. */
static iso_status measure_finely(iso_validation *v, const iso_measured_level *own, size_t i, double *rmse,
                                 iso_error *err)
{
    const iso_scene *scene = v->scene;
    iso_scene finer = *scene;
    iso_status status = ISO_OK;
    v->scene = &finer;
    for (double before = INFINITY; status == ISO_OK && !iso_validate_is_out_of_time(v) &&
                                   fabs(*rmse - before) > step_change && finer.step_voxels > finest_step_voxels;) {
        before = *rmse;
        finer.step_voxels /= 4;
        status = measure_view(v, own, i, rmse, err);
    }
    v->scene = scene;
    return status;
}

iso_status iso_validate_bound_level(iso_validation *v, const iso_measured_level *own, iso_report_level *row, bool *late,
                                    iso_error *err)
{
    const size_t views = count_views(v);
    iso_report_bound bound = {.views = views, .above = -INFINITY};
    iso_status status = ISO_OK;
    if (!iso_image_bound_is_for(v->view) || own->use == ISO_USE_SCALED ||
        v->level_tfs[own->level].own_scale || v->pyramid->levels[0].geometry.has_no_data) /* then there is none */
        return ISO_OK;
    for (size_t i = 0; i < views && status == ISO_OK; ++i) {
        double bound_rmse = NAN, rmse = own->figures[ISO_LEVEL_RMSE][i];
        report_progress(v, own->level, (double)i / (double)views);
        if (iso_validate_is_out_of_time(v))
            bound_rmse = INFINITY;
        else
            status = bound_view(v, own->level, own->use == ISO_USE_ADAPTED, i, &bound_rmse, err);
        if (status == ISO_OK && rmse > bound_rmse)
            status = measure_finely(v, own, i, &rmse, err);
        if (rmse > bound_rmse && iso_validate_is_out_of_time(v)) /* its steps may be too long */
            bound_rmse = INFINITY;
        bound.rmse += rmse / (double)views;
        bound.bound += bound_rmse / (double)views;
        const double above = rmse - bound_rmse;
        bound.above = isnan(above) || above > bound.above ? above : bound.above;
    }
    *late = *late || isinf(bound.bound);
    if (status == ISO_OK && !isinf(bound.bound))
        row->bound = bound;
    return status;
}
