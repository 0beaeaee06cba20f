/* SPDX-License-Identifier: MIT */
/* gl.h - the context of the OpenGL ray caster, for those who draw with it what is not a level: bricks, plans. */
#ifndef ISO_RENDERERS_GL_H
#define ISO_RENDERERS_GL_H

#include "render/gl/raycaster.h"
#include "renderers/renderers.h"

/* Made at its first use and kept in r. ISO_E_MISSING. */
iso_status iso_renderers_need_gl(iso_renderers *r, iso_gl **gl, iso_error *err);
void iso_render_stats_of_gl(const iso_gl_stats *inside, iso_render_stats *stats);

#endif
