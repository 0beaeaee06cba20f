/* SPDX-License-Identifier: MIT */
#include "validate/closed_form.h"

#include <math.h>
#include <stdlib.h>

#include "base/order.h"

/* s = base + slope . (index - 1/2), the index clamped to the voxels' centers. */
typedef struct linear_field {
    double base, slope[3], last[3]; /* last: size - 1 */
} linear_field;

static double value_at(const linear_field *f, const double x[3])
{
    double s = f->base;
    for (int a = 0; a < 3; ++a)
        s += f->slope[a] * fmin(fmax(x[a] - 0.5, 0), f->last[a]);
    return s;
}

static iso_status fit_linear(const iso_level *level, linear_field *f, iso_error *err)
{
    const size_t *n = level->geometry.size;
    const size_t step[3] = {1, n[0], n[0] * n[1]};
    double tolerance = 1e-6 * fmax(fabs(level->min), fabs(level->max)); /* floats are rounded to 6e-8 */
    f->base = (double)level->scalar[0];
    for (int a = 0; a < 3; ++a) {
        f->last[a] = (double)n[a] - 1;
        f->slope[a] = n[a] > 1 ? ((double)level->scalar[step[a] * (n[a] - 1)] - f->base) / f->last[a] : 0;
    }
    for (size_t i = 0; i < iso_geometry_voxel_count(&level->geometry); ++i) {
        const double x[3] = {(double)(i % n[0]) + 0.5, (double)(i / n[0] % n[1]) + 0.5, (double)(i / step[2]) + 0.5};
        double off = fabs(value_at(f, x) - (double)level->scalar[i]);
        if (!(off <= tolerance))
            return iso_fail(err, ISO_E_RANGE, "closed form: voxel %zu is %g off a linear field, at most %g", i, off,
                            tolerance);
    }
    return ISO_OK;
}

/* Finds the color of the visible entries. ISO_E_RANGE: they have several. */
static iso_status single_color(const iso_tf_table *tf, double color[3], iso_error *err)
{
    const float *found = NULL;
    for (size_t i = 0; i < tf->count; ++i) {
        const float *e = tf->entries + 4 * i;
        if (e[3] > 0 && !found)
            found = e;
        if (e[3] > 0 && (e[0] != found[0] || e[1] != found[1] || e[2] != found[2]))
            return iso_fail(err, ISO_E_RANGE, "closed form: the transfer function has several colors");
    }
    for (int c = 0; c < 3; ++c)
        color[c] = found ? (double)found[c] : 0;
    return ISO_OK;
}

/* Returns the normal of the field's one gradient after coding, zero for a constant. */
static iso_vec3 coded_normal(const iso_level *level, const linear_field *f, iso_code code)
{
    iso_mat3 to_world = iso_mat3_transpose(iso_mat3_inverse(level->geometry.index_to_world));
    iso_vec3 g = iso_mul(to_world, iso_v3(f->slope[0], f->slope[1], f->slope[2]));
    if (!(iso_norm(g) > 0))
        return iso_v3(0, 0, 0);
    g = iso_normalize(g);
    const float direction[3] = {(float)g.x, (float)g.y, (float)g.z};
    uint8_t bytes[3];
    double e[3], d[3], n[3];
    iso_code_encode(code, direction, bytes, 1);
    iso_code_lattice(code, bytes, e);
    iso_code_decode(code, e, d);
    iso_code_normal(d, n);
    return iso_v3(n[0], n[1], n[2]);
}

static double shade(const iso_view *view, iso_vec3 n, iso_vec3 to_viewer)
{
    double sum = view->shading.ambient;
    for (size_t i = 0; i < view->light_count; ++i) {
        const iso_light *l = &view->lights[i];
        double h = fabs(iso_dot(n, iso_normalize(iso_add(l->direction, to_viewer))));
        sum += l->intensity * (view->shading.diffuse * fabs(iso_dot(n, l->direction)) +
                               (view->shading.specular > 0 ? view->shading.specular * pow(h, view->shading.power) : 0));
    }
    return sum;
}

