/* SPDX-License-Identifier: MIT */
/* format_paraview_xml.c - color maps of ParaView before 5: <ColorMap name="..." space="..."><Point x o r g b/>. */
#include <stdlib.h>
#include <string.h>

#include "tf/ciede2000.h"
#include "tf/paraview.h"
#include "tf/xml.h"

static bool looks_like_color_map(const iso_tf_file *file)
{
    return iso_tf_file_has(file, "<ColorMap");
}

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
    char *text = iso_xml_text(node, attribute);
    const bool yes = text && (strcmp(text, "true") == 0 || atoi(text) != 0);
    xmlFree(text);
    return yes;
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
    char *space = iso_xml_text(map, "space");
    iso_status status = iso_paraview_space(space ? space : "RGB", file->path, &c->space, err);
    const bool opacities = has_opacities(file, map), is_ciede2000 = space && iso_paraview_is_ciede2000(space);
    xmlFree(space);
    if (status == ISO_OK && is_true(map, "indexedLookup"))
        status = iso_fail(err, ISO_E_FORMAT, "%s: has colors of categories (\"indexedLookup\"), not of values",
                          file->path);
    for (const xmlNode *p = iso_xml_child(map, "Point"); p && status == ISO_OK; p = iso_xml_next(map, p, "Point"))
        status = read_point(file, p, c, opacities, err);
    if (status == ISO_OK && is_ciede2000)
        status = iso_ciede2000_expand(&c->color, file->path, err);
    iso_paraview_fit(c);
    return status;
}

enum { MOST_MAPS = 1024 };

static iso_status choose_map(const iso_tf_file *file, const xmlNode *root, const xmlNode **map, iso_error *err)
{
    const xmlNode *nodes[MOST_MAPS] = {0};
    char *names[MOST_MAPS];
    size_t count = 0, chosen = 0;
    const xmlNode *node = iso_xml_is(root, "ColorMap") ? root : iso_xml_next(root, root, "ColorMap");
    for (; node && count < MOST_MAPS; node = iso_xml_next(root, node, "ColorMap")) {
        nodes[count] = node;
        names[count] = iso_xml_text(node, "name");
        if (!names[count])
            names[count] = (char *)xmlStrdup((const xmlChar *)"");
        ++count;
    }
    iso_status status = iso_tf_choose(file, "color map", (const char *const *)names, count, &chosen, err);
    *map = status == ISO_OK ? nodes[chosen] : NULL;
    for (size_t i = 0; i < count; ++i)
        xmlFree(names[i]);
    return status;
}

static iso_status load_color_map(const iso_tf_file *file, iso_tf *tf, iso_error *err)
{
    xmlDocPtr doc;
    iso_tf_curves curves = {0};
    const xmlNode *map;
    NEED(iso_xml_parse(file, &doc, err));
    iso_status status = choose_map(file, xmlDocGetRootElement(doc), &map, err);
    TRY(status, read_map(file, map, &curves, err));
    xmlFreeDoc(doc);
    if (status == ISO_OK)
        return iso_tf_take_curves(file, &curves, tf, err);
    iso_tf_curves_destroy(&curves);
    return status;
}

const iso_tf_format iso_tf_format_paraview_xml = {
    .name = "paraview-xml",
    .summary = "color maps of older versions of ParaView, XML; read only",
    .suffix = ".paraview.xml",
    .also = ".xml",
    .probe = looks_like_color_map,
    .load = load_color_map,
};
