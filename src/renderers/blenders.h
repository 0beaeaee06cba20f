/* SPDX-License-Identifier: MIT */
/* blenders.h - the Blenders that Cycles is taken from.
 *
 * "cycles" is the Blender that is found, or the first of a list; each other one is a renderer of its own, "cycles-4.3.2",
 * which is calibrated and compared as "cycles" is, and beside it. */
#ifndef ISO_BLENDERS_H
#define ISO_BLENDERS_H

#include "base/status.h"

/* NULL: nothing to do. Paths or names, with commas between them: "blender,/opt/blender-4.3/blender". Before any other call, by one thread.
 * ISO_E_MISSING, ISO_E_PROGRAM: one is not there, too old, or not Blender, by name. ISO_E_USAGE: too many. */
iso_status iso_renderers_take_blenders(const char *list, iso_error *err);

#endif
