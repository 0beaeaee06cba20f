/* SPDX-License-Identifier: MIT */
/* scales.c - levels that are handed over with extinction scales (fit/extinction_scale.h): made, and asked two
 * questions that pictures alone leave open. Are the bytes those that level 0 makes, for this level and this transfer
 * function? And does the renderer that draws the views use them? If not, it shows the same without them. */
#include <stdlib.h>
#include <string.h>

#include "fit/extinction_scale.h"
#include "validate/measured.h"

static iso_status make_table(const iso_validation *v, size_t level, iso_tf_table *table, iso_error *err)
{
    iso_adapt_options opt = iso_adapt_defaults();
    opt.threads = v->threads;
    opt.fall_back = false;
    return v->scales == ISO_SCALES_ADAPTED ? iso_adapt_level(v->pyramid, level, &v->view->tf, &opt, table, NULL, err)
                                           : iso_tf_table_copy(&v->view->tf, table, err);
}

iso_status iso_validate_scale(iso_validation *v, iso_error *err)
{
    for (size_t level = 1; v->scales != ISO_SCALES_NONE && level < v->pyramid->level_count; ++level) {
        iso_level_tf *own = &v->level_tfs[level];
        iso_progress_report(v->progress, "extinction scales", (double)level / (double)v->pyramid->level_count);
        NEED(make_table(v, level, &own->scaled_table, err));
        NEED(iso_extinction_scale_level(v->pyramid, level, &v->view->tf, &own->scaled_table, v->threads,
                                        &own->extinction_scale, err));
    }
    return ISO_OK;
}

/* Counts voxels whose byte differs from the one that level 0 makes. */
static iso_status compare_with_made(const iso_validation *v, const iso_pyramid *rebuilt, iso_report_level *row,
                                    iso_error *err)
{
    const iso_level_tf *own = &v->level_tfs[row->level];
    const size_t count = iso_geometry_voxel_count(&v->pyramid->levels[row->level].geometry);
    FREED uint8_t *made = NULL;
    NEED(iso_extinction_scale_level(rebuilt, row->level, &v->view->tf, &own->scaled_table, v->threads, &made, err));
    for (size_t i = 0; i < count; ++i) {
        row->scale.differing += own->extinction_scale[i] != made[i];
        row->scale.scaled += made[i] != ISO_EXTINCTION_SCALE_ONE;
    }
    return ISO_OK;
}

/* Sets *effect if view i differs from the same view without a scale, which is a scale of 1 everywhere. */
static iso_status has_effect(iso_validation *v, size_t level, size_t i, bool *effect, iso_error *err)
{
    const iso_measured_level shown = {.level = level, .method = &iso_method_stored, .use = ISO_USE_SCALED};
    uint8_t *bytes = v->level_tfs[level].extinction_scale;
    OWNED(iso_image) with = {0}, without = {0};
    iso_status status = iso_validate_render_level(v, v->pyramid, &shown, i, &with, err);
    v->level_tfs[level].extinction_scale = NULL;
    TRY(status, iso_validate_render_level(v, v->pyramid, &shown, i, &without, err));
    v->level_tfs[level].extinction_scale = bytes;
    if (status == ISO_OK)
        *effect = memcmp(with.rgba, without.rgba, 4 * with.width * with.height * sizeof *with.rgba) != 0;
    return status;
}

iso_status iso_validate_judge_scale(iso_validation *v, const iso_pyramid *rebuilt, iso_report_level *row, iso_error *err)
{
    const iso_level *level = &v->pyramid->levels[row->level];
    if (v->scales == ISO_SCALES_NONE || level->scale || level->is_optimized) /* not made from level 0 alone */
        return ISO_OK;
    row->scale.judged = true;
    iso_status status = compare_with_made(v, rebuilt, row, err);
    row->scale.has_effect = row->scale.scaled == 0 || !row->shown;
    for (size_t i = 0; i < v->consistency_views && status == ISO_OK && !row->scale.has_effect; ++i)
        status = has_effect(v, row->level, i, &row->scale.has_effect, err);
    return status;
}
