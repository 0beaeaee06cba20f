/* SPDX-License-Identifier: MIT */
#include "fit/level_scalar.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "fit/extinction_scale.h"
#include "pyramid/spline_kernel.h"
#include "tf/level_look.h"

static const struct {
    const char *name, *summary;
} kinds_of_scalar[] = {
    [ISO_LEVEL_AS_BUILT] = {"as-built", "by the pyramid's scalar filter"},
    [ISO_LEVEL_LEAST_SQUARES] = {"least-squares", "closest to level 0 under trilinear interpolation"},
    [ISO_LEVEL_DAMPED] = {"damped", "from the means .6 of the way to least squares"},
    [ISO_LEVEL_FITTED] = {"fitted", "closest to level 0 after the transfer function"},
    [ISO_LEVEL_OPTIMIZED] = {"optimized", "closest to level 0 in pictures, with its directions"},
};
const iso_names iso_level_scalar_names = ISO_NAMES_OF_ROWS("level scalar", kinds_of_scalar);

const char *iso_level_scalar_name(iso_level_scalar s)
{
    return kinds_of_scalar[s].name;
}

/* Computes c = (A^T A)^-1 c, in place: the grid's system is a product of one system per axis. */
static iso_status solve_axes(const iso_interpolation *map, size_t level, float *c, iso_error *err)
{
    const size_t n[3] = {map->axis[0].coarse_size, map->axis[1].coarse_size, map->axis[2].coarse_size};
    const size_t plane = n[0] * n[1], most = n[0] > n[1] ? (n[0] > n[2] ? n[0] : n[2]) : (n[1] > n[2] ? n[1] : n[2]);
    iso_spline_row *rows = malloc(most * sizeof *rows);
    float *scratch = malloc(ISO_SPLINE_LANES * n[0] * sizeof *scratch);
    if (!rows || !scratch) {
        free(rows);
        free(scratch);
        return iso_fail(err, ISO_E_MEMORY, "no memory for a row of %zu voxels", most);
    }
    for (int a = 0; a < 3; ++a) {
        const iso_spline_axis axis = {map->axis[a].fine_size, n[a], (size_t)1 << level};
        iso_spline_factorize(&axis, 0, n[a], rows);
        if (a == 2)
            iso_spline_solve(rows, n[2], c, plane, plane);
        for (size_t z = 0; a == 1 && z < n[2]; ++z)
            iso_spline_solve(rows, n[1], c + z * plane, n[0], n[0]);
        for (size_t y = 0; a == 0 && y < n[1] * n[2]; y += ISO_SPLINE_LANES) {
            const size_t left = n[1] * n[2] - y;
            iso_spline_solve_rows(rows, n[0], c + y * n[0], n[0], left < ISO_SPLINE_LANES ? left : ISO_SPLINE_LANES,
                                  scratch);
        }
    }
    free(rows);
    free(scratch);
    return ISO_OK;
}

static iso_status make_least_squares(const iso_level_scalar_input *in, const iso_interpolation *map, float *c,
                                     iso_error *err)
{
    const float cell = ldexpf(1, -3 * (int)in->level); /* both sides of the system are by the fine voxel */
    NEED(iso_interpolation_scatter(map, in->level0->scalar, c, in->threads, err));
    for (size_t i = 0; i < map->coarse_count; ++i)
        c[i] *= cell;
    return solve_axes(map, in->level, c, err);
}

static iso_status make_fitted(const iso_level_scalar_input *in, const iso_interpolation *map, float *fitted,
                              iso_fit_report *report, iso_error *err)
{
    OWNED(iso_fit_curve) curve = {0};
    iso_fit_report unread;
    iso_fit_options opt = iso_fit_defaults();
    const double length_mm = iso_geometry_mean_spacing_mm(&in->level0->geometry);
    opt.threads = in->threads;
    NEED(iso_fit_curve_create(in->tf, length_mm, &curve, err));
    return iso_fit_scalar(&(iso_fit_problem){map, in->level0->scalar, &curve}, &opt, fitted, report ? report : &unread,
                          err);
}

