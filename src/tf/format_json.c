/* SPDX-License-Identifier: MIT */
/* format_json.c - our own transfer functions (tf.h says what a file holds). */
#include "tf/adapt.h"
#include "tf/format.h"

static iso_status load_json(const char *path, iso_tf *tf, iso_error *err)
{
    json_t *root;
    *tf = (iso_tf){0};
    iso_status status = iso_json_load(path, &root, err);
    if (status != ISO_OK)
        return status;
    status = iso_tf_from_json(root, path, tf, err);
    json_decref(root);
    return status;
}

static iso_status save_json(const iso_tf_table *table, double unit_mm, const char *path, iso_error *err)
{
    iso_tf tf = {0};
    (void)unit_mm; /* the points' own unit comes from the table */
    iso_status status = iso_tf_from_table(table, &tf, err);
    if (status == ISO_OK)
        status = iso_tf_save(&tf, path, err);
    iso_tf_destroy(&tf);
    return status;
}

const iso_tf_format iso_tf_format_json = {
    .name = "json",
    .summary = "isoshade's own: points of value, color and opacity; converted, an entry a point",
    .suffix = ".tf.json",
    .load = load_json,
    .save = save_json,
};
