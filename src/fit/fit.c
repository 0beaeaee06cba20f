/* SPDX-License-Identifier: MIT */
#include "fit/fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "fit/curve.h"

/* ---- rows of fine voxels under a coarse level ---- */

/* A row of fine voxels under a coarse level; private to src/fit. */

/* A row of values to compare, and their targets. */
typedef struct fit_row {
    const float *fine;  /* level 0's values */
    const float *shown; /* the level's */
    float *weight;      /* w = |p'|^2; read or written */
    float *result;      /* to be scattered */
    size_t count;
    bool opacity_only;
} fit_row;

static float squared_error(const fit_row *r, size_t x, const iso_fit_curve *curve)
{
    float f, g, sum = 0;
    const float *a = curve->entries + 4 * iso_fit_curve_find(curve, r->shown[x], &f);
    const float *b = curve->entries + 4 * iso_fit_curve_find(curve, r->fine[x], &g);
    for (int c = r->opacity_only ? 3 : 0; c < 4; ++c) {
        const float d = a[c] + f * (a[c + 4] - a[c]) - (b[c] + g * (b[c + 4] - b[c]));
        sum += d * d;
    }
    return sum;
}

/* Adds the squared errors by the wide curve and by the true one. */
static void fit_row_errors(const fit_row *r, const iso_fit_curve *wide, const iso_fit_curve *curve, double sums[2])
{
    for (size_t x = 0; x < r->count; ++x) {
        sums[0] += (double)squared_error(r, x, wide);
        sums[1] += (double)squared_error(r, x, curve);
    }
}

/* Fills the weights, and result = p' . (p - p(v)); returns the squared error. */
static double fit_row_linearize(const fit_row *r, const iso_fit_curve *curve)
{
    const float per_value = (float)(1 / curve->step);
    double error = 0;
    for (size_t x = 0; x < r->count; ++x) {
        float f, g, sum = 0, weight = 0, pull = 0;
        const float *a = curve->entries + 4 * iso_fit_curve_find(curve, r->shown[x], &f);
        const float *b = curve->entries + 4 * iso_fit_curve_find(curve, r->fine[x], &g);
        for (int c = r->opacity_only ? 3 : 0; c < 4; ++c) {
            const float slope = a[c + 4] - a[c];
            const float d = a[c] + f * slope - (b[c] + g * (b[c + 4] - b[c]));
            sum += d * d;
            weight += slope * slope;
            pull += slope * d;
        }
        error += (double)sum;
        r->weight[x] = weight * per_value * per_value;
        r->result[x] = pull * per_value;
    }
    return error;
}

/* Sets result = weight shown. */
static void fit_row_weigh(const fit_row *r)
{
    for (size_t x = 0; x < r->count; ++x)
        r->result[x] = r->shown[x] * r->weight[x];
}

/* ---- the fit ---- */

/* A coarse value may leave the range of the fine ones by this part of it: more than least squares overshoots by. */
#define OVERSHOOT 0.5

iso_fit_options iso_fit_defaults(void)
{
    return (
        iso_fit_options){.round_count = 7, .widths = {4, 3, 2, 1.5, 1, 1, 1}, .solver_rounds = 4, .opacity_only = true};
}

/* The buffers of a fit. */
typedef struct fit {
    const iso_fit_problem *problem;
    int threads;
    bool opacity_only;
    size_t fine_count, coarse_count, row_count;
    iso_fit_curve wide;
    float *weight;                                                       /* a fine voxel */
    uint8_t *wanted;                                                     /* a run of them: some have weight */
    double (*sums)[2];                                                   /* a fine row */
    float *gradient, *step, *residual, *search, *product, *trial, *best; /* a coarse voxel */
} fit;

static float *floats(size_t count)
{
    return malloc((count + 1) * sizeof(float));
}

