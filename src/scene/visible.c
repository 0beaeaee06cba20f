/* SPDX-License-Identifier: MIT */
#include "scene/visible.h"

#include <math.h>
#include <stdio.h>

#include "base/parallel.h"
#include "pyramid/value_table.h"
#include "tf/color_space.h"

static const double one_step = 1.0 / 255;

/* Extinction of a table's entries from which on a value is counted. */
typedef struct threshold {
    const iso_tf_table *tf;
    double extinction;
} threshold;

static bool counts(const threshold *t, double value)
{
    double rgbs[4];
    iso_tf_lookup(t->tf, value, rgbs);
    return rgbs[3] >= t->extinction;
}

static void box_sides_mm(const iso_geometry *g, double *longest, double *mean)
{
    double spacing[3];
    iso_geometry_spacing_mm(g, spacing);
    *longest = 0, *mean = 0;
    for (int a = 0; a < 3; ++a) {
        *longest = fmax(*longest, spacing[a] * g->box_index[a]);
        *mean += spacing[a] * g->box_index[a] / 3;
    }
}

static uint32_t counts_one(const void *seen, double value)
{
    return counts(seen, value);
}

/* Counts the visible voxels of every `stride`-th row. */
static double share_of_rows(const iso_level *l, const iso_value_table *seen, size_t stride, int threads)
{
    const size_t width = l->geometry.size[0], rows = l->geometry.size[1] * l->geometry.size[2];
    const size_t taken = (rows + stride - 1) / stride;
    size_t count = 0;
#pragma omp parallel for schedule(static) num_threads(iso_threads(threads)) reduction(+ : count)
    for (size_t i = 0; i < taken; ++i)
        count += iso_value_table_sum(seen, i * stride * width, width);
    return (double)count / (double)(taken * width);
}

/* Returns the stride between rows that samples about ISO_VISIBLE_SAMPLE voxels. It is odd and no divisor of the rows of
 * a slice, so that slices are sampled at different rows. */
static size_t row_stride(const iso_geometry *g)
{
    size_t stride = iso_geometry_voxel_count(g) / ISO_VISIBLE_SAMPLE;
    if (stride < 2)
        return 1;
    stride |= 1;
    while (g->size[1] % stride == 0)
        stride += 2;
    return stride;
}

/* Counts all voxels only if a sample of them leaves doubt that enough of them are visible. */
static double visible_voxels(const iso_level *l, const threshold *seen, int threads)
{
    OWNED(iso_value_table) t = iso_value_table_create(l, counts_one, seen);
    const size_t stride = row_stride(&l->geometry);
    double share = share_of_rows(l, &t, stride, threads);
    if (stride > 1 && share < 10 * ISO_VISIBLE_LEAST)
        share = share_of_rows(l, &t, 1, threads);
    return share;
}

/* Counts the opaque voxels of both faces across one axis; each voxel shows the same area. */
static size_t opaque_on_faces(const iso_level *l, int axis, const threshold *hides)
{
    const size_t *n = l->geometry.size, stride[3] = {1, n[0], n[0] * n[1]};
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    size_t count = 0;
    for (size_t j = 0; j < n[v]; ++j)
        for (size_t i = 0; i < n[u]; ++i) {
            const size_t first = i * stride[u] + j * stride[v];
            count += counts(hides, iso_level_value(l, first));
            count += counts(hides, iso_level_value(l, first + (n[axis] - 1) * stride[axis]));
        }
    return count;
}

static double opaque_faces(const iso_level *l, const threshold *hides)
{
    enum { LEAST_SIDE = 4 };
    const iso_geometry *g = &l->geometry;
    double opaque = 0, all = 0;
    for (int a = 0; a < 3; ++a) {
        const int u = (a + 1) % 3, v = (a + 2) % 3;
        const iso_vec3 across = iso_cross(iso_column(g->index_to_world, u), iso_column(g->index_to_world, v));
        const double area = sqrt(iso_dot(across, across));
        if (g->size[a] < LEAST_SIDE)
            return 0;
        opaque += area * (double)opaque_on_faces(l, a, hides);
        all += area * 2 * (double)(g->size[u] * g->size[v]);
    }
    return opaque / all;
}

/* Finds the least and the largest value with at least the threshold's extinction. */
static void find_shown(const threshold *seen, iso_visible *v)
{
    const iso_tf_table *t = seen->tf;
    size_t first = 0, last = t->count;
    while (first < t->count && !((double)t->entries[4 * first + 3] >= seen->extinction))
        ++first;
    while (last > 0 && !((double)t->entries[4 * (last - 1) + 3] >= seen->extinction))
        --last;
    const double step = (t->hi - t->lo) / (double)(t->count - 1);
    v->shown_min = first == t->count ? INFINITY : first == 0 ? -INFINITY : t->lo + step * (double)first;
    v->shown_max = last == 0 ? -INFINITY : last == t->count ? INFINITY : t->lo + step * (double)(last - 1);
}

