/* SPDX-License-Identifier: MIT */
#include "plan/plan.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "brick/pack.h"
#include "encode/code.h"

/* ---- estimates ---------------------------------------------------------------- */

/* Inputs for estimating the errors of a view's bricks. */
typedef struct estimator {
    const iso_node_levels *nodes;
    const iso_view *view;
    const double (*integral)[4]; /* integrate_tf() of the view's table */
    double voxel_mm;
} estimator;

/* Returns the emission rate of a table's entry, extinction times color; c 3: its extinction. */
static double rate_of(const iso_tf_table *tf, size_t entry, int c)
{
    const float *e = tf->entries + 4 * entry;
    return (double)e[3] * (c < 3 ? (double)e[c] : 1);
}

/* Up to each entry, the integral of the rates; lengths in entries. To be freed; NULL: no memory. */
static double (*integrate_tf(const iso_tf_table *tf))[4]
{
    double(*integral)[4] = calloc(tf->count, sizeof *integral);
    for (size_t i = 1; integral && i < tf->count; ++i)
        for (int c = 0; c < 4; ++c)
            integral[i][c] = integral[i - 1][c] + 0.5 * (rate_of(tf, i - 1, c) + rate_of(tf, i, c));
    return integral;
}

/* Returns the integral up to a position among the entries; the first and last entry extend beyond the table. */
static double integral_at(const estimator *e, double position, int c)
{
    const iso_tf_table *tf = &e->view->tf;
    const double last = (double)(tf->count - 1), inside = fmin(fmax(position, 0), last);
    const size_t i = (size_t)fmin(inside, last - 1), end = position < 0 ? 0 : tf->count - 1;
    const double f = inside - (double)i;
    return (1 - f) * e->integral[i][c] + f * e->integral[i + 1][c] + (position - inside) * rate_of(tf, end, c);
}

/* Computes the mean entry of the values from a to b, colors weighted by their extinction. Between two nodes may be
 * visible values that neither has, if a transfer function shows few values only. */
static void mean_entry(const estimator *e, double a, double b, double entry[4])
{
    const iso_tf_table *tf = &e->view->tf;
    const double scale = (double)(tf->count - 1) / (tf->hi - tf->lo), length = (b - a) * scale;
    double sum[4];
    iso_tf_lookup(tf, 0.5 * (a + b), entry);
    if (fabs(length) < 1e-3)
        return;
    for (int c = 0; c < 4; ++c)
        sum[c] = (integral_at(e, (b - tf->lo) * scale, c) - integral_at(e, (a - tf->lo) * scale, c)) / length;
    entry[3] = fmax(sum[3], 0);
    for (int c = 0; c < 3 && sum[3] > 0; ++c)
        entry[c] = sum[c] / sum[3];
}

/* Computes the emission of an entry over one voxel in a direction, and its opacity; images depend on nothing else. */
static void emit(const estimator *e, const double entry[4], const double direction[ISO_NODE_CHANNELS - 1],
                 double rgba[4])
{
    const iso_view *view = e->view;
    double normal[3], shade = view->shading.ambient;
    iso_code_normal(direction, normal);
    for (size_t i = 0; i < view->light_count; ++i) {
        const iso_light *l = &view->lights[i];
        shade += l->intensity * view->shading.diffuse *
                 fabs(normal[0] * l->direction.x + normal[1] * l->direction.y + normal[2] * l->direction.z);
    }
    rgba[3] = -expm1(-entry[3] * e->voxel_mm);
    for (int c = 0; c < 3; ++c)
        rgba[c] = rgba[3] * shade * entry[c];
}

static double largest_difference(const double a[4], const double b[4])
{
    double worst = 0;
    for (int c = 0; c < 4; ++c)
        worst = fmax(worst, fabs(a[c] - b[c]));
    return worst;
}

/* Reads the node of level 0 at p, moved outwards by one if it lies on a face of the brick. False inside the brick and
 * at the volume's end. */
