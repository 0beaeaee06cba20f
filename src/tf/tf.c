/* SPDX-License-Identifier: MIT */
#include "tf/tf.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tf/color_space.h"

#define EXAMPLE_POINT "{\"value\": 0, \"r\": 1, \"g\": 0.5, \"b\": 0, \"opacity\": 0.2}"

static void read_point(iso_json_reader *r, const json_t *item, bool srgb, iso_tf_point *p)
{
    static const char *const keys[] = {"value", "r", "g", "b", "opacity", NULL};
    if (!json_is_object(item)) {
        TRY(r->status, iso_fail(r->err, ISO_E_FORMAT, "%s: an entry of \"points\" is not an object", r->path));
        return;
    }
    iso_json_only_keys(r, item, "a point", keys);
    iso_json_need_keys(r, item, "a point", keys, EXAMPLE_POINT);
    iso_json_get_number(r, item, "value", true, -ISO_TF_MOST_VALUE, ISO_TF_MOST_VALUE, &p->value);
    for (int c = 0; c < 3; ++c) {
        iso_json_get_number(r, item, keys[1 + c], true, 0, 1, &p->rgb_linear[c]);
        if (srgb)
            p->rgb_linear[c] = iso_srgb_to_linear(p->rgb_linear[c]);
    }
    iso_json_get_number(r, item, "opacity", true, 0, 1, &p->opacity);
}

static void read_points(iso_json_reader *r, const json_t *object, bool srgb, iso_tf *tf)
{
    json_t *list = iso_json_get_array(r, object, "points", true);
    if (!list)
        return;
    tf->point_count = json_array_size(list);
    if (tf->point_count < 1 || tf->point_count > 65536) {
        r->status = iso_fail(r->err, ISO_E_RANGE, "%s: the transfer function has %zu points, must have 1 to 65536",
                             r->path, tf->point_count);
        return;
    }
    tf->points = calloc(tf->point_count, sizeof *tf->points);
    if (!tf->points) {
        r->status = iso_fail(r->err, ISO_E_MEMORY, "%s: no memory for %zu points", r->path, tf->point_count);
        return;
    }
    for (size_t i = 0; i < tf->point_count; ++i) {
        read_point(r, json_array_get(list, i), srgb, &tf->points[i]);
        if (r->status == ISO_OK && i > 0 && tf->points[i].value < tf->points[i - 1].value)
            r->status = iso_fail(r->err, ISO_E_RANGE,
                                 "%s: point %zu has value %g below its predecessor's %g; values must ascend", r->path,
                                 i, tf->points[i].value, tf->points[i - 1].value);
    }
}

static void read_range(iso_json_reader *r, const json_t *object, iso_tf *tf)
{
    const char *word = json_string_value(json_object_get(object, "range"));
    if (word && strcmp(word, "fit") == 0) {
        tf->fit_range = true;
        return;
    }
    if (word && r->status == ISO_OK)
        r->status = iso_fail(r->err, ISO_E_FORMAT, "%s: \"range\" is \"%.40s\", must be [lo, hi] or \"fit\"", r->path,
                             word);
    iso_json_get_numbers(r, object, "range", true,
                         &(iso_json_list){tf->range, 2, -ISO_TF_MOST_VALUE, ISO_TF_MOST_VALUE});
    if (r->status == ISO_OK && !(tf->range[1] > tf->range[0]))
        r->status = iso_fail(r->err, ISO_E_RANGE, "%s: \"range\" is [%g, %g], the end must exceed the start", r->path,
                             tf->range[0], tf->range[1]);
}

iso_status iso_tf_from_json(const json_t *object, const char *path, iso_tf *tf, iso_error *err)
{
    static const char *const keys[] = {
        "schema",     "comment", "range", "unit_distance_mm", "unit_distance_voxels", "color_space",
        "table_size", "points",  NULL};
    static const char *const schemas[] = {"isoshade.tf/1", NULL};
    static const char *const spaces[] = {"linear", "srgb", NULL};
    iso_json_reader r = {.path = path, .err = err};
    int schema = 0, space = 0;
    *tf = (iso_tf){.table_size = 256};
    tf->unit_is_voxels = json_object_get(object, "unit_distance_voxels") != NULL;
    const char *const unit = tf->unit_is_voxels ? "unit_distance_voxels" : "unit_distance_mm";
    const char *const needed[] = {"schema", "range", unit, "color_space", "points", NULL};
    iso_json_only_keys(&r, object, "the transfer function", keys);
    iso_json_get_word(&r, object, "schema", false, schemas, &schema);
    iso_json_need_keys(&r, object, "the transfer function", needed,
                       "{\"schema\": \"isoshade.tf/1\", \"range\": \"fit\", \"unit_distance_mm\": 1, "
                       "\"color_space\": \"srgb\", \"points\": [" EXAMPLE_POINT "]}");
    iso_json_get_word(&r, object, "color_space", true, spaces, &space);
    iso_json_get_size(&r, object, "table_size", false, 2, ISO_TF_MOST_ENTRIES, &tf->table_size);
    read_range(&r, object, tf);
    if (tf->unit_is_voxels && json_object_get(object, "unit_distance_mm") && r.status == ISO_OK)
        r.status = iso_fail(err, ISO_E_FORMAT,
                            "%s: has both \"unit_distance_mm\" and \"unit_distance_voxels\"; remove one", path);
    iso_json_get_number(&r, object, unit, true, ISO_TF_LEAST_UNIT, ISO_TF_MOST_UNIT, &tf->unit_distance);
    read_points(&r, object, space == 1, tf);
    if (r.status != ISO_OK)
        iso_tf_destroy(tf);
    return r.status;
}

