/* SPDX-License-Identifier: MIT */
/* nrrd_segments.h - the segments that a .seg.nrrd file names; private to src/volume. */
#ifndef ISO_VOLUME_NRRD_SEGMENTS_H
#define ISO_VOLUME_NRRD_SEGMENTS_H

#include <stdbool.h>

#include <jansson.h>
#include <teem/nrrd.h>

/* Each with its layer (segments.h); NULL where the file names none. has_layers: it has an axis of them. */
json_t *iso_nrrd_segments(const Nrrd *nrrd, bool has_layers);

#endif
