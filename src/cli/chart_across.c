/* SPDX-License-Identifier: MIT */
#include "cli/chart_across.h"

#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"
#include "base/provenance.h"
#include "bench/levels_across.h"
#include "chart/across.h"
#include "base/words.h"
#include "tf/presets.h"

enum { USUAL_SIZE = 192, MOST_SIZE = 4096 };
static const char all_designs[] = "default,original,always,tf-2d,gauss,damped,damped-adapted,least-squares,lsq-adapted,"
                                  "fitted,scaled,scaled-original,scaled-damped,naive,eq1,tensor,lsq-directions";

static double error_of(const iso_level_error *e, iso_chart_metric metric)
{
    return metric == ISO_CHART_RMSE ? e->rmse : metric == ISO_CHART_FLIP ? e->flip : e->dssim;
}

static const char *metric_title(iso_chart_metric metric)
{
    return metric == ISO_CHART_RMSE ? "RMSE" : metric == ISO_CHART_FLIP ? "FLIP" : "DSSIM";
}

static iso_status find_size(const iso_chart_across *a, int *size, iso_error *err)
{
    char *end;
    const long n = a->look->size ? strtol(a->look->size, &end, 10) : USUAL_SIZE;
    if (a->look->size && (*end || end == a->look->size))
        return iso_fail(err, ISO_E_USAGE, "--size is \"%s\", --across-levels takes pixels along an edge",
                        a->look->size);
    *size = (int)(n < 0 || n > MOST_SIZE ? MOST_SIZE + 1 : n);
    return iso_words_check_range("--size", *size, 16, MOST_SIZE, err);
}

static const char *name_of_tf(const iso_cli_look *look)
{
    const char *file = look->tf ? look->tf : look->scene;
    return file ? iso_path_base(iso_provenance_name(file)) : "auto";
}

/* Checked before the volume is read, which is needed where its values make the transfer function. */
static iso_status find_tf(const iso_chart_across *a, iso_tf *tf, iso_error *err)
{
    iso_subject_look look;
    iso_scene scene = {0};
    iso_volume v = {0};
    if (a->look->view || a->look->zoom)
        return iso_fail(err, ISO_E_USAGE,
                        "--view and --zoom: --across-levels looks from all sides, at all of the volume");
    iso_status status = iso_cli_look_check(a->look, a->cli->threads, &look, err);
    if (status == ISO_OK && look.scene && !look.tf) {
        status = iso_scene_load(look.scene, &scene, err);
        if (status == ISO_OK)
            status = iso_tf_copy(&scene.tf, tf, err);
        iso_scene_destroy(&scene);
        return status;
    }
    if (status == ISO_OK)
        status = iso_volume_input_load(a->cli->arguments[0], a->input, &v, err);
    if (status == ISO_OK)
        status = iso_tf_of_volume(look.tf, &look.request, &v, a->cli->threads, tf, err);
    iso_volume_destroy(&v);
    return status;
}

static iso_status show(const iso_chart_across *a, const iso_across_chart *chart, const iso_levels_across_row *measured,
                       size_t count, iso_error *err)
{
    iso_across_row *rows = calloc(count + 1, sizeof *rows);
    if (!rows)
        return iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
    for (size_t i = 0; i < count; ++i) {
        const iso_levels_across_row *m = &measured[i];
        rows[i] = (iso_across_row){.design = m->design,
                                   .summary = m->summary,
                                   .scalar = m->scalar,
                                   .treatment = m->treatment,
                                   .directions = m->directions,
                                   .level = m->level,
                                   .bytes = m->bytes,
                                   .seconds = m->seconds,
                                   .error = error_of(&m->full, a->metric),
                                   .error_minified = error_of(&m->minified, a->metric),
                                   .chosen_within = m->chosen_within};
    }
    iso_across_rank(rows, count);
    json_t *json = iso_across_to_json(chart, rows, count), *root = iso_cli_json(a->cli);
    iso_status status = json ? iso_across_write(chart, rows, count, json, err)
                             : iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
    iso_progress_line_hide(a->cli->progress);
    json_object_update(root, json);
    if (status == ISO_OK && a->cli->json) {
        iso_cli_print_json(root);
    } else {
        if (status == ISO_OK)
            iso_across_print(rows, count);
        json_decref(root);
    }
    json_decref(json);
    free(rows);
    return status;
}

iso_status iso_cli_chart_across(const iso_chart_across *a, iso_error *err)
{
    iso_tf tf = {0};
    iso_levels_across_row *rows = NULL;
    size_t count = 0;
    int size = 0;
    iso_cli_expect(a->cli, &(iso_cli_stage){"levels", 1}, 1);
    iso_status status = find_size(a, &size, err);
    if (status == ISO_OK && a->level_count < 2)
        status = iso_fail(err, ISO_E_USAGE, "--levels is %d, --across-levels needs a coarse one: 2 and more",
                          a->level_count);
    if (status == ISO_OK)
        status = find_tf(a, &tf, err);
    const iso_levels_across in = {.cli = a->cli,
                                  .input = a->input,
                                  .volume = a->cli->arguments[0],
                                  .methods = a->designs ? a->designs : all_designs,
                                  .tf = &tf,
                                  .levels = a->level_count,
                                  .views = a->views,
                                  .size = size};
    if (status == ISO_OK)
        status = iso_levels_across_measure(&in, &rows, &count, err);
    const iso_across_chart chart = {.output = a->output,
                                    .volume = iso_provenance_title(a->cli->arguments[0]),
                                    .tf = name_of_tf(a->look),
                                    .metric = metric_title(a->metric),
                                    .style = a->style,
                                    .views = a->views,
                                    .size = size};
    if (status == ISO_OK)
        status = show(a, &chart, rows, count, err);
    free(rows);
    iso_tf_destroy(&tf);
    return status;
}