json_t *iso_tf_to_json(const iso_tf *tf)
{
    json_t *points = json_array();
    for (size_t i = 0; i < tf->point_count; ++i) {
        const iso_tf_point *p = &tf->points[i];
        json_array_append_new(points, json_pack("{s:f, s:f, s:f, s:f, s:f}", "value", p->value, "r", p->rgb_linear[0],
                                                "g", p->rgb_linear[1], "b", p->rgb_linear[2], "opacity", p->opacity));
    }
    return json_pack("{s:s, s:o, s:f, s:s, s:I, s:o}", "schema", "isoshade.tf/1", "range",
                     tf->fit_range ? json_string("fit") : iso_json_numbers(tf->range, 2),
                     tf->unit_is_voxels ? "unit_distance_voxels" : "unit_distance_mm", tf->unit_distance, "color_space",
                     "linear", "table_size", (json_int_t)tf->table_size, "points", points);
}

iso_status iso_tf_save_json(const json_t *root, const char *path, iso_error *err)
{
    OWNED(iso_tf) read = {0};
    NEED(root ? iso_tf_from_json(root, path, &read, err)
              : iso_fail(err, ISO_E_MEMORY, "%s: no memory for a transfer function", path));
    return iso_json_save(path, root, err);
}

iso_status iso_tf_save(const iso_tf *tf, const char *path, iso_error *err)
{
    json_auto_t *root = iso_tf_to_json(tf);
    return iso_tf_save_json(root, path, err);
}

iso_status iso_tf_copy(const iso_tf *from, iso_tf *to, iso_error *err)
{
    *to = *from;
    to->points = malloc(from->point_count * sizeof *to->points);
    if (!to->points) {
        *to = (iso_tf){0};
        return iso_fail(err, ISO_E_MEMORY, "no memory for %zu points of a transfer function", from->point_count);
    }
    memcpy(to->points, from->points, from->point_count * sizeof *to->points);
    return ISO_OK;
}

void iso_tf_destroy(iso_tf *tf)
{
    if (!tf)
        return;
    free(tf->points);
    *tf = (iso_tf){0};
}

/* Interpolates color and opacity of the points at a value: linear, constant beyond the ends. */
static void sample_points(const iso_tf *tf, double value, double rgba[4])
{
    const iso_tf_point *p = tf->points;
    size_t above = 0; /* number of points not above the value */
    for (size_t end = tf->point_count; above < end;) {
        const size_t middle = above + (end - above) / 2;
        if (p[middle].value <= value)
            above = middle + 1;
        else
            end = middle;
    }
    const iso_tf_point *lo = &p[above > 0 ? above - 1 : 0];
    const iso_tf_point *hi = &p[above < tf->point_count ? above : tf->point_count - 1];
    double span = hi->value - lo->value;
    double f = span > 0 ? fmin(fmax((value - lo->value) / span, 0), 1) : 0;
    for (int c = 0; c < 3; ++c)
        rgba[c] = (1 - f) * lo->rgb_linear[c] + f * hi->rgb_linear[c];
    rgba[3] = (1 - f) * lo->opacity + f * hi->opacity;
}

/* Returns a point whose opacity is far above or below that of both adjacent entries: a peak narrower than an entry,
 * which the table would not show. Never a step: its two sides are in these entries. NULL: none. */
static const iso_tf_point *find_lost(const iso_tf *tf, const iso_tf_table *t)
{
    static const double much = 0.25;
    const double span = tf->fit_range ? 1 : t->hi - t->lo, begin = tf->fit_range ? 0 : t->lo,
                 step = span / (double)(t->count - 1);
    for (size_t i = 0; i < tf->point_count; ++i) {
        const double entry = floor((tf->points[i].value - begin) / step), opacity = tf->points[i].opacity;
        double a[4], b[4];
        if (!(entry >= 0 && entry + 1 < (double)t->count))
            continue;
        sample_points(tf, begin + step * entry, a);
        sample_points(tf, begin + step * (entry + 1), b);
        if (opacity > fmax(a[3], b[3]) + much || opacity < fmin(a[3], b[3]) - much)
            return &tf->points[i];
    }
    return NULL;
}

/* Keeps the TF's points with the table if they are few. */
static void keep_points(const iso_tf *tf, double unit_mm, iso_tf_table *t)
{
    t->unit_mm = unit_mm;
    t->point_count = tf->point_count <= ISO_TF_FEW_POINTS ? tf->point_count : 0;
    for (size_t i = 0; i < t->point_count; ++i) {
        t->points[i] = tf->points[i];
        if (tf->fit_range)
            t->points[i].value = t->lo + tf->points[i].value * (t->hi - t->lo);
    }
}

