/* SPDX-License-Identifier: MIT */
/* vdb_nanovdb.h - converts OpenVDB grids to NanoVDB files; contracts in vdb_openvdb.h. Private to the C++ files of this
 * folder. */
#pragma once

#include "vdb/vdb_openvdb.h"

namespace iso_vdb {

int to_nanovdb(const char *vdb_path, const char *path, iso_vdb_message *message);
const char *nanovdb_version();

} // namespace iso_vdb
