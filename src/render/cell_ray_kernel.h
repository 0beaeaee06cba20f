/* SPDX-License-Identifier: MIT */
/* cell_ray_kernel.h - what cell_ray.h describes, for the instruction set of the function that it is compiled into. */
#pragma once

#include "render/cell_pieces.h"

/* The walk through the lattice of the planes where pieces end: voxel centers, and for labels their faces too. */
typedef struct cell_walk {
    double at[3], way[3], inverse[3], next[3]; /* place of t = 0 between voxel centers, per mm; t of the next plane */
    int plane[3], step[3], per_cell, last[3];  /* planes are counted per_cell a cell; last: of the voxels */
} cell_walk;

ISO_LANES_INLINE void set_next(cell_walk *k, int a)
{
    const double plane = (double)(k->plane[a] + (k->step[a] > 0)) / k->per_cell;
    k->next[a] = k->way[a] != 0 ? (plane - k->at[a]) * k->inverse[a] : INFINITY;
}

/* Returns the plane before which the ray is at t, between two voxels or beyond the outermost. */
ISO_LANES_INLINE int plane_at(const cell_walk *k, int a, double t)
{
    const double q = (k->at[a] + t * k->way[a]) * k->per_cell;
    return k->step[a] > 0 ? (int)floor(q) : (int)ceil(q) - 1;
}

/* Goes on to t, but never back. At an edge of two blocks rounding may move a place to before a plane that was passed:
 * the walk would go to and fro without end. */
ISO_LANES_INLINE void go_on_to(cell_walk *k, int a, double t)
{
    const int plane = plane_at(k, a, t);
    k->plane[a] = (plane - k->plane[a]) * k->step[a] > 0 ? plane : k->plane[a];
    set_next(k, a);
}

ISO_LANES_INLINE cell_walk start_walk(const iso_cell_scene *c, const iso_cell_ray *ray)
{
    const size_t *size = c->sampler->level->geometry.size;
    cell_walk k = {.at = {ray->origin.x - 0.5, ray->origin.y - 0.5, ray->origin.z - 0.5},
                   .way = {ray->direction.x, ray->direction.y, ray->direction.z},
                   .per_cell = c->sampler->level->labels ? 2 : 1};
    for (int a = 0; a < 3; ++a) {
        k.last[a] = (int)size[a] - 1;
        k.step[a] = k.way[a] >= 0 ? 1 : -1;
        k.inverse[a] = 1 / k.way[a];
        k.plane[a] = plane_at(&k, a, ray->t0);
        set_next(&k, a);
    }
    return k;
}

/* Finds the cell, as counted in empty_space.h. */
ISO_LANES_INLINE void cell_of(const cell_walk *k, int cell[3])
{
    for (int a = 0; a < 3; ++a) {
        const int i = k->per_cell == 2 ? k->plane[a] >> 1 : k->plane[a];
        cell[a] = i < -1 ? 0 : i > k->last[a] ? k->last[a] + 1 : i + 1;
    }
}

/* Passes an empty block of cells. Returns the t at which the ray leaves it. */
ISO_LANES_INLINE double leave_block(cell_walk *k, const int lo[3], const int hi[3], double t)
{
    double until = INFINITY;
    int axis = 0;
    for (int a = 0; a < 3; ++a) {
        const double face = (k->step[a] > 0 ? hi[a] : lo[a]) - 1;
        const double at = k->way[a] != 0 ? (face - k->at[a]) * k->inverse[a] : INFINITY;
        if (at < until) {
            until = at;
            axis = a;
        }
    }
    until = until > t ? until : t;
    if (!(until < INFINITY))
        return until;
    for (int a = 0; a < 3; ++a)
        if (a != axis)
            go_on_to(k, a, until);
    k->plane[axis] = k->step[axis] > 0 ? (hi[axis] - 1) * k->per_cell : (lo[axis] - 1) * k->per_cell - 1;
    set_next(k, axis);
    return until;
}

/* Reads the value on the transfer function's table, in entries, and the directions, along [a, b] of the ray inside one
 * cell. False: the cell is empty. */
ISO_LANES_INLINE bool read_cell(cell_pieces *w, const cell_walk *k, const int cell[3], double a, double b)
{
    const iso_cell_scene *c = w->scene;
    size_t voxel[8];
    double from[3], way[3], value[8];
    const size_t *n = c->sampler->level->geometry.size;
    size_t at[3][2];
    for (int i = 0; i < 3; ++i) {
        at[i][0] = (size_t)(cell[i] > 0 ? cell[i] - 1 : 0);
        at[i][1] = (size_t)(cell[i] <= k->last[i] ? cell[i] : k->last[i]);
        from[i] = k->at[i] + a * k->way[i] - (double)(cell[i] - 1);
        way[i] = (b - a) * k->way[i];
    }
    for (int i = 0; i < 8; ++i)
        voxel[i] = at[0][i & 1] + n[0] * (at[1][i >> 1 & 1] + n[1] * at[2][i >> 2]);
    const float *scalar = c->sampler->level->scalar;
    if (c->sampler->level->labels) {
        size_t nearest = 0;
        for (int i = 2; i >= 0; --i) {
            const int v = (k->plane[i] + 1) >> 1;
            nearest = nearest * n[i] + (size_t)(v < 0 ? 0 : v > k->last[i] ? k->last[i] : v);
        }
        for (int i = 0; i < 8; ++i)
            value[i] = (double)scalar[nearest];
    } else {
        for (int i = 0; i < 8; ++i)
            value[i] = (double)scalar[voxel[i]];
    }
    double lo = value[0], hi = value[0];
    bool is_whole = value[0] != (double)ISO_NO_DATA; /* a cell next to a voxel without data shows nothing */
    for (int i = 1; i < 8; ++i) {
        is_whole = is_whole && value[i] != (double)ISO_NO_DATA;
        lo = value[i] < lo ? value[i] : lo;
        hi = value[i] > hi ? value[i] : hi;
    }
    if (!is_whole || !iso_shown_values(c->shown, lo, hi))
        return false;
    four corner[8];
    for (int i = 0; i < 8; ++i)
        corner[i] = (four){(value[i] - c->tf->lo) * c->shown->per_entry, 0, 0, 0};
    if (c->lit)
        iso_cell_directions(c, voxel, cell, corner);
    cubic_of_corners(w, corner, from, way);
    w->length = b - a;
    return true;
}

ISO_LANES_INLINE stretch integrate_cells(const iso_cell_scene *c, const iso_cell_ray *ray, double *error)
{
    cell_pieces w;
    start_pieces(&w, c, ray);
    cell_walk k = start_walk(c, ray);
    bool open = true;
    for (double t = ray->t0; t < ray->t1 && open;) {
        int cell[3], lo[3], hi[3];
        cell_of(&k, cell);
        if (iso_empty_space_at(c->empty, cell, lo, hi)) {
            t = leave_block(&k, lo, hi, t);
            continue;
        }
        int axis = k.next[0] < k.next[1] ? 0 : 1;
        axis = k.next[2] < k.next[axis] ? 2 : axis;
        const double end = k.next[axis] < ray->t1 ? k.next[axis] : ray->t1;
        if (end > t && read_cell(&w, &k, cell, t, end)) {
            w.pool = ray->tolerance * (t - ray->t0) / (ray->t1 - ray->t0) - w.error;
            add_cell(&w);
            open = w.left > ISO_REFERENCE_LEFT;
        }
        k.plane[axis] += k.step[axis];
        set_next(&k, axis);
        t = end > t ? end : t;
    }
    return finish_pieces(&w, open, error);
}
