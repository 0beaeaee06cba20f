/* SPDX-License-Identifier: MIT */
/* dicom_segments.h - segmentations whose frames belong to one segment each (PS3.3 C.8.20): a label map.
 *
 * A voxel's label is the number of its segment. Segments that overlap, and those of fractional values, are channels
 * instead, named as the segments. Slices that the file leaves out are empty. */
#pragma once

#include "volume/itk/dicom.h"

/* True if each frame belongs to a segment. */
bool is_of_segments(const DicomFile &file);
/* Reads all frames. Throws Failure if slices have no even distance. */
std::unique_ptr<PlaneReader> open_segments(const DicomFile &file, size_t channel);

/* Copies the names of its segments to the header of a label map. */
void name_segments(const DicomFile &file, iso_child_header &header);