static iso_status begin(fit *f, const iso_fit_problem *problem, const iso_fit_options *opt, iso_error *err)
{
    const iso_interpolation *m = problem->map;
    *f = (fit){.problem = problem, .threads = opt->threads, .opacity_only = opt->opacity_only};
    f->fine_count = m->fine_count;
    f->coarse_count = m->coarse_count;
    f->row_count = m->axis[1].fine_size * m->axis[2].fine_size;
    f->weight = floats(f->fine_count);
    f->wanted = malloc(iso_interpolation_run_count(m));
    f->sums = malloc(f->row_count * sizeof *f->sums);
    float **coarse[] = {&f->gradient, &f->step, &f->residual, &f->search, &f->product, &f->trial, &f->best};
    bool good = f->weight && f->wanted && f->sums;
    for (size_t i = 0; i < sizeof coarse / sizeof *coarse; ++i)
        good = (*coarse[i] = floats(f->coarse_count)) && good;
    if (problem->curve) {
        f->wide = *problem->curve;
        f->wide.entries = malloc(4 * f->wide.count * sizeof(float));
        good = good && f->wide.entries;
    }
    return good ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "fit: no memory for %zu voxels", f->fine_count);
}

static void end(fit *f)
{
    float *buffers[] = {f->weight,  f->gradient, f->step, f->residual,    f->search,
                        f->product, f->trial,    f->best, f->wide.entries};
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; ++i)
        free(buffers[i]);
    free(f->wanted);
    free(f->sums);
}

static size_t row_number(const fit *f, const iso_fine_row *row)
{
    return row->y + f->problem->map->axis[1].fine_size * row->z;
}

static fit_row row_of(const fit *f, const iso_fine_row *row)
{
    const size_t at = row->x + f->problem->map->axis[0].fine_size * row_number(f, row);
    return (fit_row){f->problem->fine + at,
                     row->values ? row->values[0] : NULL,
                     f->weight + at,
                     row->results ? row->results[0] : NULL,
                     row->count,
                     f->opacity_only};
}

static void errors_of_row(void *context, const iso_fine_row *row)
{
    fit *f = context;
    const fit_row r = row_of(f, row);
    double *sums = f->sums[row_number(f, row)];
    sums[0] = sums[1] = 0;
    fit_row_errors(&r, &f->wide, f->problem->curve, sums);
}

/* Notes which runs have weight, too. */
static void linearize_row(void *context, const iso_fine_row *row)
{
    fit *f = context;
    const fit_row r = row_of(f, row);
    uint8_t *wanted = f->wanted + row_number(f, row) * ((row->count + ISO_FIT_RUN - 1) / ISO_FIT_RUN);
    f->sums[row_number(f, row)][0] = fit_row_linearize(&r, &f->wide);
    for (size_t x = 0; x < row->count; x += ISO_FIT_RUN) {
        float most = 0;
        for (size_t i = x; i < row->count && i < x + ISO_FIT_RUN; ++i)
            most = fmaxf(most, r.weight[i]);
        wanted[x / ISO_FIT_RUN] = most > 0;
    }
}

static void weigh_row(void *context, const iso_fine_row *row)
{
    const fit_row r = row_of(context, row);
    fit_row_weigh(&r);
}

/* Runs one pass over the fine voxels under `coarse`; out: the scattered values, or NULL. */
static iso_status go(fit *f, iso_fine_row_function *function, const float *coarse, float *out, iso_error *err)
{
    const iso_interpolation_pass pass = {.input_count = 1,
                                         .output_count = out ? 1 : 0,
                                         .inputs = &coarse,
                                         .outputs = &out,
                                         .function = function,
                                         .context = f,
                                         .wanted = function == weigh_row ? f->wanted : NULL};
    return iso_interpolation_run(f->problem->map, &pass, f->threads, err);
}

/* Adds up the sums of the rows, in their order. */
static double total(const fit *f, size_t which)
{
    double sum = 0;
    for (size_t i = 0; i < f->row_count; ++i)
        sum += f->sums[i][which];
    return sum;
}

static double dot(const float *a, const float *b, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; ++i)
        sum += (double)a[i] * (double)b[i];
    return sum;
}

/* Adds factor * from to `to`. */
static void add(float *to, double factor, const float *from, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        to[i] += (float)factor * from[i];
}

/* Solves A^T W A step = -gradient for f->step, from 0. */
static iso_status solve(fit *f, size_t rounds, iso_error *err)
{
    const size_t n = f->coarse_count;
    memset(f->step, 0, n * sizeof *f->step);
    for (size_t i = 0; i < n; ++i)
        f->residual[i] = f->search[i] = -f->gradient[i];
    double before = dot(f->residual, f->residual, n);
    const double first = before;
    for (size_t k = 0; k < rounds && before > 1e-12 * first; ++k) {
        const iso_status status = go(f, weigh_row, f->search, f->product, err);
        const double curvature = dot(f->search, f->product, n);
        if (status != ISO_OK || !(curvature > 0))
            return status;
        add(f->step, before / curvature, f->search, n);
        add(f->residual, -before / curvature, f->product, n);
        const double now = dot(f->residual, f->residual, n);
        for (size_t i = 0; i < n; ++i)
            f->search[i] = f->residual[i] + (float)(now / before) * f->search[i];
        before = now;
    }
    return ISO_OK;
}

