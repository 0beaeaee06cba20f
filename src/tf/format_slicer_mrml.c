/* SPDX-License-Identifier: MIT */
/* format_slicer_mrml.c - volume properties in MRML files of 3D Slicer: its presets.xml, and scenes. */

#include "tf/slicer.h"
#include "tf/xml.h"

static iso_status read_property(const iso_tf_file *file, const xmlNode *node, iso_tf_curves *c, iso_error *err)
{
    ENDED_BY(iso_xml_free_text) char *scalar = iso_xml_text(node, "scalarOpacity");
    ENDED_BY(iso_xml_free_text) char *gradient = iso_xml_text(node, "gradientOpacity");
    ENDED_BY(iso_xml_free_text) char *color = iso_xml_text(node, "colorTransfer");
    return scalar && color
               ? iso_slicer_curves(&(iso_slicer_texts){scalar, gradient ? gradient : "0", color}, file->path, c, err)
               : iso_fail(err, ISO_E_FORMAT, "%s:%ld: <VolumeProperty> has no attribute \"%s\"", file->path,
                          xmlGetLineNo((xmlNode *)node), scalar ? "colorTransfer" : "scalarOpacity");
}

static iso_status load_mrml(const iso_tf_file *file, iso_tf *tf, iso_error *err)
{
    ENDED_BY(iso_xml_free_doc) xmlDocPtr doc = NULL;
    OWNED(iso_tf_curves) curves = {0};
    const xmlNode *property;
    NEED(iso_xml_parse(file, &doc, err));
    NEED(iso_xml_choose(file, xmlDocGetRootElement(doc), "VolumeProperty", "volume property", &property, err));
    NEED(read_property(file, property, &curves, err));
    return iso_tf_take_curves(file, &curves, tf, err);
}

const iso_tf_format iso_tf_format_slicer_mrml = {
    .name = "slicer-mrml",
    .summary = "volume properties in MRML files of 3D Slicer, such as presets.xml; read only",
    .suffix = ".mrml",
    .also = ".xml",
    .marks = {"<MRML", "<VolumeProperty "},
    .load = load_mrml,
};
