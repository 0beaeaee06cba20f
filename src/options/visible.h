/* SPDX-License-Identifier: MIT */
/* visible.h - warns if a view shows almost nothing of a volume, or only an opaque box (scene/visible.h). */
#pragma once

#include "options/cli.h"
#include "scene/visible.h"

/* Prints "isoshade COMMAND: warning: ..." if the view needs one. Returns true if it does. */
bool iso_cli_warn_visible(const iso_cli *cli, const iso_visible *visible);
/* Measures a view and warns the same way, before the work begins. isosurface: value of the surface, or NULL. *warned:
 * true if a warning was printed. */
iso_visible iso_cli_warn_view(const iso_cli *cli, const iso_pyramid *p, const iso_view *view, const double *isosurface,
                              bool *warned);
/* Returns the shares {"voxels", "faces", "picture"}, for results as JSON. */
json_t *iso_cli_visible_json(const iso_visible *visible);
