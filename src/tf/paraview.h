/* SPDX-License-Identifier: MIT */
/* paraview.h - what ParaView's color maps in JSON and in XML share. */
#ifndef ISO_TF_PARAVIEW_H
#define ISO_TF_PARAVIEW_H

#include "tf/curves.h"

/* Is it the space whose curves become those of Lab by iso_ciede2000_expand()? */
bool iso_paraview_is_ciede2000(const char *name);
/* ISO_E_FORMAT lists the spaces. */
iso_status iso_paraview_space(const char *name, const char *path, iso_color_space *space, iso_error *err);
/* Maps from 0 or -1 to 1 become fractions of a range, as ParaView fits them to the data. */
void iso_paraview_fit(iso_tf_curves *curves);

#endif
