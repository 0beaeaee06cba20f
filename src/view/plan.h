/* SPDX-License-Identifier: MIT */
/* plan.h - a plan's bricks as arrays of a page: the full cache of the ray caster (brick/pack.h) with 16-bit scalars
 * over the range and directions in the pyramid's code, and the position of each brick in it. */
#pragma once

#include "view/contents.h"

/* Adds "plan" to the root, and its arrays. ISO_E_RANGE: more bricks than a texture holds. ISO_E_MEMORY. */
iso_status iso_contents_add_plan(const iso_viewer *v, iso_contents *contents, iso_error *err);
