/* SPDX-License-Identifier: MIT */
#include "lab/figure/paper_bricks.h"

#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"

iso_status iso_mixed_create(iso_mixed *m, const iso_level *level0, size_t brick_voxels, size_t coarse, int threads,
                            iso_error *err)
{
    *m = (iso_mixed){.coarse = coarse};
    iso_status status = iso_node_levels_create(&m->nodes, level0, brick_voxels, coarse + 1, true, threads, err);
    if (status != ISO_OK)
        return status;
    const size_t *count = m->nodes.count;
    if (count[0] < 2 || count[1] < 2 || count[2] < 2) {
        status = iso_fail(
            err, ISO_E_RANGE,
            "bricks of %zu voxels: the volume has %zu x %zu x %zu, needs 2 along each axis; use smaller --bricks",
            brick_voxels, count[0], count[1], count[2]);
        iso_mixed_destroy(m);
        return status;
    }
    m->levels = malloc(iso_brick_count(&m->nodes));
    if (!m->levels) {
        iso_mixed_destroy(m);
        return iso_fail(err, ISO_E_MEMORY, "no memory for %zu bricks", iso_brick_count(&m->nodes));
    }
    for (size_t z = 0; z < count[2]; ++z)
        for (size_t y = 0; y < count[1]; ++y)
            for (size_t x = 0; x < count[0]; ++x) {
                /* The upper half's border is one brick farther from the viewer. */
                const bool upper = z >= (count[2] + 1) / 2, far = y >= (count[1] + 1) / 2;
                const size_t border = count[0] / 2 + (upper && count[0] > 2) - (far && count[0] / 2 > 1);
                m->levels[iso_brick_index(&m->nodes, (const size_t[3]){x, y, z})] = x < border ? (uint8_t)coarse : 0;
            }
    return ISO_OK;
}

void iso_mixed_destroy(iso_mixed *m)
{
    if (!m)
        return;
    iso_node_levels_destroy(&m->nodes);
    free(m->levels);
    *m = (iso_mixed){0};
}

iso_brick_field iso_mixed_field(const iso_mixed *m, bool smooth)
{
    return (iso_brick_field){&m->nodes, m->levels, smooth ? ISO_FACES_BAKED : ISO_FACES_OWN};
}

/* ---- faces ---- */

/* Returns the largest jump of values across the face between a brick and the next along an axis. */
static double jump_of_face(const iso_brick_field *f, const size_t brick[3], int axis)
{
    enum { POINTS = 7 };
    const double n = (double)f->nodes->brick_voxels;
    size_t next[3] = {brick[0], brick[1], brick[2]};
    double most = 0;
    ++next[axis];
    for (int k = 0; k < POINTS * POINTS; ++k) {
        /* Avoids the nodes of the coarse level: both sides may agree there. */
        const double part[2] = {(k % POINTS + 0.37) / POINTS, (k / POINTS + 0.41) / POINTS};
        double a[ISO_NODE_CHANNELS], b[ISO_NODE_CHANNELS], q[3];
        for (int c = 0, free_axis = 0; c < 3; ++c)
            q[c] = n * ((double)brick[c] + (c == axis ? 1 : part[free_axis++]));
        iso_brick_sample_in(f, brick, q, a);
        iso_brick_sample_in(f, next, q, b);
        most = fmax(most, fabs(a[0] - b[0]));
    }
    return most;
}

double iso_mixed_jump(const iso_mixed *m, bool smooth)
{
    const iso_brick_field f = iso_mixed_field(m, smooth);
    const size_t *count = m->nodes.count;
    double most = 0;
    for (size_t i = 0; i < iso_brick_count(&m->nodes); ++i) {
        const size_t brick[3] = {i % count[0], i / count[0] % count[1], i / count[0] / count[1]};
        for (int axis = 0; axis < 3; ++axis) {
            size_t next[3] = {brick[0], brick[1], brick[2]};
            if (++next[axis] < count[axis] && m->levels[i] != m->levels[iso_brick_index(&m->nodes, next)])
                most = fmax(most, jump_of_face(&f, brick, axis));
        }
    }
    const double range = m->nodes.max - m->nodes.min;
    return range > 0 ? most / range : 0;
}

/* ---- visible places ---- */

static double extinction_of(const iso_tf_table *tf, double value)
{
    const double last = (double)(tf->count - 1);
    const double at = fmin(fmax((value - tf->lo) / (tf->hi - tf->lo) * last, 0), last);
    const size_t i = (size_t)fmin(floor(at), last - 1);
    const double t = at - (double)i;
    return (1 - t) * (double)tf->entries[4 * i + 3] + t * (double)tf->entries[4 * (i + 1) + 3];
}

/* Follows a ray until it is half absorbed or reaches the surface; returns index coordinates. */
static iso_vec3 visible_along(const iso_mixed *m, const iso_view *view, double surface, const iso_ray *ray)
{
    const iso_geometry *g = &m->nodes.geometry;
    const iso_brick_field f = iso_mixed_field(m, true);
    const double step = 0.5 * iso_geometry_min_spacing_mm(g);
    double t0, t1, depth = 0;
    if (!iso_view_ray(view, ray, g, &t0, &t1))
        return iso_v3(-1, -1, -1);
    for (double t = t0 + 0.5 * step; t < t1; t += step) {
        const iso_vec3 index = iso_geometry_to_index(g, iso_madd(ray->origin, ray->direction, t));
        double value[ISO_NODE_CHANNELS];
        iso_brick_sample(&f, index, value);
        depth += isnan(surface) ? step * extinction_of(&view->tf, value[0]) : value[0] >= surface;
        if (depth > 0.69)
            return index;
    }
    return iso_v3(-1, -1, -1);
}

