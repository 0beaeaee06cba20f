/* SPDX-License-Identifier: MIT */
/* nanovdb.h - a file of OpenVDB grids as a NanoVDB file: the same values, active voxels, names, classes and transforms.
 *
 * NanoVDB stores a grid in one block of memory, which a program maps and reads directly. Files are not compressed,
 * since many readers are built without ZIP or Blosc. They include statistics and checksums of all nodes, which
 * nanovdb_validate checks. The note "values" of an optimized level becomes blind data "isoshade_values" of each grid.
 * NanoVDB has no other metadata: units, levels and further metadata of the OpenVDB file are lost.
 *
 * Memory: a grid twice, as OpenVDB and as NanoVDB, and all finished grids. */
#pragma once

#include "base/status.h"

/* Converts all grids of type float and vec3s, in the file's order. ISO_E_MISSING: isoshade was built without
 * NanoVDB. */
iso_status iso_nanovdb_from_vdb(const char *vdb_path, const char *path, iso_error *err);

/* Returns the version of the file format, e.g. "32.4.2"; NULL: built without NanoVDB. */
const char *iso_nanovdb_version(void);
