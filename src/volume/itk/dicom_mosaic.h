/* SPDX-License-Identifier: MIT */
/* dicom_mosaic.h - Siemens mosaics: a picture whose tiles are the slices of a volume, row by row, in a square.
 *
 * The number of slices and their normal are private elements of Siemens. */
#pragma once

#include "volume/itk/dicom_elements.h"

struct Mosaic {
    bool is_one = false;
    size_t tiles = 0, side = 0; /* slices, 0: their number is missing; tiles in a row */
    Numbers normal;             /* from slice to slice; empty if it is missing */
};

Mosaic mosaic_of(const DataSet &all);
