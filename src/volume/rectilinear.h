/* SPDX-License-Identifier: MIT */
/* rectilinear.h - grids whose samples stand at coordinates of their own along each axis; private to src/volume.
 *
 * Even coordinates, within 1 % of their mean step, are a volume as they stand. Uneven ones are refused, taken for even
 * (ISO_UNEVEN_FORCE), or interpolated linearly at the smallest step of each axis (ISO_UNEVEN_RESAMPLE). */
#pragma once

#include "volume/stream_kernel.h"

typedef struct iso_rectilinear {
    double *at[3]; /* owned; coordinates in ascending order, of cells their faces; NULL: no rectilinear grid */
    size_t count[3];
} iso_rectilinear;

/* Reads the coordinates of an axis, once: the samples of a source of one row. ISO_E_FORMAT, ISO_E_MEMORY. */
iso_status iso_rectilinear_take(iso_rectilinear *r, int axis, iso_volume_source *row, iso_error *err);
void iso_rectilinear_destroy(iso_rectilinear *r);
/* Returns the first coordinate and the mean step of each axis. ISO_E_FORMAT if the coordinates are not `points`, do not
 * ascend, or are refused as uneven. */
iso_status iso_rectilinear_measure(const iso_rectilinear *r, const iso_volume_source *source, const size_t points[3],
                                   double first[3], double step[3], iso_error *err);
/* Interpolates the samples of an open source if it has uneven coordinates and the hint asks for that; the grid then has
 * steps of its own. Warns with the number of samples. */
iso_status iso_rectilinear_resample(const iso_rectilinear *r, iso_volume_source *source, iso_error *err);
