/* SPDX-License-Identifier: MIT */
/* value_unit.h - the unit of a volume's values, such as HU, which files may name: DICOM, NRRD, netCDF. Apart from input.h,
 * whose volumes do without. */
#pragma once

#include "volume/input.h"

enum { ISO_VALUE_UNIT_BYTES = 16 };

/* Returns the unit of the values as they were read; "" if the file names none, or if its scale was left out. */
const char *iso_value_unit_of(const iso_volume_notes *notes);
/* Reads the unit from a volume's header; "" also for pyramids and for files that cannot be read. */
void iso_value_unit_read(const char *path, const iso_volume_input *input, char unit[ISO_VALUE_UNIT_BYTES]);
