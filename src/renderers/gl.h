/* SPDX-License-Identifier: MIT */
/* gl.h - the context of the OpenGL ray caster, for code that draws bricks or plans instead of a level. */
#pragma once

#include "render/gl/raycaster.h"
#include "renderers/renderers.h"

/* Returns the context, which the first call creates in r. ISO_E_MISSING: there is no OpenGL. */
iso_status iso_renderers_need_gl(iso_renderers *r, iso_gl **gl, iso_error *err);
void iso_render_stats_of_gl(const iso_gl_stats *inside, iso_render_stats *stats);