iso_status iso_level_scalars_make(const iso_level_scalar_input *in, float *least_squares, float *fitted,
                                  iso_fit_report *report, iso_error *err)
{
    OWNED(iso_interpolation) map = {0};
    NEED(iso_interpolation_create(&map, in->level0->geometry.size, in->level, err));
    NEED(make_least_squares(in, &map, least_squares, err));
    if (fitted) {
        memcpy(fitted, least_squares, map.coarse_count * sizeof *fitted);
        NEED(make_fitted(in, &map, fitted, report, err));
    }
    return ISO_OK;
}

/* The fine voxels of a coarse one. */
typedef struct own_voxels {
    double mean;
    float low, high;
} own_voxels;

static own_voxels find_own(const iso_level *fine, size_t level, size_t x, size_t y, size_t z)
{
    const size_t *n = fine->geometry.size, r = (size_t)1 << level;
    own_voxels own = {0, INFINITY, -INFINITY};
    size_t count = 0;
    for (size_t k = z * r; k < (z + 1) * r && k < n[2]; ++k)
        for (size_t j = y * r; j < (y + 1) * r && j < n[1]; ++j)
            for (size_t i = x * r; i < (x + 1) * r && i < n[0]; ++i, ++count) {
                const float v = fine->scalar[(k * n[1] + j) * n[0] + i];
                own.mean += (double)v;
                own.low = fminf(own.low, v);
                own.high = fmaxf(own.high, v);
            }
    own.mean /= (double)count;
    return own;
}

void iso_level_scalar_damp(const iso_level_scalar_input *in, float *scalar)
{
    size_t n[3];
    for (int a = 0; a < 3; ++a)
        n[a] = (in->level0->geometry.size[a] + ((size_t)1 << in->level) - 1) >> in->level;
#pragma omp parallel for schedule(static) num_threads(iso_threads(in->threads))
    for (size_t i = 0; i < n[0] * n[1] * n[2]; ++i) {
        const own_voxels own = find_own(in->level0, in->level, i % n[0], i / n[0] % n[1], i / (n[0] * n[1]));
        const float held = in->level == 1 ? fminf(fmaxf(scalar[i], own.low), own.high) : scalar[i];
        scalar[i] = (float)(own.mean + (double)ISO_DAMPED_PART * ((double)held - own.mean));
    }
}

size_t iso_level_scalar_bytes(const size_t n[3])
{
    const size_t fine = n[0] * n[1] * n[2], coarse = ((n[0] + 1) / 2) * ((n[1] + 1) / 2) * ((n[2] + 1) / 2);
    return iso_fit_bytes(fine, coarse) + 2 * coarse * sizeof(float);
}

static void read_level(iso_json_reader *r, const json_t *entry, const iso_pyramid *p, iso_level_scalar kinds[32])
{
    size_t level = 1, kind = 0;
    const char *name = NULL;
    iso_json_get_size(r, entry, "level", true, 1, p->level_count - 1, &level);
    iso_json_get_string(r, entry, "scalar", true, &name);
    TRY(r->status, iso_names_find(&iso_level_scalar_names, name, &kind, r->err) == ISO_OK
                       ? ISO_OK
                       : iso_fail_in(r->err, ISO_E_FORMAT, "%s", r->path));
    if (r->status == ISO_OK)
        kinds[level] = (iso_level_scalar)kind;
}

iso_status iso_level_scalars_read(const iso_pyramid *p, iso_tf_table *tf, iso_level_scalar kinds[32], iso_error *err)
{
    iso_json_reader r = {.path = "pyramid.json", .err = err};
    *tf = (iso_tf_table){0};
    for (size_t k = 0; k < 32; ++k)
        kinds[k] = ISO_LEVEL_AS_BUILT;
    const json_t *levels = iso_json_get_array(&r, p->made_for, "levels", true);
    for (size_t i = 0; i < json_array_size(levels) && r.status == ISO_OK; ++i)
        read_level(&r, json_array_get(levels, i), p, kinds);
    iso_status status = r.status;
    TRY(status, iso_level_scene_tf(p, 0, tf, err));
    return status;
}

static void note(const iso_level *l, size_t voxel, const char *what, iso_level_check *check)
{
    const size_t *n = l->geometry.size;
    if (!check->what) {
        check->what = what;
        check->first[0] = voxel % n[0], check->first[1] = voxel / n[0] % n[1], check->first[2] = voxel / (n[0] * n[1]);
    }
    ++check->differing;
}

