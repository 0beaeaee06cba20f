/* SPDX-License-Identifier: MIT */
/* input.h - settings for reading a volume that its file lacks: size, type and spacing of a file without a header,
 * spacing, unit, which series, frame and channel; stored or physical values. The fields are the texts and numbers of
 * the options of the same names, 0 if not given. */
#pragma once

#include "volume/labels.h"

typedef struct iso_volume_input {
    char *raw_size, *raw_type, *raw_spacing; /* borrowed; "40x56x33", "uint8", "1x1x2.5" */
    char *spacing, *unit, *series;           /* "0.2x0.2x1", "um", "2" */
    char *frame, *channel, *no_data;         /* "3", "red", "-2000" */
    int raw_big_endian, stored, labels, no_labels, resample, force_spacing;
    long raw_skip_bytes;
    bool takes_first; /* of several frames and channels, unless one is named: for an overview */
} iso_volume_input;

/* Returns the given options as on a command line, each after a space; to be freed. */
char *iso_volume_input_line(const iso_volume_input *input);

/* Loads a volume as iso_volume_load() does. ISO_E_USAGE also for raw options that are missing or contradict each
 * other. */
iso_status iso_volume_input_load(const char *path, const iso_volume_input *input, iso_volume *v, iso_error *err);
iso_status iso_volume_input_open(const char *path, const iso_volume_input *input, iso_volume_source **source,
                                 iso_error *err);
/* Does the rest of iso_volume_input_load() for an open source, and closes it. */
iso_status iso_volume_input_load_source(iso_volume_source *source, const char *path, const iso_volume_input *input,
                                        iso_volume *v, iso_error *err);
/* Counts the labels of a volume that is a label map, by the caller's hint or by its samples; 0: intensities. It
 * reads only as far as needed. iso_volume_input_load() leaves the count in the notes. */
iso_status iso_volume_input_look(const char *path, const iso_volume_input *input, size_t *count,
                                 iso_label_facts *facts, iso_error *err);
/* Does the same for a volume that is read by planes. ISO_E_RANGE for labels beyond 16 bits, which only
 * iso_volume_input_load() numbers. */
iso_status iso_volume_input_labels(const char *path, const iso_volume_input *input, size_t *count, iso_error *err);
