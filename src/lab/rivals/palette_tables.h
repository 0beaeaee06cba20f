/* SPDX-License-Identifier: MIT */
/* palette_tables.h - fixed tables, independent of the data. */
#ifndef ISO_LAB_PALETTE_TABLES_H
#define ISO_LAB_PALETTE_TABLES_H

#include "palette/palette.h"

/* Subdivides [van-gelder-1996]: the icosahedron joined with its dual; `level` times each triangle is cut in four and
 * the new vertices are moved to the sphere. 60 4^level faces, 30 4^level + 2 vertices. */
size_t iso_subdivision_faces(int level);
size_t iso_subdivision_vertices(int level);
iso_status iso_palette_subdivide(int level, bool faces, float *xyz, iso_error *err);

/* Makes the grid of [glassner-1990] of at most `directions` codes (a sign, side^2 cells of x and y). Returns the number
 * of codes with a direction: about a quarter of the cells lie outside the disc. xyz may be NULL, to count. */
size_t iso_palette_grid(size_t directions, float *xyz);
void iso_palette_spiral(size_t directions, float *xyz);

#endif
