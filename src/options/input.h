/* SPDX-License-Identifier: MIT */
/* input.h - options for reading a volume, shared by all commands: rows for iso_volume_input. */
#pragma once

#include "options/option.h"
#include "volume/input.h"

extern const iso_option iso_input_rows[];
