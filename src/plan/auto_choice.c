/* SPDX-License-Identifier: MIT */
#include "plan/auto_choice.h"

#include <math.h>
#include <stdlib.h>

#include "fit/extinction_scale.h"
#include "tf/adapt.h"

/* By isoshade-lab levels of five volumes, doc/results/auto.md: least squares with a ridge of .3, which leaving one volume out
 * after the other chose. Slopes are below 0 where what gains most at the voxels rings most. The 2D transfer function has
 * no error of its own here. */
static const iso_auto_design designs[ISO_AUTO_DESIGNS] = {
    {.name = "default",
     .summary = "means, adapted TF",
     .scalar = ISO_SCALAR_MEAN,
     .adapted = true,
     .bytes = 3,
     .prior = {0, 0, 0},
     .slope = {0, 0, 0}},
    {.name = "original",
     .summary = "means, original TF",
     .scalar = ISO_SCALAR_MEAN,
     .bytes = 3,
     .prior = {0.040, 0.024, 0.113},
     .slope = {0.18, 0.29, 0.06}},
    {.name = "always",
     .summary = "means, TF adapted whatever small views say",
     .scalar = ISO_SCALAR_MEAN,
     .adapted = true,
     .always = true,
     .bytes = 3,
     .prior = {0.002, -0.003, -0.025},
     .slope = {0, 0, 0}},
    {.name = "damped",
     .summary = "damped, original TF",
     .scalar = ISO_SCALAR_DAMPED,
     .bytes = 3,
     .prior = {-0.170, -0.068, 0.024},
     .slope = {0.09, 0.25, 0.07}},
    {.name = "damped-adapted",
     .summary = "damped, adapted TF",
     .scalar = ISO_SCALAR_DAMPED,
     .adapted = true,
     .bytes = 3,
     .prior = {-0.180, -0.071, -0.037},
     .slope = {0.16, 0.05, 0.01}},
    {.name = "least-squares",
     .summary = "least squares, original TF",
     .scalar = ISO_SCALAR_LEAST_SQUARES,
     .bytes = 3,
     .prior = {-0.179, -0.098, 0.001},
     .slope = {-0.27, 0.29, 0.05}},
    {.name = "lsq-adapted",
     .summary = "least squares, adapted TF",
     .scalar = ISO_SCALAR_LEAST_SQUARES,
     .adapted = true,
     .bytes = 3,
     .prior = {-0.301, -0.063, -0.042},
     .slope = {-0.50, 0.15, 0.10}},
    {.name = "scaled",
     .summary = "means, adapted TF, extinction scale",
     .scalar = ISO_SCALAR_MEAN,
     .adapted = true,
     .always = true,
     .scaled = true,
     .bytes = 4,
     .prior = {-0.273, -0.124, -0.113},
     .slope = {0.00, 0.37, 0.05}},
    {.name = "scaled-original",
     .summary = "means, original TF, extinction scale",
     .scalar = ISO_SCALAR_MEAN,
     .scaled = true,
     .bytes = 4,
     .prior = {-0.113, -0.048, -0.019},
     .slope = {0.16, 0.37, 0.32}},
    {.name = "scaled-damped",
     .summary = "damped, adapted TF, extinction scale",
     .scalar = ISO_SCALAR_DAMPED,
     .adapted = true,
     .always = true,
     .scaled = true,
     .bytes = 4,
     .prior = {-0.276, -0.172, -0.148},
     .slope = {-0.04, 0.35, -0.02}},
    {.name = "tf-2d",
     .summary = "means, 2D TF over value and deviation",
     .scalar = ISO_SCALAR_MEAN,
     .adapted = true,
     .is_2d = true,
     .bytes = 4,
     .prior = {-0.101, -0.064, -0.062},
     .slope = {0.00, 0.00, 0.00}},
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
    if (d->always)
        return "--adapt --always";
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

/* The logarithm of the design's DSSIM over the default's at a level. */
static double predict_level(const iso_auto_choice *c, size_t d, size_t k)
{
    const size_t at = k < 3 ? k - 1 : 2;
    return designs[d].prior[at] +
           designs[d].slope[at] * log((c->error[d][k] + no_error) / (c->error[0][k] + no_error));
}

static double predict(const iso_auto_choice *c, size_t d)
{
    double sum = 0;
    for (size_t k = 1; k < c->level_count; ++k)
        sum += predict_level(c, d, k);
    return c->level_count > 1 ? exp(sum / (double)(c->level_count - 1)) : 1;
}

static iso_status check_budget(int bytes, iso_error *err)
{
    return bytes >= ISO_AUTO_LEAST_BYTES ? ISO_OK
                                         : iso_fail(err, ISO_E_RANGE,
                                                    "a budget of %d bytes a voxel: directions alone take %d", bytes,
                                                    ISO_AUTO_LEAST_BYTES);
}

iso_status iso_auto_choose(iso_auto_choice *choice, int budget_bytes, iso_error *err)
{
    const iso_status status = check_budget(budget_bytes, err);
    if (status != ISO_OK)
        return status;
    choice->chosen = 0;
    for (size_t d = 0; d < ISO_AUTO_DESIGNS; ++d) {
        choice->predicted[d] = predict(choice, d);
        const bool nearer = choice->predicted[d] < choice->predicted[choice->chosen];
        if (designs[d].bytes <= budget_bytes && nearer && choice->predicted[d] < 1 - ISO_AUTO_GAIN)
            choice->chosen = d;
    }
    return ISO_OK;
}

/* The small views' choice, of levels with this filter. */
static size_t judged_design(iso_scalar_filter scalar)
{
    size_t d = 0;
    while (d < ISO_AUTO_DESIGNS && !(designs[d].scalar == scalar && designs[d].adapted && !designs[d].always))
        ++d;
    return d;
}

iso_status iso_auto_choose_level(const iso_auto_choice *choice, size_t level, iso_scalar_filter scalar,
                                 int budget_bytes, size_t *design, double *gain, iso_error *err)
{
    const size_t judged = judged_design(scalar);
    const iso_status status = check_budget(budget_bytes, err);
    if (status != ISO_OK)
        return status;
    if (judged == ISO_AUTO_DESIGNS)
        return iso_fail(err, ISO_E_RANGE, "scalar filter %s: --auto knows mean, damped and least-squares",
                        iso_scalar_filter_name(scalar));
    double least = predict_level(choice, judged, level) + log(1 - ISO_AUTO_GAIN);
    *design = judged;
    for (size_t d = 0; d < ISO_AUTO_DESIGNS; ++d) {
        const double predicted = predict_level(choice, d, level);
        if (designs[d].scalar == scalar && designs[d].bytes <= budget_bytes && predicted < least) {
            least = predicted;
            *design = d;
        }
    }
    *gain = exp(predict_level(choice, *design, level) - predict_level(choice, judged, level));
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
