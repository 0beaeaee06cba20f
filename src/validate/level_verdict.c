/* SPDX-License-Identifier: MIT */
/* level_verdict.c - decides whether a level may replace level 0: turns measurements in the views into a verdict
 * (report/levels.h). */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "validate/measured.h"

/* Each interval by itself. */
static const double confidence = 0.95;
/* A quarter of a step of 8 bits: such a change is invisible, and smooth volumes differ by less. */
static const double margin = 1e-3;
/* Samples of coarse levels are floats, and rebuilding gives the same ones; another order of the sums would round
 * them. */
static const double scalar_limit = 1e-5;
/* A last bit of a code is up to .5 degrees (snorm), where rounding turns it; on average it hardly ever does. */
static const double direction_limit_deg = 0.1;

/* ---- is a level what level 0 makes? ---- */

static double scalar_difference(const iso_level *a, const iso_level *b)
{
    const double range = b->max > b->min ? b->max - b->min : 1;
    double most = 0;
    for (size_t i = 0; i < iso_geometry_voxel_count(&a->geometry); ++i)
        most = fmax(most, fabs((double)a->scalar[i] - (double)b->scalar[i]) / range);
    return most;
}

static iso_vec3 direction_of(const iso_level *l, iso_code code, size_t voxel)
{
    double e[3], d[3];
    iso_code_lattice(code, l->codes + 3 * voxel, e);
    iso_code_decode(code, e, d);
    return iso_v3(d[0], d[1], d[2]);
}

/* Returns the mean angle in degrees over the voxels that have a direction in either level. The longer direction is the
 * weight: short ones are grain. */
static double direction_difference_deg(const iso_level *a, const iso_level *b, iso_code code)
{
    double sum = 0, weights = 0;
    for (size_t i = 0; i < iso_geometry_voxel_count(&a->geometry); ++i) {
        const iso_vec3 x = direction_of(a, code, i), y = direction_of(b, code, i);
        const double weight = fmax(iso_norm(x), iso_norm(y));
        const double cosine = iso_dot(iso_normalize(x), iso_normalize(y));
        if (weight <= 0)
            continue;
        sum += weight * (memcmp(a->codes + 3 * i, b->codes + 3 * i, 3) == 0
                             ? 0
                             : acos(fmin(fmax(cosine, -1), 1)) * (180 / 3.14159265358979323846));
        weights += weight;
    }
    return weights > 0 ? sum / weights : 0;
}

static void compare_with_rebuilt(const iso_validation *v, const iso_pyramid *rebuilt, iso_report_level *row)
{
    const iso_level *a = &v->pyramid->levels[row->level], *b = &rebuilt->levels[row->level];
    row->scalar_limit = scalar_limit;
    row->direction_limit_deg = direction_limit_deg;
    row->scalar_off = scalar_difference(a, b);
    row->direction_off_deg = direction_difference_deg(a, b, v->pyramid->options.code);
}

/* ---- against other methods ---- */

static double mean(const double *values, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; ++i)
        sum += values[i] / (double)count;
    return sum;
}

/* Returns the option that turns the judged pictures' transfer function into the rival's. */
static const char *tf_option(const iso_measured_level *m, const iso_measured_level *own)
{
    if (m->use == own->use)
        return "";
    if (own->use == ISO_USE_SCALED)
        return m->use == ISO_USE_ADAPTED ? "--adapt without --extinction-scale" : "without --extinction-scale";
    return m->use == ISO_USE_ADAPTED ? "--adapt" : "without --adapt";
}

static void name_option(const iso_measured_level *m, const iso_measured_level *own, char *text, size_t size)
{
    const bool fly = m->method->source == ISO_FROM_ON_THE_FLY, same = m->method == own->method;
    const char *tf = tf_option(m, own);
    snprintf(text, size, "%s%s%s%s",
             same  ? ""
             : fly ? "--shading-from on-the-fly"
                   : "build --direction-filter ",
             same || fly ? "" : iso_direction_filter_name(m->method->filter), !same && tf[0] ? ", " : "", tf);
}

enum { OPTION_BYTES = 96 };

static iso_report_rival rival_of(const iso_measured_level *own, const iso_measured_level *m, size_t views,
                                 char option[OPTION_BYTES])
{
    iso_report_rival r = {.method = m->method->name, .adapted = m->use == ISO_USE_ADAPTED, .option = option};
    name_option(m, own, option, OPTION_BYTES);
    for (int k = 0; k < ISO_LEVEL_FIGURE_COUNT; ++k) {
        r.value[k] = mean(m->figures[k], views);
        r.deficit[k] = iso_paired_compare(own->figures[k], m->figures[k], views, confidence);
    }
    return r;
}

iso_level_tf_use iso_measured_own_use(const iso_validation *v, size_t level)
{
    if (v->scales != ISO_SCALES_NONE)
        return ISO_USE_SCALED;
    return v->level_tfs[level].judgment.use_original ? ISO_USE_ORIGINAL : ISO_USE_ADAPTED;
}

const iso_measured_level *iso_measured_find(const iso_measured *all, size_t level, const iso_method *method,
                                            iso_level_tf_use use)
{
    for (size_t i = 0; i < all->count; ++i)
        if (all->levels[i].level == level && all->levels[i].method == method && all->levels[i].use == use)
            return &all->levels[i];
    return NULL;
}

