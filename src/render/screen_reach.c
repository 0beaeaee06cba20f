/* SPDX-License-Identifier: MIT */
#include "render/screen_reach.h"

#include <math.h>
#include <stdlib.h>

/* A place or an extent in the camera's axes: right, up, forward. */
typedef struct seen {
    double right, up, forward;
} seen;

static seen see(const iso_camera *c, iso_vec3 v)
{
    return (seen){iso_dot(v, c->right), iso_dot(v, c->up), iso_dot(v, c->forward)};
}

/* Data shared by all blocks: the first one's middle, the way to the next along each axis, half of a block's extent
 * along each of the camera's axes, and the sphere around one. They are half a thousandth too large, to allow for
 * rounding. */
typedef struct block_shape {
    seen first, step[3], half;
    double radius;
} block_shape;

static block_shape shape_of(const iso_geometry *g, const iso_camera *c, const iso_screen_blocks *b)
{
    const double wider = 1.0005, middle = b->first + 0.5 * b->voxels;
    block_shape s = {0};
    double radius = 0;
    s.first = see(c, iso_sub(iso_geometry_to_world(g, iso_v3(middle, middle, middle)), c->position));
    for (int a = 0; a < 3; ++a) {
        const iso_vec3 way = iso_scale(iso_v3(g->index_to_world.m[0][a], g->index_to_world.m[1][a],
                                              g->index_to_world.m[2][a]),
                                       b->voxels);
        s.step[a] = see(c, way);
        s.half.right += 0.5 * wider * fabs(s.step[a].right);
        s.half.up += 0.5 * wider * fabs(s.step[a].up);
        s.half.forward += 0.5 * wider * fabs(s.step[a].forward);
    }
    /* The farthest corner, of a block that may be sheared: four of them stand for all. */
    for (int corner = 0; corner < 4; ++corner) {
        const double x = corner & 1 ? 1 : -1, y = corner & 2 ? 1 : -1;
        const double right = s.step[0].right * x + s.step[1].right * y + s.step[2].right,
                     up = s.step[0].up * x + s.step[1].up * y + s.step[2].up,
                     forward = s.step[0].forward * x + s.step[1].forward * y + s.step[2].forward;
        radius = fmax(radius, sqrt(right * right + up * up + forward * forward));
    }
    s.radius = 0.5 * wider * radius;
    return s;
}

/* Divides [lo, hi] by [near, far], near above 0: the least and the greatest quotient. */
static void divide(double *lo, double *hi, double near, double far)
{
    *lo /= *lo < 0 ? near : far;
    *hi /= *hi < 0 ? far : near;
}

/* Finds the tiles [first, last] that hold the pixels of [lo, hi]; the image is -1 to 1. None: last < first. */
static void tiles_of(double lo, double hi, size_t pixels, size_t tiles, long *first, long *last)
{
    const double per_unit = 0.5 * (double)pixels, tile = ISO_SCREEN_TILE;
    *first = (long)fmax(floor(((lo + 1) * per_unit - 1) / tile), 0);
    *last = (long)fmin(floor(((hi + 1) * per_unit + 1) / tile), (double)tiles - 1);
}

/* Returns the distance to a point along its ray. */
static double way_to(const iso_camera *c, seen at)
{
    return c->orthographic ? at.forward : sqrt(at.right * at.right + at.up * at.up + at.forward * at.forward);
}

static void add_block(iso_screen_reach *r, const iso_view *view, const block_shape *s, seen at)
{
    const iso_camera *c = &view->camera;
    const double half_width = c->half_height * (double)view->width / (double)view->height;
    const double near = at.forward - s->half.forward, far = at.forward + s->half.forward;
    const double middle = way_to(c, at);
    const double wide = s->radius + 1e-6 * fabs(middle); /* a float's rounding is less */
    const float least = (float)(middle - wide), most = (float)(middle + wide);
    long x[2] = {0, (long)r->columns - 1}, y[2] = {0, (long)r->rows - 1};
    if (far < 0)
        return; /* beyond the camera plane */
    /* A block around the camera is everywhere. */
    if (c->orthographic || near > 1e-3 * s->radius) {
        double left = at.right - s->half.right, right = at.right + s->half.right;
        double below = at.up - s->half.up, above = at.up + s->half.up;
        if (!c->orthographic) {
            divide(&left, &right, near, far);
            divide(&below, &above, near, far);
        }
        tiles_of(left / half_width, right / half_width, view->width, r->columns, &x[0], &x[1]);
        tiles_of(-above / c->half_height, -below / c->half_height, view->height, r->rows, &y[0], &y[1]);
    }
    for (long row = y[0]; row <= y[1]; ++row)
        for (long column = x[0]; column <= x[1]; ++column) {
            float *mm = r->mm + 2 * ((size_t)row * r->columns + (size_t)column);
            mm[0] = fminf(mm[0], least);
            mm[1] = fmaxf(mm[1], most);
        }
}

/* True if a visible block has an empty neighbor, or lies at the border of the grid. */
static bool is_outermost(const iso_screen_blocks *b, size_t x, size_t y, size_t z, size_t i)
{
    const size_t at[3] = {x, y, z}, stride[3] = {1, b->count[0], b->count[0] * b->count[1]};
    for (int a = 0; a < 3; ++a)
        if (at[a] == 0 || at[a] + 1 == b->count[a] || b->distance[i - stride[a]] > 0 || b->distance[i + stride[a]] > 0)
            return true;
    return false;
}

iso_status iso_screen_reach_create(iso_screen_reach *r, const iso_geometry *g, const iso_view *view,
                                   const iso_screen_blocks *blocks, iso_error *err)
{
    r->columns = (view->width + ISO_SCREEN_TILE - 1) / ISO_SCREEN_TILE;
    r->rows = (view->height + ISO_SCREEN_TILE - 1) / ISO_SCREEN_TILE;
    r->mm = malloc(2 * r->columns * r->rows * sizeof *r->mm);
    NEED_MEMORY(r->mm, err, "no memory for %zu tiles of pixels", r->columns * r->rows);
    for (size_t i = 0; i < r->columns * r->rows; ++i) {
        r->mm[2 * i] = INFINITY;
        r->mm[2 * i + 1] = -INFINITY;
    }
    const block_shape s = shape_of(g, &view->camera, blocks);
    size_t i = 0;
    for (size_t z = 0; z < blocks->count[2]; ++z)
        for (size_t y = 0; y < blocks->count[1]; ++y) {
            const double dy = (double)y, dz = (double)z;
            const seen row = {s.first.right + dy * s.step[1].right + dz * s.step[2].right,
                              s.first.up + dy * s.step[1].up + dz * s.step[2].up,
                              s.first.forward + dy * s.step[1].forward + dz * s.step[2].forward};
            for (size_t x = 0; x < blocks->count[0]; ++x, ++i) {
                const double dx = (double)x;
                const seen at = {row.right + dx * s.step[0].right, row.up + dx * s.step[0].up,
                                 row.forward + dx * s.step[0].forward};
                if (blocks->distance[i] == 0 &&
                    (is_outermost(blocks, x, y, z, i) || way_to(&view->camera, at) < s.radius))
                    add_block(r, view, &s, at);
            }
        }
    return ISO_OK;
}

void iso_screen_reach_destroy(iso_screen_reach *r)
{
    if (!r)
        return;
    free(r->mm);
    *r = (iso_screen_reach){0};
}
