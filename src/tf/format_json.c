/* SPDX-License-Identifier: MIT */
/* format_json.c - our own transfer functions (tf.h documents the file). */
#include "tf/format.h"

/* Refuses options that complete files of other programs: ours have all fields. */
static iso_status check_request(const iso_tf_file *file, iso_error *err)
{
    const iso_tf_request *q = file->request;
    const char *option = q->unit_mm > 0 ? "--unit-distance" : q->has_opacity ? "--opacity" : q->name ? "--name" : NULL;
    return option ? iso_fail(err, ISO_E_USAGE, "%s: %s is for the formats of other programs", file->path, option)
                  : ISO_OK;
}

static iso_status load_json(const iso_tf_file *file, iso_tf *tf, iso_error *err)
{
    json_auto_t *root = NULL;
    NEED(iso_json_parse(file->path, file->text, file->size, &root, err));
    NEED(check_request(file, err));
    return iso_tf_from_json(root, file->path, tf, err);
}

static iso_status save_json(const iso_tf_output *output, const char *path, iso_error *err)
{
    return iso_tf_save(output->tf, path, err);
}

const iso_tf_format iso_tf_format_json = {
    .name = "json",
    .summary = "isoshade's own format: points with value, color and opacity",
    .suffix = ".tf.json",
    .also = ".json",
    .marks = {"\"isoshade.tf/"},
    .load = load_json,
    .save = save_json,
};
