/* SPDX-License-Identifier: MIT */
/* pictures.h - a folder of numbered pictures, one per slice: PNG, JPEG, TIFF or BMP.
 *
 * The kind of most files is taken; other files, such as the log of a scanner, are left out. The names of slices differ
 * in one number, whose steps are even. Of colors one channel is given, or their luminance. */
#pragma once

#include "volume/itk/slice.h"

/* True if a file of the folder is a picture by its name or its first bytes. */
bool holds_pictures(const std::string &folder);
/* Reads the headers. Throws Failure if slices differ, or if one is missing. */
std::unique_ptr<PlaneReader> open_pictures(const std::string &folder, size_t channel);
