/* SPDX-License-Identifier: MIT */
#include "tf/curves.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"

enum { MOST_NODES = 65536 };

void iso_tf_curves_destroy(iso_tf_curves *curves)
{
    free(curves->color.nodes);
    free(curves->opacity.nodes);
    *curves = (iso_tf_curves){0};
}

static iso_status check_node(const iso_tf_node *node, int components, const char *path, iso_error *err)
{
    const char *what = components == 3 ? "color" : "opacity";
    const struct {
        const char *name;
        double value;
    } fractions[] = {{what, node->y[0]},
                     {what, node->y[components / 2]},
                     {what, node->y[components - 1]},
                     {"midpoint", node->midpoint},
                     {"sharpness", node->sharpness}};
    if (!(fabs(node->x) <= ISO_TF_MOST_VALUE))
        return iso_fail(err, ISO_E_RANGE, "%s: position of a node's %s is %g, must be %g to %g", path, what, node->x,
                        -ISO_TF_MOST_VALUE, ISO_TF_MOST_VALUE);
    for (size_t i = 0; i < sizeof fractions / sizeof *fractions; ++i)
        if (!(fractions[i].value >= 0 && fractions[i].value <= 1))
            return iso_fail(err, ISO_E_RANGE, "%s: at value %g the %s is %g, must be 0 to 1", path, node->x,
                            fractions[i].name, fractions[i].value);
    return ISO_OK;
}

iso_status iso_tf_curve_add(iso_tf_curve *curve, iso_tf_node node, int components, const char *path, iso_error *err)
{
    NEED(check_node(&node, components, path, err));
    if (curve->count == MOST_NODES)
        return iso_fail(err, ISO_E_RANGE, "%s: has more than %d points", path, (int)MOST_NODES);
    if (curve->count == curve->capacity) {
        const size_t capacity = curve->capacity ? 2 * curve->capacity : 16;
        iso_tf_node *nodes = realloc(curve->nodes, capacity * sizeof *nodes);
        NEED_MEMORY(nodes, err, "%s: no memory for %zu points", path, capacity);
        curve->nodes = nodes, curve->capacity = capacity;
    }
    curve->nodes[curve->count++] = node;
    return ISO_OK;
}

iso_status iso_tf_curve_add_color(iso_tf_curve *curve, double x, const double rgb[3], const char *path, iso_error *err)
{
    return iso_tf_curve_add(curve, (iso_tf_node){x, {rgb[0], rgb[1], rgb[2]}, 0.5, 0}, 3, path, err);
}

iso_status iso_tf_curve_add_opacity(iso_tf_curve *curve, double x, double opacity, const char *path, iso_error *err)
{
    return iso_tf_curve_add(curve, (iso_tf_node){x, {opacity}, 0.5, 0}, 1, path, err);
}

void iso_tf_curve_sort(iso_tf_curve *curve) /* insertion sort: files are nearly in order */
{
    for (size_t i = 1; i < curve->count; ++i) {
        const iso_tf_node node = curve->nodes[i];
        size_t at = i;
        for (; at > 0 && curve->nodes[at - 1].x > node.x; --at)
            curve->nodes[at] = curve->nodes[at - 1];
        curve->nodes[at] = node;
    }
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

/* Returns the midpoint, kept off the nodes as in VTK. */
static double midpoint_of(const iso_tf_node *node)
{
    return fmin(fmax(node->midpoint, 0.00001), 0.99999);
}

/* Returns the last node at or before `inside`; NULL if the curve is constant there, with *y its value. */
static const iso_tf_node *node_before(const iso_tf_curve *curve, double inside, const double **y)
{
    size_t lo = 0, hi = curve->count; /* nodes before lo are at or before it, those from hi on after */
    while (lo < hi) {
        const size_t middle = lo + (hi - lo) / 2;
        if (curve->nodes[middle].x <= inside)
            lo = middle + 1;
        else
            hi = middle;
    }
    *y = curve->nodes[lo == 0 ? 0 : curve->count - 1].y;
    return lo == 0 || lo == curve->count ? NULL : &curve->nodes[lo - 1];
}

/* Returns the position of x from the node (0) to the next (1), after VTK's midpoint and sharpness. At the midpoint the
 * side of `inside` counts. */
static double way(const iso_tf_node *node, double x, double inside)
{
    const double width = node[1].x - node->x, middle = midpoint_of(node), sharpness = node->sharpness;
    double s = fmin(fmax((x - node->x) / width, 0), 1);
    const bool before = (inside - node->x) / width < middle;
    s = before ? fmin(0.5 * s / middle, 0.5) : fmax(0.5 + 0.5 * (s - middle) / (1 - middle), 0.5);
    if (sharpness > 0.99)
        return before ? 0 : 1;
    if (sharpness < 0.01)
        return before ? fmin(s, 0.5 * (1 - 1e-15)) : s; /* stays below 1/2 for color spaces with a middle */
    return s < 0.5 ? 0.5 * pow(2 * s, 1 + 10 * sharpness) : 1 - 0.5 * pow(2 * (1 - s), 1 + 10 * sharpness);
}

void iso_tf_curve_color(const iso_tf_curve *curve, iso_color_space space, double x, double inside, double rgb[3])
{
    const double *constant;
    const iso_tf_node *node = node_before(curve, inside, &constant);
    if (!node || node->sharpness > 0.99) /* as VTK: one of the two colors, unconverted */
        memcpy(rgb, !node ? constant : node[way(node, x, inside) > 0.5].y, 3 * sizeof *rgb);
    else
        iso_color_mix(space, node->y, node[1].y, way(node, x, inside), node->sharpness, rgb);
}

double iso_tf_curve_opacity(const iso_tf_curve *curve, double x, double inside)
{
    const double *constant;
    const iso_tf_node *node = node_before(curve, inside, &constant);
    if (!node)
        return *constant;
    const double sharpness = node->sharpness > 0.99 ? 0 : node->sharpness;
    return fmin(fmax(iso_sharp_mix(*node->y, *node[1].y, way(node, x, inside), sharpness), 0), 1);
}

/* ---- corners ----------------------------------------------------------------------------------------------------- */

static size_t corners_of(const iso_tf_curve *curve, double *corners)
{
    size_t count = 0;
    for (size_t i = 0; i < curve->count; ++i) {
        const iso_tf_node *node = &curve->nodes[i];
        corners[count++] = node->x;
        if (i + 1 < curve->count && node[1].x > node->x)
            corners[count++] = node->x + midpoint_of(node) * (node[1].x - node->x);
    }
    return count;
}

double *iso_tf_curves_corners(const iso_tf_curves *curves, size_t *count)
{
    double *corners = malloc((2 * (curves->color.count + curves->opacity.count) + 1) * sizeof *corners);
    if (!corners)
        return NULL;
    size_t found = corners_of(&curves->color, corners);
    found += corners_of(&curves->opacity, corners + found);
    qsort(corners, found, sizeof *corners, iso_order_doubles);
    *count = 0;
    for (size_t i = 0; i < found; ++i)
        if (*count == 0 || corners[i] > corners[*count - 1])
            corners[(*count)++] = corners[i];
    return corners;
}
