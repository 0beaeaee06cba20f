/* SPDX-License-Identifier: MIT */
/* gl_devices.h - the devices that EGL lists, and the choice of one. Private to src/render/gl.
 *
 * Without a choice: each device except software renderers, then the platform without a surface. A choice is a device's
 * number, a part of its OpenGL vendor or renderer name (ignoring case), or "surfaceless"; a choice has no fallback.
 * */
#pragma once

#include "render/gl/gl_context.h"

/* Reports missing libraries as ISO_E_MISSING: without this check, epoxy would end the program. */
iso_status iso_gl_find_libraries(iso_error *err);

/* Makes gl->display and gl->context, current on this thread, and fills gl->info.device. choice: NULL or "": none.
 * ISO_E_MISSING lists the devices tried, with reasons. */
iso_status iso_gl_open(iso_gl *gl, const char *choice, iso_error *err);
