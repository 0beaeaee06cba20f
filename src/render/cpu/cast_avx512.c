/* SPDX-License-Identifier: MIT */
/* cast_avx512.c - the CPU ray caster with AVX-512, sixteen rays at a time. */
#include "render/cpu/cast_width.h"
#ifdef ISO_CAST_HAS_X86
#pragma GCC target("arch=x86-64-v4,prefer-vector-width=512")
#define ISO_CAST_WIDTH 16
#include "render/cpu/cast_tile.h"
#include "render/cpu/cast_paged.h"
#include "render/cpu/cast_adjoint.h"
#endif
