/* SPDX-License-Identifier: MIT */
/* palette_tables.h - a fixed table, independent of the data. */
#pragma once

#include "palette/palette.h"

/* Subdivides [van-gelder-1996]: the icosahedron joined with its dual; `level` times each triangle is cut in four and
 * the new vertices are moved to the sphere. Writes the normals of 60 4^level faces. */
size_t iso_subdivision_faces(int level);
iso_status iso_palette_subdivide(int level, float *xyz, iso_error *err);
