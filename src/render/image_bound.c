/* SPDX-License-Identifier: MIT */
#include "render/image_bound_points.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "render/reference_ray.h"

enum { CHANNELS = ISO_BOUND_CHANNELS, FINE = ISO_BOUND_FINE, COARSE = ISO_BOUND_COARSE };

/* Points along each axis of a fine voxel, and the fewest along each edge of a region, so that its ranges hold. */
enum { DENSE_POINTS = 2, REGION_POINTS = 4 };
#define DENSE_VOXELS ((size_t)1 << 21) /* volumes up to here take DENSE_POINTS an axis, larger ones 1 */

/* Ranges of one of the two levels in a region. */
typedef struct side {
    float sigma_min, sigma_max, g_min[CHANNELS], g_max[CHANNELS]; /* g where sigma > 0 */
} side;

typedef struct region {
    side side[2];
    float behind_lo[2][CHANNELS], behind_hi[2][CHANNELS]; /* of L, inside the region */
    double sum[2][CHANNELS];                              /* of the integrand with L_0, with L_k */
    float most[2][CHANNELS];                              /* its largest value */
    bool any, whole;                                      /* holds points; lies in the box as a whole */
} region;

/* A point of the volume. */
typedef struct point {
    size_t region; /* SIZE_MAX: outside the image */
    double weight; /* its share of the integral over a ray, summed over all rays of the image */
    iso_bound_values at;
} point;

typedef struct bound {
    const iso_image_bound_input *in;
    iso_bound_field field;
    size_t block_pixels, blocks[2], slabs, points_an_axis;
    double depth_from, slab_mm, pixel_size; /* pixel_size: mm, or at depth 1 of a perspective camera */
    double longest_mm;                      /* of a ray inside a slab */
    double least_depth_mm;                  /* least depth for projection: points at or beyond the camera plane are
                                             * projected at this depth */
    region *regions;                        /* slab fastest */
    bool late;                              /* the deadline came before all points were looked up */
} bound;

/* Writes the pixel's column and row, as fractions, and the depth along the camera's axis. */
static void project(const bound *b, iso_vec3 world, double at[3])
{
    const iso_camera *c = &b->in->view->camera;
    const iso_vec3 d = iso_sub(world, c->position);
    const double depth = iso_dot(d, c->forward), scale = c->orthographic ? 1 : 1 / fmax(depth, b->least_depth_mm);
    at[0] = 0.5 * (double)b->in->view->width + iso_dot(d, c->right) * scale / b->pixel_size;
    at[1] = 0.5 * (double)b->in->view->height - iso_dot(d, c->up) * scale / b->pixel_size;
    at[2] = depth;
}

static size_t region_at(const bound *b, const double at[3])
{
    const double slab = (at[2] - b->depth_from) / b->slab_mm;
    if (!(at[0] >= 0 && at[1] >= 0 && at[0] < (double)b->in->view->width && at[1] < (double)b->in->view->height &&
          at[2] > 0 && slab >= 0 && slab < (double)b->slabs))
        return SIZE_MAX;
    const size_t x = (size_t)at[0] / b->block_pixels, y = (size_t)at[1] / b->block_pixels;
    return (y * b->blocks[0] + x) * b->slabs + (size_t)slab;
}

iso_status iso_bound_field_create(iso_bound_field *field, const iso_image_bound_input *in, iso_error *err)
{
    const iso_view *v = in->view;
    *field = (iso_bound_field){.in = in,
                               .lit = v->light_count > 0 && (v->shading.diffuse > 0 || v->shading.specular > 0)};
    if (!iso_image_bound_is_for(v))
        return iso_fail(err, ISO_E_RANGE, "bound: not for clip planes, 2D transfer functions and regions of interest");
    NEED(iso_sampler_create(&field->sampler[FINE], in->fine, in->code, in->source, err));
    return iso_sampler_create(&field->sampler[COARSE], in->coarse, in->code, in->source, err);
}

