/* SPDX-License-Identifier: MIT */
#include "vdb/nanovdb.h"

#include "base/file.h"
#include "vdb/vdb_file.h"

iso_status iso_nanovdb_from_vdb(const char *vdb_path, const char *path, iso_error *err)
{
    const iso_openvdb *openvdb = iso_vdb_library(path, err);
    if (!openvdb)
        return ISO_E_MISSING;
    if (!openvdb->nanovdb_version())
        return iso_fail(err, ISO_E_MISSING,
                        "%s: isoshade was built without NanoVDB (on Debian: libnanovdb-dev, then make clean all)",
                        path);
    ENDED_BY(iso_output_abandon) iso_output out = {0};
    iso_vdb_message message = {""};
    NEED(iso_output_begin(&out, path, err));
    const int code = openvdb->to_nanovdb(vdb_path, out.temp_path, &message);
    return code == ISO_OPENVDB_OK ? iso_output_commit(&out, err) : iso_vdb_fail(code, path, &message, err);
}

const char *iso_nanovdb_version(void)
{
    const iso_openvdb *openvdb = iso_vdb_library("NanoVDB", NULL);
    return openvdb ? openvdb->nanovdb_version() : NULL;
}
