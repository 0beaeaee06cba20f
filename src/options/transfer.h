/* SPDX-License-Identifier: MIT */
/* transfer.h - options that complete transfer functions of other programs, shared by all commands that take one. */
#pragma once

#include "options/option.h"
#include "tf/tf.h"

typedef struct iso_cli_transfer {
    char *name, *unit_distance, *opacity, *range;
} iso_cli_transfer;
extern const iso_option iso_transfer_rows[];

/* Fills a request of iso_tf_load_as(). ISO_E_USAGE names the option and its value. */
iso_status iso_cli_transfer_request(const iso_cli_transfer *a, iso_tf_request *request, iso_error *err);
