/* SPDX-License-Identifier: MIT */
#include "plan/auto_choice.h"

#include <math.h>
#include <stdlib.h>

#include "fit/extinction_scale.h"
#include "tf/adapt.h"

/* By bench levels of five volumes, doc/results/auto.md: least squares with a ridge of .3, which leaving one volume out
 * after the other chose. Slopes are below 0 where what gains most at the voxels rings most. The 2D transfer function has
 * no error of its own here. */
static const iso_auto_design designs[ISO_AUTO_DESIGNS] = {
    {"default", "means, adapted TF", ISO_SCALAR_MEAN, true, false, false, 3, {0, 0, 0}, {0, 0, 0}},
    {"original",
     "means, original TF",
     ISO_SCALAR_MEAN,
     false,
     false,
     false,
     3,
     {0.040, 0.024, 0.113},
     {0.18, 0.29, 0.06}},
    {"damped",
     "damped, original TF",
     ISO_SCALAR_DAMPED,
     false,
     false,
     false,
     3,
     {-0.170, -0.068, 0.024},
     {0.09, 0.25, 0.07}},
    {"damped-adapted",
     "damped, adapted TF",
     ISO_SCALAR_DAMPED,
     true,
     false,
     false,
     3,
     {-0.180, -0.071, -0.037},
     {0.16, 0.05, 0.01}},
    {"least-squares",
     "least squares, original TF",
     ISO_SCALAR_LEAST_SQUARES,
     false,
     false,
     false,
     3,
     {-0.179, -0.098, 0.001},
     {-0.27, 0.29, 0.05}},
    {"lsq-adapted",
     "least squares, adapted TF",
     ISO_SCALAR_LEAST_SQUARES,
     true,
     false,
     false,
     3,
     {-0.301, -0.063, -0.042},
     {-0.50, 0.15, 0.10}},
    {"scaled",
     "means, adapted TF, extinction scale",
     ISO_SCALAR_MEAN,
     true,
     true,
     false,
     4,
     {-0.273, -0.124, -0.113},
     {0.00, 0.37, 0.05}},
    {"scaled-original",
     "means, original TF, extinction scale",
     ISO_SCALAR_MEAN,
     false,
     true,
     false,
     4,
     {-0.113, -0.048, -0.019},
     {0.16, 0.37, 0.32}},
    {"scaled-damped",
     "damped, adapted TF, extinction scale",
     ISO_SCALAR_DAMPED,
     true,
     true,
     false,
     4,
     {-0.276, -0.172, -0.148},
     {-0.04, 0.35, -0.02}},
    {"tf-2d",
     "means, 2D TF over value and deviation",
     ISO_SCALAR_MEAN,
     true,
     false,
     true,
     4,
     {-0.101, -0.064, -0.062},
     {0.00, 0.00, 0.00}},
};

const iso_auto_design *iso_auto_design_at(size_t index)
{
    return &designs[index];
}

const char *iso_auto_options(const iso_auto_design *d)
{
    if (d->is_2d)
        return "--adapt --tf-2d deviation";
    if (d->scaled)
        return d->adapted ? "--adapt --extinction-scale" : "--extinction-scale";
    return d->adapted ? "--adapt" : "";
}

/* ---- measuring ---- */

/* Errors of a level with and without an extinction scale, under the transfer function `own`. */
static iso_status measure_tf(iso_extinction_scaler *s, const iso_tf_table *tf, const iso_tf_table *own, uint8_t *bytes,
                             double errors[2], iso_error *err)
{
    iso_extinction_scale_cost cost = {0};
    const iso_status status = iso_extinction_scaler_apply(s, tf, own, bytes, &cost, err);
    errors[0] = cost.error_one;
    errors[1] = cost.error;
    return status;
}

/* errors[adapted][scaled] of a level. */
static iso_status measure_level(const iso_pyramid *p, size_t level, const iso_tf_table *tf, int threads,
                                double errors[2][2], iso_error *err)
{
    iso_adapt_options opt = iso_adapt_defaults();
    iso_extinction_scaler *s = NULL;
    iso_tf_table adapted = {0};
    uint8_t *bytes = malloc(iso_geometry_voxel_count(&p->levels[level].geometry));
    opt.threads = threads;
    opt.fall_back = false;
    iso_status status = bytes ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for a byte a voxel");
    if (status == ISO_OK)
        status = iso_adapt_level(p, level, tf, &opt, &adapted, NULL, err);
    if (status == ISO_OK)
        status = iso_extinction_scaler_create(&p->levels[0], &p->levels[level], level, threads, &s, err);
    if (status == ISO_OK)
        status = measure_tf(s, tf, tf, bytes, errors[0], err);
    if (status == ISO_OK)
        status = measure_tf(s, tf, &adapted, bytes, errors[1], err);
    iso_extinction_scaler_destroy(s);
    iso_tf_table_destroy(&adapted);
    free(bytes);
    return status;
}

