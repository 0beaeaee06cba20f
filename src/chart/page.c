/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "chart/result.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "base/file.h"
#include "base/provenance.h"
#include "chart/picture.h"
#include "report/page.h"

ISO_EMBED(iso_chart_html, "src/chart/chart.html");
ISO_EMBED(iso_chart_css, "src/chart/chart.css");
ISO_EMBED(iso_chart_page_js, "src/chart/chart_page.js");
ISO_EMBED(iso_chart_plot_js, "src/chart/chart_plot.js");

static const iso_page chart_page = {"isoshade chart",
                                    iso_chart_html,
                                    {iso_report_js, iso_chart_plot_js, iso_chart_page_js},
                                    iso_chart_css};

/* Total size of the embedded pictures, so that browsers open the page at once. Pictures of settings on a front are
 * always included. */
static const size_t MOST_PICTURE_BYTES = 12000000;

static bool is_on_front(const iso_chart_case *c)
{
    return c->on_time_front || c->on_bytes_front || c->on_renderer_time_front || c->on_renderer_bytes_front ||
           c->number > 0;
}

/* Collects the pictures; the keys are case numbers. */
static json_t *pictures_json(const iso_chart_result *r)
{
    json_t *pictures = json_object();
    size_t bytes = 0;
    for (int pass = 0; pass < 2; ++pass) /* fronts first */
        for (size_t i = 0; i < r->done_count; ++i) {
            const iso_chart_case *c = &r->cases[i];
            const size_t length = c->picture ? strlen(c->picture) : 0;
            char key[24];
            if (length == 0 || is_on_front(c) != (pass == 0) || (pass == 1 && bytes + length > MOST_PICTURE_BYTES))
                continue;
            bytes += length;
            snprintf(key, sizeof key, "%zu", i);
            json_object_set_new(pictures, key, json_string(c->picture));
        }
    return pictures;
}

static json_t *references_json(const iso_chart_result *r)
{
    json_t *list = json_array();
    for (size_t i = 0; i < r->bench->scene_count; ++i) {
        FREED char *uri = iso_chart_picture(&r->bench->scenes[i].reference);
        json_array_append_new(list, json_string(uri ? uri : ""));
    }
    return list;
}

static void sentence_of(const iso_chart_result *r, char *text, size_t size)
{
    char name[192] = "";
    size_t time = 0, bytes = 0;
    for (size_t i = 0; i < r->done_count; ++i) {
        time += r->cases[i].on_time_front;
        bytes += r->cases[i].on_bytes_front;
    }
    if (r->want > 0 && r->fastest < r->done_count) {
        iso_chart_describe(&r->cases[r->fastest], name, sizeof name);
        snprintf(text, size, "The fastest of %zu measured with %s of at most %.3g is %s: %.3g ms a frame.",
                 r->done_count, iso_chart_metric_title(r->metric), r->want, name,
                 1e3 * iso_chart_worst_seconds(r, &r->cases[r->fastest]));
    } else if (r->want > 0) {
        snprintf(text, size, "None of %zu measured has %s of at most %.3g.", r->done_count,
                 iso_chart_metric_title(r->metric), r->want);
    } else {
        snprintf(text, size, "%zu measured: %zu on the time front, %zu on the bytes front.", r->done_count, time,
                 bytes);
    }
}

static json_t *colors_json(void)
{
    json_t *colors = json_object();
    for (size_t i = 0; i < iso_renderer_count(); ++i)
        if (iso_renderer_at(i)->color)
            json_object_set_new(colors, iso_renderer_at(i)->name, json_string(iso_renderer_at(i)->color));
    return colors;
}

iso_status iso_chart_page_write(const iso_chart_result *r, const char *folder, const json_t *json, iso_error *err)
{
    char sentence[512];
    FREED char *path = iso_path_join(folder, "index.html");
    json_auto_t *data = json_copy((json_t *)json); /* shallow */
    const json_t *settings = json_object_get(json, "cases");
    sentence_of(r, sentence, sizeof sentence);
    json_object_update_new(data,
                           json_pack("{s:s, s:s, s:s, s:o, s:s, s:f}", "title", iso_provenance_title(r->bench->path),
                                     "sentence", sentence, "metric_title", iso_chart_metric_title(r->metric), "colors",
                                     colors_json(), "metric", iso_chart_metric_name(r->metric), "wanted", r->want));
    json_t *figures = json_array();
    for (size_t i = 0; i < r->done_count && i < json_array_size(settings); ++i) {
        const iso_chart_case *c = &r->cases[i];
        char series[160];
        iso_chart_describe_series(c, series, sizeof series);
        json_array_append_new(figures, json_pack("{s:s, s:o, s:f}", "series", series, "error",
                                                 iso_json_number(iso_chart_error(c, r->metric)), "bytes",
                                                 iso_chart_bytes_of(c, r->bytes)));
    }
    json_object_set_new(data, "figures", figures); /* parallel to the cases */
    json_auto_t *inlined = json_pack("{s:o, s:o}", "pictures", pictures_json(r), "references", references_json(r));
    return path && inlined ? iso_page_write(path, &chart_page, data, inlined, err)
                           : iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
}
