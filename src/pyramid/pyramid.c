/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "pyramid/pyramid.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "pyramid/agreement.h"
#include "pyramid/cascade.h"
#include "pyramid/filter_kernel.h"
#include "pyramid/narrow.h"
#include "pyramid/pyramid_layout.h"

static const struct {
    const char *name, *summary;
} scalar_filters[] =
    {
        [ISO_SCALAR_MEAN] = {"mean", "means of 2x2x2 voxels"},
        [ISO_SCALAR_MAJORITY] = {"majority",
                                 "of labels: the one that most of 2x2x2 voxels have; the largest of several"},
        [ISO_SCALAR_GAUSS] = {"gauss", "a Gaussian of --gauss-radius and --gauss-sigma"},
        [ISO_SCALAR_LEAST_SQUARES] = {"least-squares",
                                      "what trilinear lookup shows is nearest to level 0; from level 0"},
        [ISO_SCALAR_DAMPED] = {"damped", "from the means .6 of the way to least-squares: rings less"},
},
  direction_filters[] = {
      [ISO_DIRECTION_MOMENTS] = {"moments", "sums weighted by the squared magnitude; the coherence is the length"},
      [ISO_DIRECTION_EQ1] = {"eq1", "Eq. 1 of [diaz-garcia-2017]: a Gaussian times the gradient magnitude"},
      [ISO_DIRECTION_NAIVE] = {"naive", "means of the children's gradients, of length 1"},
      [ISO_DIRECTION_TENSOR] = {"tensor", "the main axis of summed outer products: opposite gradients agree"},
      [ISO_DIRECTION_LEAST_SQUARES] = {"least-squares",
                                       "what lookup shows is nearest to level 0's directions, weighted as moments"},
      [ISO_DIRECTION_AUTO] = {"auto", "moments or tensor, for each level by how its gradients agree"},
};
const iso_names iso_scalar_filter_names = ISO_NAMES_OF_ROWS("scalar filter", scalar_filters);
const iso_names iso_direction_filter_names = ISO_NAMES_OF_ROWS("direction filter", direction_filters);

iso_pyramid_options iso_pyramid_defaults(void)
{
    return (iso_pyramid_options){
        .level_count = 4,
        .scalar_filter = ISO_SCALAR_MEAN,
        .direction_filter = ISO_DIRECTION_MOMENTS,
        .gradient = iso_gradient_defaults(),
        .code = ISO_CODE_FIT,
        .gauss_sigma_voxels = 1,
        .gauss_radius = 2,
        .eq1_exponent = 1,
    };
}

static bool has_value_range(const iso_pyramid *p)
{
    return p->options.value_range[1] > p->options.value_range[0];
}

double iso_pyramid_lo(const iso_pyramid *p)
{
    return has_value_range(p) ? p->options.value_range[0] : p->levels[0].min;
}

double iso_pyramid_hi(const iso_pyramid *p)
{
    return has_value_range(p) ? p->options.value_range[1] : p->levels[0].max;
}

const iso_level *iso_pyramid_finest(const iso_pyramid *p)
{
    for (size_t k = 0; k < p->level_count; ++k)
        if (p->levels[k].scalar || p->levels[k].samples)
            return &p->levels[k];
    return &p->levels[0];
}

iso_status iso_pyramid_check_level(const iso_pyramid *p, const char *path, size_t level, iso_error *err)
{
    char known[48];
    snprintf(known, sizeof known, p->level_count > 1 ? "levels 0 to %zu" : "level 0 alone", p->level_count - 1);
    return level < p->level_count ? ISO_OK
                                  : iso_fail(err, ISO_E_RANGE, "%s%slevel %zu: the pyramid has %s", path ? path : "",
                                             path ? ": " : "", level, known);
}

const char *iso_scalar_filter_name(iso_scalar_filter f)
{
    return scalar_filters[f].name;
}

const char *iso_direction_filter_name(iso_direction_filter f)
{
    return direction_filters[f].name;
}

