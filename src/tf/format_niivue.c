/* SPDX-License-Identifier: MIT */
/* format_niivue.c - color maps of NiiVue and MRIcroGL: bytes R, G, B, A at places I of 0 to 255. */
#include <math.h>
#include <stdlib.h>

#include "tf/format.h"

enum { MOST_ENTRIES = 4096 };
typedef struct bytes {
    size_t count;
    double r[MOST_ENTRIES], g[MOST_ENTRIES], b[MOST_ENTRIES], a[MOST_ENTRIES], place[MOST_ENTRIES];
} bytes;

/* Reads bytes, as many as R has. False if the key is missing. */
static bool read_bytes(iso_json_reader *r, const json_t *root, const char *key, bool required, size_t count,
                       double *values)
{
    iso_json_get_numbers(r, root, key, required, &(iso_json_list){values, count, 0, 255});
    return r->status == ISO_OK && json_object_get(root, key);
}

static void read_lists(iso_json_reader *r, const json_t *root, bytes *b, iso_tf_curves *c)
{
    double lo = 0, hi = 0;
    b->count = json_array_size(iso_json_get_array(r, root, "R", true));
    if (r->status == ISO_OK && (b->count < 2 || b->count > MOST_ENTRIES))
        r->status = iso_fail(r->err, ISO_E_RANGE, "%s: \"R\" has %zu entries, must have 2 to %d", r->path, b->count,
                             (int)MOST_ENTRIES);
    if (r->status != ISO_OK)
        return;
    read_bytes(r, root, "R", true, b->count, b->r);
    read_bytes(r, root, "G", true, b->count, b->g);
    read_bytes(r, root, "B", true, b->count, b->b);
    const bool has_opacity = read_bytes(r, root, "A", false, b->count, b->a);
    if (!read_bytes(r, root, "I", false, b->count, b->place))
        for (size_t i = 0; i < b->count; ++i)
            b->place[i] = 255.0 * (double)i / (double)(b->count - 1);
    iso_json_get_number(r, root, "min", false, -ISO_TF_MOST_VALUE, ISO_TF_MOST_VALUE, &lo);
    iso_json_get_number(r, root, "max", false, -ISO_TF_MOST_VALUE, ISO_TF_MOST_VALUE, &hi);
    c->are_fractions = !(hi > lo); /* NiiVue then takes the volume's own window */
    for (size_t i = 0; i < b->count && r->status == ISO_OK; ++i) {
        const double t = b->place[i] / 255, x = c->are_fractions ? t : lo + t * (hi - lo);
        r->status = iso_tf_curve_add_color(&c->color, x, (double[]){b->r[i] / 255, b->g[i] / 255, b->b[i] / 255},
                                           r->path, r->err);
        if (r->status == ISO_OK && has_opacity)
            r->status = iso_tf_curve_add_opacity(&c->opacity, x, b->a[i] / 255, r->path, r->err);
    }
}

static iso_status load_niivue(const iso_tf_file *file, iso_tf *tf, iso_error *err)
{
    json_auto_t *root = NULL;
    OWNED(iso_tf_curves) curves = {.unit_mm = 1, .unit_is_voxel = true, .unit_is_default = true};
    NEED(iso_json_parse(file->path, file->text, file->size, &root, err));
    iso_json_reader r = {.path = file->path, .err = err};
    FREED bytes *b = malloc(sizeof *b);
    NEED_MEMORY(b, err, "%s: out of memory", file->path);
    if (json_object_get(root, "labels"))
        return iso_fail(err, ISO_E_FORMAT, "%s: is a map of labels (\"labels\"), must be one of values", file->path);
    read_lists(&r, root, b, &curves);
    NEED(r.status);
    return iso_tf_take_curves(file, &curves, tf, err);
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static json_t *byte_of(double fraction)
{
    return json_integer((json_int_t)lrint(255 * fraction));
}

static iso_status save_niivue(const iso_tf_output *output, const char *path, iso_error *err)
{
    const iso_tf_table *table = output->table;
    const double unit_mm = output->unit_mm;
    OWNED(iso_tf_curves) c = {0};
    NEED(iso_tf_reduce(table, unit_mm, 256, 0.5 / 255, &c, err));
    json_t *lists[5];
    for (int k = 0; k < 5; ++k)
        lists[k] = json_array();
    for (size_t i = 0; i < c.color.count; ++i) { /* on a grid the two curves have the same nodes */
        const iso_tf_node *color = &c.color.nodes[i];
        for (int k = 0; k < 3; ++k)
            json_array_append_new(lists[k], byte_of(color->y[k]));
        json_array_append_new(lists[3], byte_of(c.opacity.nodes[i].y[0]));
        json_array_append_new(lists[4], byte_of((color->x - table->lo) / (table->hi - table->lo)));
    }
    json_auto_t *root = json_pack("{s:f, s:f, s:o, s:o, s:o, s:o, s:o}", "min", table->lo, "max", table->hi, "R", lists[0],
                             "G", lists[1], "B", lists[2], "A", lists[3], "I", lists[4]);
    return iso_json_save(path, root, err);
}

const iso_tf_format iso_tf_format_niivue = {
    .name = "niivue",
    .summary = "a color map of NiiVue or MRIcroGL: bytes, opacity per voxel",
    .suffix = ".niivue.json",
    .also = ".json",
    .marks = {"\"R\"", "\"G\"", "\"B\""},
    .has_all_marks = true,
    .load = load_niivue,
    .save = save_niivue,
    .is_per_voxel = true,
    .needs_range = true,
};
