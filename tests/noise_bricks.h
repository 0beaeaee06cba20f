/* SPDX-License-Identifier: MIT */
/* noise_bricks.h - bricks of white noise, and how far those that meet at a point disagree on it. */
#pragma once

#include "test.h"

#include <math.h>
#include <stdlib.h>

#include "base/random.h"
#include "brick/bricks.h"

/* Values are floats, weights and sums double: a few roundings of numbers up to 1. */
#define CONTINUOUS 1e-12

static iso_random random_state;
static double random_unit(void)
{
    return iso_random_unit(&random_state);
}

/* White noise: nothing is smooth, every wrong value shows. */
static iso_node_levels noise_levels(const size_t size[3], size_t brick_voxels, size_t level_count, bool directions)
{
    iso_level level = {.geometry = iso_geometry_axis_aligned(size, (const double[3]){1, 0.8, 1.7}), .min = 0, .max = 1};
    size_t count = iso_geometry_voxel_count(&level.geometry);
    iso_node_levels n;
    level.scalar = malloc(count * sizeof *level.scalar);
    assert_non_null(level.scalar);
    for (size_t i = 0; i < count; ++i)
        level.scalar[i] = (float)random_unit();
    assert_ok(iso_node_levels_create(&n, &level, brick_voxels, level_count, directions, 0, &err));
    free(level.scalar);
    return n;
}

/* The largest difference between the limits at q from all bricks whose closed boxes hold it. */
static double jump_at(const iso_brick_field *f, const double q[3])
{
    const iso_node_levels *n = f->nodes;
    double min[ISO_NODE_CHANNELS], max[ISO_NODE_CHANNELS], jump = 0;
    for (int c = 0; c < ISO_NODE_CHANNELS; ++c)
        min[c] = INFINITY, max[c] = -INFINITY;
    for (size_t i = 0; i < iso_brick_count(n); ++i) {
        const size_t b[3] = {i % n->count[0], i / n->count[0] % n->count[1], i / (n->count[0] * n->count[1])};
        bool inside = true;
        for (int a = 0; a < 3; ++a) {
            double u = q[a] - (double)(b[a] * n->brick_voxels);
            inside = inside && u >= 0 && u <= (double)n->brick_voxels;
        }
        double value[ISO_NODE_CHANNELS];
        if (!inside)
            continue;
        iso_brick_sample_in(f, b, q, value);
        for (int c = 0; c < ISO_NODE_CHANNELS; ++c)
            min[c] = fmin(min[c], value[c]), max[c] = fmax(max[c], value[c]);
    }
    for (int c = 0; c < ISO_NODE_CHANNELS; ++c)
        if (!(max[c] - min[c] <= jump))
            jump = max[c] - min[c];
    return jump;
}

/* A point on a face (1 fixed axis), edge (2) or corner (3) between bricks; half of them near edges of cells. */
static void point_between_bricks(const iso_node_levels *n, double q[3])
{
    int fixed = 1 + (int)(7 * random_unit()); /* bits: not 0 */
    for (int a = 0; a < 3; ++a) {
        double length = (double)(n->count[a] * n->brick_voxels);
        if (fixed >> a & 1 && n->count[a] > 1)
            q[a] = (double)(n->brick_voxels * (1 + (size_t)((double)(n->count[a] - 1) * random_unit())));
        else
            q[a] = random_unit() < 0.5 ? length * random_unit() : floor(length * random_unit()) + 1e-3 * random_unit();
    }
}

static double worst_jump(const iso_brick_field *f, int points)
{
    double worst = 0;
    for (int i = 0; i < points; ++i) {
        double q[3];
        point_between_bricks(f->nodes, q);
        double jump = jump_at(f, q);
        if (!(jump <= worst))
            worst = jump;
    }
    return worst;
}