static bool node_beyond(const iso_node_levels *n, const size_t brick[3], const size_t local[3],
                        double value[ISO_NODE_CHANNELS])
{
    size_t p[3], size[3];
    bool moved = false;
    for (int a = 0; a < 3; ++a) {
        size[a] = n->count[a] * n->brick_voxels + 1;
        p[a] = brick[a] * n->brick_voxels + local[a];
        bool below = local[a] == 0 && p[a] > 0, above = local[a] == n->brick_voxels && p[a] + 1 < size[a];
        p[a] = below ? p[a] - 1 : above ? p[a] + 1 : p[a];
        moved = moved || below || above;
    }
    for (size_t c = 0; c < ISO_NODE_CHANNELS; ++c)
        value[c] = (double)n->nodes[0][ISO_NODE_CHANNELS * (p[0] + size[0] * (p[1] + size[1] * p[2])) + c];
    return moved;
}

/* Places where a node's errors are estimated: at the node, half-way to the node beyond the brick's face, and on the way
 * to the brick's next node. */
enum { AT_NODE, BEYOND_FACE, TO_NEXT, PLACES };

/* Moves q one node along an axis; the axes take turns by node. False at the brick's end. */
static bool next_node(const iso_node_levels *n, const size_t local[3], double q[3])
{
    const size_t axis = (local[0] + local[1] + local[2]) % 3;
    q[axis] += 1;
    return local[axis] < n->brick_voxels;
}

/* Adds the errors of one node at every level. Places are the node, on a face half-way to the next brick's node (the
 * face belongs to that cell, too), and the way to the next node if the error there is larger. Returns true if level 0
 * shows anything there. */
static bool add_errors(const estimator *e, const iso_brick_field *f, uint8_t *level, const size_t brick[3],
                       const size_t local[3], double *sum)
{
    const iso_node_levels *n = e->nodes;
    double q[3], to[3], exact[PLACES][4], beyond[ISO_NODE_CHANNELS];
    bool looked_at[PLACES] = {[AT_NODE] = true, [BEYOND_FACE] = node_beyond(n, brick, local, beyond)}, shows = false;
    for (int a = 0; a < 3; ++a)
        to[a] = q[a] = (double)(brick[a] * n->brick_voxels + local[a]);
    looked_at[TO_NEXT] = next_node(n, local, to);
    for (size_t l = 0; l < n->level_count; ++l) {
        double node[ISO_NODE_CHANNELS], next[ISO_NODE_CHANNELS], entry[PLACES][4], error[PLACES] = {0};
        *level = (uint8_t)l;
        iso_brick_sample_in(f, brick, q, node);
        iso_tf_lookup(&e->view->tf, node[0], entry[AT_NODE]);
        iso_tf_lookup(&e->view->tf, 0.5 * (node[0] + beyond[0]), entry[BEYOND_FACE]);
        if (looked_at[TO_NEXT]) {
            iso_brick_sample_in(f, brick, to, next);
            mean_entry(e, node[0], next[0], entry[TO_NEXT]);
        }
        for (int place = 0; place < PLACES; ++place) {
            if (!looked_at[place])
                continue;
            double direction[ISO_NODE_CHANNELS - 1], rgba[4];
            const double *other = place == AT_NODE ? node : place == BEYOND_FACE ? beyond : next;
            for (int c = 1; c < ISO_NODE_CHANNELS; ++c)
                direction[c - 1] = 0.5 * (node[c] + other[c]);
            emit(e, entry[place], direction, l == 0 ? exact[place] : rgba);
            error[place] = l == 0 ? 0 : largest_difference(rgba, exact[place]);
        }
        sum[l] += fmax(error[AT_NODE], error[TO_NEXT]) + error[BEYOND_FACE];
    }
    for (int place = 0; place < PLACES; ++place)
        shows = shows || (looked_at[place] && exact[place][3] > 0);
    return shows;
}

/* Looks at a quarter of the nodes, in a lattice that no plane and no row evades, although a single voxel may. So if
 * nothing visible is found, the next quarter is looked at as well. */
