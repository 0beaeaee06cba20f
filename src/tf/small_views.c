/* SPDX-License-Identifier: MIT */
#include "tf/small_views.h"

#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "compare/ssim.h"

enum { PIXELS = ISO_SMALL_VIEWS_PIXELS, PICTURES = 1 + ISO_SMALL_VIEWS_MAX_TFS };

/* Below this transmittance a ray has no more to show: half a step of 8 bits, seen 16 times enlarged. */
#define OPAQUE 1e-4

/* An orthographic camera in the index space of level 0, which its rays cross. */
typedef struct small_camera {
    iso_vec3 corner, right, down, direction; /* of the first pixel's centre; a pixel's steps; a ray step */
    double step_mm;
    long step_count;
} small_camera;

/* A third of v, mirrored along one axis of the world, or along none where axis is 0. */
static iso_vec3 turn(iso_vec3 v, int axis)
{
    return iso_v3((axis == 1 ? -v.x : v.x) / 3, (axis == 2 ? -v.y : v.y) / 3, (axis == 3 ? -v.z : v.z) / 3);
}

static const iso_vec3 directions[3][3] = {{{2, 2, -1}, {2, -1, 2}, {-1, 2, 2}},
                                          {{2, -1, 2}, {-1, 2, 2}, {2, 2, -1}},
                                          {{-1, 2, 2}, {2, 2, -1}, {2, -1, 2}}};

iso_vec3 iso_small_views_direction(int view)
{
    return turn(directions[view % 3][0], view / 3);
}

static small_camera frame_box(const iso_geometry *g, int view)
{
    const iso_vec3 center = iso_geometry_box_center_mm(g);
    iso_vec3 axes[3];
    double half[3] = {0}; /* of the box along the axes */
    for (int a = 0; a < 3; ++a)
        axes[a] = turn(directions[view % 3][a], view / 3);
    for (int corner = 0; corner < 8; ++corner) {
        const iso_vec3 index = iso_v3(corner & 1 ? g->box_index[0] : 0, corner & 2 ? g->box_index[1] : 0,
                                      corner & 4 ? g->box_index[2] : 0);
        for (int a = 0; a < 3; ++a)
            half[a] = fmax(half[a], fabs(iso_dot(axes[a], iso_sub(iso_geometry_to_world(g, index), center))));
    }
    const double extent = fmax(half[1], half[2]), pixel = 2 * extent / PIXELS;
    const iso_mat3 to_index = iso_mat3_inverse(g->index_to_world);
    small_camera c = {.step_mm = iso_geometry_min_spacing_mm(g)};
    iso_vec3 corner = iso_madd(center, axes[0], 0.5 * c.step_mm - half[0]);
    for (int a = 1; a < 3; ++a)
        corner = iso_madd(corner, axes[a], 0.5 * pixel - extent);
    c.step_count = (long)ceil(2 * half[0] / c.step_mm);
    c.corner = iso_geometry_to_index(g, corner);
    c.direction = iso_mul(to_index, iso_scale(axes[0], c.step_mm));
    c.right = iso_mul(to_index, iso_scale(axes[1], pixel));
    c.down = iso_mul(to_index, iso_scale(axes[2], pixel));
    return c;
}

/* Steps [*first, *last] of a ray from p that lie in the box; none: *first > *last. */
static void clip_to_box(const small_camera *c, const iso_geometry *g, iso_vec3 p, long *first, long *last)
{
    const double at[3] = {p.x, p.y, p.z}, d[3] = {c->direction.x, c->direction.y, c->direction.z};
    double t0 = 0, t1 = (double)c->step_count;
    for (int a = 0; a < 3; ++a) {
        if (fabs(d[a]) < 1e-12) {
            t1 = at[a] < 0 || at[a] > g->box_index[a] ? -1 : t1;
            continue;
        }
        const double near = -at[a] / d[a], far = (g->box_index[a] - at[a]) / d[a];
        t0 = fmax(t0, fmin(near, far));
        t1 = fmin(t1, fmax(near, far));
    }
    *first = (long)ceil(t0);
    *last = t1 < t0 ? *first - 1 : (long)floor(t1);
}

/* Trilinear between voxel centres at i + 1/2, clamped to the edge. */
static double sample(const iso_level *level, const double index[3])
{
    const size_t *n = level->geometry.size;
    size_t i[3], step[3] = {1, n[0], n[0] * n[1]};
    double f[3];
    for (int a = 0; a < 3; ++a) {
        const double last = (double)(n[a] - 1);
        double x = index[a] - 0.5;
        x = x > 0 ? (x < last ? x : last) : 0;
        i[a] = (size_t)x;
        f[a] = x - (double)i[a];
        step[a] = i[a] + 1 < n[a] ? step[a] : 0;
    }
    const float *v = level->scalar + i[0] + n[0] * (i[1] + n[1] * i[2]);
    double rows[4];
    for (size_t row = 0; row < 4; ++row) {
        const float *r = v + (row & 1) * step[1] + (row >> 1) * step[2];
        rows[row] = (double)r[0] + f[0] * ((double)r[step[0]] - (double)r[0]);
    }
    const double near = rows[0] + f[1] * (rows[1] - rows[0]), far = rows[2] + f[1] * (rows[3] - rows[2]);
    return near + f[2] * (far - near);
}

