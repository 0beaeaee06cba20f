/* SPDX-License-Identifier: MIT */
/* cast_one.c - the CPU ray caster, a ray at a time: the others are tested against it. */
#define ISO_CAST_WIDTH 1
#include "render/cpu/cast_tile.h"
#include "render/cpu/cast_paged.h"
#include "render/cpu/cast_adjoint.h"
