/* SPDX-License-Identifier: MIT */
/* tf_suggest.h - `isoshade tf suggest`: writes a transfer function for a volume, to edit. */
#pragma once

#include "cli/tf_adapt.h"

iso_status iso_cli_tf_suggest(const iso_tf_arguments *a, iso_error *err);