bool iso_measured_is_open(const iso_measured_level *own, const iso_measured_level *simple, size_t views)
{
    for (int k = 0; k < ISO_LEVEL_FIGURE_COUNT; ++k) {
        const iso_paired behind = iso_paired_compare(own->figures[k], simple->figures[k], views, confidence);
        if (behind.difference > margin && !iso_paired_is_larger(behind, margin))
            return true;
    }
    return false;
}

bool iso_measured_is_behind(const iso_measured_level *own, const iso_measured_level *simple, size_t views)
{
    for (int k = 0; k < ISO_LEVEL_FIGURE_COUNT; ++k)
        if (iso_paired_is_larger(iso_paired_compare(own->figures[k], simple->figures[k], views, confidence), margin))
            return true;
    return false;
}

/* Returns the level's figures in twenty views, if the others left it open: two in a row, or NULL. */
static const iso_measured_level *find_more(const iso_measured *all, size_t level)
{
    for (size_t i = 0; i < all->more_count; i += 2)
        if (all->more[i].level == level)
            return &all->more[i];
    return NULL;
}

/* Measures the angles of the pyramid's own directions and of gradients on the fly to level 0's. */
static iso_status compare_directions(const iso_validation *v, const iso_measured *all, const iso_pyramid *rebuilt,
                                     iso_report_level *row, iso_error *err)
{
    const iso_measured_level *own = iso_measured_find(all, row->level, all->own, ISO_USE_ORIGINAL),
                             *fly = iso_measured_find(all, row->level, all->on_the_fly, ISO_USE_ORIGINAL);
    const iso_angles_of stored = {v->pyramid, ISO_FROM_CODES}, simple = {rebuilt, ISO_FROM_ON_THE_FLY};
    row->angle_deg = own->angle_deg;
    row->simple_angle_deg = fly->angle_deg;
    return iso_validate_compare_angles(v, row->level, stored, simple, confidence, &row->angle_deficit, err);
}

/* Judges a level. *late: it is judged without its bound, because time has run out. */
static iso_status judge(iso_validation *v, const iso_measured *all, const iso_pyramid *rebuilt, size_t level,
                        bool *late, iso_error *err)
{
    char options[ISO_MEASURED_MOST][OPTION_BYTES], simple[OPTION_BYTES];
    iso_report_rival rivals[ISO_MEASURED_MOST];
    const bool refused = v->level_tfs[level].judgment.use_original;
    const iso_level_tf_use use = iso_measured_own_use(v, level);
    const iso_measured_level *own = iso_measured_find(all, level, all->own, use),
                             *fly = iso_measured_find(all, level, all->on_the_fly, ISO_USE_ORIGINAL),
                             *more = find_more(all, level);
    const iso_measured_level *judged = more ? &more[0] : own, *simple_way = more ? &more[1] : fly;
    const size_t views = more ? ISO_FACE_VIEWS : v->consistency_views;
    const struct iso_scene_asked *asked = &v->scene->levels;
    const iso_scene_level_limits *limits[] = {&asked->ssim_dissimilarity, &asked->flip, &asked->rmse};
    const bool is_chosen = all->own->filter == ISO_DIRECTION_AUTO && v->pyramid->options.choice.is_made;
    const iso_direction_filter chosen = iso_direction_filter_of(&v->pyramid->options, level);
    iso_report_level row = {.shown = all->shown,
                            .level = level,
                            .views = views,
                            .views_before = v->consistency_views,
                            .method = all->own->name,
                            .chosen = is_chosen ? iso_direction_filter_name(chosen) : NULL,
                            .adapted = use == ISO_USE_ADAPTED,
                            .scaled = use == ISO_USE_SCALED,
                            .confidence = confidence,
                            .margin = margin,
                            .rivals = rivals,
                            .simple = rival_of(judged, simple_way, views, simple)};
    for (int k = 0; k < ISO_LEVEL_FIGURE_COUNT; ++k) {
        row.value[k] = mean(judged->figures[k], views);
        row.asked[k] = iso_scene_level_limit(limits[k], level);
    }
    for (size_t i = 0; i < all->count && row.rival_count < ISO_MEASURED_MOST; ++i) {
        const iso_measured_level *m = &all->levels[i];
        if (m->level != level || m == own || m == fly ||
            (m->use == ISO_USE_ADAPTED && refused)) /* the original's pictures */
            continue;
        if (is_chosen && m->method->source == ISO_FROM_CODES && m->method->filter == chosen && m->use == use)
            continue; /* the same pictures */
        rivals[row.rival_count] = rival_of(own, m, v->consistency_views, options[row.rival_count]);
        ++row.rival_count;
    }
    compare_with_rebuilt(v, rebuilt, &row);
    iso_status status = compare_directions(v, all, rebuilt, &row, err);
    TRY(status, iso_validate_bound_level(v, own, &row, late, err));
    TRY(status, iso_validate_judge_scale(v, rebuilt, &row, err));
    return status == ISO_OK ? iso_report_add_level(v->report, &row, err) : status;
}

iso_status iso_validate_judge_levels(iso_validation *v, const iso_measured *all, const iso_pyramid *rebuilt,
                                     iso_error *err)
{
    iso_status status = ISO_OK;
    bool late = false;
    for (size_t level = 1; level < v->pyramid->level_count && status == ISO_OK; ++level)
        status = judge(v, all, rebuilt, level, &late, err);
    return status == ISO_OK && late ? iso_validate_stage_left_out(v, "bounds of levels", err) : status;
}
