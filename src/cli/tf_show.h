/* SPDX-License-Identifier: MIT */
/* tf_show.h - `isoshade tf show`: draws transfer functions over the histogram of a volume. */
#pragma once

#include "cli/tf_adapt.h"

iso_status iso_cli_tf_show(const iso_tf_arguments *a, iso_error *err);
