/* SPDX-License-Identifier: MIT */
/* result_files.c - the folder of a chart: its table, charts, and the images that commands refer to. */
#define _GNU_SOURCE
#include "chart/result.h"
#include "chart/kept.h"

#include <stdio.h>
#include <stdlib.h>

#include "base/embed.h"
#include "base/file.h"
#include "base/machine.h"
#include "base/provenance.h"
#include "base/version.h"
#include "report/gnuplot.h"

ISO_EMBED(iso_pareto_gp, "src/chart/pareto.gp");

static void put_field(FILE *f, const char *text)
{
    fputs(",\"", f);
    for (const char *c = text ? text : ""; *c; ++c)
        *c == '"' ? fputs("\"\"", f) : fputc(*c, f);
    fputc('"', f);
}

/* Returns flags, the same in every scene: 1 for the fastest within the wanted error, 2 for the smallest. */
static int chosen(const iso_chart_result *r, const iso_chart_case *c)
{
    const size_t which[] = {r->fastest, r->smallest};
    int flags = 0;
    for (int k = 0; k < 2; ++k)
        if (which[k] < r->done_count && r->cases[which[k]].setting == c->setting)
            flags |= 1 << k;
    return flags;
}

/* Writes the results as CSV; pareto.gp finds the columns by their names. */
static char *result_csv(const iso_chart_result *r)
{
    char *text = NULL, machine[320];
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f)
        return NULL;
    json_auto_t *about = iso_machine_describe();
    snprintf(machine, sizeof machine, "%s; %d cores", json_string_value(json_object_get(about, "processor")),
             (int)json_integer_value(json_object_get(about, "cores")));
    fputs("series,setting,renderer,level,shading_from,filter,estimator,tf,quadrature,step_voxels,plan_error,"
          "milliseconds,milliseconds_median,milliseconds_most,frames,setup_milliseconds,device_bytes,stored_bytes,"
          "bytes,error,rmse,max_abs,flip_mean,ssim,time_front,bytes_front,number,chosen,want,metric,"
          "time_kind,bytes_kind,width,height,volume,scene,versions,machine,build_seconds,"
          "renderer_time_front,renderer_bytes_front,command\n",
          f);
    for (size_t i = 0; i < r->done_count; ++i) {
        const iso_chart_case *c = &r->cases[i];
        char series[160], setting[192], shading_from[64], versions[400];
        iso_chart_describe_series(c, series, sizeof series);
        iso_chart_describe(c, setting, sizeof setting);
        iso_chart_name_shading(c, shading_from, sizeof shading_from);
        snprintf(versions, sizeof versions, "isoshade %s; %s", ISO_VERSION,
                 r->versions[iso_renderer_index(c->renderer)]);
        FREED char *typed = iso_chart_command(r, c), *command = typed ? iso_provenance_line(typed) : NULL;
        fprintf(f, "%s,%s,%s,%zu,%s,%s,%s,%s,%s,%g,%g,", series, setting, c->renderer->name, c->level, shading_from,
                iso_direction_filter_name(c->filter), iso_gradient_name(c->estimator), iso_chart_name_tf(c),
                c->preintegrated ? "preintegrated" : "midpoint", c->step_voxels, c->plan_error);
        fprintf(f, "%.9g,%.9g,%.9g,%zu,%.6g,%.12g,%.12g,%.12g,", 1e3 * c->took.seconds, 1e3 * c->took.median_seconds,
                1e3 * c->took.most_seconds, c->took.count, 1e3 * c->took.setup_seconds, c->took.bytes, c->stored_bytes,
                iso_chart_bytes_of(c, r->bytes));
        fprintf(f, "%.9g,%.9g,%.9g,%.9g,%.9g,%d,%d,%zu,%d,%.6g,%s,%s,%s,%zu,%zu", iso_chart_error(c, r->metric),
                c->metrics.rmse, c->metrics.max_abs, c->metrics.flip_mean, c->metrics.ssim, c->on_time_front,
                c->on_bytes_front, c->number, chosen(r, c), r->want, iso_chart_metric_title(r->metric),
                iso_chart_time_kind(r), iso_chart_bytes_kind(r), r->bench->scenes[c->scene].view.width,
                r->bench->scenes[c->scene].view.height);
        put_field(f, iso_provenance_name(r->bench->path));
        put_field(f, iso_chart_scene_title(r, c->scene));
        put_field(f, versions);
        put_field(f, machine);
        fprintf(f, ",%.6g,%d,%d", c->build_seconds, c->on_renderer_time_front, c->on_renderer_bytes_front);
        put_field(f, command);
        fputc('\n', f);
    }
    if (fclose(f) == 0)
        return text;
    free(text);
    return NULL;
}

/* Writes the references and palettes that commands refer to. */
static iso_status write_images(const iso_chart_result *r, const char *dir, iso_error *err)
{
    const iso_image_note notes[] = {{"isoshade:command", r->command_line}, {NULL, NULL}};
    for (size_t i = 0; i < r->bench->scene_count; ++i) {
        char name[192];
        iso_chart_reference_name(r->bench, i, name, sizeof name);
        FREED char *path = iso_path_join(dir, name);
        NEED(path ? iso_image_save_exr(&r->bench->scenes[i].reference, path, notes, err)
                  : iso_fail(err, ISO_E_MEMORY, "chart: out of memory"));
    }
    for (size_t i = 0; i < ISO_CHART_PALETTES; ++i) {
        char name[64];
        snprintf(name, sizeof name, "palette-%zu.csv", iso_chart_palettes[i]);
        if (!r->bench->palettes[i].xyz)
            continue;
        FREED char *path = iso_path_join(dir, name);
        NEED(path ? iso_palette_save_csv(&r->bench->palettes[i], path, err)
                  : iso_fail(err, ISO_E_MEMORY, "chart: out of memory"));
    }
    return ISO_OK;
}

iso_status iso_chart_result_write(const iso_chart_result *r, const char *folder, const json_t *json, iso_error *err)
{
    FREED char *csv = result_csv(r), *path = iso_path_join(folder, "chart.json");
    NEED(csv && path ? iso_json_save(path, json, err) : iso_fail(err, ISO_E_MEMORY, "chart: out of memory"));
    NEED(write_images(r, folder, err));
    NEED(iso_chart_page_write(r, folder, json, err));
    if (r->style)
        NEED(iso_gnuplot_use_style(r->style, folder, err));
    NEED(iso_gnuplot_draw(folder, "pareto", csv, iso_pareto_gp, "svg", err));
    return iso_gnuplot_draw(folder, "pareto", csv, iso_pareto_gp, "pdf", err);
}
