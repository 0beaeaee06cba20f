/* SPDX-License-Identifier: MIT */
/* dicom_mosaic.h - Siemens mosaics: a picture whose tiles are the slices of a volume, row by row, in a square.
 *
 * The number of slices and their normal are private elements of Siemens. The picture's place is the corner of a slice of
 * the whole picture's size with the same center. */
#ifndef ISO_VOLUME_ITK_DICOM_MOSAIC_H
#define ISO_VOLUME_ITK_DICOM_MOSAIC_H

#include "volume/itk/dicom.h"
#include "volume/itk/dicom_elements.h"

/* True if ImageType has the word. */
bool is_mosaic(const DataSet &all);
/* Turns the file's only frame into one per tile, `step` mm apart, and its size into that of a tile. Throws Failure if the
 * number of tiles is missing or impossible. */
void take_mosaic(const DataSet &all, double step, DicomFile &file);

#endif
