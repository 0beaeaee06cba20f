/* SPDX-License-Identifier: MIT */
/* format_slicer.c - 3D Slicer's volume properties, NAME.vp.json (volume-property-schema-v1.0.0.json). */
#include <stdio.h>
#include <stdlib.h>

#include "tf/slicer.h"

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static void read_node(iso_json_reader *r, const json_t *item, int components, iso_tf_curve *curve)
{
    iso_tf_node node = {.midpoint = 0.5};
    iso_json_get_number(r, item, "x", true, -ISO_TF_MOST_VALUE, ISO_TF_MOST_VALUE, &node.x);
    if (components == 3)
        iso_json_get_numbers(r, item, "color", true, &(iso_json_list){node.y, 3, 0, 1});
    else
        iso_json_get_number(r, item, "y", true, 0, 1, &node.y[0]);
    iso_json_get_number(r, item, "midpoint", false, 0, 1, &node.midpoint);
    iso_json_get_number(r, item, "sharpness", false, 0, 1, &node.sharpness);
    TRY(r->status, iso_tf_curve_add(curve, node, components, r->path, r->err));
}

static void read_curve(iso_json_reader *r, const json_t *component, const char *key, int components,
                       iso_tf_curve *curve)
{
    const json_t *function = iso_json_get_object(r, component, key, false);
    const json_t *points = function ? iso_json_get_array(r, function, "points", true) : NULL;
    for (size_t i = 0; r->status == ISO_OK && i < json_array_size(points); ++i)
        read_node(r, json_array_get(points, i), components, curve);
}

static void refuse_gradient_opacity(iso_json_reader *r, const json_t *component)
{
    iso_tf_curve curve = {0};
    bool disabled = false;
    iso_json_get_bool(r, component, "disableGradientOpacity", false, &disabled);
    if (!disabled)
        read_curve(r, component, "gradientOpacity", 1, &curve);
    TRY(r->status,
        iso_slicer_check_gradient(&curve, ": set it to 1, or \"disableGradientOpacity\" to true", r->path, r->err));
    free(curve.nodes);
}

/* Reads a gray function as a color function with three equal components. */
static void read_gray(iso_json_reader *r, const json_t *component, iso_tf_curve *color)
{
    read_curve(r, component, "grayTransferFunction", 1, color);
    for (size_t i = 0; i < color->count; ++i)
        color->nodes[i].y[1] = color->nodes[i].y[2] = color->nodes[i].y[0];
}

static void read_component(iso_json_reader *r, const json_t *component, iso_tf_curves *c)
{
    c->unit_is_default = json_object_get(component, "scalarOpacityUnitDistance") == NULL;
    c->unit_mm = 1; /* Slicer's default */
    iso_json_get_number(r, component, "scalarOpacityUnitDistance", false, ISO_TF_LEAST_UNIT, ISO_TF_MOST_UNIT,
                        &c->unit_mm);
    if (r->status == ISO_OK && json_object_get(component, "transferFunction2D"))
        r->status = iso_fail(r->err, ISO_E_FORMAT,
                             "%s: \"transferFunction2D\" is not supported, only curves of one value", r->path);
    refuse_gradient_opacity(r, component);
    read_curve(r, component, "scalarOpacity", 1, &c->opacity);
    read_curve(r, component, "rgbTransferFunction", 3, &c->color);
    if (r->status == ISO_OK && c->color.count == 0)
        read_gray(r, component, &c->color);
    if (r->status == ISO_OK && c->color.count == 0)
        r->status = iso_fail(r->err, ISO_E_FORMAT,
                             "%s: a component has no \"rgbTransferFunction\" and no \"grayTransferFunction\"", r->path);
}

enum { MOST_COMPONENTS = 64, NAME_SIZE = 48 };

/* Lists the components of all properties; named "2", or "1.2" if there are several properties. */
static size_t list_components(iso_json_reader *r, const json_t *properties, json_t **components,
                              char (*names)[NAME_SIZE])
{
    size_t count = 0;
    for (size_t p = 0; p < json_array_size(properties); ++p) {
        const json_t *list = iso_json_get_array(r, json_array_get(properties, p), "components", true);
        for (size_t k = 0; k < json_array_size(list) && count < MOST_COMPONENTS; ++k, ++count) {
            components[count] = json_array_get(list, k);
            if (json_array_size(properties) > 1)
                snprintf(names[count], sizeof *names, "%zu.%zu", p + 1, k + 1);
            else
                snprintf(names[count], sizeof *names, "%zu", k + 1);
        }
    }
    return count;
}

static iso_status load_slicer(const iso_tf_file *file, iso_tf *tf, iso_error *err)
{
    json_auto_t *root = NULL;
    json_t *components[MOST_COMPONENTS];
    char names[MOST_COMPONENTS][NAME_SIZE];
    const char *list[MOST_COMPONENTS];
    OWNED(iso_tf_curves) curves = {0};
    size_t chosen = 0;
    NEED(iso_json_parse(file->path, file->text, file->size, &root, err));
    iso_json_reader r = {.path = file->path, .err = err};
    const json_t *properties = iso_json_get_array(&r, root, "volumeProperties", true);
    const size_t count = list_components(&r, properties, components, names);
    for (size_t i = 0; i < count; ++i)
        list[i] = names[i];
    TRY(r.status, iso_tf_choose(file, "component", list, count, &chosen, err));
    if (r.status == ISO_OK)
        read_component(&r, components[chosen], &curves);
    NEED(r.status);
    return iso_tf_take_curves(file, &curves, tf, err);
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static json_t *points_of(const iso_tf_curve *curve, int components)
{
    json_t *points = json_array();
    for (size_t i = 0; i < curve->count; ++i) {
        const iso_tf_node *n = &curve->nodes[i];
        json_array_append_new(points, json_pack("{s:f, s:o, s:f, s:f}", "x", n->x, components == 3 ? "color" : "y",
                                                components == 3 ? iso_json_numbers(n->y, 3) : json_real(n->y[0]),
                                                "midpoint", n->midpoint, "sharpness", n->sharpness));
    }
    return json_pack("{s:o}", "points", points);
}

static const char schema[] = "https://raw.githubusercontent.com/Slicer/Slicer/main/Modules/Loadable/VolumeRendering/"
                             "Resources/Schema/volume-property-schema-v1.0.0.json#";

static iso_status save_slicer(const iso_tf_output *output, const char *path, iso_error *err)
{
    const iso_tf_table *table = output->table;
    const double unit_mm = output->unit_mm;
    OWNED(iso_tf_curves) c = {0};
    NEED(iso_tf_reduce(table, unit_mm, 0, 1.0 / 2048, &c, err));
    json_t *component = json_pack("{s:b, s:f, s:o, s:o}", "shade", 1, "scalarOpacityUnitDistance", unit_mm,
                                  "scalarOpacity", points_of(&c.opacity, 1), "rgbTransferFunction",
                                  points_of(&c.color, 3));
    json_auto_t *root = json_pack("{s:s, s:[{s:[f, f], s:[o]}]}", "@schema", schema, "volumeProperties",
                                  "effectiveRange", table->lo, table->hi, "components", component);
    return iso_json_save(path, root, err);
}

const iso_tf_format iso_tf_format_slicer = {
    .name = "slicer",
    .summary = "a volume property of 3D Slicer",
    .suffix = ".vp.json",
    .also = ".json",
    .marks = {"\"volumeProperties\""},
    .load = load_slicer,
    .save = save_slicer,
    .needs_range = true,
};
