/* SPDX-License-Identifier: MIT */
/* visible.h - a line on stderr where a view shows next to nothing of a volume, or an opaque box (scene/visible.h). */
#ifndef ISO_OPTIONS_VISIBLE_H
#define ISO_OPTIONS_VISIBLE_H

#include "options/cli.h"
#include "scene/visible.h"

/* "isoshade COMMAND: warning: ..."; whether there was one. */
bool iso_cli_warn_of(const iso_cli *cli, const iso_visible *visible);
/* The same of a view, before it is worked on. isosurface: NULL, or the value whose first hit is shown. */
iso_visible iso_cli_warn_of_view(const iso_cli *cli, const iso_pyramid *p, const iso_view *view,
                                 const double *isosurface, bool *warned);
/* {"voxels": share, "faces": share, "picture": share}, for results as JSON. */
json_t *iso_cli_visible_json(const iso_visible *visible);

#endif
