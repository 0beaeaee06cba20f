#define _GNU_SOURCE
#include "pyramid/pyramid.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/parallel.h"
#include "pyramid/filter_kernel.h"

static const char *const scalar_names[ISO_SCALAR_COUNT] = {"mean", "gauss"};
static const char *const direction_names[ISO_DIRECTION_COUNT] = {"moments", "eq1", "naive"};

iso_pyramid_options iso_pyramid_defaults(void)
{
    return (iso_pyramid_options){
        .level_count = 4,
        .scalar_filter = ISO_SCALAR_MEAN,
        .direction_filter = ISO_DIRECTION_MOMENTS,
        .gradient = iso_gradient_defaults(),
        .code = ISO_CODE_SNORM,
        .gauss_sigma_voxels = 1,
        .gauss_radius = 2,
    };
}

const char *iso_scalar_filter_name(iso_scalar_filter f)
{
    return scalar_names[f];
}

const char *iso_direction_filter_name(iso_direction_filter f)
{
    return direction_names[f];
}

iso_status iso_scalar_filter_from_name(const char *name, iso_scalar_filter *f, iso_error *err)
{
    for (int i = 0; i < ISO_SCALAR_COUNT; ++i)
        if (strcmp(scalar_names[i], name) == 0)
            return *f = (iso_scalar_filter)i, ISO_OK;
    return iso_fail(err, ISO_E_USAGE, "unknown scalar filter \"%s\", must be one of: mean, gauss", name);
}

iso_status iso_direction_filter_from_name(const char *name, iso_direction_filter *f, iso_error *err)
{
    for (int i = 0; i < ISO_DIRECTION_COUNT; ++i)
        if (strcmp(direction_names[i], name) == 0)
            return *f = (iso_direction_filter)i, ISO_OK;
    return iso_fail(err, ISO_E_USAGE, "unknown direction filter \"%s\", must be one of: moments, eq1, naive", name);
}

static iso_status check_options(const iso_pyramid_options *opt, iso_error *err)
{
    const size_t max_radius = ISO_FILTER_MAX_TAPS / 2;
    if (opt->level_count < 1 || opt->level_count > 32)
        return iso_fail(err, ISO_E_RANGE, "levels: %zu, must be 1 to 32", opt->level_count);
    if (opt->gauss_radius < 1 || opt->gauss_radius > max_radius)
        return iso_fail(err, ISO_E_RANGE, "Gaussian radius: %zu voxels, must be 1 to %zu", opt->gauss_radius, max_radius);
    if (!(opt->gauss_sigma_voxels >= 0.1 && opt->gauss_sigma_voxels <= 100))
        return iso_fail(err, ISO_E_RANGE, "Gaussian sigma: %g voxels, must be 0.1 to 100", opt->gauss_sigma_voxels);
    return ISO_OK;
}

/* The largest difference that the samples can have: from the type where it is
 * narrow, else measured. */
static iso_status sample_range(const iso_volume *v, const char *source, double *range, iso_error *err)
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
    if (!(*range <= FLT_MAX && fabs(stats.min) <= FLT_MAX && fabs(stats.max) <= FLT_MAX))
        return iso_fail(err, ISO_E_RANGE, "%s: values from %g to %g, differences up to %g can be taken", source,
                        stats.min, stats.max, (double)FLT_MAX);
    return ISO_OK;
}

/* A power of two that brings the gradients near 1, so that their fourth powers
 * neither overflow nor vanish whatever the units are. */
static double gradient_scale(const iso_geometry *g, double range)
{
    iso_mat3 m = iso_geometry_gradient_to_world(g);
    double largest = 0;
    for (int i = 0; i < 9; ++i)
        largest = fmax(largest, fabs(m.m[i / 3][i % 3]));
    return range > 0 ? ldexp(1, -ilogb(range) - ilogb(largest)) : 1;
}

static size_t count_levels(const iso_geometry *g, size_t wanted)
{
    iso_geometry at = *g;
    size_t count = 1;
    for (; count < wanted; ++count) {
        at = iso_geometry_coarser(&at);
        if (iso_geometry_voxel_count(&at) == 1)
            break;
    }
    return count;
}

