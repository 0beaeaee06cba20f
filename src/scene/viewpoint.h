/* SPDX-License-Identifier: MIT */
/* viewpoint.h - viewpoints of a volume, by a name or by two angles; and a whole scene without a scene file.
 *
 * The world is right, anterior, superior if the file names an anatomical space. Other files' axes are used in the
 * same way: front is the view along -y, z is up. Angles: AZ degrees round the z axis from the front towards the left
 * (patient's left: -x), EL degrees above the horizon. */
#ifndef ISO_SCENE_VIEWPOINT_H
#define ISO_SCENE_VIEWPOINT_H

#include "base/names.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

typedef struct iso_viewpoint {
    iso_vec3 direction, up; /* looking along direction */
} iso_viewpoint;

extern const iso_names iso_viewpoint_names;

/* A name of the table, or "AZ,EL" in degrees. ISO_E_USAGE. */
iso_status iso_viewpoint_parse(const char *text, iso_viewpoint *viewpoint, iso_error *err);
/* "front" of a patient, else "iso": whose axes are not known, of that three faces should be seen. */
const char *iso_viewpoint_usual(const iso_geometry *g);

/* Camera, light, shading and background of a first picture: the camera frames the corners of the box closely. The
 * transfer function is left empty, to be set. */
iso_scene iso_scene_first(const iso_geometry *level0, const iso_viewpoint *viewpoint, size_t width, size_t height);
/* The camera moves nearer if the visible part needs at most this part of the distance at which the box is framed. */
#define ISO_FRAME_VISIBLE_BELOW 0.7
/* Frames the part of level 0 that the table makes visible: the planes across each axis without a thousandth of all
 * opacity at each end. For a first picture's camera. ISO_E_MEMORY. */
iso_status iso_scene_frame_visible(iso_scene *scene, const iso_level *level0, const iso_tf_table *tf, int threads,
                                   iso_error *err);
/* A camera that looks from there in a scene that has another, framing the box of `level0`. */
void iso_scene_look_from(iso_scene *scene, const iso_geometry *level0, const iso_viewpoint *viewpoint);

#endif
