/* SPDX-License-Identifier: MIT */
#include "tf/slicer.h"

#include <stdlib.h>

/* Reads a curve from Slicer's text: "8 x y x y x y x y", or "8 x r g b x r g b". what: its name in messages. */
static iso_status read_curve(const char *text, const char *what, int components, const char *path, iso_tf_curve *curve,
                             iso_error *err)
{
    char *end = (char *)text;
    const double count = strtod(text, &end);
    const int each = 1 + components;
    if (end == text || !(count >= 0 && count <= 65536) || (int)count != count || (int)count % each != 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: %s must begin with the count of numbers that follow, %d per point",
                        path, what, each);
    for (int i = 0; i < (int)count; i += each) {
        double v[4] = {0};
        for (int k = 0; k < each; ++k) {
            const char *from = end;
            v[k] = strtod(from, &end);
            if (end == from)
                return iso_fail(err, ISO_E_FORMAT, "%s: %s has %d numbers, its count is %d", path, what, i + k,
                                (int)count);
        }
        NEED(iso_tf_curve_add(curve, (iso_tf_node){v[0], {v[1], v[2], v[3]}, 0.5, 0}, components, path, err));
    }
    return ISO_OK;
}

iso_status iso_slicer_check_gradient(const iso_tf_curve *curve, const char *hint, const char *path, iso_error *err)
{
    for (size_t i = 0; i < curve->count; ++i)
        if (curve->nodes[i].y[0] != 1)
            return iso_fail(err, ISO_E_FORMAT, "%s: the gradient opacity is %g at %g, only 1 is supported%s", path,
                            curve->nodes[i].y[0], curve->nodes[i].x, hint);
    return ISO_OK;
}

iso_status iso_slicer_curves(const iso_slicer_texts *texts, const char *path, iso_tf_curves *curves, iso_error *err)
{
    OWNED(iso_tf_curves) gradient = {0};
    curves->unit_mm = 1, curves->unit_is_default = true;
    NEED(read_curve(texts->scalar_opacity, "scalarOpacity", 1, path, &curves->opacity, err));
    NEED(read_curve(texts->gradient_opacity, "gradientOpacity", 1, path, &gradient.opacity, err));
    NEED(iso_slicer_check_gradient(&gradient.opacity, "", path, err));
    return read_curve(texts->color, "colorTransfer", 3, path, &curves->color, err);
}
