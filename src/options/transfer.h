/* SPDX-License-Identifier: MIT */
/* transfer.h - the options for what a transfer function of another program leaves open, alike in every command that takes
 * one.
 *
 *     iso_cli_transfer transfer = {0};
 *     struct poptOption options[] = {ISO_CLI_TRANSFER_OPTIONS(&transfer), ..., POPT_TABLEEND};
 *     ... iso_cli_parse(...), iso_cli_transfer_load(&transfer, path, &tf, err) ...
 */
#ifndef ISO_OPTIONS_TRANSFER_H
#define ISO_OPTIONS_TRANSFER_H

#include <popt.h>

#include "tf/tf.h"

typedef struct iso_cli_transfer {
    char *name, *unit_distance, *opacity, *range; /* by popt; live until the process ends */
} iso_cli_transfer;

/* clang-format off */
#define ISO_CLI_TRANSFER_OPTIONS(a)                                                                                            \
    {"name", 0, POPT_ARG_STRING, &(a)->name, 0, "of a file with several transfer functions, this one", "NAME"},                \
    {"unit-distance", 0, POPT_ARG_STRING, &(a)->unit_distance, 0, "the length that opacities of the file are for, where it does not say", "MM"}, \
    {"opacity", 0, POPT_ARG_STRING, &(a)->opacity, 0, "of a file with colors alone: at the range's start and end", "A[,B]"},      \
    {"range", 0, POPT_ARG_STRING, &(a)->range, 0, "put the file's range here instead; fit: the volume's range", "fit|LO,HI"}
/* clang-format on */

/* ISO_E_USAGE with option and value. */
iso_status iso_cli_transfer_request(const iso_cli_transfer *a, iso_tf_request *request, iso_error *err);
iso_status iso_cli_transfer_load(const iso_cli_transfer *a, const char *path, iso_tf *tf, iso_error *err);

#endif
