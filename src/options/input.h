/* SPDX-License-Identifier: MIT */
/* input.h - the options by which every command reads a volume.
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
    {"raw-size", 0, POPT_ARG_STRING, &(in)->raw_size, 0, "the volume is a file without a header, of this size", "NXxNYxNZ"}, \
    {"raw-type", 0, POPT_ARG_STRING, &(in)->raw_type, 0, "its type: uint8, int16, float, ...", "TYPE"},        \
    {"raw-spacing", 0, POPT_ARG_STRING, &(in)->raw_spacing, 0, "its spacing (1), in mm where --unit names no other", "SXxSYxSZ"},           \
    {"raw-big-endian", 0, POPT_ARG_NONE, &(in)->raw_big_endian, 0, "its bytes are big-endian", NULL},          \
    {"raw-skip", 0, POPT_ARG_LONG, &(in)->raw_skip_bytes, 0, "bytes before its samples", "BYTES"},      \
    {"spacing", 0, POPT_ARG_STRING, &(in)->spacing, 0, "the volume's spacing, where its file has none or a wrong one", "SXxSYxSZ"}, \
    {"unit", 0, POPT_ARG_STRING, &(in)->unit, 0, "unit of lengths, in the file and here: " ISO_UNIT_NAMES, "UNIT"}, \
    {"series", 0, POPT_ARG_STRING, &(in)->series, 0, "which of a folder's series: its number, or its name", "N|NAME"}, \
    {"frame", 0, POPT_ARG_STRING, &(in)->frame, 0, "which of a file's time steps, or of numbered files, from 0; which layer of segments, by a name, too", "K"}, \
    {"channel", 0, POPT_ARG_STRING, &(in)->channel, 0, "which of a voxel's numbers, from 0, or its name; colors: luminance", "K|NAME"}, \
    {"stored", 0, POPT_ARG_NONE, &(in)->stored, 0, "values as they are stored, without the file's slope and intercept", NULL}, \
    {"labels", 0, POPT_ARG_NONE, &(in)->labels, 0, "the volume is a label map, whatever its samples look like", NULL}, \
    {"no-labels", 0, POPT_ARG_NONE, &(in)->no_labels, 0, "the volume has intensities, which are interpolated", NULL}, \
    {"physical", 0, POPT_ARG_NONE | POPT_ARGFLAG_DOC_HIDDEN, NULL, 0, "the default", NULL}
/* clang-format on */

#endif
