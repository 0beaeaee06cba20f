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

/* Nodes of level 0: those of a brick and one more on all sides. */
typedef struct fine_box {
    size_t side; /* of the box */
    float *nodes;
} fine_box;

static const float *fine_node(const fine_box *f, const size_t local[3], int axis, int step)
{
    size_t at[3] = {local[0] + 1, local[1] + 1, local[2] + 1};
    at[axis] += (size_t)step; /* -1 wraps around */
    return f->nodes + ISO_NODE_CHANNELS * (at[0] + f->side * (at[1] + f->side * at[2]));
}

/* Reads the node of level 0, moved outwards by one if it lies on a face of the brick. False inside the brick and at the
 * volume's end. */
static bool node_beyond(const iso_node_levels *n, const fine_box *f, const size_t brick[3], const size_t local[3],
                        double value[ISO_NODE_CHANNELS])
{
    size_t at[3];
    bool moved = false;
    for (int a = 0; a < 3; ++a) {
        const bool below = local[a] == 0 && brick[a] > 0,
                   above = local[a] == n->brick_voxels && brick[a] + 1 < n->count[a];
        at[a] = local[a] + above - below; /* -1 wraps around */
        moved = moved || below || above;
    }
    const float *node = fine_node(f, at, 0, 0);
    for (size_t c = 0; c < ISO_NODE_CHANNELS; ++c)
        value[c] = (double)node[c];
    return moved;
}

/* Places where a node's errors are estimated: at the node, half-way to the node beyond the brick's face, and on the way
 * to the brick's next node. */
enum { AT_NODE, BEYOND_FACE, TO_NEXT, PLACES };

/* Returns the axis of the way to the next node; the axes take turns by node. */
static int axis_to_next(const size_t local[3])
{
    return (int)((local[0] + local[1] + local[2]) % 3);
}

/* Samples the brick at its level at a node of level 0, moved by `step` along an axis. */
static void sample_node(const iso_brick_field *f, const fine_box *box, const size_t brick[3], const size_t local[3],
                        int axis, int step, double node[ISO_NODE_CHANNELS])
{
    const iso_node_levels *n = f->nodes;
    double q[3];
    if (f->levels[iso_brick_index(n, brick)] == 0) {
        const float *at = fine_node(box, local, axis, step);
        for (int c = 0; c < ISO_NODE_CHANNELS; ++c)
            node[c] = (double)at[c];
        return;
    }
    for (int a = 0; a < 3; ++a)
        q[a] = (double)(brick[a] * n->brick_voxels + local[a]);
    q[axis] += step;
    iso_brick_sample_in(f, brick, q, node);
}

/* Adds the errors of one node at every level. Places are the node, on a face half-way to the next brick's node (the
 * face belongs to that cell, too), and the way to the next node if the error there is larger. Returns true if level 0
 * shows anything there. */
