/* SPDX-License-Identifier: MIT */
/* decode_double.h - code_decode.h in double precision, for C. */
#pragma once

#include "base/linalg.h"

#define ISO_REAL double
#define ISO_VEC3 iso_vec3
#define ISO_MAKE_VEC3(x, y, z) iso_v3(x, y, z)
#define ISO_SQRT(x) sqrt(x)
#define ISO_ABS(x) fabs(x)
#include "encode/code_decode.h"