/* Constants of all rays through the voxels of level 0. */
typedef struct marching {
    const iso_level *level;
    const iso_view *view;
    iso_mat3 to_index;
    double step_mm;
    bool is_isosurface;
    double isosurface;
} marching;

static bool shows_something(const marching *m, const iso_ray *ray, double t0, double t1)
{
    const iso_geometry *g = &m->level->geometry;
    const double wanted = -log1p(-one_step), origin[3] = {g->origin_mm.x, g->origin_mm.y, g->origin_mm.z};
    double depth = 0;
    for (double t = t0; t < t1; t += m->step_mm) {
        const double length = fmin(m->step_mm, t1 - t);
        const iso_vec3 p = iso_madd(ray->origin, ray->direction, t + 0.5 * length);
        const iso_vec3 at = iso_mul(m->to_index, (iso_vec3){p.x - origin[0], p.y - origin[1], p.z - origin[2]});
        const double index[3] = {at.x, at.y, at.z};
        size_t i = 0;
        for (int a = 2; a >= 0; --a) {
            const double last = (double)(g->size[a] - 1);
            i = i * g->size[a] + (size_t)fmin(fmax(index[a], 0), last);
        }
        const double value = iso_level_value(m->level, i);
        if (m->is_isosurface) {
            if (value >= m->isosurface)
                return true;
            continue;
        }
        double rgbs[4];
        iso_tf_lookup(&m->view->tf, value, rgbs);
        depth += rgbs[3] * length;
        if (depth >= wanted)
            return true;
    }
    return false;
}

static double share_of_rays(const marching *m, int threads)
{
    enum { MOST = 64 };
    const iso_view *view = m->view;
    const size_t width = view->width < MOST ? view->width : MOST, height = view->height < MOST ? view->height : MOST;
    size_t count = 0;
#pragma omp parallel for schedule(dynamic) num_threads(iso_threads(threads)) reduction(+ : count)
    for (size_t y = 0; y < height; ++y)
        for (size_t x = 0; x < width; ++x) {
            const size_t column = (2 * x + 1) * view->width / (2 * width),
                         row = (2 * y + 1) * view->height / (2 * height);
            const iso_ray ray = iso_camera_ray(&view->camera, view->width, view->height, column, row);
            double t0, t1;
            count += iso_view_ray(view, &ray, &m->level->geometry, &t0, &t1) && shows_something(m, &ray, t0, t1);
        }
    return (double)count / (double)(width * height);
}

static double share_of_box(const iso_level *l, const iso_view *view, bool clipped, int threads)
{
    size_t count = 0;
#pragma omp parallel for schedule(static) num_threads(iso_threads(threads)) reduction(+ : count)
    for (size_t y = 0; y < view->height; ++y)
        for (size_t x = 0; x < view->width; ++x) {
            const iso_ray ray = iso_camera_ray(&view->camera, view->width, view->height, x, y);
            double t0, t1;
            count += clipped ? iso_view_ray(view, &ray, &l->geometry, &t0, &t1)
                             : iso_ray_box(&ray, &l->geometry, &t0, &t1);
        }
    return (double)count / (double)(view->width * view->height);
}

iso_visible iso_visible_measure(const iso_level *level0, const iso_view *view, const double *isosurface, int threads)
{
    const iso_geometry *g = &level0->geometry;
    double longest, mean;
    box_sides_mm(g, &longest, &mean);
    const threshold seen = {&view->tf, -log1p(-one_step) / longest}, hides = {&view->tf, 10 * log(10) / mean};
    const marching march = {.level = level0,
                            .view = view,
                            .to_index = iso_mat3_inverse(g->index_to_world),
                            .step_mm = iso_geometry_min_spacing_mm(g),
                            .is_isosurface = isosurface != NULL,
                            .isosurface = isosurface ? *isosurface : 0};
    iso_visible v = {.value_min = level0->min,
                     .value_max = level0->max,
                     .range = {view->tf.lo, view->tf.hi},
                     .size = {view->width, view->height},
                     .is_isosurface = isosurface != NULL,
                     .isosurface = isosurface ? *isosurface : 0};
    find_shown(&seen, &v);
    v.voxels = isosurface ? 1 : visible_voxels(level0, &seen, threads);
    v.faces = isosurface || view->clip_count > 0 ? 0 : opaque_faces(level0, &hides);
    v.box = share_of_box(level0, view, true, threads);
    v.is_clipped_away = v.box < ISO_VISIBLE_LEAST && share_of_box(level0, view, false, threads) >= ISO_VISIBLE_LEAST;
    v.picture = share_of_rays(&march, threads);
    return v;
}

static double display(float linear)
{
    return iso_linear_to_srgb(fmin(fmax((double)linear, 0), 1));
}