iso_direction_filter iso_direction_filter_of(const iso_pyramid_options *opt, size_t level)
{
    const bool chosen = opt->direction_filter == ISO_DIRECTION_AUTO && opt->choice.is_made && level < 32;
    return chosen ? opt->choice.filter[level] : opt->direction_filter;
}

iso_status iso_scalar_filter_from_name(const char *name, iso_scalar_filter *f, iso_error *err)
{
    size_t row = 0;
    NEED(iso_names_find(&iso_scalar_filter_names, name, &row, err));
    *f = (iso_scalar_filter)row;
    return ISO_OK;
}

iso_status iso_direction_filter_from_name(const char *name, iso_direction_filter *f, iso_error *err)
{
    size_t row = 0;
    NEED(iso_names_find(&iso_direction_filter_names, name, &row, err));
    *f = (iso_direction_filter)row;
    return ISO_OK;
}

iso_status iso_pyramid_check_options(const iso_pyramid_options *opt, iso_error *err)
{
    const size_t max_radius = ISO_FILTER_MAX_TAPS / 2;
    if (opt->level_count < 1 || opt->level_count > 32)
        return iso_fail(err, ISO_E_RANGE, "levels: %zu, must be 1 to 32", opt->level_count);
    if (opt->gauss_radius < 1 || opt->gauss_radius > max_radius)
        return iso_fail(err, ISO_E_RANGE, "Gaussian radius: %zu voxels, must be 1 to %zu", opt->gauss_radius,
                        max_radius);
    if (!(opt->gauss_sigma_voxels >= 0.1 && opt->gauss_sigma_voxels <= 100))
        return iso_fail(err, ISO_E_RANGE, "Gaussian sigma: %g voxels, must be 0.1 to 100", opt->gauss_sigma_voxels);
    if (opt->eq1_exponent > 4)
        return iso_fail(err, ISO_E_RANGE, "exponent of Eq. 1: %zu, must be 0 to 4", opt->eq1_exponent);
    if (!iso_code_describe(opt->code)->is_textured)
        return iso_fail(err, ISO_E_RANGE,
                        "code %s: not for pyramids, whose codes are 3 bytes that a texture can filter",
                        iso_code_describe(opt->code)->name);
    return ISO_OK;
}

/* A filter sums some dozens of samples; least squares make values of a level larger than those of level 0, but not by
 * this much. */
#define LARGEST (FLT_MAX / 256)

iso_status iso_pyramid_check_values(double lo, double hi, const char *source, iso_error *err)
{
    if (lo >= -(double)LARGEST && hi <= (double)LARGEST)
        return ISO_OK;
    return iso_fail(err, ISO_E_RANGE,
                    "%s: values from %g to %g, must be %g to %g, so that sums of them are floats; divide them before",
                    source, lo, hi, -(double)LARGEST, (double)LARGEST);
}

iso_status iso_pyramid_sample_range(const iso_volume *v, const char *source, double *range, iso_error *err)
{
    size_t bytes = iso_type_bytes(v->type);
    *range = bytes == 1 ? 255 : 65535;
    if (bytes <= 2)
        return ISO_OK;
    iso_volume_stats stats = iso_volume_measure(v);
    if (stats.nonfinite_count > 0)
        return iso_fail(err, ISO_E_RANGE, "%s: %zu voxels are not finite, the first is (%zu, %zu, %zu)", source,
                        stats.nonfinite_count, stats.first_nonfinite[0], stats.first_nonfinite[1],
                        stats.first_nonfinite[2]);
    *range = stats.max - stats.min;
    return iso_pyramid_check_values(stats.min, stats.max, source, err);
}

