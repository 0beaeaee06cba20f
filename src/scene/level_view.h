/* SPDX-License-Identifier: MIT */
/* level_view.h - shows levels that were made for a scene under their own transfer function and extinction scale
 * (tf/level_look.h). Each command that draws or exports a level asks here first. */
#pragma once

#include "pyramid/pyramid.h"
#include "scene/scene.h"

/* Copies the level's scale to the view, if it has one. ISO_E_MEMORY. */
iso_status iso_view_take_scale(iso_view *view, const iso_level *level, iso_error *err);

/* If the level was made for the view's transfer function, replaces this and the extinction scale by the level's.
 * *found: True then. Otherwise a level with has_no_data gives its scale alone. ISO_E_FORMAT, ISO_E_MEMORY. */
iso_status iso_view_take_level(iso_view *view, const iso_pyramid *p, size_t level, bool *found, iso_error *err);
