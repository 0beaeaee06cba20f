/* SPDX-License-Identifier: MIT */
/* blenders.h - the Blenders that Cycles is taken from.
 *
 * "cycles" is the installed Blender, or the first of a list. Each other one is a renderer of its own, such as
 * "cycles-4.3.2"; it is calibrated like "cycles" and also compared with it. */
#pragma once

#include "base/status.h"

/* Registers a list of paths or names, separated by commas: "blender,/opt/blender-4.3/blender"; NULL: nothing to do.
 * Call it before all others, from one thread. ISO_E_MISSING, ISO_E_PROGRAM: one is not installed, too old, or not
 * Blender; the message names it. ISO_E_USAGE: too many. */
iso_status iso_renderers_take_blenders(const char *list, iso_error *err);
