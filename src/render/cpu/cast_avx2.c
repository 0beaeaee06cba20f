/* SPDX-License-Identifier: MIT */
/* cast_avx2.c - the CPU ray caster with AVX2, eight rays at a time. */
#include "render/cpu/cast_width.h"
#ifdef ISO_CAST_HAS_X86
#pragma GCC target("avx2")
#define ISO_CAST_WIDTH 8
#include "render/cpu/cast_tile.h"
#include "render/cpu/cast_paged.h"
#include "render/cpu/cast_adjoint.h"
#endif
