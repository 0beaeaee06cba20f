/* SPDX-License-Identifier: MIT */
/* transfer.c - transfer functions of the library's interface. */
#include <math.h>
#include <stdlib.h>

#include "library/shared.h"
#include "tf/adapt.h"
#include "tf/presets.h"

/* Moves `from` into a new handle; *tf is NULL on failure. */
static iso_status keep(iso_status status, iso_tf *from, iso_tf **tf, iso_error *err)
{
    *tf = NULL;
    if (status != ISO_OK)
        return status;
    *tf = malloc(sizeof **tf);
    if (!*tf) {
        iso_tf_destroy(from);
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    }
    **tf = *from;
    return ISO_OK;
}

iso_status iso_tf_open(const char *path, iso_tf **tf, iso_error *err)
{
    iso_tf loaded;
    return keep(iso_tf_load(path, &loaded, err), &loaded, tf, err);
}

static bool is_fraction(double value)
{
    return value >= 0 && value <= 1;
}

static iso_status check_point(const iso_tf_point *points, size_t i, iso_error *err)
{
    const iso_tf_point *p = &points[i];
    if (!(fabs(p->value) <= ISO_TF_MOST_VALUE))
        return iso_fail(err, ISO_E_RANGE, "point %zu has the value %g, must be %g to %g", i, p->value,
                        -ISO_TF_MOST_VALUE, ISO_TF_MOST_VALUE);
    if (i > 0 && p->value < points[i - 1].value)
        return iso_fail(err, ISO_E_RANGE, "point %zu has the value %g below its predecessor's %g; values must rise", i,
                        p->value, points[i - 1].value);
    if (!is_fraction(p->rgb_linear[0]) || !is_fraction(p->rgb_linear[1]) || !is_fraction(p->rgb_linear[2]))
        return iso_fail(err, ISO_E_RANGE, "point %zu has the color (%g, %g, %g), each must be 0 to 1", i,
                        p->rgb_linear[0], p->rgb_linear[1], p->rgb_linear[2]);
    if (!is_fraction(p->opacity))
        return iso_fail(err, ISO_E_RANGE, "point %zu has the opacity %g, must be 0 to 1", i, p->opacity);
    return ISO_OK;
}

static iso_status check_points(const iso_tf_point *points, size_t count, double unit_mm, iso_error *err)
{
    if (count < 2 || count > 65536)
        return iso_fail(err, ISO_E_RANGE, "a transfer function of %zu points, must be 2 to 65536", count);
    if (!(unit_mm >= ISO_TF_LEAST_UNIT && unit_mm <= ISO_TF_MOST_UNIT))
        return iso_fail(err, ISO_E_RANGE, "opacities are for %g mm, must be %g to %g", unit_mm, ISO_TF_LEAST_UNIT,
                        ISO_TF_MOST_UNIT);
    for (size_t i = 0; i < count; ++i)
        NEED(check_point(points, i, err));
    if (!(points[count - 1].value > points[0].value))
        return iso_fail(err, ISO_E_RANGE, "all points have the value %g, must span a range", points[0].value);
    return ISO_OK;
}

iso_status iso_tf_from_points(const iso_tf_point *points, size_t count, double unit_mm, iso_tf **tf, iso_error *err)
{
    *tf = NULL;
    NEED(check_points(points, count, unit_mm, err));
    const iso_tf borrowed = {.point_count = count,
                             .points = (iso_tf_point *)points,
                             .range = {points[0].value, points[count - 1].value},
                             .unit_distance = unit_mm,
                             .table_size = 4096};
    iso_tf copy;
    return keep(iso_tf_copy(&borrowed, &copy, err), &copy, tf, err);
}

/* Makes the table that renderers of the pyramid look up. */
static iso_status tabulate(const iso_tf *tf, const iso_pyramid *p, iso_tf_table *table, iso_error *err)
{
    const iso_level *level0 = &p->levels[0];
    return iso_tf_tabulate(tf, iso_pyramid_lo(p), iso_pyramid_hi(p), &level0->geometry, table, err);
}

iso_status iso_tf_adapt(const iso_tf *tf, const iso_pyramid *pyramid, size_t level, iso_tf **adapted, iso_error *err)
{
    const iso_adapt_options o = iso_adapt_defaults();
    OWNED(iso_tf_table) original = {0}, table = {0};
    iso_tf made;
    *adapted = NULL;
    NEED(iso_pyramid_check_level(pyramid, NULL, level, err));
    if (level == 0)
        return keep(iso_tf_copy(tf, &made, err), &made, adapted, err);
    NEED(tabulate(tf, pyramid, &original, err));
    NEED(iso_adapt_level(pyramid, level, &original, &o, &table, NULL, err));
    return keep(iso_tf_from_table(&table, &made, err), &made, adapted, err);
}

iso_status iso_tf_evaluate(const iso_tf *tf, const iso_pyramid *pyramid, const double *values, size_t count,
                           double (*rgb_extinction)[4], iso_error *err)
{
    OWNED(iso_tf_table) table = {0};
    NEED(tabulate(tf, pyramid, &table, err));
    for (size_t i = 0; i < count; ++i)
        iso_tf_lookup(&table, values[i], rgb_extinction[i]);
    return ISO_OK;
}

iso_status iso_tf_suggest(const iso_pyramid *pyramid, const char *name, iso_tf **tf, iso_error *err)
{
    const iso_tf_request request = {0};
    iso_tf made;
    iso_status status = iso_tf_check_name(name, &request, err);
    TRY(status, iso_tf_of_level(name, &request, NULL, &pyramid->levels[0], 0, &made, err));
    return keep(status, &made, tf, err);
}

size_t iso_tf_points(const iso_tf *tf, iso_tf_point *points, size_t most)
{
    for (size_t i = 0; i < tf->point_count && i < most; ++i)
        points[i] = tf->points[i];
    return tf->point_count;
}

iso_status iso_tf_text(const iso_tf *tf, char **json, iso_error *err)
{
    return iso_text_of_json(iso_tf_to_json(tf), json, err);
}

iso_status iso_tf_from_text(const char *json, iso_tf **tf, iso_error *err)
{
    json_auto_t *root = NULL;
    iso_tf made;
    *tf = NULL;
    NEED(iso_json_of_text(json, "the transfer function", &root, err));
    return keep(iso_tf_from_json(root, "the transfer function", &made, err), &made, tf, err);
}

void iso_tf_free(iso_tf *tf)
{
    if (tf)
        iso_tf_destroy(tf);
    free(tf);
}
