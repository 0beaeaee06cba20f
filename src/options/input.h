/* SPDX-License-Identifier: MIT */
/* input.h - options for reading a volume, shared by all commands.
 *
 *     iso_volume_input input;
 *     struct poptOption options[] = {ISO_CLI_INPUT_OPTIONS(&input), ..., POPT_TABLEEND};
 *     iso_volume_input_defaults(&input);
 *     ... iso_cli_parse(...) ...
 *     iso_volume_input_load(path, &input, &volume, err); */
#ifndef ISO_OPTIONS_INPUT_H
#define ISO_OPTIONS_INPUT_H

#include <popt.h>

#include "volume/input.h"
#include "volume/unit.h"

/* clang-format off */
#define ISO_CLI_INPUT_OPTIONS(in)                                                                              \
    {"raw-size", 0, POPT_ARG_STRING, &(in)->raw_size, 0, "read a file without a header, of this size", "NXxNYxNZ"}, \
    {"raw-type", 0, POPT_ARG_STRING, &(in)->raw_type, 0, "its type: uint8, int16, float16, ...", "TYPE"},        \
    {"raw-spacing", 0, POPT_ARG_STRING, &(in)->raw_spacing, 0, "its spacing, in mm or --unit (1)", "SXxSYxSZ"},           \
    {"raw-big-endian", 0, POPT_ARG_NONE, &(in)->raw_big_endian, 0, "read its samples as big-endian", NULL},          \
    {"raw-skip", 0, POPT_ARG_LONG, &(in)->raw_skip_bytes, 0, "bytes before its samples (0)", "BYTES"},      \
    {"spacing", 0, POPT_ARG_STRING, &(in)->spacing, 0, "replace the spacing of the file", "SXxSYxSZ"}, \
    {"unit", 0, POPT_ARG_STRING, &(in)->unit, 0, "unit of lengths in the file and in options: " ISO_UNIT_NAMES, "UNIT"}, \
    {"series", 0, POPT_ARG_STRING, &(in)->series, 0, "series of a folder, by number or name", "N|NAME"}, \
    {"frame", 0, POPT_ARG_STRING, &(in)->frame, 0, "time step, numbered file or segment layer, from 0; layers also by name", "K"}, \
    {"channel", 0, POPT_ARG_STRING, &(in)->channel, 0, "channel of a voxel, from 0, or its name (colors: luminance)", "K|NAME"}, \
    {"no-data", 0, POPT_ARG_STRING, &(in)->no_data, 0, "values of voxels without data (NaN and the file's)", \
     "V|LO,HI|none"}, \
    {"resample", 0, POPT_ARG_NONE, &(in)->resample, 0, "interpolate unevenly spaced or missing slices", NULL}, \
    {"force-spacing", 0, POPT_ARG_NONE, &(in)->force_spacing, 0, "take such slices for evenly spaced", NULL}, \
    {"stored", 0, POPT_ARG_NONE, &(in)->stored, 0, "ignore the file's slope and intercept", NULL}, \
    {"labels", 0, POPT_ARG_NONE, &(in)->labels, 0, "read the volume as a label map", NULL}, \
    {"no-labels", 0, POPT_ARG_NONE, &(in)->no_labels, 0, "read the volume as intensities, which are interpolated", NULL}, \
    {"physical", 0, POPT_ARG_NONE | POPT_ARGFLAG_DOC_HIDDEN, NULL, 0, "the default", NULL}
/* clang-format on */

#endif
