/* SPDX-License-Identifier: MIT */
/* viewpoint.h - viewpoints of a volume by a name or by two angles, and a default scene for volumes without a scene
 * file.
 *
 * World axes are right, anterior, superior if the file names an anatomical space; other files' axes are used in the
 * same way: front is the view along -y, z is up. Angles: AZ degrees around the z axis from the front towards the left
 * (patient's left: -x), EL degrees above the horizon. */
#pragma once

#include "base/names.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

typedef struct iso_viewpoint {
    iso_vec3 direction, up; /* view along `direction` */
} iso_viewpoint;

extern const iso_names iso_viewpoint_names;

/* Parses a name of the table, or "AZ,EL" in degrees. ISO_E_USAGE. */
iso_status iso_viewpoint_parse(const char *text, iso_viewpoint *viewpoint, iso_error *err);
/* Returns the view along the shortest axis of a thin slab, "front" for a patient, or "iso", which shows three faces if
 * the axes are unknown. */
const char *iso_viewpoint_usual(const iso_geometry *g);

/* Returns camera, light, shading and background of a first picture. The camera frames the corners of the box closely;
 * the caller sets the transfer function. */
iso_scene iso_scene_first(const iso_geometry *level0, const iso_viewpoint *viewpoint, size_t width, size_t height);
/* The camera moves closer if the visible part needs at most this fraction of the distance for the box. */
#define ISO_FRAME_VISIBLE_BELOW 0.7
/* A box in index coordinates of level 0. */
typedef struct iso_scene_part {
    double lo[3], hi[3];
    bool is_known; /* False: not found yet */
} iso_scene_part;
/* Frames the visible part of level 0, without the planes at each end of an axis that hold a thousandth of all opacity.
 * For a first picture's camera. visible: kept between the views of one TF, which starts as {0}; or NULL. ISO_E_MEMORY. */
iso_status iso_scene_frame_visible(iso_scene *scene, const iso_level *level0, const iso_tf_table *tf, int threads,
                                   iso_scene_part *visible, iso_error *err);
/* Replaces the camera of a scene by one from this viewpoint, which frames the box of `level0`. */
void iso_scene_look_from(iso_scene *scene, const iso_geometry *level0, const iso_viewpoint *viewpoint);