void iso_visible_take_image(iso_visible *v, const iso_image *image, const double background[3])
{
    const size_t count = image->width * image->height;
    size_t same = 0;
    for (size_t i = 0; i < count; ++i) {
        const float *p = image->rgba + 4 * i;
        double color = 0;
        for (int c = 0; c < 3; ++c)
            color = fmax(color, fabs(display(p[c]) - display((float)background[c])));
        same += (double)p[3] >= one_step && color < one_step;
    }
    v->picture = iso_image_shown_share(image);
    v->same_color = (double)same / (double)count;
    v->from_image = true;
}

/* ---- messages
 * ------------------------------------------------------------------------------------------------------ */

static const char *shown_text(const iso_visible *v, char text[96])
{
    if (v->shown_min > v->shown_max)
        snprintf(text, 96, "no values");
    else if (isinf(v->shown_min) && isinf(v->shown_max))
        snprintf(text, 96, "values up to both ends of its range");
    else if (isinf(v->shown_max))
        snprintf(text, 96, "values from %.6g up", v->shown_min);
    else if (isinf(v->shown_min))
        snprintf(text, 96, "values up to %.6g", v->shown_max);
    else
        snprintf(text, 96, "values from %.6g to %.6g", v->shown_min, v->shown_max);
    return text;
}

/* Formats "0.012 %", with more digits near 100 % so that it is not rounded up to it. */
static const char *percent(double share, char text[24])
{
    snprintf(text, 24, share > 0.99 && share < 1 ? "%.3f %%" : "%.3g %%", 100 * share);
    return text;
}

static bool complain_of_camera(const iso_visible *v, char *text, size_t size)
{
    char box[24];
    if (!(v->box < ISO_VISIBLE_LEAST))
        return false;
    percent(v->box, box);
    if (v->is_clipped_away)
        snprintf(text, size, "the scene's \"clip_planes\" leave only %s of the picture visible", box);
    else
        snprintf(
            text, size,
            "the camera looks past the volume, whose box covers %s of the picture; --view iso, or \"fit\": true in the scene's "
            "\"camera\", frames any volume",
            box);
    return true;
}

static bool complain_of_values(const iso_visible *v, const char *volume, char *text, size_t size)
{
    char share[24], shown[96];
    if (v->is_isosurface) {
        if (v->isosurface <= v->value_max && v->isosurface > v->value_min)
            return false;
        snprintf(text, size, "the isosurface of %g %s: the volume's values are %.6g to %.6g", v->isosurface,
                 v->isosurface > v->value_max ? "is nowhere" : "is the whole box", v->value_min, v->value_max);
        return true;
    }
    if (!(v->voxels < ISO_VISIBLE_LEAST))
        return false;
    snprintf(
        text, size,
        "%s of the voxels can be seen: the transfer function shows %s (its range: %.6g to %.6g), the volume's values are "
        "%.6g to %.6g; `isoshade tf suggest %s -o new.tf.json` makes one for it",
        percent(v->voxels, share), shown_text(v, shown), v->range[0], v->range[1], v->value_min, v->value_max, volume);
    return true;
}

static bool complain_of_box(const iso_visible *v, const char *volume, char *text, size_t size)
{
    char share[24], shown[96];
    if (!(v->faces > ISO_VISIBLE_MOST_FACES))
        return false;
    snprintf(
        text, size,
        "the picture is of a box: %s of its faces hide the inside; the transfer function shows %s (its range: %.6g "
        "to %.6g), the volume's values are %.6g to %.6g; make the outer ones transparent, or: isoshade tf suggest %s -o new.tf.json",
        percent(v->faces, share), shown_text(v, shown), v->range[0], v->range[1], v->value_min, v->value_max, volume);
    return true;
}

static bool complain_of_picture(const iso_visible *v, char *text, size_t size)
{
    char picture[24], voxels[24];
    if (v->picture < ISO_VISIBLE_LEAST) {
        snprintf(
            text, size,
            "something is on %s of the picture of %zu x %zu pixels, but %s of the voxels can be seen: they are too "
            "thin, or the camera, clip planes or a region leave them out",
            percent(v->picture, picture), v->size[0], v->size[1], percent(v->voxels, voxels));
        return true;
    }
    if (!v->from_image || !(v->same_color > (1 - ISO_VISIBLE_LEAST) * v->picture))
        return false;
    snprintf(
        text, size,
        "the volume, on %s of the picture, has the background's color; use other colors in the transfer function, more light "
        "(\"ambient\", \"lights\") or another \"background\"",
        percent(v->picture, picture));
    return true;
}

bool iso_visible_complaint(const iso_visible *v, const char *volume, char *text, size_t size)
{
    return complain_of_camera(v, text, size) || complain_of_values(v, volume, text, size) ||
           complain_of_box(v, volume, text, size) || complain_of_picture(v, text, size);
}
