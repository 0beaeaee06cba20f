/* SPDX-License-Identifier: MIT */
/* resample.c - conversion of curves of display colors to points of linear light, and the error of that. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tf/curves.h"

/* Largest distance of a line from a curve, in display color and opacity: well below a step of 8 bits. */
static const double closest = 1.0 / 2048;
enum { DEEPEST = 10, MOST_POINTS = 65536, LARGEST_TABLE = 4096 };

typedef struct resampling {
    const iso_tf_curves *curves;
    const char *path;
    iso_tf *tf;
    size_t capacity;
    iso_error *err;
} resampling;

/* Evaluates the curves at x on the side of `inside`: display color and opacity. */
static void look_up(const iso_tf_curves *c, double x, double inside, double rgba[4])
{
    iso_tf_curve_color(&c->color, c->space, x, inside, rgba);
    rgba[3] = iso_tf_curve_opacity(&c->opacity, x, inside);
}

static iso_tf_point point_at(const iso_tf_curves *c, double x, double inside)
{
    double rgba[4];
    look_up(c, x, inside, rgba);
    return (iso_tf_point){x,
                          {iso_srgb_to_linear(rgba[0]), iso_srgb_to_linear(rgba[1]), iso_srgb_to_linear(rgba[2])},
                          rgba[3]};
}

static bool are_equal(const iso_tf_point *a, const iso_tf_point *b)
{
    bool alike = fabs(a->opacity - b->opacity) < 1e-12;
    for (int c = 0; c < 3; ++c)
        alike = alike && fabs(a->rgb_linear[c] - b->rgb_linear[c]) < 1e-12;
    return alike;
}

static iso_status append(resampling *r, const iso_tf_point *p)
{
    iso_tf *tf = r->tf;
    if (tf->point_count && tf->points[tf->point_count - 1].value == p->value &&
        are_equal(&tf->points[tf->point_count - 1], p))
        return ISO_OK;
    if (tf->point_count == MOST_POINTS)
        return iso_fail(r->err, ISO_E_RANGE, "%s: its curves need more than %d points", r->path, (int)MOST_POINTS);
    if (tf->point_count == r->capacity) {
        const size_t capacity = r->capacity ? 2 * r->capacity : 64;
        iso_tf_point *points = realloc(tf->points, capacity * sizeof *points);
        if (!points)
            return iso_fail(r->err, ISO_E_MEMORY, "%s: no memory for %zu points", r->path, capacity);
        tf->points = points, r->capacity = capacity;
    }
    tf->points[tf->point_count++] = *p;
    return ISO_OK;
}

/* Returns the distance between the line from a to b and the curves at its fraction t. */
static double distance(const iso_tf_curves *c, const iso_tf_point *a, const iso_tf_point *b, double t)
{
    const double x = a->value + t * (b->value - a->value);
    double rgba[4], most;
    look_up(c, x, x, rgba);
    most = fabs((1 - t) * a->opacity + t * b->opacity - rgba[3]);
    for (int i = 0; i < 3; ++i)
        most = fmax(most, fabs(iso_linear_to_srgb((1 - t) * a->rgb_linear[i] + t * b->rgb_linear[i]) - rgba[i]));
    return most;
}

/* Appends points between a and b until the lines are close enough; the caller appends a and b. */
static iso_status fill(resampling *r, const iso_tf_point *a, const iso_tf_point *b, int depth)
{
    bool close = true;
    for (int i = 1; i < 8 && close; ++i)
        close = distance(r->curves, a, b, i / 8.0) <= closest;
    const double x = 0.5 * (a->value + b->value);
    if (close || depth == DEEPEST || !(x > a->value && x < b->value))
        return ISO_OK;
    const iso_tf_point middle = point_at(r->curves, x, x);
    NEED(fill(r, a, &middle, depth + 1));
    NEED(append(r, &middle));
    return fill(r, &middle, b, depth + 1);
}

/* Drops points on the line between their neighbors: mostly midpoints of straight segments. */
static void drop_needless(iso_tf *tf)
{
    size_t kept = tf->point_count ? 1 : 0;
    for (size_t i = 1; i < tf->point_count; ++i) {
        const iso_tf_point *before = &tf->points[kept - 1], *p = &tf->points[i], *next = p + 1;
        bool needed = i + 1 == tf->point_count || p->value == before->value || p->value == next->value;
        if (!needed) {
            const double t = (p->value - before->value) / (next->value - before->value);
            needed = fabs((1 - t) * before->opacity + t * next->opacity - p->opacity) > 1e-9;
            for (int k = 0; k < 3; ++k)
                needed = needed ||
                         fabs((1 - t) * before->rgb_linear[k] + t * next->rgb_linear[k] - p->rgb_linear[k]) > 1e-9;
        }
        if (needed)
            tf->points[kept++] = *p;
    }
    tf->point_count = kept;
}

/* True if the end can be dropped: it is constant or invisible. A smaller range has finer entries. */
static bool is_needless(const iso_tf_point *end, const iso_tf_point *next)
{
    return are_equal(end, next) || (end->opacity == 0 && next->opacity == 0);
}

