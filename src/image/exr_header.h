/* SPDX-License-Identifier: MIT */
/* exr_header.h - checks the sizes in OpenEXR headers before the library reads them.
 *
 * The library reserves memory by sizes in the file before it looks for the bytes: of attributes, of strings in them, of
 * previews, and of its tables of tiles. So a file of 600 bytes can make it fill gigabytes. */
#pragma once

#include <stddef.h>

#include "base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Checks that all attributes of all headers lie in the file and have the sizes of their types. Checks also that the
 * file can hold an entry of 8 bytes per tile. ISO_E_FORMAT names the attribute. */
iso_status iso_exr_header_check(const char *path, const char *data, size_t size, iso_error *err);

#ifdef __cplusplus
}
#endif
