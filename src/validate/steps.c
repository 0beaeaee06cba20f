/* SPDX-License-Identifier: MIT */
/* steps.c - the steps of a validation for its line of progress. Costs are constant: about seconds on two cores of small
 * pictures of a small volume, of which only the ratios matter. */
#include "validate/validate.h"

static double row_cost(const iso_renderer_info *r, bool limit)
{
    return (iso_renderer_has(r, ISO_IS_PROGRAM) ? 5 : 1) * (limit ? 4 : 1);
}

/* Returns the cost of the rows of a level. */
static double rows_cost(const bool *wanted, bool samples, bool limits)
{
    double sum = 0;
    for (size_t i = 0; i < iso_renderer_count(); ++i) {
        const iso_renderer_info *r = iso_renderer_at(i);
        if (wanted[i] && samples && r->lock_step)
            sum += row_cost(r, false);
        if (wanted[i] && limits && iso_renderer_has(r, ISO_HAS_LIMIT))
            sum += row_cost(r, true);
    }
    return sum;
}

void iso_validate_end_row(const iso_validation *v, const iso_renderer_info *renderer, bool limit)
{
    const double all = rows_cost(v->wanted, v->agreement_part != ISO_VALIDATE_LIMITS,
                                 v->agreement_part != ISO_VALIDATE_SAMPLES);
    if (!v->variant[0])
        iso_progress_line_add(v->line, row_cost(renderer, limit) / ((double)v->pyramid->level_count * all));
}

static void expect_methods(iso_progress_line *line, double cost)
{
    for (size_t i = 0; i < iso_method_count; ++i)
        iso_progress_line_expect(line, iso_methods[i].name, cost);
}

static void expect_consistency(iso_progress_line *line, double levels)
{
    iso_progress_line_expect(line, "consistency", 12 * levels);
    iso_progress_line_expect(line, "consistency: verdict", levels);
}

void iso_validate_expect(iso_progress_line *line, const bool *wanted, size_t level_count, bool hurried)
{
    const double levels = (double)level_count, samples = rows_cost(wanted, true, false),
                 limits = rows_cost(wanted, false, true);
    double programs = 0;
    for (size_t i = 0; i < iso_renderer_count(); ++i)
        programs += wanted[i] && iso_renderer_has(iso_renderer_at(i), ISO_IS_PROGRAM);
    iso_progress_line_expect(line, "pyramid", 1);
    iso_progress_line_expect(line, "levels", 1);
    iso_progress_line_expect(line, "calibration", 0.2 + 5 * programs);
    iso_progress_line_expect(line, "agreement", levels * (hurried ? samples : samples + limits));
    iso_progress_line_expect(line, "adaptation", levels);
    if (hurried) {
        expect_consistency(line, levels);
        iso_progress_line_expect(line, "limits", levels * limits);
    }
    expect_methods(line, 0.1 * levels * samples);
    if (!hurried)
        expect_consistency(line, levels);
    iso_progress_line_expect(line, "artefacts", 4 * programs);
    iso_progress_line_expect(line, "report", 1);
}