/* Allocates a level; narrow: without scalars and codes. False if memory runs out. */
static bool create_level(iso_level *l, const iso_geometry *g, iso_type type, bool narrow,
                         const iso_pyramid_options *opt)
{
    const size_t count = iso_geometry_voxel_count(g);
    *l = (iso_level){.geometry = *g, .stored_type = type, .labels = opt->scalar_filter == ISO_SCALAR_MAJORITY};
    if (!narrow)
        l->scalar = malloc(count * sizeof *l->scalar);
    if (!narrow)
        l->codes = malloc(3 * count);
    if (opt->keep_float)
        l->directions = malloc(3 * count * sizeof *l->directions);
    if (opt->keep_magnitude)
        l->magnitude = malloc(count * sizeof *l->magnitude);
    return (narrow || (l->scalar && l->codes)) && (l->directions || !opt->keep_float) &&
           (l->magnitude || !opt->keep_magnitude);
}

/* Rounds to a float. Not inline: from two adjacent conversions gcc 12 makes a vector and then rounds neither. */
__attribute__((noinline)) static float nearest_float(double value)
{
    return (float)value;
}

/* Fills a level that keeps no data. Its range is of samples as floats, as in the cascade. */
static void measure_level0(const iso_volume *v, const iso_pyramid_options *opt, iso_level *l)
{
    const iso_volume_stats stats = iso_volume_measure(v);
    *l = (iso_level){.geometry = v->geometry,
                     .stored_type = iso_layout_type(v->type),
                     .labels = opt->scalar_filter == ISO_SCALAR_MAJORITY,
                     .min = (double)nearest_float(stats.min),
                     .max = (double)nearest_float(stats.max)};
}

/* Builds all levels; narrow: level 0 has no scalars and codes. */
static iso_status build_levels(const iso_volume *v, double scale, bool narrow, iso_pyramid *p,
                               const iso_progress *progress, iso_error *err)
{
    const iso_pyramid_options *opt = &p->options;
    iso_geometry g = v->geometry;
    iso_cascade *cascade = NULL;
    iso_cascade_out out[32];
    const size_t nz = v->geometry.size[2];
    const iso_planes planes = {v->data, v->type, {v->geometry.size[0], v->geometry.size[1], nz}, 0, nz,
                               v->geometry.has_no_data};
    iso_status status = iso_agreement_choose_for(&planes, &g, scale, &p->options, progress, err);
    TRY(status, iso_cascade_create(&g, opt, scale, &cascade, err));
    for (size_t k = 0; k < p->level_count && status == ISO_OK; ++k) {
        iso_level *l = &p->levels[k];
        const iso_type type = k == 0 ? iso_layout_type(v->type) : ISO_F32;
        if (!create_level(l, &g, type, narrow && k == 0, opt))
            status = iso_fail(err, ISO_E_MEMORY, "pyramid: no memory for level %zu of %zu x %zu x %zu voxels", k,
                              g.size[0], g.size[1], g.size[2]);
        out[k] = (iso_cascade_out){0, l->scalar, l->codes, l->directions, l->magnitude};
        g = iso_geometry_coarser(&g);
    }
    const size_t slab = status == ISO_OK ? iso_cascade_step(cascade) * 4 : 1;
    for (size_t z = 0; z < nz && status == ISO_OK; z += slab) {
        iso_progress_report(progress, "pyramid", (double)z / (double)nz);
        status = iso_progress_check(progress, err);
        TRY(status, iso_cascade_feed(cascade, &planes, z, z + slab < nz ? z + slab : nz, out, err));
    }
    for (size_t k = 0; k < p->level_count && status == ISO_OK; ++k)
        iso_cascade_range(cascade, k, &p->levels[k].min, &p->levels[k].max);
    iso_cascade_destroy(cascade);
    iso_progress_report(progress, "pyramid", 1);
    return status;
}

iso_pyramid_unit iso_pyramid_unit_of(const iso_volume_notes *notes)
{
    iso_pyramid_unit unit = {.mm = notes->unit[0] ? notes->unit_mm : 1};
    snprintf(unit.name, sizeof unit.name, "%s", notes->unit);
    return unit;
}

