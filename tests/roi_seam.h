/* SPDX-License-Identifier: MIT */
/* roi_seam.h - measures the seam around a region of interest: the step of emission across the faces of the box and of its
 * band, and the step in an image that looks along them. */
#pragma once

#include <math.h>

#include "image/image.h"
#include "render/sampler.h"
#include "scene/roi.h"
#include "scene/scene.h"

/* The two levels of a region of interest, at any point. */
typedef struct iso_roi_setup {
    const iso_roi *roi;
    iso_sampler around, inside;
    double length_mm; /* of one voxel of level 0 */
} iso_roi_setup;

/* Differences of (premultiplied color, opacity) over one level-0 voxel, unshaded, at faces of box and band. */
typedef struct iso_roi_step {
    double rms, largest; /* between the limits from both sides */
    double own;          /* RMS of the finer level, half a voxel to either side of the box's faces */
    double change;       /* RMS between the two levels in one place */
    double tone;         /* of their means over the faces: visible as one brighter side */
} iso_roi_step;

/* Computes emission and absorption of a point over one level-0 voxel, unshaded: premultiplied color and opacity. */
static void emit(const iso_roi_setup *s, const iso_sampler *at, iso_vec3 index, const iso_tf_table *tf, double weight,
                 double e[4])
{
    double rgbs[4];
    if (weight <= 0)
        return;
    iso_tf_lookup(tf, iso_sample_scalar(at, index), rgbs);
    double opacity = -expm1(-weight * rgbs[3] * s->length_mm);
    for (int c = 0; c < 3; ++c)
        e[c] += opacity * rgbs[c];
    e[3] += opacity;
}

static double distance(const double a[4], const double b[4])
{
    double sum = 0;
    for (int c = 0; c < 4; ++c)
        sum += (a[c] - b[c]) * (a[c] - b[c]);
    return sqrt(sum);
}

/* Does so for the region of interest at an index of the level around it; kind: with the weights of roi. */
static void emit_blended(const iso_roi_setup *s, const iso_roi *roi, const iso_tf_table *around, iso_vec3 index,
                         double e[4])
{
    const double w = iso_roi_weight(roi, index);
    for (int c = 0; c < 4; ++c)
        e[c] = 0;
    emit(s, &s->inside, iso_roi_inside(roi, index), &roi->tf, w, e);
    emit(s, &s->around, index, around, 1 - w, e);
}

typedef struct squares {
    double sum, largest;
    size_t count;
} squares;

static void note(squares *q, double d)
{
    q->sum += d * d;
    q->largest = fmax(q->largest, d);
    ++q->count;
}

static double rms(const squares *q)
{
    return q->count ? sqrt(q->sum / (double)q->count) : 0;
}

/* Returns the i-th point of a face of the box grown by `grown`, spread by an additive recurrence. */
static iso_vec3 face_point(const iso_roi *f, double grown, size_t i, double normal[3])
{
    const int axis = (int)(i % 3), b = (axis + 1) % 3, c = (axis + 2) % 3;
    const bool upper = i / 3 % 2;
    double p[3], u = fmod(0.5 + 0.7548776662466927 * (double)i, 1), v = fmod(0.5 + 0.5698402909980532 * (double)i, 1);
    p[axis] = upper ? f->hi[axis] + grown : f->lo[axis] - grown;
    p[b] = f->lo[b] + u * (f->hi[b] - f->lo[b]);
    p[c] = f->lo[c] + v * (f->hi[c] - f->lo[c]);
    normal[0] = normal[1] = normal[2] = 0;
    normal[axis] = upper ? 1 : -1;
    return iso_v3(p[0], p[1], p[2]);
}

static iso_vec3 shifted(iso_vec3 p, const double normal[3], double by)
{
    return iso_v3(p.x + by * normal[0], p.y + by * normal[1], p.z + by * normal[2]);
}

static iso_status iso_roi_setup_create(iso_roi_setup *s, const iso_pyramid *p, size_t level, const iso_roi *roi,
                                       iso_error *err)
{
    *s = (iso_roi_setup){.length_mm = iso_geometry_mean_spacing_mm(&p->levels[0].geometry), .roi = roi};
    iso_status status = iso_sampler_create(&s->around, &p->levels[level], p->options.code, ISO_FROM_CODES, err);
    TRY(status, iso_sampler_create(&s->inside, &roi->level, p->options.code, ISO_FROM_CODES, err));
    return status;
}

static void iso_roi_setup_destroy(iso_roi_setup *s)
{
    iso_sampler_destroy(&s->around);
    iso_sampler_destroy(&s->inside);
}

