/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "chart/across.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "base/file.h"
#include "base/json.h"
#include "chart/pareto.h"
#include "report/gnuplot.h"

ISO_EMBED(iso_across_gp, "src/chart/across.gp");

enum { MOST_DESIGNS = 64, MOST_ROWS = 64 * 32 };
static const double no_error = 1e-9;

/* ---- fronts ---- */

void iso_across_rank(iso_across_row *rows, size_t count)
{
    double cost[MOST_ROWS] = {0}, error[MOST_ROWS] = {0};
    bool front[MOST_ROWS];
    count = count < MOST_ROWS ? count : MOST_ROWS;
    for (size_t i = 0; i < count; ++i) {
        size_t first = 0; /* the first design has its level there */
        while (rows[first].level != rows[i].level)
            ++first;
        rows[i].ratio = (rows[i].error + no_error) / (rows[first].error + no_error);
        rows[i].ratio_minified = (rows[i].error_minified + no_error) / (rows[first].error_minified + no_error);
        error[i] = rows[i].error;
        cost[i] = rows[i].bytes;
    }
    iso_pareto_front(cost, error, count, front);
    for (size_t i = 0; i < count; ++i) {
        rows[i].bytes_front = front[i];
        cost[i] = rows[i].seconds;
    }
    iso_pareto_front(cost, error, count, front);
    for (size_t i = 0; i < count; ++i)
        rows[i].time_front = front[i];
}

static void add_row(const iso_across_row *row, iso_across_design *d)
{
    d->ratio += log(row->ratio);
    d->ratio_minified += log(row->ratio_minified);
    d->bytes += row->bytes;
    d->seconds += row->seconds;
}

size_t iso_across_designs(const iso_across_row *rows, size_t count, iso_across_design *designs, size_t most)
{
    double cost[MOST_DESIGNS] = {0}, error[MOST_DESIGNS] = {0};
    bool front[MOST_DESIGNS];
    size_t n = 0, levels = 0;
    most = most < MOST_DESIGNS ? most : MOST_DESIGNS;
    for (size_t i = 0; i < count; ++i) {
        if (i == 0 || strcmp(rows[i].design, rows[i - 1].design) != 0) {
            if (n == most)
                break;
            designs[n++] = (iso_across_design){.name = rows[i].design, .chosen_within = rows[i].chosen_within};
        }
        levels += n == 1;
        add_row(&rows[i], &designs[n - 1]);
    }
    for (size_t d = 0; d < n; ++d) {
        designs[d].ratio = exp(designs[d].ratio / (double)levels);
        designs[d].ratio_minified = exp(designs[d].ratio_minified / (double)levels);
        designs[d].seconds /= (double)levels;
        error[d] = designs[d].ratio_minified;
        cost[d] = designs[d].bytes;
    }
    iso_pareto_front(cost, error, n, front);
    for (size_t d = 0; d < n; ++d) {
        designs[d].bytes_front = front[d];
        cost[d] = designs[d].seconds;
    }
    iso_pareto_front(cost, error, n, front);
    for (size_t d = 0; d < n; ++d)
        designs[d].time_front = front[d];
    return n;
}

/* ---- files ---- */

static char *rows_csv(const iso_across_chart *c, const iso_across_row *rows, size_t count)
{
    iso_across_design designs[MOST_DESIGNS];
    const size_t n = iso_across_designs(rows, count, designs, MOST_DESIGNS);
    char *text = NULL;
    size_t size = 0, at = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f)
        return NULL;
    fprintf(f, "design,at,level,scalar,treatment,directions,bytes,milliseconds,error,error_minified,bytes_front,"
               "time_front,ratio,ratio_minified,design_ratio_minified,auto,metric,volume,tf,views,size\n");
    for (size_t i = 0; i < count; ++i) {
        while (at + 1 < n && strcmp(designs[at].name, rows[i].design) != 0)
            ++at;
        const iso_across_row *r = &rows[i];
        fprintf(f, "%s,%zu,%zu,%s,%s,%s,%.9g,%.9g,%.9g,%.9g,%d,%d,%.9g,%.9g,%.9g,%d,%s,\"%s\",\"%s\",%d,%d\n",
                r->design, at, r->level, r->scalar, r->treatment, r->directions, r->bytes, 1e3 * r->seconds, r->error,
                r->error_minified, r->bytes_front, r->time_front, r->ratio, r->ratio_minified,
                designs[at].ratio_minified, r->chosen_within, c->metric, c->volume, c->tf, c->views, c->size);
    }
    if (fclose(f) == 0)
        return text;
    free(text);
    return NULL;
}

