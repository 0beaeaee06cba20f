/* SPDX-License-Identifier: MIT */
/* vdb_open.c - opens the formats of the program isoshade-vdb: grids of OpenVDB, of which FILE:GRID names one. */
#define _GNU_SOURCE
#include <string.h>

#include "volume/child.h"

static iso_status open_vdb(iso_volume_source *source, iso_error *err)
{
    static const iso_child_program vdb = {"isoshade-vdb", "OpenVDB", "libopenvdb-dev"};
    return iso_child_open(source, &vdb, source->part, err);
}

const iso_volume_format iso_volume_format_vdb = {
    .name = "vdb",
    .title = "OpenVDB",
    .summary = "FILE:GRID, the box of its active voxels; the grid's tree at once",
    .suffixes = ".vdb",
    .starts = "\" BDV\"",
    .takes_part = true,
    .marks = {ISO_MARK(0, " BDV\0\0\0\0")},
    .open = open_vdb,
};
