/* SPDX-License-Identifier: MIT */
#include "tf/presets.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "tf/color_space.h"
#include "tf/suggest.h"

enum { MOST_POINTS = 8 };

typedef enum preset_scale { SCALE_AUTO, SCALE_HOUNSFIELD, SCALE_OBJECT, SCALE_SIGNED } preset_scale;

/* at: position on the preset's scale; srgb: display color; opacity over `unit` */
typedef struct preset_point {
    double at, srgb[3], opacity;
} preset_point;

typedef struct preset {
    const char *name, *summary;
    preset_scale scale;
    double unit; /* in mm on the Hounsfield scale, otherwise in voxels */
    size_t count;
    preset_point points[MOST_POINTS];
} preset;

/* clang-format off */
static const preset presets[] = {
    {.name = "auto", .summary = "same as tf suggest: materials from the volume's own histogram"},
    {.name = "ct-bone", .summary = "CT: bone alone, from 200 HU",
     .scale = SCALE_HOUNSFIELD, .unit = 1, .count = 4, .points = {
        {180,   {0.80, 0.60, 0.45}, 0},
        {400,   {0.93, 0.84, 0.70}, 0.55},
        {1200,  {1.00, 0.97, 0.90}, 0.85},
        {3000,  {1.00, 1.00, 1.00}, 0.95}}},
    {.name = "ct-soft-tissue", .summary = "CT: skin and organs, bone through them",
     .scale = SCALE_HOUNSFIELD, .unit = 1, .count = 7, .points = {
        {-500,  {0.88, 0.62, 0.50}, 0},
        {-200,  {0.88, 0.62, 0.50}, 0.006},
        {-60,   {0.92, 0.70, 0.45}, 0.008},
        {40,    {0.85, 0.40, 0.32}, 0.02},
        {150,   {0.90, 0.55, 0.42}, 0.05},
        {250,   {0.97, 0.90, 0.78}, 0.35},
        {1500,  {1.00, 1.00, 0.97}, 0.9}}},
    {.name = "ct-vessels", .summary = "CT with contrast medium: vessels red, bone pale",
     .scale = SCALE_HOUNSFIELD, .unit = 1, .count = 5, .points = {
        {110,   {0.75, 0.15, 0.12}, 0},
        {180,   {0.85, 0.20, 0.15}, 0.35},
        {320,   {0.95, 0.45, 0.30}, 0.6},
        {600,   {0.98, 0.90, 0.78}, 0.75},
        {1500,  {1.00, 1.00, 0.97}, 0.9}}},
    {.name = "ct-lung", .summary = "CT: lungs blue, their bounds and the skin a red veil, dense bone faint",
     .scale = SCALE_HOUNSFIELD, .unit = 1, .count = 8, .points = {
        {-960,  {0.35, 0.55, 0.90}, 0},
        {-900,  {0.35, 0.55, 0.90}, 0.006},
        {-750,  {0.50, 0.65, 0.90}, 0.02},
        {-600,  {0.90, 0.60, 0.60}, 0.03},
        {-450,  {0.95, 0.65, 0.55}, 0.01},
        {-350,  {0.90, 0.50, 0.40}, 0},
        {300,   {1.00, 0.97, 0.90}, 0},
        {1000,  {1.00, 0.97, 0.90}, 0.1}}},
    {.name = "mri-brain", .summary = "MRI: dark tissue is a veil, bright tissue dense",
     .scale = SCALE_OBJECT, .unit = 4, .count = 5, .points = {
        {0.10,  {0.55, 0.40, 0.35}, 0},
        {0.30,  {0.80, 0.55, 0.45}, 0.06},
        {0.45,  {0.93, 0.68, 0.55}, 0.30},
        {0.65,  {1.00, 0.88, 0.76}, 0.80},
        {1.00,  {1.00, 1.00, 0.95}, 0.90}}},
    {.name = "angiography", .summary = "vessels that are brighter than the rest",
     .scale = SCALE_OBJECT, .unit = 1, .count = 4, .points = {
        {0.12,  {0.70, 0.10, 0.08}, 0},
        {0.30,  {0.85, 0.20, 0.12}, 0.5},
        {0.60,  {0.98, 0.60, 0.35}, 0.75},
        {1.00,  {1.00, 0.95, 0.80}, 0.85}}},
    {.name = "microscopy", .summary = "fluorescence: dim is green and thin, bright is pale and dense",
     .scale = SCALE_OBJECT, .unit = 2, .count = 5, .points = {
        {0.03,  {0.05, 0.30, 0.25}, 0},
        {0.12,  {0.10, 0.65, 0.40}, 0.10},
        {0.35,  {0.35, 0.85, 0.40}, 0.40},
        {0.70,  {0.85, 0.95, 0.50}, 0.75},
        {1.00,  {1.00, 1.00, 0.90}, 0.85}}},
    {.name = "orbital", .summary = "signed values: positive orange, negative blue, background invisible",
     .scale = SCALE_SIGNED, .unit = 2, .count = 8, .points = {
        {-1.00, {0.60, 0.85, 1.00}, 0.8},
        {-0.30, {0.20, 0.50, 0.95}, 0.7},
        {-0.15, {0.20, 0.50, 0.95}, 0.15},
        {-0.05, {0.20, 0.50, 0.95}, 0},
        {0.05,  {0.95, 0.55, 0.20}, 0},
        {0.15,  {0.95, 0.55, 0.20}, 0.15},
        {0.30,  {0.95, 0.55, 0.20}, 0.7},
        {1.00,  {1.00, 0.85, 0.55}, 0.8}}},
    {.name = "simulation", .summary = "a plume: low values blue and thin, high values yellow and dense",
     .scale = SCALE_OBJECT, .unit = 4, .count = 6, .points = {
        {0.02,  {0.15, 0.20, 0.60}, 0},
        {0.10,  {0.20, 0.40, 0.80}, 0.06},
        {0.30,  {0.55, 0.35, 0.75}, 0.15},
        {0.55,  {0.90, 0.40, 0.35}, 0.40},
        {0.80,  {0.98, 0.70, 0.30}, 0.70},
        {1.00,  {1.00, 0.95, 0.65}, 0.85}}},
};
/* clang-format on */

