/* SPDX-License-Identifier: MIT */
/* format_paraview_xml.c - color maps of ParaView before 5: <ColorMap name="..." space="..."><Point x o r g b/>. */
#include <stdlib.h>
#include <string.h>

#include "tf/ciede2000.h"
#include "tf/paraview.h"
#include "tf/xml.h"

static iso_status read_point(const iso_tf_file *file, const xmlNode *node, iso_tf_curves *c, bool has_opacity,
                             iso_error *err)
{
    static const char *const attributes[] = {"r", "g", "b"};
    double x = 0, o = 1, rgb[3] = {0};
    NEED(iso_xml_number(file, node, "x", iso_xml_any, &x, err));
    for (int k = 0; k < 3; ++k)
        NEED(iso_xml_number(file, node, attributes[k], iso_xml_fraction, &rgb[k], err));
    NEED(iso_tf_curve_add_color(&c->color, x, rgb, file->path, err));
    if (has_opacity)
        NEED(iso_xml_number(file, node, "o", iso_xml_fraction, &o, err));
    return has_opacity ? iso_tf_curve_add_opacity(&c->opacity, x, o, file->path, err) : ISO_OK;
}

/* True if the attribute is "true" or a number other than 0. */
static bool is_true(const xmlNode *node, const char *attribute)
{
    ENDED_BY(iso_xml_free_text) char *text = iso_xml_text(node, attribute);
    return text && (strcmp(text, "true") == 0 || atoi(text) != 0);
}

/* True if an opacity differs from 1. If all are 1, ParaView keeps its own opacities, so the user has to give them. */
static bool has_opacities(const iso_tf_file *file, const xmlNode *map)
{
    for (const xmlNode *p = iso_xml_child(map, "Point"); p; p = iso_xml_next(map, p, "Point")) {
        double o = 1;
        if (iso_xml_optional_number(file, p, "o", iso_xml_any, &o, NULL) == ISO_OK && o != 1)
            return true;
    }
    return false;
}

static iso_status read_map(const iso_tf_file *file, const xmlNode *map, iso_tf_curves *c, iso_error *err)
{
    ENDED_BY(iso_xml_free_text) char *space = iso_xml_text(map, "space");
    const bool opacities = has_opacities(file, map);
    NEED(iso_paraview_space(space ? space : "RGB", file->path, &c->space, err));
    if (is_true(map, "indexedLookup"))
        return iso_fail(err, ISO_E_FORMAT, "%s: has colors of categories (\"indexedLookup\"), not of values",
                        file->path);
    for (const xmlNode *p = iso_xml_child(map, "Point"); p; p = iso_xml_next(map, p, "Point"))
        NEED(read_point(file, p, c, opacities, err));
    if (space && iso_paraview_is_ciede2000(space))
        NEED(iso_ciede2000_expand(&c->color, file->path, err));
    iso_paraview_fit(c);
    return ISO_OK;
}

static iso_status load_color_map(const iso_tf_file *file, iso_tf *tf, iso_error *err)
{
    ENDED_BY(iso_xml_free_doc) xmlDocPtr doc = NULL;
    OWNED(iso_tf_curves) curves = {0};
    const xmlNode *map;
    NEED(iso_xml_parse(file, &doc, err));
    NEED(iso_xml_choose(file, xmlDocGetRootElement(doc), "ColorMap", "color map", &map, err));
    NEED(read_map(file, map, &curves, err));
    return iso_tf_take_curves(file, &curves, tf, err);
}

const iso_tf_format iso_tf_format_paraview_xml = {
    .name = "paraview-xml",
    .summary = "color maps of older versions of ParaView, XML; read only",
    .suffix = ".paraview.xml",
    .also = ".xml",
    .marks = {"<ColorMap"},
    .load = load_color_map,
};
