/* SPDX-License-Identifier: MIT */
#include "lab/ray_faults.h"

#include <math.h>
#include <stdlib.h>

#include "render/sampler.h"

static const double step_voxels = 0.125;

/* A level with all that its faulty pictures need. */
typedef struct marcher {
    const iso_view *view;
    iso_sampler sampler;
    iso_level part[3]; /* x, y and z of the voxels' normals, each as the scalar of a level */
    iso_sampler part_sampler[3];
} marcher;

static void end_marcher(marcher *m)
{
    for (int a = 0; a < 3; ++a)
        free(m->part[a].scalar);
    iso_sampler_destroy(&m->sampler);
}

static iso_status start_marcher(marcher *m, const iso_render_request *q, iso_error *err)
{
    const iso_level *level = &q->pyramid->levels[q->level];
    const size_t count = iso_geometry_voxel_count(&level->geometry);
    *m = (marcher){.view = q->view};
    if (q->view->roi || q->view->tf_2d || q->view->extinction_scale)
        return iso_fail(err, ISO_E_USAGE,
                        "faults of rays are planted into scenes of one level and a TF over the value");
    iso_status status = iso_sampler_create(&m->sampler, level, q->pyramid->options.code, ISO_FROM_DECODED, err);
    for (int a = 0; a < 3; ++a) {
        m->part[a] = (iso_level){.geometry = level->geometry, .scalar = malloc(count * sizeof(float))};
        m->part_sampler[a] = (iso_sampler){.level = &m->part[a]};
        if (status == ISO_OK && !m->part[a].scalar)
            status = iso_fail(err, ISO_E_MEMORY, "no memory for %zu normals", count);
    }
    for (size_t i = 0; i < count && status == ISO_OK; ++i) {
        float v[3];
        iso_sampler_vector(&m->sampler, i, v);
        const double d[3] = {(double)v[0], (double)v[1], (double)v[2]};
        double n[3];
        iso_code_normal(d, n);
        for (int a = 0; a < 3; ++a)
            m->part[a].scalar[i] = (float)n[a];
    }
    return status;
}

static iso_vec3 normal_at(const marcher *m, iso_ray_fault fault, iso_vec3 index)
{
    if (fault != ISO_RAY_NOT_NORMALIZED)
        return iso_sample_normal(&m->sampler, index);
    return iso_v3(iso_sample_scalar(&m->part_sampler[0], index), iso_sample_scalar(&m->part_sampler[1], index),
                  iso_sample_scalar(&m->part_sampler[2], index));
}

static iso_vec3 to_viewer(const iso_camera *c, iso_ray_fault fault, const iso_ray *ray, iso_vec3 at)
{
    if (fault != ISO_RAY_OTHER_EYE)
        return iso_scale(ray->direction, -1);
    return c->orthographic ? iso_normalize(iso_sub(c->position, at)) : iso_scale(c->forward, -1);
}

static double shade(const iso_view *view, iso_vec3 n, iso_vec3 v)
{
    double sum = view->shading.ambient;
    for (size_t i = 0; i < view->light_count; ++i) {
        const iso_light *l = &view->lights[i];
        const double h = fabs(iso_dot(n, iso_normalize(iso_add(l->direction, v))));
        sum += l->intensity * view->shading.diffuse * fabs(iso_dot(n, l->direction));
        if (view->shading.specular > 0)
            sum += l->intensity * view->shading.specular * pow(h, view->shading.power);
    }
    return sum;
}

/* Marches along a ray. The background is left out, since no fault here changes it or alpha. */
static void march(const marcher *m, iso_ray_fault fault, const iso_ray *ray, double color[3])
{
    const iso_geometry *g = &m->sampler.level->geometry;
    double t0, t1, through = 1;
    color[0] = color[1] = color[2] = 0;
    if (!iso_view_ray(m->view, ray, g, &t0, &t1))
        return;
    const size_t count = (size_t)ceil((t1 - t0) / (step_voxels * iso_geometry_min_spacing_mm(g))) + 1;
    const double step = (t1 - t0) / (double)count;
    for (size_t i = 0; i < count; ++i) {
        const size_t nth = fault == ISO_RAY_REVERSED ? count - 1 - i : i;
        const iso_vec3 at = iso_madd(ray->origin, ray->direction, t0 + ((double)nth + 0.5) * step);
        const iso_vec3 index = iso_geometry_to_index(g, at);
        double rgbs[4];
        iso_tf_lookup(&m->view->tf, iso_sample_scalar(&m->sampler, index), rgbs);
        const double alpha = -expm1(-rgbs[3] * step);
        const double lit = alpha > 0
                               ? shade(m->view, normal_at(m, fault, index), to_viewer(&m->view->camera, fault, ray, at))
                               : 0;
        for (int c = 0; c < 3; ++c)
            color[c] += through * alpha * lit * rgbs[c];
        through *= 1 - alpha;
    }
}

iso_status iso_ray_fault_add(const iso_render_request *request, iso_ray_fault fault, iso_image *image, iso_error *err)
{
    marcher m;
    iso_status status = start_marcher(&m, request, err);
    for (size_t i = 0; i < image->width * image->height && status == ISO_OK; ++i) {
        double right[3], wrong[3];
        const iso_ray ray = iso_camera_ray(&m.view->camera, image->width, image->height, i % image->width,
                                           i / image->width);
        march(&m, ISO_RAY_RIGHT, &ray, right);
        march(&m, fault, &ray, wrong);
        for (int c = 0; c < 3; ++c)
            image->rgba[4 * i + (size_t)c] += (float)(wrong[c] - right[c]);
    }
    end_marcher(&m);
    return status;
}
