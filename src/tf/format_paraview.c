/* SPDX-License-Identifier: MIT */
/* format_paraview.c - color maps that ParaView exports and ships with, in JSON. */
#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "tf/ciede2000.h"
#include "tf/format.h"
#include "tf/paraview.h"

/* ---- shared with the XML format ---------------------------------------------------------------------------------- */

bool iso_paraview_is_ciede2000(const char *name)
{
    return strcmp(name, "Lab/CIEDE2000") == 0;
}

iso_status iso_paraview_space(const char *name, const char *path, iso_color_space *space, iso_error *err)
{
    size_t row = 0;
    iso_error unused;
    *space = ISO_SPACE_LAB;
    if (strcmp(name, "CIELAB") == 0 || iso_paraview_is_ciede2000(name)) /* one of ParaView's own maps says CIELAB */
        return ISO_OK;
    if (iso_names_find(&iso_color_space_names, name, &row, &unused) == ISO_OK) {
        *space = (iso_color_space)row;
        return ISO_OK;
    }
    char list[160];
    return iso_fail(err, ISO_E_FORMAT, "%s: the color space is \"%s\", must be one of: %s, Lab/CIEDE2000", path, name,
                    iso_names_join(&iso_color_space_names, NULL, list, sizeof list));
}

/* Marks maps from 0 or -1 to 1 as fractions of a range, since ParaView fits its presets to the data. */
void iso_paraview_fit(iso_tf_curves *c)
{
    iso_tf_curve *const both[] = {&c->color, &c->opacity};
    const iso_tf_curve *color = &c->color;
    iso_tf_curve_sort(&c->color);
    if (color->count == 0)
        return;
    const double lo = color->nodes[0].x, hi = color->nodes[color->count - 1].x;
    c->unit_is = "as ParaView keeps it with the representation (Scalar Opacity Unit Distance)";
    c->are_fractions = hi == 1 && (lo == 0 || lo == -1);
    for (size_t k = 0; k < 2 && c->are_fractions; ++k)
        for (size_t i = 0; i < both[k]->count; ++i)
            both[k]->nodes[i].x = (both[k]->nodes[i].x - lo) / (hi - lo);
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

/* Replaces commas before a closing bracket by spaces: ParaView's reader allows them, and its own file has one. */
static char *without_last_commas(const iso_tf_file *file)
{
    char *text = malloc(file->size + 1), *comma = NULL;
    bool in_string = false;
    if (!text)
        return NULL;
    memcpy(text, file->text, file->size);
    text[file->size] = '\0';
    for (char *p = text; p < text + file->size; ++p) {
        if (in_string) {
            in_string = *p != '"';
            p += *p == '\\';
        } else if (!isspace((unsigned char)*p)) {
            if (comma && (*p == ']' || *p == '}'))
                *comma = ' ';
            comma = *p == ',' ? p : NULL;
            in_string = *p == '"';
        }
    }
    return text;
}

/* Reads a flat list of numbers, `per` of them for each node. */
static iso_status read_nodes(const iso_tf_file *file, const json_t *map, const char *key, iso_tf_curve *curve,
                             iso_error *err)
{
    const json_t *list = json_object_get(map, key);
    const int components = strcmp(key, "RGBPoints") == 0 ? 3 : 1;
    if (!list || json_is_null(list))
        return ISO_OK;
    if (!json_is_array(list) || json_array_size(list) % 4 != 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: \"%s\" is not a list of four numbers per point", file->path, key);
    for (size_t i = 0; i + 3 < json_array_size(list); i += 4) {
        double v[4];
        for (size_t k = 0; k < 4; ++k) {
            const json_t *item = json_array_get(list, i + k);
            v[k] = json_number_value(item);
            if (!json_is_number(item))
                return iso_fail(err, ISO_E_FORMAT, "%s: \"%s\": entry %zu is not a number", file->path, key, i + k);
        }
        const iso_tf_node node = components == 3 ? (iso_tf_node){v[0], {v[1], v[2], v[3]}, 0.5, 0}
                                                 : (iso_tf_node){v[0], {v[1]}, v[2], v[3]};
        NEED(iso_tf_curve_add(curve, node, components, file->path, err));
    }
    return ISO_OK;
}

/* True if the value is true or a number other than 0. */
static bool is_on(const json_t *map, const char *key)
{
    const json_t *value = json_object_get(map, key);
    return json_is_true(value) || json_number_value(value) != 0;
}

static iso_status read_map(const iso_tf_file *file, const json_t *map, iso_tf_curves *c, iso_error *err)
{
    const char *name = json_string_value(json_object_get(map, "Name"));
    if (!json_object_get(map, "RGBPoints") && json_object_get(map, "IndexedColors"))
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: \"%s\" has colors of categories (\"IndexedColors\"), not of values (\"RGBPoints\")",
                        file->path, name ? name : "");
    if (is_on(map, "UseLogScale"))
        return iso_fail(err, ISO_E_FORMAT, "%s: \"UseLogScale\" is not supported, only colors of values as they are",
                        file->path);
    const char *space = json_string_value(json_object_get(map, "ColorSpace"));
    NEED(iso_paraview_space(space ? space : "", file->path, &c->space, err));
    if (c->space == ISO_SPACE_HSV && is_on(map, "HSVWrap"))
        c->space = ISO_SPACE_WRAPPED;
    NEED(read_nodes(file, map, "RGBPoints", &c->color, err));
    if (iso_paraview_is_ciede2000(space))
        NEED(iso_ciede2000_expand(&c->color, file->path, err));
    NEED(read_nodes(file, map, "Points", &c->opacity, err));
    iso_paraview_fit(c);
    return ISO_OK;
}