static iso_status tabulate(const iso_tf *tf, double value_min, double value_max, const iso_geometry *level0,
                           iso_tf_table *table, iso_error *err)
{
    *table = (iso_tf_table){.count = tf->table_size, .lo = tf->range[0], .hi = tf->range[1]};
    if (tf->point_count == 0)
        return iso_fail(err, ISO_E_RANGE, "the transfer function has no points");
    if (tf->fit_range) {
        if (!isfinite(value_min) || !isfinite(value_max))
            return iso_fail(err, ISO_E_RANGE, "cannot fit the transfer function to the range %g to %g", value_min,
                            value_max);
        table->lo = value_min;
        /* A constant volume: any range that starts at its value will do. */
        table->hi = value_max > value_min ? value_max : value_min + fmax(1, fabs(value_min));
    }
    const iso_tf_point *lost = find_lost(tf, table);
    if (lost)
        return iso_fail(
            err, ISO_E_RANGE,
            "the transfer function's point at %g with opacity %.3g is lost between two of its table's %zu entries "
            "over %g to %g; use a larger \"table_size\" (at most %d) or a narrower \"range\"",
            lost->value, lost->opacity, table->count, table->lo, table->hi, ISO_TF_MOST_ENTRIES);
    double unit_mm = tf->unit_distance * (tf->unit_is_voxels ? iso_geometry_mean_spacing_mm(level0) : 1);
    table->entries = malloc(table->count * 4 * sizeof *table->entries);
    NEED_MEMORY(table->entries, err, "no memory for a transfer function of %zu entries", table->count);
    for (size_t i = 0; i < table->count; ++i) {
        double t = (double)i / (double)(table->count - 1), rgba[4];
        sample_points(tf, tf->fit_range ? t : table->lo + t * (table->hi - table->lo), rgba);
        for (int c = 0; c < 3; ++c)
            table->entries[4 * i + (size_t)c] = (float)rgba[c];
        const double extinction = -log1p(-fmin(rgba[3], ISO_TF_MAX_OPACITY)) / unit_mm;
        if (!(extinction <= ISO_TF_MOST_EXTINCTION)) {
            iso_tf_table_destroy(table);
            return iso_fail(err, ISO_E_RANGE, "the transfer function's opacities are for %g mm, must be %g or more",
                            unit_mm, ISO_TF_LEAST_UNIT);
        }
        table->entries[4 * i + 3] = (float)extinction;
    }
    keep_points(tf, unit_mm, table);
    return ISO_OK;
}

iso_status iso_tf_table_end_below(iso_tf_table *t, double value_min, iso_error *err)
{
    if (!(t->entries[3] > 0) || t->count >= ISO_TF_MOST_ENTRIES)
        return ISO_OK;
    const double step = (t->hi - t->lo) / (double)(t->count - 1), room = (double)(ISO_TF_MOST_ENTRIES - t->count - 1);
    const size_t more = 1 + (size_t)fmin(fmax(ceil((t->lo - value_min) / step), 0), room);
    float *entries = malloc(4 * (t->count + more) * sizeof *entries);
    NEED_MEMORY(entries, err, "no memory for a transfer function of %zu entries", t->count + more);
    memcpy(entries + 4 * more, t->entries, 4 * t->count * sizeof *entries);
    for (size_t i = 0; i < more; ++i)
        memcpy(entries + 4 * i, t->entries, 4 * sizeof *entries);
    entries[3] = 0;
    free(t->entries);
    t->entries = entries;
    t->lo -= step * (double)more;
    t->count += more;
    t->point_count = 0; /* the points do not say it */
    return ISO_OK;
}

iso_status iso_tf_tabulate(const iso_tf *tf, double value_min, double value_max, const iso_geometry *level0,
                           iso_tf_table *table, iso_error *err)
{
    iso_status status = tabulate(tf, value_min, value_max, level0, table, err);
    if (status == ISO_OK && level0->has_no_data)
        status = iso_tf_table_end_below(table, value_min, err);
    return status == ISO_OK || !tf->of[0] ? status : iso_fail_in(err, status, "%s", tf->of);
}

iso_status iso_tf_table_copy(const iso_tf_table *from, iso_tf_table *to, iso_error *err)
{
    *to = *from;
    to->entries = malloc(4 * from->count * sizeof *to->entries);
    if (!to->entries) {
        *to = (iso_tf_table){0};
        return iso_fail(err, ISO_E_MEMORY, "no memory for %zu entries of a transfer function", from->count);
    }
    memcpy(to->entries, from->entries, 4 * from->count * sizeof *to->entries);
    return ISO_OK;
}

bool iso_tf_table_equals(const iso_tf_table *a, const iso_tf_table *b)
{
    return a->count == b->count && a->lo == b->lo && a->hi == b->hi &&
           memcmp(a->entries, b->entries, 4 * a->count * sizeof *a->entries) == 0;
}

void iso_tf_table_destroy(iso_tf_table *table)
{
    if (!table)
        return;
    free(table->entries);
    *table = (iso_tf_table){0};
}
