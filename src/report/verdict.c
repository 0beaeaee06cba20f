/* SPDX-License-Identifier: MIT */
/* verdict.c - verdict and severity of a row. */
#include <math.h>

#include "compare/statistics.h"
#include "report/report.h"

/* Returns the largest ratio of a metric to its limit; infinite if nothing can be measured. */
double iso_report_severity(const iso_report_agreement *row)
{
    const iso_metrics *m = &row->metrics;
    if (row->refused || m->nonfinite_count > 0 || !isfinite(m->max_abs))
        return INFINITY;
    const double pairs[][2] = {
        {m->rmse, row->tolerances.rmse},           {m->max_abs, row->tolerances.max_abs},
        {m->p99_abs, row->tolerances.p99_abs},     {1 - m->ssim, row->tolerances.ssim_dissimilarity},
        {m->flip_mean, row->tolerances.flip_mean},
    };
    double worst = 0;
    bool asked = false;
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; ++i)
        if (pairs[i][1] > 0) {
            asked = true;
            worst = iso_larger(worst, pairs[i][0] / pairs[i][1]);
        }
    if (!asked && row->gate_count == 0)
        return m->max_abs > 0 ? INFINITY : 0;
    for (size_t i = 0; i < row->gate_count; ++i) {
        const iso_report_gate *g = &row->gates[i];
        double ratio = g->limit > 0 ? g->value / g->limit : g->value <= 0 ? 0 : INFINITY;
        if (isnan(ratio))
            return INFINITY;
        worst = fmax(worst, ratio);
    }
    return isnan(worst) ? INFINITY : worst;
}

static bool gates_hold(const iso_report_agreement *row)
{
    for (size_t i = 0; i < row->gate_count; ++i)
        if (!(row->gates[i].value <= row->gates[i].limit))
            return false;
    return true;
}

static bool has_tolerances(const iso_tolerances *l)
{
    return l->rmse > 0 || l->max_abs > 0 || l->p99_abs > 0 || l->ssim_dissimilarity > 0 || l->flip_mean > 0;
}

iso_verdict iso_report_verdict(const iso_report_agreement *row)
{
    if (row->refused)
        return ISO_VERDICT_REFUSED;
    const bool metrics = row->gate_count > 0 && !has_tolerances(&row->tolerances)
                             ? row->metrics.nonfinite_count == 0
                             : iso_metrics_within(&row->metrics, &row->tolerances);
    if (!metrics || !gates_hold(row)) /* also if the reference shows nothing: b draws something then */
        return ISO_VERDICT_DIFFER;
    return row->uncompared == ISO_UNCOMPARED_NOT ? ISO_VERDICT_AGREE : ISO_VERDICT_NOT_COMPARED;
}
