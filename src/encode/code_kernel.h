/* SPDX-License-Identifier: MIT */
/* code_kernel.h - the rows of the table of codes. Private to src/encode. */
#pragma once

#include "encode/code.h"
#include "encode/decode_double.h"

#define ISO_CODE_DECLARE(code, row) extern const iso_code_info iso_code_##row;
ISO_CODE_LIST(ISO_CODE_DECLARE)
#undef ISO_CODE_DECLARE
