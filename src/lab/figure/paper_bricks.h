/* SPDX-License-Identifier: MIT */
/* paper_bricks.h - a volume in bricks of two levels, and a visible place where the levels meet.
 *
 * Bricks on one side of the volume have level 0, those on the other side the coarse level. The border between them has
 * a corner, so that the levels share faces of all three directions, edges and a corner. */
#pragma once

#include "brick/bricks.h"
#include "scene/scene.h"

typedef struct iso_mixed {
    iso_node_levels nodes;
    uint8_t *levels; /* owned; one per brick */
    size_t coarse;   /* the coarse level */
} iso_mixed;

/* Splits the volume into bricks. ISO_E_RANGE: fewer than two bricks along an axis. ISO_E_MEMORY. */
iso_status iso_mixed_create(iso_mixed *m, const iso_level *level0, size_t brick_voxels, size_t coarse, int threads,
                            iso_error *err);
void iso_mixed_destroy(iso_mixed *m); /* accepts empty and NULL */

iso_brick_field iso_mixed_field(const iso_mixed *m, bool smooth);

/* Returns the largest difference between both sides of the faces between bricks of different levels, over a grid of
 * points per face, as a fraction of the volume's range. */
double iso_mixed_jump(const iso_mixed *m, bool smooth);

/* First visible places at `width` x `height` points of a view's picture, in index coordinates; x is negative if nothing
 * is visible. By opacity along the ray (`surface` NaN), or the first place with at least the value `surface`. */
typedef struct iso_mixed_seen {
    size_t width, height;
    iso_vec3 *index; /* owned */
} iso_mixed_seen;
iso_status iso_mixed_look(const iso_mixed *m, const iso_view *view, double surface, size_t width, int threads,
                          iso_mixed_seen *seen, iso_error *err);
/* True if the place lies in a brick of level 0. */
bool iso_mixed_is_fine(const iso_mixed *m, iso_vec3 index);

/* Finds, among the visible places within a voxel of a face between levels, the one with the largest jump of values.
 * Returns false if there is none. */
bool iso_mixed_find_border(const iso_mixed *m, const iso_mixed_seen *seen, iso_vec3 *index);

/* Turns the view to a place, so that its picture is `height_mm` high there. frame: that picture's left, top, right and
 * bottom within the original one, 0 to 1. */
void iso_mixed_magnify(const iso_view *view, iso_vec3 world_mm, double height_mm, iso_view *magnified, double frame[4]);