/* Returns the integral of the table's extinction from lo to s: trapezia, exact. */
static double antiderivative(const iso_tf_table *tf, double s)
{
    const double width = (tf->hi - tf->lo) / (double)(tf->count - 1), x = (s - tf->lo) / width;
    double sum = 0, rgbs[4];
    if (s <= tf->lo)
        return (s - tf->lo) * (double)tf->entries[3];
    size_t whole = (size_t)fmin(floor(x), (double)(tf->count - 1));
    for (size_t i = 0; i < whole; ++i)
        sum += 0.5 * width * ((double)tf->entries[4 * i + 3] + (double)tf->entries[4 * i + 7]);
    double from = tf->lo + (double)whole * width;
    iso_tf_lookup(tf, s, rgbs);
    return sum + 0.5 * (s - from) * ((double)tf->entries[4 * whole + 3] + rgbs[3]);
}

static double optical_depth(const linear_field *f, const iso_geometry *g, const iso_tf_table *tf, const iso_ray *ray,
                            double t0, double t1)
{
    iso_mat3 to_index = iso_mat3_inverse(g->index_to_world);
    iso_vec3 o = iso_mul(to_index, iso_sub(ray->origin, g->origin_mm)), d = iso_mul(to_index, ray->direction);
    const double origin[3] = {o.x, o.y, o.z}, direction[3] = {d.x, d.y, d.z};
    double t[8] = {t0, t1}, depth = 0, before = 0;
    int count = 2;
    for (int a = 0; a < 3; ++a) /* where clamping begins and ends */
        for (int end = 0; end < 2; ++end) {
            double at = ((end ? f->last[a] : 0) + 0.5 - origin[a]) / direction[a];
            if (at > t0 && at < t1)
                t[count++] = at;
        }
    qsort(t, (size_t)count, sizeof *t, iso_order_doubles);
    for (int i = 0; i < count; ++i) {
        const double x[3] = {origin[0] + t[i] * direction[0], origin[1] + t[i] * direction[1],
                             origin[2] + t[i] * direction[2]};
        double s = value_at(f, x), rgbs[4];
        if (i > 0 && fabs(s - before) > 1e-9 * (tf->hi - tf->lo))
            depth += (t[i] - t[i - 1]) * (antiderivative(tf, s) - antiderivative(tf, before)) / (s - before);
        else if (i > 0) {
            iso_tf_lookup(tf, 0.5 * (s + before), rgbs);
            depth += (t[i] - t[i - 1]) * rgbs[3];
        }
        before = s;
    }
    return depth;
}

iso_status iso_closed_form_check(const iso_level *level, const iso_view *view, iso_error *err)
{
    linear_field f = {0};
    double color[3];
    const iso_status status = fit_linear(level, &f, err);
    return status == ISO_OK ? single_color(&view->tf, color, err) : status;
}

iso_status iso_closed_form_render(const iso_level *level, iso_code code, const iso_view *view, iso_image *image,
                                  iso_error *err)
{
    linear_field f = {0};
    double color[3];
    *image = (iso_image){0};
    NEED(fit_linear(level, &f, err));
    NEED(single_color(&view->tf, color, err));
    NEED(iso_image_create(image, view->width, view->height, err));
    iso_vec3 n = coded_normal(level, &f, code);
    for (size_t i = 0; i < view->width * view->height; ++i) {
        iso_ray ray = iso_camera_ray(&view->camera, view->width, view->height, i % view->width, i / view->width);
        double t0, t1, tau = 0;
        if (iso_ray_box(&ray, &level->geometry, &t0, &t1))
            tau = optical_depth(&f, &level->geometry, &view->tf, &ray, t0, t1);
        double through = exp(-tau), lit = shade(view, n, iso_scale(ray.direction, -1));
        for (int c = 0; c < 3; ++c)
            image->rgba[4 * i + (size_t)c] = (float)(color[c] * lit * -expm1(-tau) + through * view->background[c]);
        image->rgba[4 * i + 3] = (float)-expm1(-tau);
    }
    return ISO_OK;
}
