/* SPDX-License-Identifier: MIT */
/* analyzed.h - read before each file that clang's analyzer looks at (analyze.sh). It looks into one file at a time, and
 * would follow ways on which iso_fail() or iso_errno_status() return success. */
#define _GNU_SOURCE /* as most files say at first */
#include "base/status.h"
#define iso_fail(err, status, ...) (iso_fail(err, status, __VA_ARGS__), (status))
#define iso_errno_status() ISO_E_IO