/* Adds a step to a pixel, front to back; pixel[3] is its transmittance. */
static void add_step(const iso_tf_table *tf, double value, double length_mm, double pixel[4])
{
    double rgbs[4];
    iso_tf_lookup(tf, value, rgbs);
    if (rgbs[3] <= 0 || pixel[3] <= OPAQUE)
        return;
    const double through = exp(-rgbs[3] * length_mm), seen = pixel[3] * (1 - through);
    for (int c = 0; c < 3; ++c)
        pixel[c] += seen * rgbs[c];
    pixel[3] *= through;
}

/* One pixel of all pictures: level 0's, then one for each transfer function. */
static void march(const iso_small_views_input *in, const small_camera *c, iso_vec3 from, double pixels[PICTURES][4])
{
    const double scale = ldexp(1, -(int)in->level);
    long first, last;
    for (size_t i = 0; i <= in->tf_count; ++i)
        pixels[i][0] = pixels[i][1] = pixels[i][2] = 0, pixels[i][3] = 1;
    clip_to_box(c, &in->fine->geometry, from, &first, &last);
    for (long k = first; k <= last; ++k) {
        const iso_vec3 p = iso_madd(from, c->direction, (double)k);
        bool all_opaque = true;
        if (pixels[0][3] > OPAQUE)
            add_step(in->original, sample(in->fine, (double[]){p.x, p.y, p.z}), c->step_mm, pixels[0]);
        for (size_t i = 0; i <= in->tf_count; ++i)
            all_opaque = all_opaque && pixels[i][3] <= OPAQUE;
        if (all_opaque)
            break;
        const double value = sample(in->coarse, (double[]){scale * p.x, scale * p.y, scale * p.z});
        for (size_t i = 0; i < in->tf_count; ++i)
            add_step(in->tfs[i], value, c->step_mm, pixels[1 + i]);
    }
}

static void draw_view(const iso_small_views_input *in, int view, iso_image pictures[PICTURES])
{
    const small_camera c = frame_box(&in->fine->geometry, view);
#pragma omp parallel for schedule(dynamic, 4) num_threads(iso_threads(in->threads))
    for (int y = 0; y < PIXELS; ++y)
        for (int x = 0; x < PIXELS; ++x) {
            double pixels[PICTURES][4];
            march(in, &c, iso_madd(iso_madd(c.corner, c.right, x), c.down, y), pixels);
            for (size_t i = 0; i <= in->tf_count; ++i) {
                float *to = pictures[i].rgba + 4 * (size_t)(y * PIXELS + x);
                for (int k = 0; k < 3; ++k)
                    to[k] = (float)pixels[i][k];
                to[3] = (float)(1 - pixels[i][3]);
            }
        }
}

/* Notes 1 - SSIM of a view, and adds the mean square difference of colour. */
static iso_status add_error(const iso_image *wanted, const iso_image *seen, int view, iso_small_views_error *e,
                            iso_error *err)
{
    double ssim = 0, square = 0;
    const iso_status status = iso_ssim_mean(wanted, seen, &ssim, err);
    for (size_t i = 0; i < (size_t)4 * PIXELS * PIXELS; ++i) {
        const double d = (double)seen->rgba[i] - (double)wanted->rgba[i];
        square += i % 4 < 3 ? d * d : 0;
    }
    e->of_view[view] = 1 - ssim;
    e->ssim_dissimilarity += (1 - ssim) / ISO_SMALL_VIEWS_COUNT;
    e->rmse += square / (3.0 * PIXELS * PIXELS * ISO_SMALL_VIEWS_COUNT);
    return status;
}

iso_status iso_small_views_compare(const iso_small_views_input *in,
                                   iso_small_views_error errors[ISO_SMALL_VIEWS_MAX_TFS], iso_error *err)
{
    iso_image pictures[PICTURES] = {{0}};
    iso_status status = ISO_OK;
    for (size_t i = 0; i <= in->tf_count && status == ISO_OK; ++i)
        status = iso_image_create(&pictures[i], PIXELS, PIXELS, err);
    for (size_t i = 0; i < in->tf_count; ++i)
        errors[i] = (iso_small_views_error){0};
    for (int view = 0; view < ISO_SMALL_VIEWS_COUNT && status == ISO_OK; ++view) {
        draw_view(in, view, pictures);
        for (size_t i = 0; i < in->tf_count && status == ISO_OK; ++i)
            status = add_error(&pictures[0], &pictures[1 + i], view, &errors[i], err);
    }
    for (size_t i = 0; i < in->tf_count; ++i)
        errors[i].rmse = sqrt(errors[i].rmse);
    for (size_t i = 0; i <= in->tf_count; ++i)
        iso_image_destroy(&pictures[i]);
    return status;
}
