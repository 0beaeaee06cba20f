/* SPDX-License-Identifier: MIT */
/* vdb_nanovdb.h - writes NanoVDB files: the grids of an OpenVDB file with the same values, active voxels, names,
 * classes and transforms. Private to the C++ files of this folder.
 *
 * NanoVDB stores a grid in one block, which a program maps and reads directly. Files are not compressed, since many
 * readers are built without ZIP or Blosc. They include statistics and checksums of all nodes, which nanovdb_validate
 * checks. The note "values" of an optimized level becomes blind data "isoshade_values" of each grid. NanoVDB has no
 * other metadata: units, levels and further metadata are lost.
 *
 * The file is the same as that of NanoVDB's own conversion, bit for bit. But leaves are written when they are read, and
 * only the nodes above them stay in memory: 35 kB for 128 x 128 x 128 voxels, 67 kB for vectors. */
#pragma once

#include <ostream>

#include "vdb/vdb_openvdb.h"

namespace iso_vdb {

void write_nanovdb(std::ostream &out, const iso_vdb_file &file);
const char *nanovdb_version();

} // namespace iso_vdb