/* Notes the voxels of a level that differ from those made again. */
static void compare(const iso_level *l, const float *made, iso_level_check *check)
{
    const size_t count = iso_geometry_voxel_count(&l->geometry);
    double lo = INFINITY, hi = -INFINITY;
    for (size_t i = 0; i < count; ++i) {
        lo = fmin(lo, (double)made[i]);
        hi = fmax(hi, (double)made[i]);
        if (memcmp(&l->scalar[i], &made[i], sizeof(float)) != 0)
            note(l, i, "values", check);
    }
    if (!check->what && (lo != l->min || hi != l->max)) {
        check->what = "range";
        check->differing = check->voxels;
    }
}

/* Makes a scene's extinction scale of a level again and adds it to the sums. */
static iso_status add_scale(const iso_pyramid *p, size_t level, size_t scene, iso_extinction_scaler *scaler,
                            uint8_t *made, size_t *sums, iso_error *err)
{
    OWNED(iso_tf_table) tf = {0}, own = {0};
    NEED(iso_level_scene_tf(p, scene, &tf, err));
    NEED(iso_level_look(p, level, &tf, &own, NULL, err));
    NEED(iso_extinction_scaler_apply(scaler, &tf, &own, made, NULL, err));
    for (size_t i = 0; i < iso_geometry_voxel_count(&p->levels[level].geometry); ++i)
        sums[i] += made[i];
    return ISO_OK;
}

/* Makes a level's extinction scale again: the mean of those for its scenes. */
static iso_status compare_scale(const iso_pyramid *p, size_t level, int threads, iso_level_check *check, iso_error *err)
{
    const iso_level *l = &p->levels[level];
    const size_t bytes = iso_geometry_voxel_count(&l->geometry), scenes = iso_level_scene_count(p);
    iso_extinction_scaler *scaler = NULL;
    if (!l->scale)
        return ISO_OK;
    FREED uint8_t *made = malloc(bytes);
    FREED size_t *sums = calloc(bytes, sizeof *sums);
    iso_status status = made && sums ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for %zu voxels", bytes);
    TRY(status, iso_extinction_scaler_create(&p->levels[0], l, level, threads, &scaler, err));
    for (size_t i = 0; i < scenes; ++i)
        TRY(status, add_scale(p, level, i, scaler, made, sums, err));
    for (size_t i = 0; i < bytes && status == ISO_OK; ++i)
        if (l->scale[i] != iso_extinction_scale_mean(sums[i], scenes))
            note(l, i, "extinction scale", check);
    iso_extinction_scaler_destroy(scaler);
    return status;
}

iso_status iso_fit_verify(const iso_pyramid *p, int threads, iso_level_check *checks, const iso_progress *progress,
                          iso_error *err)
{
    OWNED(iso_tf_table) tf = {0};
    iso_level_scalar kinds[32];
    NEED(iso_pyramid_verify(p, threads, checks, progress, err));
    if (!p->made_for)
        return ISO_OK;
    NEED(iso_level_scalars_read(p, &tf, kinds, err));
    for (size_t k = 1; k < p->level_count; ++k) {
        const size_t bytes = iso_geometry_voxel_count(&p->levels[k].geometry) * sizeof(float);
        FREED float *least_squares = malloc(bytes), *fitted = malloc(bytes);
        NEED_MEMORY(least_squares && fitted, err, "no memory to make level %zu again", k);
        iso_progress_report(progress, "levels", (double)k / (double)p->level_count);
        if (kinds[k] != ISO_LEVEL_AS_BUILT && kinds[k] != ISO_LEVEL_OPTIMIZED) {
            const bool is_fitted = kinds[k] == ISO_LEVEL_FITTED;
            const iso_level_scalar_input in = {&p->levels[0], &tf, k, threads};
            NEED(iso_level_scalars_make(&in, least_squares, is_fitted ? fitted : NULL, NULL, err));
            if (kinds[k] == ISO_LEVEL_DAMPED)
                iso_level_scalar_damp(&in, least_squares);
            compare(&p->levels[k], is_fitted ? fitted : least_squares, &checks[k]);
        }
        if (kinds[k] != ISO_LEVEL_OPTIMIZED)
            NEED(compare_scale(p, k, threads, &checks[k], err));
    }
    return ISO_OK;
}