static void estimate_brick(const estimator *e, uint8_t *levels, size_t index, float *errors)
{
    enum { QUARTERS = 4 };
    const iso_node_levels *n = e->nodes;
    const size_t brick[3] = {index % n->count[0], index / n->count[0] % n->count[1],
                             index / (n->count[0] * n->count[1])};
    /* levels[index] alone is looked at: faces of its own. */
    const iso_brick_field f = {.nodes = n, .levels = levels, .faces = ISO_FACES_OWN};
    double sum[ISO_BRICK_MAX_LEVELS] = {0};
    size_t count = 0, side = n->brick_voxels;
    bool shows = false;
    for (size_t quarter = 0; quarter < QUARTERS && !shows; ++quarter)
        for (size_t z = 0; z <= side; ++z)
            for (size_t y = 0; y <= side; ++y)
                for (size_t x = (y + 2 * z + quarter) % QUARTERS; x <= side; x += QUARTERS, ++count)
                    shows |= add_errors(e, &f, &levels[index], brick, (const size_t[3]){x, y, z}, sum);
    /* A mean over the brick, times the voxels of a ray through it; no pixel is wrong by more than 1. */
    for (size_t l = 0; l < n->level_count; ++l)
        errors[l] = (float)fmin(1, sum[l] / (double)count * (double)side);
    levels[index] = 0;
}

/* Adds T^2 once to each brick that a ray through the finest level enters, where T is the transmittance there. */
static void trace(const iso_brick_field *f, const iso_view *view, const iso_ray *ray, const uint8_t *shown,
                  double *seen)
{
    const iso_node_levels *n = f->nodes;
    double t0, t1, step = iso_geometry_min_spacing_mm(&n->geometry), transmittance = 1;
    size_t last = SIZE_MAX;
    if (!iso_view_ray(view, ray, &n->geometry, &t0, &t1))
        return;
    for (double t = t0 + 0.5 * step; t < t1 && transmittance >= ISO_PLAN_HIDDEN; t += step) {
        iso_vec3 p = iso_geometry_to_index(&n->geometry, iso_madd(ray->origin, ray->direction, t));
        const double index[3] = {p.x - 0.5, p.y - 0.5, p.z - 0.5};
        double node[ISO_NODE_CHANNELS], entry[4];
        size_t brick[3];
        for (int a = 0; a < 3; ++a) {
            double b = floor(index[a] / (double)n->brick_voxels), end = (double)(n->count[a] - 1);
            brick[a] = (size_t)(b > 0 ? (b < end ? b : end) : 0);
        }
        size_t here = iso_brick_index(n, brick);
        if (here != last)
            seen[here] += transmittance * transmittance;
        last = here;
        if (!shown[here])
            continue;
        iso_brick_sample(f, p, node);
        iso_tf_lookup(&view->tf, node[0], entry);
        transmittance *= exp(-entry[3] * step);
    }
}

/* Sends rays through every `stride`-th pixel, so that the smallest brick meets several. A brick counts stride^2 pixels
 * per ray through it. */
static iso_status find_footprints(const iso_plan *plan, const iso_node_levels *n, const iso_view *view,
                                  const uint8_t *shown, int threads, float *footprints, iso_error *err)
{
    size_t larger = view->width > view->height ? view->width : view->height, stride = (larger + 255) / 256;
    const iso_brick_field finest = {.nodes = n, .levels = plan->levels, .faces = ISO_FACES_OWN};
    size_t columns = (view->width + stride - 1) / stride, rows = (view->height + stride - 1) / stride;
    double *seen = calloc(plan->brick_count * rows, sizeof *seen);
    if (!seen)
        return iso_fail(err, ISO_E_MEMORY, "plan: no memory for the footprints of %zu bricks", plan->brick_count);
#pragma omp parallel for schedule(dynamic) num_threads(iso_threads(threads))
    for (size_t row = 0; row < rows; ++row)
        for (size_t column = 0; column < columns; ++column) {
            size_t x = column * stride + stride / 2, y = row * stride + stride / 2;
            iso_ray ray = iso_camera_ray(&view->camera, view->width, view->height,
                                         x < view->width ? x : view->width - 1,
                                         y < view->height ? y : view->height - 1);
            trace(&finest, view, &ray, shown, seen + row * plan->brick_count);
        }
    /* Row by row and then in order: the sum does not depend on threads. */
    for (size_t i = 0; i < plan->brick_count; ++i) {
        double sum = 0;
        for (size_t row = 0; row < rows; ++row)
            sum += seen[row * plan->brick_count + i];
        footprints[i] = (float)(sum * (double)(stride * stride));
    }
    free(seen);
    return ISO_OK;
}

