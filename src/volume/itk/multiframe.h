/* SPDX-License-Identifier: MIT */
/* multiframe.h - where the frames of one DICOM file stand, and when: what ITK and GDCM do not say of each of them. */
#ifndef ISO_VOLUME_ITK_MULTIFRAME_H
#define ISO_VOLUME_ITK_MULTIFRAME_H

#include "volume/itk/stack.h"

struct FramePlanes {
    std::vector<Plane> planes;     /* empty: the file does not say where each frame stands */
    Vector u{1, 0, 0}, v{0, 1, 0}; /* from pixel to pixel in a row, and from row to row */
    bool is_spaced = false;        /* it says otherwise how far frames are apart */
};

/* Throws Failure where frames are turned against each other, or have scales of their own. */
FramePlanes planes_in(const std::string &path, size_t frames);

#endif