static iso_status choose_map(const iso_tf_file *file, const json_t *root, const json_t **map, iso_error *err)
{
    const size_t count = json_is_array(root) ? json_array_size(root) : 1;
    FREED const char **names = malloc((count + 1) * sizeof *names);
    size_t chosen = 0;
    NEED_MEMORY(names, err, "%s: out of memory", file->path);
    for (size_t i = 0; i < count; ++i) {
        const json_t *item = json_is_array(root) ? json_array_get(root, i) : root;
        const char *name = json_string_value(json_object_get(item, "Name"));
        names[i] = name ? name : "";
    }
    NEED(iso_tf_choose(file, "color map", names, count, &chosen, err));
    *map = json_is_array(root) ? json_array_get(root, chosen) : root;
    return ISO_OK;
}

static iso_status load_paraview(const iso_tf_file *file, iso_tf *tf, iso_error *err)
{
    json_error_t where;
    OWNED(iso_tf_curves) curves = {0};
    const json_t *map = NULL;
    FREED char *text = without_last_commas(file);
    json_auto_t *root = text ? json_loads(text, 0, &where) : NULL;
    NEED_MEMORY(text, err, "%s: out of memory", file->path);
    if (!root)
        return iso_fail(err, ISO_E_FORMAT, "%s:%d:%d: not JSON: %s", file->path, where.line, where.column, where.text);
    NEED(choose_map(file, root, &map, err));
    NEED(read_map(file, map, &curves, err));
    return iso_tf_take_curves(file, &curves, tf, err);
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static json_t *flat(const iso_tf_curve *curve, int components)
{
    json_t *list = json_array();
    for (size_t i = 0; i < curve->count; ++i) {
        const iso_tf_node *n = &curve->nodes[i];
        const double color[4] = {n->x, n->y[0], n->y[1], n->y[2]},
                     opacity[4] = {n->x, n->y[0], n->midpoint, n->sharpness};
        for (int k = 0; k < 4; ++k)
            json_array_append_new(list, json_real(components == 3 ? color[k] : opacity[k]));
    }
    return list;
}

static iso_status save_paraview(const iso_tf_output *output, const char *path, iso_error *err)
{
    const iso_tf_table *table = output->table;
    const double unit_mm = output->unit_mm;
    OWNED(iso_tf_curves) c = {0};
    NEED(iso_tf_reduce(table, unit_mm, 0, 1.0 / 2048, &c, err));
    json_auto_t *root = json_pack("[{s:s, s:s, s:o, s:o}]", "Name", "isoshade", "ColorSpace", "RGB", "RGBPoints",
                                  flat(&c.color, 3), "Points", flat(&c.opacity, 1));
    return iso_json_save(path, root, err);
}

const iso_tf_format iso_tf_format_paraview = {
    .name = "paraview",
    .summary = "color maps of ParaView, JSON; without the length of opacities",
    .suffix = ".paraview.json",
    .also = ".json",
    .marks = {"\"RGBPoints\"", "\"IndexedColors\""},
    .load = load_paraview,
    .save = save_paraview,
    .has_no_unit = true,
};
