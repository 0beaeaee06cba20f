/* SPDX-License-Identifier: MIT */
/* dicom_series.h - the series of a folder of DICOM files: of one SeriesInstanceUID, size, direction and spacing. */
#pragma once

#include "volume/itk/dicom.h"

struct DicomSeries {
    std::string name;
    std::vector<DicomFile> files; /* in the order of their names */
    std::string warning;          /* "", or which files are left out */
};

/* Compares names, with runs of digits as numbers: "a9" is before "a10". */
bool comes_before(const std::string &a, const std::string &b);

/* Takes the series of this name or number; NULL: the only one that is more than one slice. A folder without images,
 * such as a CD's, stands for all folders below. Without files if there is no image of DICOM. Throws Failure if there
 * are several, or if a file is damaged. */
DicomSeries choose_series(const std::string &folder, const char *wanted);
