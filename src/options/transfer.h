/* SPDX-License-Identifier: MIT */
/* transfer.h - options that complete transfer functions of other programs, shared by all commands that take one.
 *
 *     iso_cli_transfer transfer = {0};
 *     struct poptOption options[] = {ISO_CLI_TRANSFER_OPTIONS(&transfer), ..., POPT_TABLEEND};
 *     ... iso_cli_parse(...), iso_cli_transfer_request(&transfer, &request, err) ...
 */
#ifndef ISO_OPTIONS_TRANSFER_H
#define ISO_OPTIONS_TRANSFER_H

#include <popt.h>

#include "tf/tf.h"

typedef struct iso_cli_transfer {
    char *name, *unit_distance, *opacity, *range; /* set by popt, live until the process ends */
} iso_cli_transfer;

/* clang-format off */
#define ISO_CLI_TRANSFER_OPTIONS(a)                                                                                            \
    {"name", 0, POPT_ARG_STRING, &(a)->name, 0, "transfer function of a file that holds several", "NAME"},                \
    {"unit-distance", 0, POPT_ARG_STRING, &(a)->unit_distance, 0, "length that the opacities are for, if the file lacks it", "MM"}, \
    {"opacity", 0, POPT_ARG_STRING, &(a)->opacity, 0, "opacity at both ends of the range, for files of colors only", "A[,B]"},      \
    {"range", 0, POPT_ARG_STRING, &(a)->range, 0, "replace the file's range; fit: use the volume's range", "fit|LO,HI"}
/* clang-format on */

/* Fills a request of iso_tf_load_as(). ISO_E_USAGE names the option and its value. */
iso_status iso_cli_transfer_request(const iso_cli_transfer *a, iso_tf_request *request, iso_error *err);

#endif