void iso_bound_field_destroy(iso_bound_field *field)
{
    iso_sampler_destroy(&field->sampler[FINE]);
    iso_sampler_destroy(&field->sampler[COARSE]);
}

void iso_bound_look_up(const iso_bound_field *field, iso_vec3 index, iso_vec3 to_viewer, iso_bound_values *values)
{
    const iso_view *view = field->in->view;
    const iso_vec3 at[2] = {index, iso_scale(index, ldexp(1, -(int)field->in->level))};
    const iso_tf_table *tf[2] = {&view->tf, field->in->coarse_tf};
    for (int i = 0; i < 2; ++i) {
        double rgbs[4];
        iso_tf_lookup(tf[i], iso_sample_scalar(&field->sampler[i], at[i]), rgbs);
        values->sigma[i] = rgbs[3];
        const double light = rgbs[3] > 0 && field->lit
                                 ? iso_shade(view, iso_sample_normal(&field->sampler[i], at[i]), to_viewer)
                                 : view->shading.ambient;
        for (int c = 0; c < 3; ++c)
            values->g[i][c] = rgbs[c] * light;
        values->g[i][3] = 1;
    }
}

/* Makes point n of a fine voxel: a corner of a cubic lattice, moved by a step of the 3D golden ratio sequence. So no
 * plane of the grid gets more points than others. */
