/* SPDX-License-Identifier: MIT */
/* format_slicer_vp.c - the volume property that older versions of 3D Slicer save, NAME.vp: nine lines of text. */
#define _DEFAULT_SOURCE
#include <stdlib.h>
#include <string.h>

#include "tf/slicer.h"

/* Interpolation, shade, diffuse, ambient, specular and its power, then the curves. */
enum { SCALAR_OPACITY = 6, GRADIENT_OPACITY = 7, COLOR = 8, LINES = 9 };

static iso_status load_vp(const iso_tf_file *file, iso_tf *tf, iso_error *err)
{
    const char *lines[LINES];
    OWNED(iso_tf_curves) curves = {0};
    FREED char *text = strdup(file->text);
    char *rest = text;
    int count = 0;
    NEED_MEMORY(text, err, "%s: out of memory", file->path);
    for (; count < LINES && rest && *rest; ++count)
        lines[count] = strsep(&rest, "\n");
    if (count < LINES)
        return iso_fail(err, ISO_E_FORMAT, "%s: has %d lines, a volume property of 3D Slicer has %d", file->path, count,
                        (int)LINES);
    const iso_slicer_texts texts = {lines[SCALAR_OPACITY], lines[GRADIENT_OPACITY], lines[COLOR]};
    NEED(iso_slicer_curves(&texts, file->path, &curves, err));
    return iso_tf_take_curves(file, &curves, tf, err);
}

const iso_tf_format iso_tf_format_slicer_vp = {
    .name = "slicer-vp",
    .summary = "a volume property of older versions of 3D Slicer, nine lines of text; read only",
    .suffix = ".vp",
    .load = load_vp,
};
