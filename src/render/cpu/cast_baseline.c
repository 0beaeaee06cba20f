/* SPDX-License-Identifier: MIT */
/* cast_baseline.c - the CPU ray caster for any machine, four rays at a time. */
#define ISO_CAST_WIDTH 4
#include "render/cpu/cast_tile.h"
#include "render/cpu/cast_paged.h"
#include "render/cpu/cast_adjoint.h"
