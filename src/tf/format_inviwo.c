/* SPDX-License-Identifier: MIT */
/* format_inviwo.c - transfer functions of Inviwo, in both forms that its versions have written. */
#include "tf/xml.h"

/* Reads <point><pos x y/><rgba x y z w/></point>, or the newer <Point><pos content/><rgba x y z w/></Point>. */
static iso_status read_point(const iso_tf_file *file, const xmlNode *point, iso_tf_curves *c, iso_error *err)
{
    static const char *const attributes[] = {"x", "y", "z", "w"};
    const xmlNode *pos = iso_xml_child(point, "pos"), *rgba = iso_xml_child(point, "rgba");
    double x = 0, color[4] = {0};
    if (!pos || !rgba)
        return iso_fail(err, ISO_E_FORMAT, "%s:%ld: a point has no <%s>", file->path, xmlGetLineNo((xmlNode *)point),
                        pos ? "rgba" : "pos");
    const bool newer = xmlHasProp((xmlNode *)pos, (const xmlChar *)"content");
    NEED(iso_xml_number(file, pos, newer ? "content" : "x", iso_xml_fraction, &x, err));
    for (int k = 0; k < 4; ++k)
        NEED(iso_xml_number(file, rgba, attributes[k], iso_xml_fraction, &color[k], err));
    NEED(iso_tf_curve_add_color(&c->color, x, color, file->path, err));
    return iso_tf_curve_add_opacity(&c->opacity, x, color[3], file->path, err);
}

/* Refuses masks other than the whole range: values outside a mask are invisible. */
static iso_status check_mask(const iso_tf_file *file, const xmlNode *root, iso_error *err)
{
    double lo = 0, hi = 1;
    NEED(iso_xml_optional_number(file, iso_xml_next(root, root, "maskMin"), "content", iso_xml_any, &lo, err));
    NEED(iso_xml_optional_number(file, iso_xml_next(root, root, "maskMax"), "content", iso_xml_any, &hi, err));
    if (lo > 0 || hi < 1)
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: is masked to %g to %g (\"maskMin\", \"maskMax\"), only 0 to 1 is supported", file->path,
                        lo, hi);
    return ISO_OK;
}

static iso_status read_points(const iso_tf_file *file, const xmlNode *root, iso_tf_curves *c, iso_error *err)
{
    static const char *const names[] = {"point", "Point"};
    NEED(check_mask(file, root, err));
    for (int k = 0; k < 2; ++k)
        for (const xmlNode *p = iso_xml_next(root, root, names[k]); p; p = iso_xml_next(root, p, names[k]))
            NEED(read_point(file, p, c, err));
    return ISO_OK;
}

static iso_status load_inviwo(const iso_tf_file *file, iso_tf *tf, iso_error *err)
{
    ENDED_BY(iso_xml_free_doc) xmlDocPtr doc = NULL;
    OWNED(iso_tf_curves)
    curves = {.are_fractions = true, .unit_is = "in Inviwo a 150th of the volume's longest side"};
    NEED(iso_xml_parse(file, &doc, err));
    const xmlNode *root = xmlDocGetRootElement(doc);
    if (!iso_xml_is(root, "InviwoTreeData") && !iso_xml_is(root, "InviwoWorkspace"))
        return iso_fail(err, ISO_E_FORMAT, "%s: is <%.40s>, must be <InviwoTreeData> or <InviwoWorkspace>", file->path,
                        (const char *)root->name);
    NEED(read_points(file, root, &curves, err));
    return iso_tf_take_curves(file, &curves, tf, err);
}

const iso_tf_format iso_tf_format_inviwo = {
    .name = "inviwo",
    .summary = "a transfer function of Inviwo; read only",
    .suffix = ".itf",
    .marks = {"<InviwoTreeData", "<InviwoWorkspace"},
    .load = load_inviwo,
};
