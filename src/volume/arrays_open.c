/* SPDX-License-Identifier: MIT */
/* arrays_open.c - opens the formats of the program isoshade-arrays: files that hold arrays, of which FILE:DATASET
 * names one. */
#define _GNU_SOURCE
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inputs.h"
#include "volume/child.h"

static iso_status open_arrays(iso_volume_source *source, iso_error *err)
{
    static const iso_child_program arrays = {"isoshade-arrays", "HDF5 or netCDF",
                                             "libhdf5-dev, libnetcdf-dev, libblosc-dev and liblz4-dev"};
    if (iso_path_is_dir(source->path))
        NEED(iso_inputs_note_folder(source->path, err));
    return iso_child_open(source, &arrays, source->part, err);
}

#define HDF5_MARK ISO_MARK(0, "\x89HDF\r\n\x1a\n")

/* True for HDF5 after bytes of the user's own, at 512, 1024, 2048 ...: so MATLAB's files of version 7.3 begin. */
static bool has_user_block(const char *path)
{
    enum { MOST_BYTES = 1 << 20 };
    static const iso_mark mark = HDF5_MARK;
    unsigned char head[8];
    ENDED_BY(iso_close_file) FILE *f = iso_path_is_file(path) ? fopen(path, "rb") : NULL;
    bool found = false;
    for (long at = 512; f && !found && at <= MOST_BYTES && fseek(f, at, SEEK_SET) == 0; at *= 2)
        found = iso_marks_fit(&mark, 1, head, fread(head, 1, sizeof head, f));
    return found;
}

/* True if the folder is a Zarr array or group, of version 2 or 3. */
static bool is_zarr(const char *path)
{
    static const char *const files[] = {".zarray", ".zgroup", ".zattrs", "zarr.json"};
    bool found = false;
    for (size_t i = 0; i < sizeof files / sizeof files[0] && !found; ++i) {
        FREED char *file = iso_path_is_dir(path) ? iso_path_join(path, files[i]) : NULL;
        found = file && iso_path_exists(file);
    }
    return found;
}

const iso_volume_format iso_volume_format_hdf5 = {
    .name = "hdf5",
    .title = "HDF5, netCDF-4 and MINC 2",
    .summary = "FILE:DATASET, by its coordinates, chunk by chunk; needs HDF5's library",
    .suffixes = ".h5 .hdf5 .hdf .nc .nc4 .mnc .ims",
    .starts = "\"\\x89HDF\"",
    .takes_part = true,
    .marks = {HDF5_MARK},
    .probe_path = has_user_block,
    .open = open_arrays,
};

const iso_volume_format iso_volume_format_netcdf = {
    .name = "netcdf",
    .title = "netCDF and MINC 1",
    .summary = "classic files, FILE:VARIABLE, by its coordinates, plane by plane; needs netCDF's library",
    .suffixes = ".nc .cdf .mnc",
    .starts = "\"CDF\"",
    .takes_part = true,
    .marks = {ISO_MARK(0, "CDF\1"), ISO_MARK(0, "CDF\2"), ISO_MARK(0, "CDF\5")},
    .open = open_arrays,
};

const iso_volume_format iso_volume_format_zarr = {
    .name = "zarr",
    .title = "OME-Zarr and Zarr 2 and 3",
    .summary = "a folder, its largest level or FOLDER:ARRAY; shards, blosc, gzip, lz4, zlib and zstd, chunk by chunk",
    .suffixes = ".ome.zarr .zarr",
    .starts = "a folder with .zattrs, .zarray or zarr.json",
    .takes_part = true,
    .probe_path = is_zarr,
    .open = open_arrays,
};
