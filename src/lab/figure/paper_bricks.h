/* SPDX-License-Identifier: MIT */
/* paper_bricks.h - a volume in bricks of two levels, and a place where they meet that a view sees.
 *
 * Bricks on one side of the volume have level 0, those on the other side the coarse level; the border between them
 * has a corner, so that faces of all three directions, edges and a corner are shared by both. */
#ifndef ISO_LAB_FIGURE_PAPER_BRICKS_H
#define ISO_LAB_FIGURE_PAPER_BRICKS_H

#include "brick/bricks.h"
#include "scene/scene.h"

typedef struct iso_mixed {
    iso_node_levels nodes;
    uint8_t *levels; /* owned; of each brick */
    size_t coarse;   /* the coarse level */
} iso_mixed;

/* ISO_E_RANGE: fewer than two bricks along an axis; ISO_E_MEMORY. */
iso_status iso_mixed_create(iso_mixed *m, const iso_level *level0, size_t brick_voxels, size_t coarse, int threads,
                            iso_error *err);
void iso_mixed_destroy(iso_mixed *m); /* accepts empty and NULL */

iso_brick_field iso_mixed_field(const iso_mixed *m, bool smooth);

/* The largest difference across all faces between bricks of different levels, of the limits from both sides, on a
 * grid of points of each face; a part of the volume's range. */
double iso_mixed_jump(const iso_mixed *m, bool smooth);

/* What a view sees first at `width` x `height` points of its picture: index coordinates, x negative where nothing. By
 * the opacity along the ray, or the first place of at least the value `surface` (NaN: by the transfer function). */
typedef struct iso_mixed_seen {
    size_t width, height;
    iso_vec3 *index; /* owned */
} iso_mixed_seen;
iso_status iso_mixed_look(const iso_mixed *m, const iso_view *view, double surface, size_t width, int threads,
                          iso_mixed_seen *seen, iso_error *err);
/* Whether such a place lies in a brick of level 0. */
bool iso_mixed_is_fine(const iso_mixed *m, iso_vec3 index);

/* Of the places that are seen within a voxel of a face between levels, the one where values jump most. False: there is
 * none. */
bool iso_mixed_find_border(const iso_mixed *m, const iso_mixed_seen *seen, iso_vec3 *index);

/* The view turned to a place, which fills its picture with `height_mm` there; and that picture's frame in the picture
 * of the view: left, top, right, bottom, 0 to 1. */
void iso_mixed_magnify(const iso_view *view, iso_vec3 world_mm, double height_mm, iso_view *magnified, double frame[4]);

#endif
