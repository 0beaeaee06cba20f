/* SPDX-License-Identifier: MIT */
/* nanovdb.h - a file of OpenVDB grids as a NanoVDB file: the same values, active voxels, names, classes and transforms.
 *
 * NanoVDB has one block of memory a grid, which a program maps and reads as it is. Files are not compressed, since readers
 * are built with ZIP and Blosc or without; statistics and checksums of all nodes are in them, which nanovdb_validate looks
 * at. NanoVDB has no place for other metadata: units, levels and what OpenVDB files say beyond the above is left out.
 *
 * Memory: a grid twice, as OpenVDB and as NanoVDB hold it, and those that are finished. */
#ifndef ISO_EXPORT_NANOVDB_H
#define ISO_EXPORT_NANOVDB_H

#include "base/status.h"

/* All grids, of type float and vec3s, in the file's order. ISO_E_MISSING where isoshade was built without NanoVDB. */
iso_status iso_nanovdb_from_vdb(const char *vdb_path, const char *path, iso_error *err);

/* Of the files' format, as "32.4.2"; NULL: built without NanoVDB. */
const char *iso_nanovdb_version(void);

#endif
