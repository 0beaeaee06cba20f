/* SPDX-License-Identifier: MIT */
/* versions.c - compares two versions of a program. Each is compared with the reference by its limit; here the limits
 * are compared with each other, seed by seed, so that the scatter over seeds is part of the difference. Two images of
 * one program are identical. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/json.h"
#include "base/parallel.h"
#include "validate/limits.h"
#include "validate/validate.h"

bool iso_validate_has_versions(const iso_validation *v, const iso_renderer_info *renderer)
{
    for (size_t i = 0; i < iso_renderer_count(); ++i) {
        const iso_renderer_info *other = iso_renderer_at(i);
        if (v->wanted[i] && other->beside && (other == renderer || other->beside == renderer))
            return true;
    }
    return false;
}

static json_t *change_to_json(const iso_extrapolated_change *c)
{
    return json_pack("{s:o, s:o, s:[I,I], s:s#, s:I, s:I, s:o, s:o}", "largest_change", iso_json_number(c->largest),
                     "noise_there", iso_json_number(c->noise), "pixel", (json_int_t)c->column, (json_int_t)c->row,
                     "channel", "RGBA" + c->channel, 1, "pixels_tested", (json_int_t)c->test.tests,
                     "pixels_beyond_chance", (json_int_t)c->test.rejected, "signed_bias", iso_json_number(c->test.bias),
                     "standard_error_of_bias", iso_json_number(c->test.bias_error));
}

iso_status iso_validate_versions(iso_validation *v, size_t level, const iso_version_limit *first,
                                 const iso_version_limit *other, iso_error *err)
{
    const double start = iso_clock_seconds();
    const iso_extrapolated *a = first->limit, *b = other->limit;
    iso_extrapolated_change change;
    char why[256], faint[512];
    iso_report_agreement row = {.level = level,
                                .order = v->order,
                                .scene = v->scene_name,
                                .a = first->renderer->name,
                                .renderer = other->renderer->name,
                                .comparison = ISO_COMPARISON_VERSIONS,
                                .variant = v->variant,
                                .image_a = first->image_name,
                                .image_b = other->image_name,
                                .tier = "versions",
                                .error_bar = hypot(a->bar, b->bar),
                                .why = why};
    row.tolerances = (iso_tolerances){.rmse = row.error_bar + ISO_EXTRAPOLATION_ROUNDING};
    NEED(iso_metrics_measure(&a->image, &b->image, &row.metrics, err));
    NEED(iso_signal_of(&a->image, v->view->background, hypot(iso_extrapolated_held_to(a), iso_extrapolated_held_to(b)),
                       ISO_SIGNAL_RMS, &row.signal, err));
    NEED(iso_extrapolated_compare(a, b, &change, err));
    if (change.largest > 0 && !iso_signal_suffices(&row.signal)) { /* equal images leave no doubt */
        iso_signal_explain(&row.signal, faint, sizeof faint);
        row.uncompared = ISO_UNCOMPARED_FAINT;
        row.uncompared_why = faint;
    }
    row.gates[row.gate_count++] = (iso_report_gate){ISO_GATE_PIXELS, (double)change.test.rejected, 0};
    row.gates[row.gate_count++] = (iso_report_gate){ISO_GATE_BIAS, change.test.biased, 0};
    row.statistics = change_to_json(&change);
    snprintf(why, sizeof why,
             "both limits have error bars; the largest change is %.2g, in column %zu, row %zu, where the seeds scatter it "
             "by %.2g (standard error)",
             change.largest, change.column, change.row, change.noise);
    char *command = iso_validate_reproduce(v, level, other->renderer, other->options, first->image_name, &row.tolerances);
    row.command = command;
    row.seconds = iso_clock_seconds() - start;
    iso_status status = iso_report_add_agreement(v->report, &row, err);
    json_decref(row.statistics);
    free(command);
    return status;
}