/* Measures the steps. around: the TF of the level around the box. */
static iso_roi_step iso_roi_measure_step(const iso_roi_setup *s, const iso_roi *roi, const iso_tf_table *around)
{
    enum { points = 3000 };
    static const double limit = 1e-6; /* in voxels of the level around the box, to either side */
    squares step = {0}, own = {0}, change = {0};
    double inside_mean[4] = {0}, around_mean[4] = {0};
    for (size_t i = 0; i < points; ++i) {
        double normal[3], before[4], behind[4];
        for (int band = 0; band < 2; ++band) {
            iso_vec3 at = face_point(roi, band * roi->band, i, normal);
            emit_blended(s, roi, around, shifted(at, normal, -limit), before);
            emit_blended(s, roi, around, shifted(at, normal, limit), behind);
            note(&step, distance(before, behind));
        }
        /* The finer level's own variation over a voxel, and the difference between both levels in one place. */
        iso_vec3 at = iso_roi_inside(roi, face_point(roi, 0, i, normal));
        double here[4] = {0}, beyond[4] = {0};
        before[0] = before[1] = before[2] = before[3] = behind[0] = behind[1] = behind[2] = behind[3] = 0;
        emit(s, &s->inside, shifted(at, normal, -0.5), &roi->tf, 1, before);
        emit(s, &s->inside, shifted(at, normal, 0.5), &roi->tf, 1, behind);
        note(&own, distance(before, behind));
        emit(s, &s->inside, at, &roi->tf, 1, here);
        emit(s, &s->around, face_point(roi, 0, i, normal), around, 1, beyond);
        note(&change, distance(here, beyond));
        for (int c = 0; c < 4; ++c) {
            inside_mean[c] += here[c] / points;
            around_mean[c] += beyond[c] / points;
        }
    }
    return (iso_roi_step){rms(&step), step.largest, rms(&own), rms(&change), distance(inside_mean, around_mean)};
}

/* Sets up a view of an axis-aligned grid along -z, orthographic, ISO_ROI_PIXELS pixels per voxel. */
#define ISO_ROI_PIXELS 2
static iso_status iso_roi_make_view(const iso_scene *scene, const iso_pyramid *p, iso_view *view, iso_error *err)
{
    const iso_geometry *g = &p->levels[0].geometry;
    double h[3];
    iso_geometry_spacing_mm(g, h);
    *view = (iso_view){0};
    iso_scene along = *scene; /* borrowed, except for the camera */
    const iso_vec3 center = iso_geometry_box_center_mm(g);
    along.camera_fit = false;
    along.orthographic = true;
    along.camera_direction = iso_v3(0, 0, -1);
    along.camera_up = iso_v3(0, 1, 0);
    along.camera_position = iso_madd(center, along.camera_direction, -2 * iso_geometry_box_radius_mm(g));
    along.camera_look_at = center;
    along.height_mm = g->box_index[1] * h[1];
    along.height = ISO_ROI_PIXELS * g->size[1];
    along.width = (size_t)lrint((double)along.height * g->box_index[0] * h[0] / along.height_mm);
    return iso_scene_resolve(&along, g, p->levels[0].min, p->levels[0].max, view, err);
}

/* Returns the RMS color difference of two neighboring columns, over the rows in between. */
static double column_step(const iso_image *image, size_t column, size_t row0, size_t row1)
{
    squares q = {0};
    for (size_t row = row0; row < row1; ++row)
        for (int c = 0; c < 3; ++c) {
            const float *pixel = image->rgba + 4 * (row * image->width + column) + c;
            note(&q, fabs((double)pixel[0] - (double)pixel[-4]));
        }
    return rms(&q);
}

/* Returns the RMS color difference between the pixels on both sides of the box's faces in x, in such an image. */
static double iso_roi_image_step(const iso_image *image, const iso_pyramid *p, const iso_roi_options *box)
{
    const double x_scale = (double)image->width / (double)p->levels[0].geometry.size[0];
    const double y_scale = (double)image->height / (double)p->levels[0].geometry.size[1];
    /* Row 0 is the top, at the largest y. */
    size_t row0 = (size_t)((double)image->height - box->hi[1] * y_scale),
           row1 = (size_t)((double)image->height - box->lo[1] * y_scale);
    double left = column_step(image, (size_t)lrint(box->lo[0] * x_scale), row0, row1);
    double right = column_step(image, (size_t)lrint(box->hi[0] * x_scale), row0, row1);
    return sqrt(0.5 * (left * left + right * right));
}