static void trim(iso_tf *tf)
{
    size_t first = 0, last = tf->point_count - 1;
    while (first + 1 < last && is_needless(&tf->points[first], &tf->points[first + 1]))
        ++first;
    while (last > first + 1 && is_needless(&tf->points[last], &tf->points[last - 1]))
        --last;
    if (!(tf->points[last].value > tf->points[first].value))
        return;
    tf->point_count = last - first + 1;
    memmove(tf->points, tf->points + first, tf->point_count * sizeof *tf->points);
}

/* Sets the range. Steps take the value after them, so before a step at the start the range gets one entry more. */
static void set_range(iso_tf *tf)
{
    const iso_tf_point *first = tf->points, *last = &tf->points[tf->point_count - 1];
    tf->range[0] = first->value, tf->range[1] = last->value;
    if (!tf->fit_range && first[1].value == first->value)
        tf->range[0] -= (tf->range[1] - tf->range[0]) / (LARGEST_TABLE - 2);
}

/* Returns the number of entries. Points at equal distances are already a table. */
static size_t table_size(const iso_tf *tf)
{
    const size_t n = tf->point_count;
    const double lo = tf->range[0], step = (tf->points[n - 1].value - lo) / (double)(n - 1);
    bool even = n >= 16 && n <= LARGEST_TABLE && !tf->fit_range;
    for (size_t i = 1; i < n && even; ++i)
        even = fabs(tf->points[i].value - lo - step * (double)i) <= 1e-6 * step;
    return even ? n : LARGEST_TABLE;
}

static iso_status between_corners(resampling *r, const double *corners, size_t count)
{
    /* Beyond the ends the curves may have other values: this makes steps at the first and the last corner. */
    const iso_tf_point before = point_at(r->curves, corners[0], -INFINITY);
    const iso_tf_point after = point_at(r->curves, corners[count - 1], INFINITY);
    NEED(append(r, &before));
    for (size_t i = 0; i + 1 < count; ++i) {
        const double inside = 0.5 * (corners[i] + corners[i + 1]);
        const iso_tf_point a = point_at(r->curves, corners[i], inside), b = point_at(r->curves, corners[i + 1], inside);
        NEED(append(r, &a));
        NEED(fill(r, &a, &b, 0));
        NEED(append(r, &b));
    }
    return append(r, &after);
}

iso_status iso_tf_resample(const iso_tf_curves *curves, const char *path, iso_tf *tf, iso_error *err)
{
    resampling r = {curves, path, tf, 0, err};
    size_t count = 0;
    *tf = (iso_tf){.fit_range = curves->are_fractions,
                   .unit_distance = curves->unit_mm,
                   .unit_is_voxels = curves->unit_is_voxel};
    double *corners = iso_tf_curves_corners(curves, &count);
    NEED_MEMORY(corners, err, "%s: out of memory", path);
    iso_status status = count < 2 ? iso_fail(err, ISO_E_RANGE, "%s: all points are at one value", path)
                                  : between_corners(&r, corners, count);
    free(corners);
    if (status == ISO_OK) {
        drop_needless(tf);
        if (!tf->fit_range)
            trim(tf);
        set_range(tf);
        tf->table_size = table_size(tf);
    } else {
        iso_tf_destroy(tf);
    }
    return status;
}

/* Compares the rendered table with the curves at x; raises *color and *opacity to the largest differences. */
static void compare(const iso_tf_curves *c, const iso_tf_table *t, double unit, double x, double *color,
                    double *opacity)
{
    double seen[4], ours[4];
    look_up(c, x, x, seen);
    iso_tf_lookup(t, x, ours);
    for (int a = 0; a < 3; ++a)
        *color = fmax(*color, fabs(iso_linear_to_srgb(ours[a]) - seen[a]));
    *opacity = fmax(*opacity, fabs(-expm1(-ours[3] * unit) - fmin(seen[3], ISO_TF_MAX_OPACITY)));
}

iso_status iso_tf_measure_loss(const iso_tf_curves *c, iso_tf *tf, iso_error *err)
{
    const iso_geometry unit = iso_geometry_axis_aligned((size_t[]){1, 1, 1}, (double[]){1, 1, 1});
    OWNED(iso_tf_table) t = {0};
    iso_tf_loss *loss = &tf->loss;
    NEED(iso_tf_tabulate(tf, 0, 1, &unit, &t, err));
    enum { BETWEEN = 4 };
    *loss = (iso_tf_loss){.measured = true};
    for (size_t i = 0; i < t.count; ++i) {
        const double width = (t.hi - t.lo) / (double)(t.count - 1), x = t.lo + width * (double)i;
        compare(c, &t, tf->unit_distance, x, &loss->color, &loss->opacity);
        for (int k = 1; k < BETWEEN && i + 1 < t.count; ++k)
            compare(c, &t, tf->unit_distance, x + width * k / BETWEEN, &loss->between, &loss->between);
    }
    return ISO_OK;
}