static bool add_errors(const estimator *e, const iso_brick_field *f, const fine_box *box, uint8_t *level,
                       const size_t brick[3], const size_t local[3], double *sum)
{
    const iso_node_levels *n = e->nodes;
    const int axis = axis_to_next(local);
    double exact[PLACES][4] = {{0}}, beyond[ISO_NODE_CHANNELS];
    const bool looked_at[PLACES] = {[AT_NODE] = true,
                                    [BEYOND_FACE] = node_beyond(n, box, brick, local, beyond),
                                    [TO_NEXT] = local[axis] < n->brick_voxels};
    bool shows = false;
    for (size_t l = 0; l < n->level_count; ++l) {
        double node[ISO_NODE_CHANNELS], next[ISO_NODE_CHANNELS], entry[PLACES][4], error[PLACES] = {0};
        *level = (uint8_t)l;
        sample_node(f, box, brick, local, axis, 0, node);
        iso_tf_lookup(&e->view->tf, node[0], entry[AT_NODE]);
        if (looked_at[BEYOND_FACE])
            iso_tf_lookup(&e->view->tf, 0.5 * (node[0] + beyond[0]), entry[BEYOND_FACE]);
        if (looked_at[TO_NEXT]) {
            sample_node(f, box, brick, local, axis, 1, next);
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
static iso_status estimate_brick(const estimator *e, uint8_t *levels, size_t index, float *room, float *errors)
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
    long first[3];
    for (int a = 0; a < 3; ++a)
        first[a] = (long)(brick[a] * side) - 1;
    const fine_box box = {side + 3, room};
    NEED(iso_node_levels_read(n, first, (const size_t[3]){side + 3, side + 3, side + 3}, room, NULL));
    for (size_t quarter = 0; quarter < QUARTERS && !shows; ++quarter)
        for (size_t z = 0; z <= side; ++z)
            for (size_t y = 0; y <= side; ++y)
                for (size_t x = (y + 2 * z + quarter) % QUARTERS; x <= side; x += QUARTERS, ++count)
                    shows |= add_errors(e, &f, &box, &levels[index], brick, (const size_t[3]){x, y, z}, sum);
    /* A mean over the brick, times the voxels of a ray through it; no pixel is wrong by more than 1. */
    for (size_t l = 0; l < n->level_count; ++l)
        errors[l] = (float)fmin(1, sum[l] / (double)count * (double)side);
    levels[index] = 0;
    return ISO_OK;
}

/* Samples the scalar of level 0 at index coordinates, clamped to the volume's nodes. */
static double scalar_at(const iso_node_levels *n, iso_vec3 index)
{
    const double p[3] = {index.x - 0.5, index.y - 0.5, index.z - 0.5};
    size_t lo[3], count[3];
    double part[3], sum = 0;
    for (int a = 0; a < 3; ++a) {
        const double last = (double)(n->geometry.size[a] - 1), q = p[a] > 0 ? (p[a] < last ? p[a] : last) : 0;
        lo[a] = (size_t)q;
        part[a] = q - (double)lo[a];
        count[a] = part[a] > 0 ? 2 : 1;
    }
    for (size_t z = 0; z < count[2]; ++z)
        for (size_t y = 0; y < count[1]; ++y) {
            float row[2];
            iso_node_levels_voxels(n, lo[0], lo[1] + y, lo[2] + z, count[0], row);
            for (size_t x = 0; x < count[0]; ++x)
                sum += (x ? part[0] : 1 - part[0]) * (y ? part[1] : 1 - part[1]) * (z ? part[2] : 1 - part[2]) *
                       (double)row[x];
        }
    return sum;
}

/* Adds T^2 once to each brick that a ray through the finest level enters, where T is the transmittance there. */
static void trace(const iso_node_levels *n, const iso_view *view, const iso_ray *ray, const uint8_t *shown,
                  double *seen)
{
    double t0, t1, step = iso_geometry_min_spacing_mm(&n->geometry), transmittance = 1;
    size_t last = SIZE_MAX;
    if (!iso_view_ray(view, ray, &n->geometry, &t0, &t1))
        return;
    for (double t = t0 + 0.5 * step; t < t1 && transmittance >= ISO_PLAN_HIDDEN; t += step) {
        iso_vec3 p = iso_geometry_to_index(&n->geometry, iso_madd(ray->origin, ray->direction, t));
        const double index[3] = {p.x - 0.5, p.y - 0.5, p.z - 0.5};
        double entry[4];
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
        iso_tf_lookup(&view->tf, scalar_at(n, p), entry);
        transmittance *= exp(-entry[3] * step);
    }
}

/* Sends rays through every `stride`-th pixel, so that the smallest brick meets several. A brick counts stride^2 pixels
 * per ray through it. */
static iso_status find_footprints(const iso_plan_errors *plan, const iso_node_levels *n, const iso_view *view,
                                  const uint8_t *shown, int threads, float *footprints, iso_error *err)
{
    size_t larger = view->width > view->height ? view->width : view->height, stride = (larger + 255) / 256;
    size_t columns = (view->width + stride - 1) / stride, rows = (view->height + stride - 1) / stride;
    const iso_progress *progress = iso_progress_current();
    double *seen = calloc(plan->brick_count * rows, sizeof *seen);
    NEED_MEMORY(seen, err, "plan: no memory for the footprints of %zu bricks", plan->brick_count);
#pragma omp parallel for schedule(dynamic) num_threads(iso_threads(threads))
    for (size_t row = 0; row < rows; ++row)
        for (size_t column = 0; column < columns && !iso_progress_poll(progress); ++column) {
            size_t x = column * stride + stride / 2, y = row * stride + stride / 2;
            iso_ray ray = iso_camera_ray(&view->camera, view->width, view->height,
                                         x < view->width ? x : view->width - 1,
                                         y < view->height ? y : view->height - 1);
            trace(n, view, &ray, shown, seen + row * plan->brick_count);
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

/* Adds the errors of the bricks that a view sees. */
static iso_status add_errors_of_view(iso_plan_errors *plan, const estimator *e, const float *footprints,
                                     const uint8_t *shown, int threads, iso_error *err)
{
    const size_t side = e->nodes->brick_voxels + 3, levels = plan->level_count;
    const iso_progress *progress = iso_progress_current();
    bool failed = false;
#pragma omp parallel num_threads(iso_threads(threads)) reduction(|| : failed)
    {
        float *room = malloc(ISO_NODE_CHANNELS * side * side * side * sizeof *room);
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < plan->brick_count; ++i) {
            float errors[ISO_BRICK_MAX_LEVELS] = {0};
            plan->footprints[i] += footprints[i];
            if (footprints[i] <= 0 || !shown[i] || iso_progress_poll(progress))
                continue;
            plan->shown[i] = 1;
            failed = failed || !room || estimate_brick(e, plan->levels, i, room, errors) != ISO_OK;
            for (size_t l = 0; l < levels; ++l)
                plan->squares[i * levels + l] += footprints[i] * errors[l] * errors[l];
        }
        free(room);
    }
    return failed ? iso_fail(err, ISO_E_MEMORY, "plan: no memory for a brick of %zu nodes per side", side) : ISO_OK;
}

/* Adds what one view sees. */
static iso_status add_view(iso_plan_errors *plan, const iso_node_levels *n, const iso_view *view, uint8_t *shown,
                           float *footprints, int threads, iso_error *err)
{
    const iso_brick_field finest = {.nodes = n, .levels = plan->levels, .faces = ISO_FACES_OWN};
    iso_brick_cull(&finest, &view->tf, NULL, threads, shown);
    NEED(find_footprints(plan, n, view, shown, threads, footprints, err));
    double(*integral)[4] = integrate_tf(&view->tf);
    NEED_MEMORY(integral, err, "plan: no memory for %zu entries of a transfer function", view->tf.count);
    const estimator e = {n, view, (const double(*)[4])integral, iso_geometry_mean_spacing_mm(&n->geometry)};
    iso_status status = add_errors_of_view(plan, &e, footprints, shown, threads, err);
    free(integral);
    plan->pixel_count += (double)(view->width * view->height);
    return status;
}

iso_status iso_plan_errors_create(iso_plan_errors *plan, const iso_node_levels *n, const iso_view *views,
                                  size_t view_count, int threads, const iso_progress *progress, iso_error *err)
{
    size_t count = iso_brick_count(n);
    *plan = (iso_plan_errors){.brick_count = count, .level_count = n->level_count};
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
        iso_plan_errors_destroy(plan);
    return status;
}

void iso_plan_errors_destroy(iso_plan_errors *plan)
{
    if (!plan)
        return;
    free(plan->squares);
    free(plan->footprints);
    free(plan->levels);
    free(plan->shown);
    *plan = (iso_plan_errors){0};
}

/* ---- choice ------------------------------------------------------------------- */

/* Chooses the levels for one lambda; returns the predicted RMSE. */
static double choose_for(iso_plan_errors *plan, const iso_node_levels *n, double lambda)
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

double iso_plan_choose(iso_plan_errors *plan, const iso_node_levels *n, double rmse)
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