static point make_point(const bound *b, const size_t voxel[3], size_t n)
{
    static const double golden[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    const iso_geometry *g = &b->in->fine->geometry;
    const iso_camera *camera = &b->in->view->camera;
    const size_t a = b->points_an_axis, part[3] = {n % a, n / a % a, n / (a * a)};
    const double number = (double)((voxel[2] * g->size[1] + voxel[1]) * g->size[0] + voxel[0]) * (double)(a * a * a) +
                          (double)n;
    double index[3], at[3];
    for (int i = 0; i < 3; ++i) {
        const double move = number * golden[i] + 0.5;
        index[i] = (double)voxel[i] + ((double)part[i] + move - floor(move)) / (double)a;
    }
    const iso_vec3 place = iso_v3(index[0], index[1], index[2]), world = iso_geometry_to_world(g, place);
    project(b, world, at);
    point p = {.region = region_at(b, at)};
    if (p.region == SIZE_MAX)
        return p;
    const iso_vec3 to_viewer = camera->orthographic ? iso_scale(camera->forward, -1)
                                                    : iso_normalize(iso_sub(camera->position, world));
    const iso_mat3 *m = &g->index_to_world;
    const double volume = iso_dot(iso_column(*m, 0), iso_cross(iso_column(*m, 1), iso_column(*m, 2)));
    const double pixel = b->pixel_size * b->pixel_size;
    p.weight = fabs(volume) / (double)(a * a * a) / pixel;
    if (!camera->orthographic) /* the cone of a pixel widens with the depth, and leaves the axis by an angle */
        p.weight /= at[2] * at[2] * -iso_dot(to_viewer, camera->forward);
    iso_bound_look_up(&b->field, place, to_viewer, &p.at);
    return p;
}

static void widen(const point *p, region *r)
{
    for (int i = 0; i < 2; ++i) {
        side *s = &r->side[i];
        const float sigma = (float)p->at.sigma[i];
        s->sigma_min = r->any ? fminf(s->sigma_min, sigma) : sigma;
        s->sigma_max = r->any ? fmaxf(s->sigma_max, sigma) : sigma;
        for (int c = 0; c < CHANNELS; ++c) {
            s->g_min[c] = r->any ? s->g_min[c] : FLT_MAX;
            s->g_max[c] = r->any ? s->g_max[c] : -FLT_MAX;
            if (sigma > 0) {
                s->g_min[c] = fminf(s->g_min[c], (float)p->at.g[i][c]);
                s->g_max[c] = fmaxf(s->g_max[c], (float)p->at.g[i][c]);
            }
        }
    }
    r->any = true;
}

/* Adds the sup over L of |s_k (g_k - L) - s_0 (g_0 - L)|, which is linear in L, for L_0 and for L_k. */
static void add_integrand(const point *p, region *r)
{
    for (int i = 0; i < 2; ++i)
        for (int c = 0; c < CHANNELS; ++c) {
            const double l[2] = {r->behind_lo[i][c], r->behind_hi[i][c]};
            double most = 0;
            for (int end = 0; end < 2; ++end)
                most = fmax(most, fabs(p->at.sigma[COARSE] * (p->at.g[COARSE][c] - l[end]) -
                                       p->at.sigma[FINE] * (p->at.g[FINE][c] - l[end])));
            r->sum[i][c] += p->weight * most;
            r->most[i][c] = fmaxf(r->most[i][c], (float)most);
        }
}

static bool is_late(bound *b)
{
    b->late = b->late || (b->in->deadline > 0 && iso_clock_seconds() >= b->in->deadline);
    return b->late;
}

/* Passes all points to take(), a plane of voxels at a time. Threads make them; they are taken in order, so that sums do
 * not depend on threads. */
static iso_status for_points(bound *b, void (*take)(const point *p, region *r), iso_error *err)
{
    const size_t *n = b->in->fine->geometry.size, a = b->points_an_axis, of_voxel = a * a * a;
    const size_t count = n[0] * n[1] * of_voxel;
    point *points = malloc(count * sizeof *points);
    NEED_MEMORY(points, err, "bound: no memory for %zu points", count);
    for (size_t z = 0; z < n[2] && !is_late(b); ++z) {
#pragma omp parallel for schedule(static) num_threads(iso_threads(b->in->threads))
        for (size_t i = 0; i < count; ++i) {
            const size_t voxel = i / of_voxel;
            points[i] = make_point(b, (size_t[]){voxel % n[0], voxel / n[0], z}, i % of_voxel);
        }
        for (size_t i = 0; i < count; ++i)
            if (points[i].region != SIZE_MAX)
                take(&points[i], &b->regions[points[i].region]);
    }
    free(points);
    return ISO_OK;
}

/* Maps the range of L beyond a slab to the range in front of it, for transmittance in [t_min, t_max] and colors in
 * [g_min, g_max]. */
static void pass_slab(const side *s, double slab_mm, bool whole, double lo[CHANNELS], double hi[CHANNELS])
{
    if (!(s->sigma_max > 0))
        return;
    /* Rays may leave the axis, and points miss the largest value: nothing is asked of the least transmittance. */
    const double t_max = whole ? exp(-(double)s->sigma_min * slab_mm) : 1, t_min = 0;
    for (int c = 0; c < CHANNELS; ++c) {
        const double g_lo = s->g_min[c], g_hi = s->g_max[c];
        const double t_hi = hi[c] > g_hi ? t_max : t_min, t_lo = lo[c] < g_lo ? t_max : t_min;
        hi[c] = t_hi * hi[c] + (1 - t_hi) * g_hi;
        lo[c] = t_lo * lo[c] + (1 - t_lo) * g_lo;
    }
}

/* Computes the ranges of L in a block's regions, from the back; lo and hi end as those of the pixels. */
static void follow_back_to_front(const bound *b, region *block, int i, double lo[CHANNELS], double hi[CHANNELS])
{
    for (int c = 0; c < CHANNELS; ++c)
        lo[c] = hi[c] = c < 3 ? b->in->view->background[c] : 0;
    for (size_t slab = b->slabs; slab-- > 0;) {
        region *r = &block[slab];
        const side *s = &r->side[i];
        for (int c = 0; c < CHANNELS; ++c) {
            const bool seen = r->any && s->sigma_max > 0;
            r->behind_lo[i][c] = (float)(seen ? fmin(lo[c], (double)s->g_min[c]) : lo[c]);
            r->behind_hi[i][c] = (float)(seen ? fmax(hi[c], (double)s->g_max[c]) : hi[c]);
        }
        if (r->any)
            pass_slab(s, b->slab_mm, r->whole, lo, hi);
    }
}

/* Integrates along the rays of a block, as mean and maximum: T_k and L_0 (i = 0), or T_0 and L_k (i = 1). */
static void integrate(const bound *b, const region *block, int i, double mean[CHANNELS], double most[CHANNELS])
{
    double through = 1;
    for (int c = 0; c < CHANNELS; ++c)
        mean[c] = most[c] = 0;
    for (size_t slab = 0; slab < b->slabs; ++slab) {
        const region *r = &block[slab];
        for (int c = 0; c < CHANNELS; ++c) {
            mean[c] += through * r->sum[i][c];
            most[c] += through * (double)r->most[i][c] * b->longest_mm;
        }
        if (r->any && r->whole)
            through *= exp(-(double)r->side[1 - i].sigma_min * b->slab_mm);
    }
}

/* Returns an upper bound of the sum of squares over a block's pixels. */
static double bound_block(const bound *b, const region *block, const double range[2][2][CHANNELS], double pixels)
{
    double mean[2][CHANNELS], most[2][CHANNELS], squares = 0;
    for (int i = 0; i < 2; ++i)
        integrate(b, block, i, mean[i], most[i]);
    for (int c = 0; c < CHANNELS; ++c) {
        const double apart = fmax(range[COARSE][1][c] - range[FINE][0][c], range[FINE][1][c] - range[COARSE][0][c]);
        const double largest = fmin(apart, fmin(most[0][c], most[1][c]));
        squares += largest * fmin(pixels * largest, fmin(mean[0][c], mean[1][c]));
    }
    return squares;
}

/* True if the box holds all corners of a region, and so the region: both are convex. */
static bool lies_inside(const bound *b, size_t x, size_t y, size_t slab)
{
    const iso_view *v = b->in->view;
    const iso_camera *c = &v->camera;
    const iso_geometry *g = &b->in->fine->geometry;
    for (int corner = 0; corner < 8; ++corner) {
        const double depth = b->depth_from + b->slab_mm * (double)(slab + (size_t)(corner >> 2));
        const double scale = b->pixel_size * (c->orthographic ? 1 : depth);
        const double column = fmin((double)((x + (size_t)(corner & 1)) * b->block_pixels), (double)v->width),
                     row = fmin((double)((y + (size_t)(corner >> 1 & 1)) * b->block_pixels), (double)v->height);
        iso_vec3 world = iso_madd(c->position, c->forward, depth);
        world = iso_madd(world, c->right, (column - 0.5 * (double)v->width) * scale);
        world = iso_madd(world, c->up, (0.5 * (double)v->height - row) * scale);
        const iso_vec3 index = iso_geometry_to_index(g, world);
        if (!(depth > 0 && index.x >= 0 && index.y >= 0 && index.z >= 0 && index.x <= g->box_index[0] &&
              index.y <= g->box_index[1] && index.z <= g->box_index[2]))
            return false;
    }
    return true;
}

static size_t points_an_axis(const iso_image_bound_input *in)
{
    if (in->points > 0)
        return (size_t)in->points;
    return iso_geometry_voxel_count(&in->fine->geometry) <= DENSE_VOXELS ? DENSE_POINTS : 1;
}

/* Cuts the image into blocks and slabs with edges of REGION_POINTS points. Smaller regions would not hold the ranges;
 * larger ones would vary more inside. */
static iso_status cut_image(bound *b, iso_error *err)
{
    const iso_view *v = b->in->view;
    const iso_geometry *g = &b->in->fine->geometry;
    double spacing[3], nearest = INFINITY, farthest = 0;
    iso_geometry_spacing_mm(g, spacing);
    b->points_an_axis = points_an_axis(b->in);
    b->pixel_size = 2 * v->camera.half_height / (double)v->height;
    b->least_depth_mm = 1e-9 * iso_geometry_min_spacing_mm(g);
    for (int corner = 0; corner < 8; ++corner) {
        const iso_vec3 index = iso_v3(corner & 1 ? g->box_index[0] : 0, corner & 2 ? g->box_index[1] : 0,
                                      corner & 4 ? g->box_index[2] : 0);
        double at[3];
        project(b, iso_geometry_to_world(g, index), at);
        nearest = fmin(nearest, at[2]);
        farthest = fmax(farthest, at[2]);
    }
    nearest = fmax(nearest, 0);
    const double edge = (double)REGION_POINTS / (double)b->points_an_axis *
                        fmax(spacing[0], fmax(spacing[1], spacing[2]));
    const double pixel_mm = b->pixel_size *
                            (v->camera.orthographic ? 1 : fmax(0.5 * (nearest + farthest), b->least_depth_mm));
    b->block_pixels = (size_t)fmax(1, ceil(edge / pixel_mm));
    b->blocks[0] = (v->width + b->block_pixels - 1) / b->block_pixels;
    b->blocks[1] = (v->height + b->block_pixels - 1) / b->block_pixels;
    b->depth_from = nearest;
    b->slabs = (size_t)fmax(1, ceil((farthest - nearest) / edge));
    b->slab_mm = edge;
    const double aspect = (double)v->width / (double)v->height;
    const double edge_of_view = v->camera.orthographic ? 0 : v->camera.half_height * sqrt(1 + aspect * aspect);
    b->longest_mm = edge * sqrt(1 + edge_of_view * edge_of_view);
    const size_t count = b->blocks[0] * b->blocks[1] * b->slabs;
    b->regions = calloc(count, sizeof *b->regions);
    return b->regions ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "bound: no memory for %zu regions", count);
}

