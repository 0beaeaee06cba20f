/* SPDX-License-Identifier: MIT */
/* format_slicer_mrml.c - volume properties in MRML files of 3D Slicer: its presets.xml, and scenes. */

#include "tf/slicer.h"
#include "tf/xml.h"

static bool looks_like_mrml(const iso_tf_file *file)
{
    return iso_tf_file_has(file, "<MRML") || iso_tf_file_has(file, "<VolumeProperty ");
}

static iso_status read_property(const iso_tf_file *file, const xmlNode *node, iso_tf_curves *c, iso_error *err)
{
    char *scalar = iso_xml_text(node, "scalarOpacity"), *gradient = iso_xml_text(node, "gradientOpacity"),
         *color = iso_xml_text(node, "colorTransfer");
    iso_status status = scalar && color
                            ? iso_slicer_curves(&(iso_slicer_texts){scalar, gradient ? gradient : "0", color},
                                                file->path, c, err)
                            : iso_fail(err, ISO_E_FORMAT, "%s:%ld: <VolumeProperty> has no attribute \"%s\"",
                                       file->path, xmlGetLineNo((xmlNode *)node),
                                       scalar ? "colorTransfer" : "scalarOpacity");
    xmlFree(scalar);
    xmlFree(gradient);
    xmlFree(color);
    return status;
}

enum { MOST_PROPERTIES = 1024 };

static iso_status choose_property(const iso_tf_file *file, const xmlNode *root, const xmlNode **property,
                                  iso_error *err)
{
    const xmlNode *nodes[MOST_PROPERTIES] = {0};
    char *names[MOST_PROPERTIES];
    size_t count = 0, chosen = 0;
    const xmlNode *node = iso_xml_is(root, "VolumeProperty") ? root : iso_xml_next(root, root, "VolumeProperty");
    for (; node && count < MOST_PROPERTIES; node = iso_xml_next(root, node, "VolumeProperty")) {
        nodes[count] = node;
        names[count] = iso_xml_text(node, "name");
        if (!names[count])
            names[count] = (char *)xmlStrdup((const xmlChar *)"");
        ++count;
    }
    iso_status status = iso_tf_choose(file, "volume property", (const char *const *)names, count, &chosen, err);
    *property = status == ISO_OK ? nodes[chosen] : NULL;
    for (size_t i = 0; i < count; ++i)
        xmlFree(names[i]);
    return status;
}

static iso_status load_mrml(const iso_tf_file *file, iso_tf *tf, iso_error *err)
{
    xmlDocPtr doc;
    iso_tf_curves curves = {0};
    const xmlNode *property;
    NEED(iso_xml_parse(file, &doc, err));
    iso_status status = choose_property(file, xmlDocGetRootElement(doc), &property, err);
    TRY(status, read_property(file, property, &curves, err));
    xmlFreeDoc(doc);
    if (status == ISO_OK)
        return iso_tf_take_curves(file, &curves, tf, err);
    iso_tf_curves_destroy(&curves);
    return status;
}

const iso_tf_format iso_tf_format_slicer_mrml = {
    .name = "slicer-mrml",
    .summary = "volume properties in MRML files of 3D Slicer, such as presets.xml; read only",
    .suffix = ".mrml",
    .also = ".xml",
    .probe = looks_like_mrml,
    .load = load_mrml,
};
