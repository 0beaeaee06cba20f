/* SPDX-License-Identifier: MIT */
/* netcdf_header.h - the header of a classic netCDF file, before netCDF's library sees it: the library copies names and
 * lists of dimensions of any length into its callers' buffers (nc_inq_var() and the like of 4.9), which its
 * documentation lets be of NC_MAX_NAME and NC_MAX_VAR_DIMS. */
#pragma once

#include <string>

/* Checks a classic header. Throws Failure (child_writer.h): ISO_E_FORMAT if a name, a list or the header itself is
 * longer than allowed. Files that are not classic are left to the library. Format: the netCDF Classic Format
 * Specification, versions 1, 2 and 5. */
void check_netcdf_header(const std::string &path);
