/* SPDX-License-Identifier: MIT */
/* field.h - the field of one level for a renderer, and the source of its directions. */
#pragma once

#include "base/names.h"
#include "pyramid/pyramid.h"

typedef enum iso_direction_source {
    ISO_FROM_CODES,           /* fetch codes, filter, decode, as on a GPU */
    ISO_FROM_DECODED,         /* decode at the voxels, then filter, as in exports; the same for linear codes */
    ISO_FROM_FLOAT,           /* iso_level.directions */
    ISO_FROM_FLIPPED,         /* decode at the voxels, turn them to one side (code_decode.h), then filter */
    ISO_FROM_ON_THE_FLY,      /* central differences of the filtered scalar, one voxel apart */
    ISO_FROM_PALETTE,         /* iso_level.palette: entries of the eight voxels, filtered */
    ISO_FROM_PALETTE_NEAREST, /* the entry of the voxel that contains the point */
    ISO_SOURCE_COUNT
} iso_direction_source;

extern const iso_names iso_direction_source_names;
const char *iso_direction_source_name(iso_direction_source s);
iso_status iso_direction_source_from_name(const char *name, iso_direction_source *s, iso_error *err);

/* The content of an image of a first-hit isosurface. */
typedef enum iso_surface_output {
    ISO_SURFACE_COLOR,    /* c(iso) shade(d) */
    ISO_SURFACE_POSITION, /* of the hit, in index coordinates of the level; alpha 0: no hit */
    ISO_SURFACE_NORMAL    /* n of the hit; alpha 0: no hit */
} iso_surface_output;

typedef struct iso_surface {
    double iso; /* opaque from this value up */
    iso_surface_output output;
} iso_surface;