static double pixels_of(const bound *b, size_t x, size_t y)
{
    const size_t w = b->in->view->width - x * b->block_pixels, h = b->in->view->height - y * b->block_pixels;
    return (double)(w < b->block_pixels ? w : b->block_pixels) * (double)(h < b->block_pixels ? h : b->block_pixels);
}

/* Computes the ranges of L for all regions, then the integrand, then the sum over the blocks. */
static iso_status sum_squares(bound *b, double (*ranges)[2][2][CHANNELS], double *squares, iso_error *err)
{
    const size_t count = b->blocks[0] * b->blocks[1];
    iso_status status = for_points(b, widen, err);
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        for (size_t slab = 0; slab < b->slabs; ++slab) {
            region *r = &b->regions[i * b->slabs + slab];
            r->whole = r->any && lies_inside(b, i % b->blocks[0], i / b->blocks[0], slab);
        }
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        for (int which = 0; which < 2; ++which)
            follow_back_to_front(b, b->regions + i * b->slabs, which, ranges[i][which][0], ranges[i][which][1]);
    TRY(status, for_points(b, add_integrand, err));
    *squares = 0;
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        *squares += bound_block(b, b->regions + i * b->slabs, (const double(*)[2][CHANNELS])ranges[i],
                                pixels_of(b, i % b->blocks[0], i / b->blocks[0]));
    return status;
}

bool iso_image_bound_is_for(const iso_view *view)
{
    return view->clip_count == 0 && !view->tf_2d && !view->extinction_scale && !view->roi;
}

size_t iso_image_bound_points(double voxels)
{
    return voxels <= (double)DENSE_VOXELS ? DENSE_POINTS * DENSE_POINTS * DENSE_POINTS : 1;
}

iso_status iso_image_bound_rmse(const iso_image_bound_input *in, double *rmse, iso_error *err)
{
    bound b = {.in = in};
    double(*ranges)[2][2][CHANNELS] = NULL, squares = 0;
    iso_status status = iso_bound_field_create(&b.field, in, err);
    TRY(status, cut_image(&b, err));
    if (status == ISO_OK && !(ranges = calloc(b.blocks[0] * b.blocks[1], sizeof *ranges)))
        status = iso_fail(err, ISO_E_MEMORY, "bound: out of memory");
    TRY(status, sum_squares(&b, ranges, &squares, err));
    *rmse = b.late ? INFINITY : sqrt(squares / (double)(CHANNELS * in->view->width * in->view->height));
    free(ranges);
    free(b.regions);
    iso_bound_field_destroy(&b.field);
    return status;
}
