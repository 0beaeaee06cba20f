/* SPDX-License-Identifier: MIT */
/* nrrd_segments.h - the segments that a .seg.nrrd file names; private to src/volume. */
#pragma once

#include <stdbool.h>

#include <jansson.h>
#include <teem/nrrd.h>

/* Returns each segment with its layer (segments.h); NULL if the file names none. has_layers: it has an axis of them. */
json_t *iso_nrrd_segments(const Nrrd *nrrd, bool has_layers);
