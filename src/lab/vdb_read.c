/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "lab/vdb_read.h"

#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/parallel.h"
#include "vdb/vdb_file.h"

iso_status iso_vdb_measure(const char *path, iso_vdb_stats *stats, iso_error *err)
{
    iso_vdb_message message = {""};
    struct stat about;
    *stats = (iso_vdb_stats){0};
    if (stat(path, &about) != 0)
        return iso_fail(err, ISO_E_IO, "%s: no such file", path);
    const iso_openvdb *openvdb = iso_vdb_library(path, err);
    if (!openvdb)
        return ISO_E_MISSING;
    double start = iso_clock_seconds();
    int code = openvdb->measure(path, &stats->active_voxels, &stats->memory_bytes, &message);
    stats->read_seconds = iso_clock_seconds() - start;
    stats->file_bytes = (size_t)about.st_size;
    return code == ISO_OPENVDB_OK ? ISO_OK : iso_vdb_fail(code, path, &message, err);
}

iso_status iso_vdb_load_grid(const char *path, const char *grid, int channels, const size_t size[3], float *out,
                             iso_geometry *geometry, iso_error *err)
{
    if (channels != 1 && channels != 3)
        return iso_fail(err, ISO_E_RANGE, "%s: %d channels, a grid has 1 or 3", path, channels);
    if (!iso_path_exists(path))
        return iso_fail(err, ISO_E_IO, "%s: no such file", path);
    const iso_openvdb *openvdb = iso_vdb_library(path, err);
    if (!openvdb)
        return ISO_E_MISSING;
    iso_vdb_grid_info info;
    iso_vdb_message message = {""};
    int code = openvdb->read(path, grid, channels, size, out, &info, &message);
    if (code == ISO_OPENVDB_IO) /* the file exists, so its content is wrong */
        return iso_fail(err, ISO_E_FORMAT, "%s: cannot be read as OpenVDB: %s", path, message.text);
    if (code != ISO_OPENVDB_OK)
        return iso_vdb_fail(code, path, &message, err);
    if (!geometry)
        return ISO_OK;
    *geometry = (iso_geometry){.size = {size[0], size[1], size[2]}};
    memcpy(geometry->box_index, info.box_index, sizeof info.box_index);
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
            geometry->index_to_world.m[r][c] = info.unit_mm * info.index_to_world[r][c];
    iso_vec3 half = iso_mul(geometry->index_to_world, iso_v3(0.5, 0.5, 0.5));
    const iso_vec3 first = iso_v3(info.index_to_world[0][3], info.index_to_world[1][3], info.index_to_world[2][3]);
    const iso_vec3 origin = iso_v3(info.origin_mm[0], info.origin_mm[1], info.origin_mm[2]);
    geometry->origin_mm = iso_sub(iso_madd(origin, first, info.unit_mm), half);
    return iso_geometry_check(geometry, path, err);
}
