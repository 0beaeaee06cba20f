/* SPDX-License-Identifier: MIT */
#include "cli/tf.h"


#include <math.h>
#include <stdio.h>

#include "render/image_bound.h"
#include "options/visible.h"

/* Computes the bounds of one level for the scene's transfer function and for the adapted one. */
static iso_status bound_level(const iso_tf_arguments *a, const iso_pyramid *p, const iso_view *view, size_t level,
                              double rmse[2], iso_error *err)
{
    const char *path = a->cli->arguments[1];
    iso_adapt_options opt;
    OWNED(iso_tf_table) table = {0};
    NEED(iso_cli_adapt_options(&a->adapted, a->cli->threads, &opt, err));
    opt.folder = iso_pyramid_is_one(path) ? path : NULL;
    NEED(iso_adapt_level(p, level, &view->tf, &opt, &table, NULL, err));
    const iso_tf_table *tfs[2] = {&view->tf, &table};
    for (int i = 0; i < 2; ++i) {
        const iso_image_bound_input in = {.fine = &p->levels[0],
                                          .coarse = &p->levels[level],
                                          .level = level,
                                          .code = p->options.code,
                                          .source = ISO_FROM_CODES,
                                          .view = view,
                                          .coarse_tf = tfs[i],
                                          .threads = a->cli->threads};
        NEED(iso_image_bound_rmse(&in, &rmse[i], err));
    }
    return ISO_OK;
}

static iso_status bound_levels(const iso_tf_arguments *a, const iso_pyramid *p, const iso_view *view, json_t *levels,
                               iso_error *err)
{
    const iso_progress progress = iso_cli_progress(a->cli);
    for (size_t level = 1; level < p->level_count; ++level) {
        double rmse[2] = {NAN, NAN};
        iso_progress_report(&progress, ISO_TF_LEVELS_STAGE, (double)(level - 1) / (double)(p->level_count - 1));
        if (a->level > 0 && (size_t)a->level != level)
            continue;
        NEED(bound_level(a, p, view, level, rmse, err));
        json_array_append_new(levels, json_pack("{s:i, s:f, s:f}", "level", (int)level, "rmse_bound", rmse[0],
                                                "rmse_bound_adapted", rmse[1]));
        if (!a->cli->json)
            printf("level %zu  RMSE at most %.4f, with --adapt %.4f\n", level, rmse[0], rmse[1]);
    }
    iso_progress_report(&progress, ISO_TF_LEVELS_STAGE, 1);
    return ISO_OK;
}

iso_status iso_cli_tf_bound(const iso_tf_arguments *a, iso_error *err)
{
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_progress progress = iso_cli_progress(a->cli);
    OWNED(iso_pyramid) p = {0};
    OWNED(iso_view) view = {0};
    iso_subject_look look;
    iso_adapt_options checked;
    json_auto_t *levels = json_array();
    iso_cli_tf_expect_levels(a->cli);
    build.threads = a->cli->threads;
    build.level_count = (size_t)(a->level > 0 ? a->level + 1 : a->level_count);
    if (a->cli->argument_count != 2)
        return iso_fail(err, ISO_E_USAGE, "usage: isoshade tf bound VOLUME|PYRAMID.iso [--scene FILE.scene.json]");
    NEED(iso_cli_look_check(&a->look, a->cli->threads, &look, err));
    NEED(iso_cli_adapt_options(&a->adapted, a->cli->threads, &checked, err));
    NEED(iso_subject_load_pyramid(a->cli->arguments[1], &a->input, &build, &progress, &p, err));
    if (p.levels[0].geometry.has_no_data)
        return iso_fail(err, ISO_E_RANGE, "%s: some voxels have no data, for which there is no bound",
                        a->cli->arguments[1]);
    NEED(iso_subject_refuse_labels(&p, a->cli->arguments[1], "the bound", err));
    NEED(iso_pyramid_check_level(&p, a->cli->arguments[1], (size_t)a->level, err));
    NEED(iso_subject_make_view(&look, &p, &view, err));
    iso_cli_warn_view(a->cli, &p, &view, NULL, &(bool){false});
    NEED(bound_levels(a, &p, &view, levels, err));
    if (a->cli->json)
        iso_cli_print_results(a->cli, json_pack("{s:O}", "levels", levels));
    return ISO_OK;
}