/* Takes a step of Gauss-Newton, halved until the wide curve's error falls. *error: E after it; unchanged if no step
 * helps. */
static iso_status improve(fit *f, const float limits[2], size_t solver_rounds, float *coarse, double *error,
                          iso_error *err)
{
    NEED(go(f, linearize_row, coarse, f->gradient, err));
    const double start = total(f, 0);
    NEED(solve(f, solver_rounds, err));
    for (double t = 1; t > 0.1; t /= 2) {
        for (size_t i = 0; i < f->coarse_count; ++i)
            f->trial[i] = fminf(fmaxf(coarse[i] + (float)t * f->step[i], limits[0]), limits[1]);
        NEED(go(f, errors_of_row, f->trial, NULL, err));
        if (total(f, 0) < start) {
            memcpy(coarse, f->trial, f->coarse_count * sizeof *coarse);
            *error = total(f, 1);
            break;
        }
    }
    return ISO_OK;
}

static void find_limits(const float *fine, size_t count, float limits[2])
{
    float lo = fine[0], hi = fine[0];
    for (size_t i = 1; i < count; ++i) {
        lo = fminf(lo, fine[i]);
        hi = fmaxf(hi, fine[i]);
    }
    limits[0] = lo - (float)OVERSHOOT * (hi - lo);
    limits[1] = hi + (float)OVERSHOOT * (hi - lo);
}

static iso_status run(fit *f, const iso_fit_options *opt, float *coarse, iso_fit_report *report, iso_error *err)
{
    const double width = iso_fit_curve_ramp_width(f->problem->curve);
    const size_t bytes = f->coarse_count * sizeof *coarse;
    float limits[2];
    find_limits(f->problem->fine, f->fine_count, limits);
    iso_fit_curve_widen(f->problem->curve, 0, &f->wide);
    iso_status status = go(f, errors_of_row, coarse, NULL, err);
    if (status != ISO_OK)
        return status;
    report->error_start = report->error_end = total(f, 1);
    memcpy(f->best, coarse, bytes);
    for (size_t i = 0; i < opt->round_count && width > 0 && status == ISO_OK; ++i) {
        double error = INFINITY;
        iso_fit_curve_widen(f->problem->curve, (opt->widths[i] - 1) * width, &f->wide);
        status = improve(f, limits, opt->solver_rounds, coarse, &error, err);
        if (status == ISO_OK && error < report->error_end) {
            memcpy(f->best, coarse, bytes);
            report->error_end = error;
            report->best_round = i + 1;
        }
    }
    memcpy(coarse, f->best, bytes);
    return status;
}

iso_status iso_fit_scalar(const iso_fit_problem *problem, const iso_fit_options *opt, float *coarse,
                          iso_fit_report *report, iso_error *err)
{
    const double began = iso_clock_seconds();
    fit f;
    *report = (iso_fit_report){0};
    iso_status status = begin(&f, problem, opt, err);
    TRY(status, run(&f, opt, coarse, report, err));
    end(&f);
    report->seconds = iso_clock_seconds() - began;
    return status;
}

iso_status iso_fit_error(const iso_fit_problem *problem, const iso_fit_options *opt, double width, const float *coarse,
                         double *error, float *gradient, iso_error *err)
{
    fit f;
    iso_status status = begin(&f, problem, opt, err);
    if (status == ISO_OK) {
        iso_fit_curve_widen(problem->curve, (width - 1) * iso_fit_curve_ramp_width(problem->curve), &f.wide);
        status = go(&f, linearize_row, coarse, f.gradient, err);
    }
    if (status == ISO_OK)
        *error = total(&f, 0);
    for (size_t i = 0; gradient && status == ISO_OK && i < f.coarse_count; ++i)
        gradient[i] = 2 * f.gradient[i];
    end(&f);
    return status;
}

size_t iso_fit_bytes(size_t fine_count, size_t coarse_count)
{
    return fine_count * sizeof(float) + fine_count / ISO_FIT_RUN + 7 * coarse_count * sizeof(float);
}
