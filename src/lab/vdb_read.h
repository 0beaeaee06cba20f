/* SPDX-License-Identifier: MIT */
/* vdb_read.h - reads exported grid files back, and measures them; for tests and `isoshade-lab plan`. */
#pragma once

#include "vdb/vdb.h"

/* Loads a grid as a dense array of `size` voxels from index (0, 0, 0). channels: 1 or 3; out: channels * size floats, x
 * fastest. If geometry is not NULL, *geometry gets the transform in isoshade's convention. ISO_E_FORMAT: no such
 * grid. */
iso_status iso_vdb_load_grid(const char *path, const char *grid, int channels, const size_t size[3], float *out,
                             iso_geometry *geometry, iso_error *err);

/* Memory of a file's grids in a reader, by OpenVDB's own count, and seconds to read them. */
typedef struct iso_vdb_stats {
    size_t file_bytes, active_voxels, memory_bytes;
    double read_seconds;
} iso_vdb_stats;
iso_status iso_vdb_measure(const char *path, iso_vdb_stats *stats, iso_error *err);
