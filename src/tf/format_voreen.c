/* SPDX-License-Identifier: MIT */
/* format_voreen.c - transfer functions of Voreen: keys over a domain, with byte colors, or two of them for a step. */
#include <string.h>

#include "tf/xml.h"

typedef struct range {
    double lo, hi;
} range;

static iso_status read_side(const iso_tf_file *file, const xmlNode *key, const char *side, double x, iso_tf_curves *c,
                            iso_error *err)
{
    static const char *const attributes[] = {"r", "g", "b", "a"};
    const xmlNode *color = iso_xml_child(key, side);
    double v[4] = {0};
    if (!color)
        return iso_fail(err, ISO_E_FORMAT, "%s:%ld: a key has no <%s>", file->path, xmlGetLineNo((xmlNode *)key), side);
    for (int k = 0; k < 4; ++k) {
        NEED(iso_xml_number(file, color, attributes[k], iso_xml_byte, &v[k], err));
        v[k] /= 255;
    }
    NEED(iso_tf_curve_add_color(&c->color, x, v, file->path, err));
    return iso_tf_curve_add_opacity(&c->opacity, x, v[3], file->path, err);
}

static bool is_split(const xmlNode *key)
{
    ENDED_BY(iso_xml_free_text) char *text = iso_xml_text(iso_xml_child(key, "split"), "value");
    return text && strcmp(text, "true") == 0;
}

static iso_status read_key(const iso_tf_file *file, const xmlNode *key, range domain, iso_tf_curves *c, iso_error *err)
{
    const xmlNode *intensity = iso_xml_child(key, "intensity");
    double t = 0;
    NEED(intensity ? iso_xml_number(file, intensity, "value", iso_xml_fraction, &t, err)
                   : iso_fail(err, ISO_E_FORMAT, "%s:%ld: a key has no <intensity>", file->path,
                              xmlGetLineNo((xmlNode *)key)));
    const double x = domain.lo + t * (domain.hi - domain.lo);
    NEED(read_side(file, key, "colorL", x, c, err));
    return is_split(key) ? read_side(file, key, "colorR", x, c, err) : ISO_OK;
}

/* Refuses settings that change the picture and are not supported. */
static iso_status check_rest(const iso_tf_file *file, const xmlNode *tf, iso_error *err)
{
    double lo = 0, hi = 1, gamma = 1;
    const xmlNode *threshold = iso_xml_child(tf, "threshold");
    NEED(iso_xml_optional_number(file, threshold, "x", iso_xml_any, &lo, err));
    NEED(iso_xml_optional_number(file, threshold, "y", iso_xml_any, &hi, err));
    NEED(iso_xml_optional_number(file, iso_xml_child(tf, "gammaValue"), "value", iso_xml_any, &gamma, err));
    if (lo > 0 || hi < 1)
        return iso_fail(err, ISO_E_FORMAT, "%s: has a <threshold> of %g to %g, only 0 to 1 is supported", file->path,
                        lo, hi);
    return gamma == 1 ? ISO_OK
                      : iso_fail(err, ISO_E_FORMAT, "%s: has a <gammaValue> of %g, only 1 is supported", file->path,
                                 gamma);
}

static iso_status read_tf(const iso_tf_file *file, const xmlNode *tf, iso_tf_curves *c, iso_error *err)
{
    const xmlNode *domain = iso_xml_child(tf, "domain"), *keys = iso_xml_child(tf, "Keys");
    range r = {0, 1};
    NEED(check_rest(file, tf, err));
    NEED(iso_xml_optional_number(file, domain, "x", iso_xml_any, &r.lo, err));
    NEED(iso_xml_optional_number(file, domain, "y", iso_xml_any, &r.hi, err));
    c->are_fractions = !domain || (r.lo == 0 && r.hi == 1);
    if (!(r.hi > r.lo))
        return iso_fail(err, ISO_E_RANGE, "%s: <domain> is %g to %g, the end must exceed the start", file->path, r.lo,
                        r.hi);
    for (const xmlNode *key = iso_xml_child(keys, "key"); key; key = iso_xml_next(keys, key, "key"))
        NEED(read_key(file, key, r, c, err));
    return ISO_OK;
}

static iso_status load_voreen(const iso_tf_file *file, iso_tf *tf, iso_error *err)
{
    ENDED_BY(iso_xml_free_doc) xmlDocPtr doc = NULL;
    OWNED(iso_tf_curves) curves = {.unit_is = "in Voreen a 200th of the volume's longest side"};
    NEED(iso_xml_parse(file, &doc, err));
    const xmlNode *root = xmlDocGetRootElement(doc);
    const xmlNode *found = iso_xml_next(root, root, "TransFuncIntensity");
    if (!found)
        found = iso_xml_next(root, root, "TransFunc1DKeys"); /* name in later versions */
    if (!found)
        return iso_fail(err, ISO_E_FORMAT, "%s: has no <TransFuncIntensity>, the 1D transfer function of Voreen",
                        file->path);
    NEED(read_tf(file, found, &curves, err));
    return iso_tf_take_curves(file, &curves, tf, err);
}

const iso_tf_format iso_tf_format_voreen = {
    .name = "voreen",
    .summary = "a 1D transfer function of Voreen; read only",
    .suffix = ".tfi",
    .marks = {"<TransFunc", "<VoreenData"},
    .load = load_voreen,
};