static iso_status build(const iso_volume *v, bool narrow, const char *source, const iso_pyramid_options *opt,
                        iso_pyramid *out, const iso_progress *progress, iso_error *err)
{
    double range = 0;
    *out = (iso_pyramid){.options = *opt};
    iso_status status = iso_pyramid_check_options(opt, err);
    TRY(status, iso_pyramid_sample_range(v, source, &range, err));
    if (status != ISO_OK)
        return status;
    out->source = strdup(source);
    out->unit = iso_pyramid_unit_of(&v->notes);
    out->segments = opt->scalar_filter == ISO_SCALAR_MAJORITY ? json_incref(v->segments) : NULL;
    snprintf(out->built_by, sizeof out->built_by, "isoshade " ISO_VERSION);
    out->level_count = iso_cascade_level_count(&v->geometry, opt);
    out->levels = calloc(out->level_count, sizeof *out->levels);
    if (!out->source || !out->levels)
        status = iso_fail(err, ISO_E_MEMORY, "%s: no memory for its levels", source);
    else if (narrow && out->level_count == 1 && !opt->keep_float && !opt->keep_magnitude)
        measure_level0(v, opt, &out->levels[0]);
    else
        status = build_levels(v, iso_cascade_scale(&v->geometry, range), narrow, out, progress, err);
    TRY(status, iso_pyramid_scale_by_share(out, v, err));
    iso_pyramid_share_segments(out);
    if (status != ISO_OK)
        iso_pyramid_destroy(out);
    return status;
}

iso_status iso_pyramid_build(const iso_volume *v, const char *source, const iso_pyramid_options *opt, iso_pyramid *out,
                             const iso_progress *progress, iso_error *err)
{
    return build(v, false, source, opt, out, progress, err);
}

iso_status iso_pyramid_build_narrow(const iso_volume *v, const char *source, const iso_pyramid_options *opt,
                                    iso_pyramid *out, const iso_progress *progress, iso_error *err)
{
    return build(v, true, source, opt, out, progress, err);
}

iso_status iso_pyramid_begin(iso_volume *v, const char *source, const iso_pyramid_options *opt, iso_pyramid *out,
                             iso_error *err)
{
    iso_pyramid_options own = *opt;
    own.level_count = 1;
    own.keep_float = own.keep_magnitude = false;
    iso_status status = build(v, true, source, &own, out, NULL, err);
    if (status == ISO_OK && !(out->volume = malloc(sizeof *out->volume)))
        status = iso_fail(err, ISO_E_MEMORY, "%s: out of memory", source);
    if (status == ISO_OK) {
        *out->volume = *v;
        out->levels[0].samples = out->volume;
        out->levels[0].estimator = own.gradient.method;
    } else {
        iso_volume_destroy(v);
        iso_pyramid_destroy(out);
    }
    *v = (iso_volume){0};
    return status;
}

iso_status iso_pyramid_complete(iso_pyramid *p, const iso_progress *progress, iso_error *err)
{
    iso_pyramid whole;
    if (!p->volume)
        return ISO_OK;
    NEED(iso_pyramid_build(p->volume, p->source, &p->options, &whole, progress, err));
    iso_pyramid_destroy(p);
    *p = whole;
    return ISO_OK;
}

void iso_pyramid_share_segments(iso_pyramid *p)
{
    for (size_t k = 0; p->levels && k < p->level_count; ++k)
        p->levels[k].segments = p->segments;
}

void iso_pyramid_destroy(iso_pyramid *p)
{
    if (!p)
        return;
    for (size_t k = 0; p->levels && k < p->level_count; ++k) {
        free(p->levels[k].scalar);
        free(p->levels[k].codes);
        free(p->levels[k].directions);
        free(p->levels[k].magnitude);
        free(p->levels[k].scale);
    }
    free(p->levels);
    if (p->volume)
        iso_volume_destroy(p->volume);
    free(p->volume);
    free(p->source);
    json_decref(p->segments);
    json_decref(p->made_for);
    *p = (iso_pyramid){0};
}