iso_status iso_across_write(const iso_across_chart *c, const iso_across_row *rows, size_t count, const json_t *json,
                            iso_error *err)
{
    iso_output out;
    iso_status status = iso_output_begin_dir(&out, c->output, "chart.json", err);
    if (status != ISO_OK)
        return status;
    char *csv = rows_csv(c, rows, count), *path = iso_path_join(out.temp_path, "chart.json");
    if (!csv || !path)
        status = iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
    if (status == ISO_OK)
        status = iso_json_save(path, json, err);
    if (status == ISO_OK && c->style)
        status = iso_gnuplot_use_style(c->style, out.temp_path, err);
    const char *const formats[] = {"svg", "pdf"};
    for (size_t i = 0; i < 2 && status == ISO_OK; ++i)
        status = iso_gnuplot_draw(out.temp_path, "across", csv, iso_across_gp, formats[i], err);
    if (status == ISO_OK)
        status = iso_output_commit(&out, err);
    iso_output_abandon(&out);
    free(csv);
    free(path);
    return status;
}

json_t *iso_across_to_json(const iso_across_chart *c, const iso_across_row *rows, size_t count)
{
    iso_across_design designs[MOST_DESIGNS];
    const size_t n = iso_across_designs(rows, count, designs, MOST_DESIGNS);
    json_t *list = json_array(), *levels = json_array();
    for (size_t d = 0; d < n; ++d)
        json_array_append_new(list, json_pack("{s:s, s:f, s:f, s:f, s:f, s:b, s:b, s:i}", "design", designs[d].name,
                                              "bytes", designs[d].bytes, "milliseconds", 1e3 * designs[d].seconds,
                                              "ratio", designs[d].ratio, "ratio_minified", designs[d].ratio_minified,
                                              "bytes_front", designs[d].bytes_front, "time_front",
                                              designs[d].time_front, "chosen_within", designs[d].chosen_within));
    for (size_t i = 0; i < count; ++i)
        json_array_append_new(levels, json_pack("{s:s, s:i, s:f, s:f, s:f, s:f, s:b, s:b}", "design", rows[i].design,
                                                "level", (int)rows[i].level, "bytes", rows[i].bytes, "milliseconds",
                                                1e3 * rows[i].seconds, "error", rows[i].error, "error_minified",
                                                rows[i].error_minified, "bytes_front", rows[i].bytes_front,
                                                "time_front", rows[i].time_front));
    return json_pack("{s:s, s:s, s:s, s:i, s:i, s:o, s:o}", "volume", c->volume, "tf", c->tf, "metric", c->metric,
                     "views", c->views, "size", c->size, "designs", list, "levels", levels);
}

void iso_across_print(const iso_across_row *rows, size_t count)
{
    iso_across_design designs[MOST_DESIGNS];
    const size_t n = iso_across_designs(rows, count, designs, MOST_DESIGNS);
    printf("error over that of %s, all levels together; * on the front by bytes, + by time, of the minified error\n"
           "%-18s %9s %9s %10s %8s\n",
           n > 0 ? designs[0].name : "the first", "design", "minified", "rendered", "bytes", "ms");
    for (size_t d = 0; d < n; ++d) {
        const iso_across_design *one = &designs[d];
        printf("%-18s %9.3f %9.3f %10.0f %8.2f %s%s", one->name, one->ratio_minified, one->ratio, one->bytes,
               1e3 * one->seconds, one->bytes_front ? "*" : " ", one->time_front ? "+" : "");
        if (one->chosen_within > 0)
            printf("  chosen by --auto --budget %d", one->chosen_within);
        printf("\n");
    }
}
