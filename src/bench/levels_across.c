/* SPDX-License-Identifier: MIT */
#include "bench/levels_across.h"

#include <stdlib.h>
#include <string.h>

#include "bench/level_scene.h"
#include "bench/levels_run.h"
#include "plan/auto_choice.h"

enum { SCALAR_BYTES = 2 };

/* Fitted scalars are made of least squares and are none of the filters; they are shown as --adapt does. */
static bool is_fitted(const iso_level_method *m)
{
    return m->make == iso_level_make_fitted || m->make == iso_level_make_for_scene;
}

static const char *treatment_name(const iso_level_method *m)
{
    static const char *const names[] = {[ISO_LEVEL_TF_ORIGINAL] = "original",
                                        [ISO_LEVEL_TF_ADAPTED] = "adapted",
                                        [ISO_LEVEL_TF_ALWAYS] = "adapted",
                                        [ISO_LEVEL_TF_2D] = "2D"};
    return strncmp(m->name, "scaled", 6) == 0 ? "scaled" : names[is_fitted(m) ? ISO_LEVEL_TF_ADAPTED : m->treatment];
}

static const char *scalar_name(const iso_level_method *m)
{
    return is_fitted(m) ? "fitted" : iso_scalar_filter_name(m->scalar);
}

/* The designs that build --auto chooses within each budget, by name. */
static iso_status choose(const iso_levels_run *run, const iso_levels_across *in, const char *chosen[2], iso_error *err)
{
    iso_volume v = {0};
    iso_tf_table table = {0};
    iso_auto_choice choice;
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = (size_t)run->levels;
    opt.threads = in->cli->threads;
    iso_status status = iso_volume_input_load(in->volume, in->input, &v, err);
    if (status == ISO_OK) {
        const iso_volume_stats stats = iso_volume_measure(&v);
        status = iso_tf_tabulate(in->tf, stats.min, stats.max, &v.geometry, &table, err);
    }
    if (status == ISO_OK)
        status = iso_auto_measure(&v, &opt, &table, &choice, NULL, err);
    for (int i = 0; i < 2 && status == ISO_OK; ++i) {
        status = iso_auto_choose(&choice, ISO_AUTO_LEAST_BYTES + i, err);
        chosen[i] = iso_auto_design_at(choice.chosen)->name;
    }
    iso_tf_table_destroy(&table);
    iso_volume_destroy(&v);
    return status;
}

static int chosen_within(const char *const chosen[2], const char *name)
{
    for (int i = 0; i < 2; ++i)
        if (chosen[i] && strcmp(chosen[i], name) == 0)
            return ISO_AUTO_LEAST_BYTES + i;
    return 0;
}

static size_t voxels_of(const iso_geometry *level0, size_t level)
{
    iso_geometry g = *level0;
    for (; level > 0; --level)
        g = iso_geometry_coarser(&g);
    return iso_geometry_voxel_count(&g);
}

static iso_status fill(const iso_levels_run *run, const iso_geometry *level0, const char *const chosen[2],
                       iso_levels_across_row **rows, size_t *count, iso_error *err)
{
    *count = 0;
    *rows = calloc(run->cases.count * iso_level_method_count() + 1, sizeof **rows);
    if (!*rows)
        return iso_fail(err, ISO_E_MEMORY, "no memory for the designs");
    for (size_t m = 0; m < iso_level_method_count(); ++m)
        for (size_t i = 0; i < run->cases.count && run->cases.wanted[m]; ++i) {
            const iso_level_method *method = iso_level_method_at(m);
            const iso_level_case *c = &run->cases.cases[i];
            (*rows)[(*count)++] = (iso_levels_across_row){
                .design = method->name,
                .summary = method->summary,
                .level = c->level,
                .bytes = (SCALAR_BYTES + method->bytes) * (double)voxels_of(level0, c->level),
                .seconds = c->results[m].seconds,
                .full = c->results[m].full,
                .minified = c->results[m].minified,
                .scalar = scalar_name(method),
                .treatment = treatment_name(method),
                .directions = iso_direction_filter_name(method->directions),
                .chosen_within = chosen_within(chosen, method->name)};
        }
    return ISO_OK;
}

static iso_status geometry_of(const iso_levels_across *in, iso_geometry *g, iso_error *err)
{
    iso_volume_source *source = NULL;
    const iso_status status = iso_volume_input_open(in->volume, in->input, &source, err);
    if (status == ISO_OK)
        *g = iso_source_volume(source)->geometry;
    iso_source_close(source);
    return status;
}

iso_status iso_levels_across_measure(const iso_levels_across *in, iso_levels_across_row **rows, size_t *count,
                                     iso_error *err)
{
    iso_levels_run *run = calloc(1, sizeof *run);
    const char *chosen[2] = {NULL, NULL};
    iso_geometry g;
    if (!run)
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    *run = (iso_levels_run){.cli = in->cli,
                            .input = *in->input,
                            .views = in->views,
                            .size = in->size,
                            .levels = in->levels,
                            .step_voxels = 0.5,
                            .renderer = iso_renderers_usual(),
                            .own_tf = in->tf,
                            .silent = true,
                            .volume_count = 1,
                            .named_count = 1,
                            .volumes = {in->volume}};
    const iso_progress progress = iso_cli_progress(in->cli);
    iso_status status = iso_level_methods_choose(in->methods, run->cases.wanted, err);
    if (status == ISO_OK)
        status = geometry_of(in, &g, err);
    if (status == ISO_OK)
        status = choose(run, in, chosen, err);
    if (status == ISO_OK)
        status = iso_levels_run_volume(run, &progress, err);
    if (status == ISO_OK)
        status = fill(run, &g, chosen, rows, count, err);
    iso_level_cases_destroy(&run->cases);
    iso_renderers_end(&run->renderers);
    free(run);
    return status;
}
