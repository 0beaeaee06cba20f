/* SPDX-License-Identifier: MIT */
/* placement.h - positions and scale of an array's samples, by the file's attributes. */
#pragma once

#include "volume/arrays/store.h"

/* Fills the header of the array, except size and type. space: the array's axes of the grid, the fastest first. */
void place(Store &store, const Array &array, const size_t (&space)[3], const std::string &path,
           iso_child_header &header);

/* Takes the distance of samples along the axis of frames, and its unit, if the file has one and it is even (within 1
 * %). */
void take_frame_step(Store &store, const Array &array, size_t axis, iso_child_header &header);

/* MINC scales each slice for itself. */
struct SliceScales {
    std::vector<double> slope, intercept; /* empty, or of each plane */
};
/* A scale that is the same everywhere goes into the header. */
SliceScales take_scale(Store &store, const Array &array, size_t planes, size_t frame, const std::string &path,
                       iso_child_header &header);
