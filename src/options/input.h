/* input.h - the options by which every command reads a volume.
 *
 *     iso_cli_input input;
 *     struct poptOption options[] = {ISO_CLI_INPUT_OPTIONS(&input), ..., POPT_TABLEEND};
 *     iso_cli_input_defaults(&input);
 *     ... iso_cli_parse(...) ...
 *     iso_cli_load_volume(path, &input, &volume, err); */
#ifndef ISO_OPTIONS_INPUT_H
#define ISO_OPTIONS_INPUT_H

#include <popt.h>

#include "volume/stream.h"

typedef struct iso_cli_input {
    char *raw_size, *raw_type, *raw_spacing; /* by popt; live until the process ends */
    int raw_big_endian, physical;
    long raw_skip_bytes;
} iso_cli_input;

#define ISO_CLI_INPUT_OPTIONS(in)                                                                              \
    {"raw-size", 0, POPT_ARG_STRING, &(in)->raw_size, 0, "the volume is a file without a header, of this size", "NXxNYxNZ"}, \
    {"raw-type", 0, POPT_ARG_STRING, &(in)->raw_type, 0, "its type: uint8, int16, float, ...", "TYPE"},        \
    {"raw-spacing", 0, POPT_ARG_STRING, &(in)->raw_spacing, 0, "its spacing in mm (1)", "SXxSYxSZ"},           \
    {"raw-big-endian", 0, POPT_ARG_NONE, &(in)->raw_big_endian, 0, "its bytes are big-endian", NULL},          \
    {"raw-skip", 0, POPT_ARG_LONG, &(in)->raw_skip_bytes, 0, "bytes before its samples", "BYTES"},      \
    {"physical", 0, POPT_ARG_NONE, &(in)->physical, 0, "apply the file's slope and intercept; samples become float", NULL}

void iso_cli_input_defaults(iso_cli_input *input);
/* The options that were given, as a command line has them, each after a space; to be freed. */
char *iso_cli_input_line(const iso_cli_input *input);

/* ISO_E_USAGE for raw options that miss or contradict; else as iso_volume_load. */
iso_status iso_cli_load_volume(const char *path, const iso_cli_input *input, iso_volume *v, iso_error *err);
iso_status iso_cli_open_source(const char *path, const iso_cli_input *input, iso_volume_source **source, iso_error *err);

#endif
