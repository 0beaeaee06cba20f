/* SPDX-License-Identifier: MIT */
/* frames_all.h - all frames of a file, or of numbered files: their number, their range, names of their outputs. */
#pragma once

#include "volume/input.h"

typedef struct iso_frames_facts {
    size_t count;
    double range[2];  /* of all frames */
    size_t widest;    /* the frame whose own range is the widest, the first of several */
    bool has_no_data; /* some voxels of some frames have none */
} iso_frames_facts;

/* Reads all frames, plane by plane. ISO_E_USAGE if there is only one; ISO_E_RANGE for NaN and infinite voxels, and for a frame
 * without data. */
iso_status iso_frames_measure(const char *path, const iso_volume_input *input, iso_frames_facts *facts, iso_error *err);
/* Does the work of iso_volume_input_labels() for all frames: the most labels of one. ISO_E_USAGE if some look like
 * label maps, others do not, and the input does not decide it. */
iso_status iso_frames_labels(const char *path, const iso_volume_input *input, size_t *count, iso_error *err);
/* Makes "out_0003.iso" of "out.iso" and "out_%04d.iso", if the suffix is ".iso"; to be freed, NULL: out of memory. */
char *iso_frames_name(const char *output, const char *suffix, size_t frame);