/* Adds what one view sees. */
static iso_status add_view(iso_plan *plan, const iso_node_levels *n, const iso_view *view, uint8_t *shown,
                           float *footprints, int threads, iso_error *err)
{
    const iso_brick_field finest = {.nodes = n, .levels = plan->levels, .faces = ISO_FACES_OWN};
    iso_brick_cull(&finest, &view->tf, threads, shown);
    iso_status status = find_footprints(plan, n, view, shown, threads, footprints, err);
    if (status != ISO_OK)
        return status;
    double(*integral)[4] = integrate_tf(&view->tf);
    if (!integral)
        return iso_fail(err, ISO_E_MEMORY, "plan: no memory for %zu entries of a transfer function", view->tf.count);
    const estimator e = {n, view, (const double(*)[4])integral, iso_geometry_mean_spacing_mm(&n->geometry)};
#pragma omp parallel for schedule(dynamic) num_threads(iso_threads(threads))
    for (size_t i = 0; i < plan->brick_count; ++i) {
        float errors[ISO_BRICK_MAX_LEVELS] = {0};
        plan->footprints[i] += footprints[i];
        if (footprints[i] <= 0 || !shown[i])
            continue;
        plan->shown[i] = 1;
        estimate_brick(&e, plan->levels, i, errors);
        for (size_t l = 0; l < n->level_count; ++l)
            plan->squares[i * n->level_count + l] += footprints[i] * errors[l] * errors[l];
    }
    free(integral);
    plan->pixel_count += (double)(view->width * view->height);
    return ISO_OK;
}

iso_status iso_plan_create(iso_plan *plan, const iso_node_levels *n, const iso_view *views, size_t view_count,
                           int threads, const iso_progress *progress, iso_error *err)
{
    size_t count = iso_brick_count(n);
    *plan = (iso_plan){.brick_count = count, .level_count = n->level_count};
    plan->squares = calloc(count * n->level_count, sizeof *plan->squares);
    plan->footprints = calloc(count, sizeof *plan->footprints);
    plan->levels = calloc(count, 1);
    plan->shown = calloc(count, 1);
    uint8_t *shown = malloc(count);
    float *footprints = malloc(count * sizeof *footprints);
    iso_status status = ISO_OK;
    if (!plan->squares || !plan->footprints || !plan->levels || !plan->shown || !shown || !footprints)
        status = iso_fail(err, ISO_E_MEMORY, "plan: no memory for %zu bricks", count);
    for (size_t v = 0; v < view_count && status == ISO_OK; ++v) {
        iso_progress_report(progress, "plan", (double)v / (double)view_count);
        status = add_view(plan, n, &views[v], shown, footprints, threads, err);
    }
    iso_progress_report(progress, "plan", 1);
    free(shown);
    free(footprints);
    if (status != ISO_OK)
        iso_plan_destroy(plan);
    return status;
}

void iso_plan_destroy(iso_plan *plan)
{
    if (!plan)
        return;
    free(plan->squares);
    free(plan->footprints);
    free(plan->levels);
    free(plan->shown);
    *plan = (iso_plan){0};
}

/* ---- choice ------------------------------------------------------------------- */

/* Chooses the levels for one lambda; returns the predicted RMSE. */
static double choose_for(iso_plan *plan, const iso_node_levels *n, double lambda)
{
    double sum = 0;
    for (size_t i = 0; i < plan->brick_count; ++i) {
        const float *squares = plan->squares + i * plan->level_count;
        double least = INFINITY, square = 0;
        plan->levels[i] = 0;
        if (!plan->shown[i] || plan->footprints[i] <= 0)
            continue;
        for (size_t l = plan->level_count; l-- > 0;) {
            double side = (double)iso_brick_side(n, l), cost = side * side * side + lambda * (double)squares[l];
            if (cost < least) {
                least = cost;
                square = (double)squares[l];
                plan->levels[i] = (uint8_t)l;
            }
        }
        sum += square;
    }
    return sqrt(sum / plan->pixel_count);
}

double iso_plan_choose(iso_plan *plan, const iso_node_levels *n, double rmse)
{
    /* The prediction falls as lambda rises; lambda in decades, to a thousandth of one. */
    double low = -12, high = 24;
    if (choose_for(plan, n, pow(10, low)) <= rmse)
        return choose_for(plan, n, pow(10, low));
    while (high - low > 1e-3) {
        double middle = 0.5 * (low + high);
        *(choose_for(plan, n, pow(10, middle)) <= rmse ? &high : &low) = middle;
    }
    return choose_for(plan, n, pow(10, high));
}