static bool create_level(iso_level *l, const iso_geometry *g, iso_type type, const iso_pyramid_options *opt)
{
    const size_t count = iso_geometry_voxel_count(g);
    *l = (iso_level){.geometry = *g, .stored_type = type};
    l->scalar = malloc(count * sizeof *l->scalar);
    l->codes = malloc(3 * count);
    if (opt->keep_float)
        l->directions = malloc(3 * count * sizeof *l->directions);
    if (opt->keep_magnitude)
        l->magnitude = malloc(count * sizeof *l->magnitude);
    return l->scalar && l->codes && (l->directions || !opt->keep_float) && (l->magnitude || !opt->keep_magnitude);
}

/* One axis of a separable filter with decimation: in is outer x n x inner
 * floats, out is outer x (n + 1) / 2 x inner. */
static void decimate_axis(const float *restrict in, size_t outer, size_t n, size_t inner, const iso_taps *taps,
                          int threads, float *restrict out)
{
    const size_t half = (n + 1) / 2;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t row = 0; row < outer * half; ++row) {
        const size_t o = row / half, i = row % half;
        float *to = out + row * inner;
        memset(to, 0, inner * sizeof *to);
        for (size_t t = 0; t < taps->count; ++t) {
            const float *from = in + (o * n + iso_taps_source(taps, i, t, n)) * inner;
            const float weight = taps->weight[t];
            for (size_t k = 0; k < inner; ++k)
                to[k] += weight * from[k];
        }
    }
}

/* Filters and decimates the field `in` of `components` floats a voxel. */
static iso_status decimate(const float *in, const iso_geometry *fine, size_t components, const iso_taps *taps,
                           int threads, float *out, iso_error *err)
{
    const size_t nx = fine->size[0], ny = fine->size[1], nz = fine->size[2];
    const size_t hx = (nx + 1) / 2, hy = (ny + 1) / 2;
    float *by_x = malloc(hx * ny * nz * components * sizeof *by_x);
    float *by_y = malloc(hx * hy * nz * components * sizeof *by_y);
    iso_status status = ISO_OK;
    if (by_x && by_y) {
        decimate_axis(in, ny * nz, nx, components, taps, threads, by_x);
        decimate_axis(by_x, nz, ny, hx * components, taps, threads, by_y);
        decimate_axis(by_y, 1, nz, hx * hy * components, taps, threads, out);
    } else {
        status = iso_fail(err, ISO_E_MEMORY, "pyramid: no memory to filter %zu x %zu x %zu voxels", nx, ny, nz);
    }
    free(by_x);
    free(by_y);
    return status;
}

/* What is stored of a level whose scalar and state are known. */
static iso_status finish_level(iso_level *l, const iso_pyramid_options *opt, bool fine, double scale,
                               const float *state, iso_error *err)
{
    const size_t nx = l->geometry.size[0], row_count = l->geometry.size[1] * l->geometry.size[2];
    const int threads = iso_threads(opt->threads);
    const float unscale = (float)(1 / scale);
    float *work = malloc((size_t)threads * 3 * nx * sizeof *work);
    if (!work)
        return iso_fail(err, ISO_E_MEMORY, "pyramid: no memory for %d threads' rows of %zu voxels", threads, nx);
    float lo = INFINITY, hi = -INFINITY;
#pragma omp parallel for schedule(static) num_threads(threads) reduction(min : lo) reduction(max : hi)
    for (size_t row = 0; row < row_count; ++row) {
        const size_t at = row * nx;
        float *d = l->directions ? l->directions + 3 * at : work + (size_t)iso_thread_index() * 3 * nx;
        float *magnitude = l->magnitude ? l->magnitude + at : NULL;
        iso_state_directions(opt->direction_filter, fine, state + 4 * at, nx, d, magnitude);
        iso_code_encode(opt->code, d, l->codes + 3 * at, nx);
        for (size_t x = 0; x < nx; ++x) {
            lo = fminf(lo, l->scalar[at + x]);
            hi = fmaxf(hi, l->scalar[at + x]);
            if (magnitude)
                magnitude[x] *= unscale;
        }
    }
    free(work);
    l->min = lo;
    l->max = hi;
    return ISO_OK;
}