static iso_status measure_scalar(const iso_volume *v, const iso_pyramid_options *opt, const iso_tf_table *tf,
                                 iso_auto_choice *choice, iso_error *err)
{
    iso_pyramid p = {0};
    iso_status status = iso_pyramid_build(v, "measured", opt, &p, NULL, err);
    choice->level_count = p.level_count;
    for (size_t k = 1; k < p.level_count && status == ISO_OK; ++k) {
        double errors[2][2];
        status = measure_level(&p, k, tf, opt->threads, errors, err);
        for (size_t d = 0; d < ISO_AUTO_DESIGNS && status == ISO_OK; ++d)
            if (designs[d].scalar == opt->scalar_filter)
                choice->error[d][k] = errors[designs[d].adapted][designs[d].scaled];
    }
    iso_pyramid_destroy(&p);
    return status;
}

iso_status iso_auto_measure(const iso_volume *v, const iso_pyramid_options *opt, const iso_tf_table *tf,
                            iso_auto_choice *choice, const iso_progress *progress, iso_error *err)
{
    static const iso_scalar_filter filters[] = {ISO_SCALAR_MEAN, ISO_SCALAR_DAMPED, ISO_SCALAR_LEAST_SQUARES};
    iso_pyramid_options own = *opt;
    iso_status status = ISO_OK;
    *choice = (iso_auto_choice){0};
    own.direction_filter = ISO_DIRECTION_NAIVE; /* the cheapest: no direction is looked at */
    for (size_t f = 0; f < 3 && status == ISO_OK; ++f) {
        iso_progress_report(progress, "choosing", (double)f / 3);
        own.scalar_filter = filters[f];
        status = measure_scalar(v, &own, tf, choice, err);
    }
    iso_progress_report(progress, "choosing", 1);
    return status;
}

/* ---- choosing ---- */

/* Below this, both show what level 0 shows. */
static const double no_error = 1e-6;

static double predict(const iso_auto_choice *c, size_t d)
{
    double sum = 0;
    for (size_t k = 1; k < c->level_count; ++k)
        sum += designs[d].prior[k < 3 ? k - 1 : 2] +
               designs[d].slope[k < 3 ? k - 1 : 2] * log((c->error[d][k] + no_error) / (c->error[0][k] + no_error));
    return c->level_count > 1 ? exp(sum / (double)(c->level_count - 1)) : 1;
}

iso_status iso_auto_choose(iso_auto_choice *choice, int budget_bytes, iso_error *err)
{
    if (budget_bytes < ISO_AUTO_LEAST_BYTES)
        return iso_fail(err, ISO_E_RANGE, "a budget of %d bytes a voxel: directions alone take %d", budget_bytes,
                        ISO_AUTO_LEAST_BYTES);
    choice->chosen = 0;
    for (size_t d = 0; d < ISO_AUTO_DESIGNS; ++d) {
        choice->predicted[d] = predict(choice, d);
        const bool nearer = choice->predicted[d] < choice->predicted[choice->chosen];
        if (designs[d].bytes <= budget_bytes && nearer && choice->predicted[d] < 1 - ISO_AUTO_GAIN)
            choice->chosen = d;
    }
    return ISO_OK;
}

json_t *iso_auto_to_json(const iso_auto_choice *choice, int budget_bytes, const char *tf)
{
    json_t *list = json_array();
    for (size_t d = 0; d < ISO_AUTO_DESIGNS; ++d) {
        json_t *errors = json_array();
        for (size_t k = 1; k < choice->level_count; ++k)
            json_array_append_new(errors, json_real(choice->error[d][k]));
        json_array_append_new(list, json_pack("{s:s, s:s, s:i, s:f, s:o}", "name", designs[d].name, "summary",
                                              designs[d].summary, "bytes_per_voxel", designs[d].bytes, "predicted",
                                              choice->predicted[d], "opacity_errors", errors));
    }
    return json_pack("{s:s, s:i, s:s, s:s, s:o}", "tf", tf, "budget_bytes_per_voxel", budget_bytes, "chosen",
                     designs[choice->chosen].name, "options", iso_auto_options(&designs[choice->chosen]), "designs",
                     list);
}