iso_status iso_mixed_look(const iso_mixed *m, const iso_view *view, double surface, size_t width, int threads,
                          iso_mixed_seen *seen, iso_error *err)
{
    *seen = (iso_mixed_seen){.width = width < view->width ? width : view->width};
    seen->height = (size_t)fmax(1, rint((double)seen->width * (double)view->height / (double)view->width));
    seen->index = malloc(seen->width * seen->height * sizeof *seen->index);
    NEED_MEMORY(seen->index, err, "no memory for %zu x %zu places", seen->width, seen->height);
#pragma omp parallel for schedule(dynamic) num_threads(iso_threads(threads))
    for (size_t row = 0; row < seen->height; ++row)
        for (size_t column = 0; column < seen->width; ++column) {
            const iso_ray ray = iso_camera_ray(&view->camera, seen->width, seen->height, column, row);
            seen->index[row * seen->width + column] = visible_along(m, view, surface, &ray);
        }
    return ISO_OK;
}

static size_t brick_of(const iso_mixed *m, const double q[3])
{
    size_t brick[3];
    for (int a = 0; a < 3; ++a)
        brick[a] = (size_t)fmin(fmax(floor(q[a] / (double)m->nodes.brick_voxels), 0), (double)(m->nodes.count[a] - 1));
    return iso_brick_index(&m->nodes, brick);
}

bool iso_mixed_is_fine(const iso_mixed *m, iso_vec3 index)
{
    return m->levels[brick_of(m, (const double[3]){index.x - 0.5, index.y - 0.5, index.z - 0.5})] == 0;
}

/* Returns the jump of values at a face between levels within a voxel of a place; negative if there is no such face. */
static double jump_at(const iso_mixed *m, iso_vec3 index)
{
    const iso_brick_field f = iso_mixed_field(m, false);
    const double n = (double)m->nodes.brick_voxels, q[3] = {index.x - 0.5, index.y - 0.5, index.z - 0.5};
    double most = -1;
    for (int a = 0; a < 3; ++a) {
        double on_face[3] = {q[0], q[1], q[2]}, low[3] = {q[0], q[1], q[2]}, high[3] = {q[0], q[1], q[2]};
        on_face[a] = n * rint(q[a] / n);
        if (fabs(on_face[a] - q[a]) > 1)
            continue;
        low[a] = on_face[a] - 0.5, high[a] = on_face[a] + 0.5;
        const size_t i = brick_of(m, low), j = brick_of(m, high), *count = m->nodes.count;
        double below[ISO_NODE_CHANNELS], above[ISO_NODE_CHANNELS];
        if (m->levels[i] == m->levels[j])
            continue;
        iso_brick_sample_in(&f, (const size_t[3]){i % count[0], i / count[0] % count[1], i / count[0] / count[1]},
                            on_face, below);
        iso_brick_sample_in(&f, (const size_t[3]){j % count[0], j / count[0] % count[1], j / count[0] / count[1]},
                            on_face, above);
        most = fmax(most, fabs(below[0] - above[0]));
    }
    return most;
}

bool iso_mixed_find_border(const iso_mixed *m, const iso_mixed_seen *seen, iso_vec3 *index)
{
    double most = -1;
    for (size_t i = 0; i < seen->width * seen->height; ++i) {
        const double jump = seen->index[i].x >= 0 ? jump_at(m, seen->index[i]) : -1;
        if (jump > most)
            most = jump, *index = seen->index[i];
    }
    return most >= 0;
}

/* ---- magnified view ---- */

/* Projects v to picture coordinates: a direction (perspective), or a place relative to the camera (orthographic). */
static void place_in(const iso_view *view, iso_vec3 v, double *x, double *y)
{
    const iso_camera *c = &view->camera;
    const double aspect = (double)view->width / (double)view->height;
    const double deep = c->orthographic ? 1 : iso_dot(v, c->forward);
    *x = 0.5 + 0.5 * iso_dot(v, c->right) / (deep * c->half_height * aspect);
    *y = 0.5 - 0.5 * iso_dot(v, c->up) / (deep * c->half_height);
}

void iso_mixed_magnify(const iso_view *view, iso_vec3 world_mm, double height_mm, iso_view *magnified, double frame[4])
{
    const iso_vec3 to = iso_sub(world_mm, view->camera.position);
    const double aspect = (double)view->width / (double)view->height;
    *magnified = *view; /* keeps the table and all other settings */
    iso_camera *c = &magnified->camera;
    if (c->orthographic) {
        c->position = iso_sub(world_mm, iso_scale(c->forward, iso_dot(to, c->forward)));
        c->half_height = 0.5 * height_mm;
    } else {
        c->forward = iso_normalize(to);
        c->right = iso_normalize(iso_cross(c->forward, view->camera.up));
        c->up = iso_cross(c->right, c->forward);
        c->half_height = 0.5 * height_mm / iso_norm(to);
    }
    for (int k = 0; k < 2; ++k) { /* upper left corner, lower right corner */
        const double side = k ? 1 : -1;
        iso_vec3 corner = c->orthographic ? iso_sub(c->position, view->camera.position) : c->forward;
        corner = iso_madd(iso_madd(corner, c->right, side * aspect * c->half_height), c->up, -side * c->half_height);
        place_in(view, corner, &frame[2 * k], &frame[2 * k + 1]);
    }
}
