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

static bool starts_like_vdb(const unsigned char *head, size_t size)
{
    return size >= 8 && memcmp(head, " BDV\0\0\0\0", 8) == 0;
}

const iso_volume_format iso_volume_format_vdb = {
    .name = "vdb",
    .title = "OpenVDB",
    .summary = "FILE:GRID, the box of its active voxels; the grid's tree at once",
    .suffixes = ".vdb",
    .starts = "\" BDV\"",
    .takes_part = true,
    .probe = starts_like_vdb,
    .open = open_vdb,
};
