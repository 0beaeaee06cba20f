/* SPDX-License-Identifier: MIT */
/* paraview.h - parts shared by the readers of ParaView's color maps in JSON and in XML. */
#pragma once

#include "tf/curves.h"

/* True for the space whose curves iso_ciede2000_expand() converts to Lab. */
bool iso_paraview_is_ciede2000(const char *name);
/* Finds the color space of a name. ISO_E_FORMAT lists the names. */
iso_status iso_paraview_space(const char *name, const char *path, iso_color_space *space, iso_error *err);
/* Marks maps from 0 or -1 to 1 as fractions of a range, as ParaView fits them to the data. */
void iso_paraview_fit(iso_tf_curves *curves);
