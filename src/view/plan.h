/* SPDX-License-Identifier: MIT */
/* plan.h - a plan's bricks as arrays of a page: the cache that the ray caster would fill (brick/pack.h), scalars in 16 bits
 * over the range, directions by the pyramid's code, and where each brick is in it. */
#ifndef ISO_VIEW_PLAN_H
#define ISO_VIEW_PLAN_H

#include "view/contents.h"

/* Adds "plan" to the root, and its arrays. ISO_E_RANGE: more than one texture holds; ISO_E_MEMORY. */
iso_status iso_contents_add_plan(const iso_viewer *v, iso_contents *contents, iso_error *err);

#endif