/* State of level 0: gradients of the volume, scaled. */
static iso_status first_state(const iso_volume *v, const iso_pyramid_options *opt, double scale, float *state,
                              iso_error *err)
{
    const size_t count = iso_geometry_voxel_count(&v->geometry);
    float *gradients = malloc(3 * count * sizeof *gradients);
    if (!gradients)
        return iso_fail(err, ISO_E_MEMORY, "pyramid: no memory for %zu gradients", count);
    iso_volume scaled = *v; /* a geometry whose unit is the scale gives scaled gradients */
    scaled.geometry.index_to_world = iso_mat3_scale(v->geometry.index_to_world, 1 / scale);
    iso_gradient_options gradient = opt->gradient;
    gradient.threads = opt->threads;
    iso_status status = iso_gradient_compute(&scaled, &gradient, gradients, err);
    if (status == ISO_OK)
        iso_state_from_gradients(opt->direction_filter, gradients, count, state);
    free(gradients);
    return status;
}

static iso_status next_level(const iso_level *fine, const iso_pyramid_options *opt, const float *fine_state,
                             iso_level *coarse, float *state, iso_error *err)
{
    const int threads = iso_threads(opt->threads);
    const iso_taps mean = iso_taps_mean(), gauss = iso_taps_gauss(opt->gauss_radius, opt->gauss_sigma_voxels);
    iso_status status = decimate(fine->scalar, &fine->geometry, 1,
                                 opt->scalar_filter == ISO_SCALAR_GAUSS ? &gauss : &mean, threads, coarse->scalar, err);
    if (status == ISO_OK)
        status = decimate(fine_state, &fine->geometry, 4, opt->direction_filter == ISO_DIRECTION_EQ1 ? &gauss : &mean,
                          threads, state, err);
    if (status == ISO_OK)
        iso_state_finish(opt->direction_filter, state, iso_geometry_voxel_count(&coarse->geometry));
    return status;
}

static iso_status build_levels(const iso_volume *v, double scale, iso_pyramid *p, const iso_progress *progress,
                               iso_error *err)
{
    const iso_pyramid_options *opt = &p->options;
    iso_geometry g = v->geometry;
    float *state = NULL;
    iso_status status = ISO_OK;
    for (size_t k = 0; k < p->level_count && status == ISO_OK; ++k) {
        iso_progress_report(progress, "pyramid", (double)k / (double)p->level_count);
        iso_level *l = &p->levels[k];
        const iso_type type = k == 0 && iso_type_bytes(v->type) <= 2 ? v->type : ISO_F32;
        float *next = malloc(4 * iso_geometry_voxel_count(&g) * sizeof *next);
        if (!create_level(l, &g, type, opt) || !next)
            status = iso_fail(err, ISO_E_MEMORY, "pyramid: no memory for level %zu of %zu x %zu x %zu voxels", k,
                              g.size[0], g.size[1], g.size[2]);
        if (status == ISO_OK && k == 0) {
            iso_volume_floats(v, l->scalar);
            status = first_state(v, opt, scale, next, err);
        } else if (status == ISO_OK) {
            status = next_level(&p->levels[k - 1], opt, state, l, next, err);
        }
        if (status == ISO_OK)
            status = finish_level(l, opt, k == 0, scale, next, err);
        free(state);
        state = next;
        g = iso_geometry_coarser(&g);
    }
    free(state);
    iso_progress_report(progress, "pyramid", 1);
    return status;
}

iso_status iso_pyramid_build(const iso_volume *v, const char *source, const iso_pyramid_options *opt, iso_pyramid *out,
                             const iso_progress *progress, iso_error *err)
{
    double range = 0;
    *out = (iso_pyramid){.options = *opt};
    iso_status status = check_options(opt, err);
    if (status == ISO_OK)
        status = sample_range(v, source, &range, err);
    if (status != ISO_OK)
        return status;
    out->source = strdup(source);
    out->level_count = count_levels(&v->geometry, opt->level_count);
    out->levels = calloc(out->level_count, sizeof *out->levels);
    if (!out->source || !out->levels)
        status = iso_fail(err, ISO_E_MEMORY, "%s: no memory for its levels", source);
    else
        status = build_levels(v, gradient_scale(&v->geometry, range), out, progress, err);
    if (status != ISO_OK)
        iso_pyramid_destroy(out);
    return status;
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
    }
    free(p->levels);
    free(p->source);
    *p = (iso_pyramid){0};
}
