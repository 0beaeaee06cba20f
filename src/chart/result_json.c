/* SPDX-License-Identifier: MIT */
/* result_json.c - the result of a chart as JSON. */
#include <stdio.h>
#include <stdlib.h>

#include "base/machine.h"
#include "base/provenance.h"
#include "base/version.h"
#include "chart/kept.h"
#include "chart/result.h"

static json_t *case_json(const iso_chart_result *r, const iso_chart_case *c)
{
    char shading_from[64], setting[192];
    iso_chart_name_shading(c, shading_from, sizeof shading_from);
    iso_chart_describe(c, setting, sizeof setting);
    FREED char *typed = iso_chart_command(r, c), *command = typed ? iso_provenance_line(typed) : NULL;
    json_t *o = json_pack("{s:s, s:s, s:I, s:s, s:s, s:s, s:s, s:s, s:f}", "setting", setting, "renderer",
                          c->renderer->name, "level", (json_int_t)c->level, "shading_from", shading_from, "filter",
                          iso_direction_filter_name(c->filter), "estimator", iso_gradient_name(c->estimator), "tf",
                          iso_chart_name_tf(c), "quadrature", c->preintegrated ? "preintegrated" : "midpoint",
                          "step_voxels", c->step_voxels);
    if (c->plan_error > 0)
        json_object_set_new(o, "plan_error", json_real(c->plan_error));
    json_object_update_new(o, json_pack("{s:f, s:f, s:f, s:I, s:f, s:f, s:f}", "milliseconds", 1e3 * c->took.seconds,
                                        "milliseconds_median", 1e3 * c->took.median_seconds, "milliseconds_most",
                                        1e3 * c->took.most_seconds, "frames", (json_int_t)c->took.count,
                                        "setup_milliseconds", 1e3 * c->took.setup_seconds, "device_bytes",
                                        c->took.bytes, "stored_bytes", c->stored_bytes));
    if (c->build_seconds > 0)
        json_object_set_new(o, "build_seconds", json_real(c->build_seconds));
    json_object_update_new(o, iso_metrics_to_json(&c->metrics));
    json_object_set_new(o, "scene", json_string(r->bench->scenes[c->scene].name));
    json_object_set_new(o, "on_time_front", json_boolean(c->on_time_front));
    json_object_set_new(o, "on_bytes_front", json_boolean(c->on_bytes_front));
    json_object_set_new(o, "on_renderer_time_front", json_boolean(c->on_renderer_time_front));
    json_object_set_new(o, "on_renderer_bytes_front", json_boolean(c->on_renderer_bytes_front));
    json_object_set_new(o, "kept", json_boolean(c->kept));
    if (c->number > 0)
        json_object_set_new(o, "number", json_integer((json_int_t)c->number));
    json_object_set_new(o, "command", json_string(command ? command : ""));
    return o;
}

static json_t *strings_json(const char (*texts)[320])
{
    json_t *o = json_object();
    for (size_t i = 0; i < iso_renderer_count(); ++i)
        if (texts[i][0])
            json_object_set_new(o, iso_renderer_at(i)->name, json_string(texts[i]));
    return o;
}

static json_t *want_json(const iso_chart_result *r)
{
    json_t *want = json_pack("{s:s, s:f}", "metric", iso_chart_metric_name(r->metric), "error", r->want);
    const char *const keys[] = {"fastest", "smallest", "best"};
    const size_t chosen[] = {r->fastest, r->smallest, r->best};
    for (int k = 0; k < 3; ++k)
        json_object_set_new(want, keys[k],
                            chosen[k] < r->done_count ? case_json(r, &r->cases[chosen[k]]) : json_null());
    return want;
}