const iso_names iso_tf_preset_names = ISO_NAMES_OF_ROWS("transfer function preset", presets);

/* ---- scales ---- */

/* Returns the quantile of the values beyond the background that has this part of them below it. */
static double object_quantile(const iso_survey *s, double begins, double part)
{
    double below = 0;
    while (below < 1 && iso_survey_quantile(s, below) <= begins)
        below += 1.0 / ISO_SURVEY_QUANTILES;
    return iso_survey_quantile(s, below + (1 - below) * part);
}

/* Computes the scale: value = zero + at * one. */
static void lay_scale(preset_scale scale, const iso_survey *s, double *zero, double *one)
{
    *zero = 0;
    *one = 1;
    if (scale == SCALE_HOUNSFIELD && !s->is_hounsfield) {
        const double air = s->has_background ? s->background : s->lo, bright = iso_survey_quantile(s, 0.999);
        *one = (bright - air) / 2500;
        *zero = air + 1000 * *one;
    } else if (scale == SCALE_OBJECT) {
        *zero = s->has_background ? s->background_hi : s->lo;
        *one = object_quantile(s, *zero, 0.999) - *zero;
    } else if (scale == SCALE_SIGNED) {
        *zero = s->has_background ? s->background : 0;
        *one = fmax(iso_survey_quantile(s, 0.9998) - *zero, *zero - iso_survey_quantile(s, 0.0002));
    }
    if (!(*one > 0))
        *one = fmax(1, fabs(*zero));
}

static iso_status apply(const preset *p, const iso_survey *s, const iso_geometry *level0, iso_tf *tf, iso_error *err)
{
    double zero, one;
    lay_scale(p->scale, s, &zero, &one);
    *tf = (iso_tf){.table_size = 1024, .point_count = p->count, .unit_distance = p->unit};
    tf->points = calloc(p->count, sizeof *tf->points);
    NEED_MEMORY(tf->points, err, "no memory for a transfer function");
    if (p->scale != SCALE_HOUNSFIELD || !s->is_hounsfield)
        tf->unit_distance *= iso_geometry_mean_spacing_mm(level0);
    for (size_t i = 0; i < p->count; ++i) {
        tf->points[i].value = zero + p->points[i].at * one;
        tf->points[i].opacity = p->points[i].opacity;
        for (int c = 0; c < 3; ++c)
            tf->points[i].rgb_linear[c] = iso_srgb_to_linear(p->points[i].srgb[c]);
    }
    tf->range[0] = tf->points[0].value;
    tf->range[1] = tf->points[p->count - 1].value;
    return ISO_OK;
}

bool iso_tf_preset_find(const char *name, size_t *row)
{
    return iso_names_find(&iso_tf_preset_names, name, row, NULL) == ISO_OK;
}

iso_status iso_tf_preset_apply(size_t row, const iso_survey *survey, const iso_geometry *level0, iso_tf *tf,
                               iso_error *err)
{
    iso_suggestion suggestion;
    iso_status status;
    if (presets[row].scale != SCALE_AUTO) {
        status = apply(&presets[row], survey, level0, tf, err);
    } else {
        status = iso_suggest(survey, level0, &suggestion, err);
        *tf = suggestion.tf;
    }
    snprintf(tf->of, sizeof tf->of, "--tf %s", presets[row].name);
    return status;
}

iso_status iso_tf_of_level(const char *name, const iso_tf_request *request, const iso_survey *survey,
                           const iso_level *level0, int threads, iso_tf *tf, iso_error *err)
{
    size_t row = 0;
    *tf = (iso_tf){0};
    if (name && !iso_tf_preset_find(name, &row))
        return iso_tf_load_as(name, request, tf, err);
    if (survey)
        return iso_tf_preset_apply(row, survey, &level0->geometry, tf, err);
    FREED iso_survey *own = NULL;
    NEED(iso_survey_make(level0, threads, &own, err));
    return iso_tf_preset_apply(row, own, &level0->geometry, tf, err);
}

iso_status iso_tf_of_volume(const char *name, const iso_tf_request *request, const iso_volume *v, int threads,
                            iso_tf *tf, iso_error *err)
{
    size_t row;
    *tf = (iso_tf){0};
    if (name && !iso_tf_preset_find(name, &row))
        return iso_tf_load_as(name, request, tf, err);
    const iso_volume_stats stats = iso_volume_measure(v);
    const iso_level level = {
        .geometry = v->geometry, .stored_type = v->type, .samples = v, .min = stats.min, .max = stats.max};
    return iso_tf_of_level(name, request, NULL, &level, threads, tf, err);
}

iso_status iso_tf_check_name(const char *name, const iso_tf_request *request, iso_error *err)
{
    size_t row = 0;
    OWNED(iso_tf) tf = {0};
    if (!name || iso_tf_preset_find(name, &row))
        return ISO_OK;
    if (!iso_path_exists(name) && !strpbrk(name, "./"))
        return iso_names_find(&iso_tf_preset_names, name, &row, err);
    return iso_tf_load_as(name, request, &tf, err);
}
