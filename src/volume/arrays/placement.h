/* SPDX-License-Identifier: MIT */
/* placement.h - where an array's samples stand, and their scale, by what the file says of them. */
#ifndef ISO_VOLUME_ARRAYS_PLACEMENT_H
#define ISO_VOLUME_ARRAYS_PLACEMENT_H

#include "volume/arrays/store.h"

/* space: which axes of the array are its grid's, the fastest first. Fills in all of the header but its size and type. */
void place(Store &store, const Array &array, const size_t (&space)[3], const std::string &path,
           iso_child_header &header);

/* How far the samples along the axis of frames are apart, and in what, where the file says so evenly (within 1 %). */
void take_frame_step(Store &store, const Array &array, size_t axis, iso_child_header &header);

/* MINC scales each slice for itself. */
struct SliceScales {
    std::vector<double> slope, intercept; /* empty, or of each plane */
};
/* A scale that is the same everywhere goes into the header. */
SliceScales take_scale(Store &store, const Array &array, size_t planes, const std::string &path,
                       iso_child_header &header);

#endif