static json_t *scenes_json(const iso_chart_result *r)
{
    json_t *list = json_array();
    for (size_t i = 0; i < r->bench->scene_count; ++i) {
        const iso_chart_scene *s = &r->bench->scenes[i];
        char reference[192];
        iso_chart_reference_name(r->bench, i, reference, sizeof reference);
        json_t *o = json_pack("{s:s, s:s, s:[I,I], s:s, s:f, s:f}", "name", s->name, "scene",
                              iso_chart_scene_title(r, i), "image", (json_int_t)s->view.width,
                              (json_int_t)s->view.height, "reference", reference, "reference_tolerance",
                              s->reference_tolerance, "reference_seconds", s->reference_seconds);
        if (r->viewers[i][0])
            json_object_set_new(o, "viewer", json_string(r->viewers[i]));
        json_array_append_new(list, o);
    }
    return list;
}

/* Adds a setting's values on the axes as keys, "level 2", "step 0.5", unless `without` has them. */
static void add_values(const iso_chart_case *c, const json_t *without, json_t *to)
{
    enum { MOST = 64 };
    char values[6][96];
    iso_chart_describe_series(c, values[0], sizeof *values);
    snprintf(values[1], sizeof *values, "level %zu", c->level);
    snprintf(values[2], sizeof *values, "step %g", c->step_voxels);
    snprintf(values[3], sizeof *values, "filter %s", iso_direction_filter_name(c->filter));
    snprintf(values[4], sizeof *values, "estimator %s", iso_gradient_name(c->estimator));
    snprintf(values[5], sizeof *values, "%s%s",
             c->preintegrated ? "pre-integration"
             : c->level > 0   ? "TF "
                              : "midpoints",
             !c->preintegrated && c->level > 0 ? iso_chart_name_tf(c) : "");
    for (size_t i = 0; i < 6; ++i)
        if (json_object_size(to) < MOST && !json_object_get(without, values[i]))
            json_object_set_new(to, values[i], json_true());
}

json_t *iso_chart_untried(const iso_chart_result *r)
{
    json_auto_t *tried = json_object();
    json_t *untried = json_object();
    for (size_t i = 0; i < r->count; ++i)
        add_values(&r->cases[i], i < r->done_count ? NULL : tried, i < r->done_count ? tried : untried);
    return untried;
}

json_t *iso_chart_result_json(const iso_chart_result *r)
{
    json_t *root = json_pack("{s:s, s:s}", "schema", "isoshade.chart/2", "command", r->command_line),
           *cases = json_array(), *names = json_array();
    const iso_chart_scene *first = &r->bench->scenes[0];
    json_auto_t *untried = iso_chart_untried(r);
    const char *value;
    json_t *unused;
    json_object_set_new(root, "options",
                        json_pack("{s:s, s:s, s:s, s:s, s:s, s:f, s:[I,I]}", "volume",
                                  iso_provenance_name(r->bench->path), "scene", iso_chart_scene_title(r, 0), "metric",
                                  iso_chart_metric_name(r->metric), "time", iso_chart_time_kind(r), "bytes",
                                  iso_chart_bytes_kind(r), "budget_seconds", r->budget_seconds, "image",
                                  (json_int_t)first->view.width, (json_int_t)first->view.height));
    json_object_set_new(root, "scenes", scenes_json(r));
    json_object_set_new(root, "isoshade", json_string(ISO_VERSION));
    json_object_set_new(root, "versions", strings_json(r->versions));
    json_object_set_new(root, "machine", iso_machine_describe());
    json_object_set_new(root, "spent_seconds", json_real(r->spent_seconds));
    json_object_set_new(root, "reference_seconds", json_real(first->reference_seconds));
    json_object_set_new(root, "kept_count", json_integer((json_int_t)r->kept_count));
    json_object_set_new(root, "skipped_count", json_integer((json_int_t)(r->count - r->done_count - r->refused_count)));
    json_object_set_new(root, "refused_count", json_integer((json_int_t)r->refused_count));
    json_object_set_new(root, "left_out", strings_json(r->left_out));
    json_object_foreach (untried, value, unused)
        json_array_append_new(names, json_string(value));
    json_object_set_new(root, "untried", names);
    if (r->want > 0)
        json_object_set_new(root, "want", want_json(r));
    for (size_t i = 0; i < r->done_count; ++i)
        json_array_append_new(cases, case_json(r, &r->cases[i]));
    json_object_set_new(root, "cases", cases);
    return root;
}
