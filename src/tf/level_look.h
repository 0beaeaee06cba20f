/* SPDX-License-Identifier: MIT */
/* level_look.h - the transfer functions of levels that were made for scenes (plan/scene_levels.h): that of each scene,
 * and the level's own, which shows it. Both stand in iso_pyramid.made_for (doc/reference/files-pyramid.md). A level may
 * have an extinction scale, too, iso_level.scale.
 *
 * Under a scene's transfer function a level is shown so by all commands, without --adapt. Under another one it is
 * shown as any level; an optimized one as it is. */
#pragma once

#include "pyramid/pyramid.h"
#include "tf/tf.h"

/* Returns the number of scenes that levels were made for. */
size_t iso_level_scene_count(const iso_pyramid *p);
/* Returns their names with commas, to be freed; NULL: no memory. */
char *iso_level_scene_names(const iso_pyramid *p);
/* Makes the table of a scene's transfer function. ISO_E_FORMAT, ISO_E_MEMORY. */
iso_status iso_level_scene_tf(const iso_pyramid *p, size_t scene, iso_tf_table *tf, iso_error *err);

/* Copies the level's own table, or tf if it has none. *found (may be NULL): False, with no table, if the level was not
 * made for tf, level 0's. ISO_E_FORMAT: what pyramid.json says is no transfer function; ISO_E_MEMORY. */
iso_status iso_level_look(const iso_pyramid *p, size_t level, const iso_tf_table *tf, iso_tf_table *own, bool *found,
                          iso_error *err);

/* Returns the level's extinction scale, borrowed; NULL if it has none or was not made for tf. The share of voxels with
 * data is for any tf. */
const uint8_t *iso_level_own_scale(const iso_pyramid *p, size_t level, const iso_tf_table *tf);

/* Returns a new object for a level of made_for. */
json_t *iso_level_look_to_json(const iso_tf_table *own);
