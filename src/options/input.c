/* SPDX-License-Identifier: MIT */
#include "options/input.h"

#include "volume/unit.h"

const iso_option iso_input_rows[] = {
    {"raw-size", 0, "read a file without a header, of this size", "NXxNYxNZ", ISO_IN(iso_volume_input, raw_size)},
    {"raw-type", 0, "its type: uint8, int16, float16, ...", "TYPE", ISO_IN(iso_volume_input, raw_type)},
    {"raw-spacing", 0, "its spacing, in mm or --unit (1)", "SXxSYxSZ", ISO_IN(iso_volume_input, raw_spacing)},
    {"raw-big-endian", 0, "read its samples as big-endian", NULL, ISO_IN(iso_volume_input, raw_big_endian)},
    {"raw-skip", 0, "bytes before its samples (0)", "BYTES", ISO_IN(iso_volume_input, raw_skip_bytes)},
    {"spacing", 0, "replace the spacing of the file", "SXxSYxSZ", ISO_IN(iso_volume_input, spacing)},
    {"unit", 0, "unit of lengths in the file and in options: " ISO_UNIT_NAMES, "UNIT", ISO_IN(iso_volume_input, unit)},
    {"series", 0, "series of a folder, by number or name", "N|NAME", ISO_IN(iso_volume_input, series)},
    {"frame", 0, "time step, numbered file or segment layer, from 0; layers also by name", "K",
     ISO_IN(iso_volume_input, frame)},
    {"channel", 0, "channel of a voxel, from 0, or its name (colors: luminance)", "K|NAME",
     ISO_IN(iso_volume_input, channel)},
    {"no-data", 0, "values of voxels without data (NaN and the file's)", "V|LO,HI|none",
     ISO_IN(iso_volume_input, no_data)},
    {"resample", 0, "interpolate unevenly spaced or missing slices", NULL, ISO_IN(iso_volume_input, resample)},
    {"force-spacing", 0, "take such slices for evenly spaced", NULL, ISO_IN(iso_volume_input, force_spacing)},
    {"stored", 0, "ignore the file's slope and intercept", NULL, ISO_IN(iso_volume_input, stored)},
    {"labels", 0, "read the volume as a label map", NULL, ISO_IN(iso_volume_input, labels)},
    {"no-labels", 0, "read the volume as intensities, which are interpolated", NULL,
     ISO_IN(iso_volume_input, no_labels)},
    ISO_OPTIONS_END,
};
