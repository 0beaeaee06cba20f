/* SPDX-License-Identifier: MIT */
/* level_scene.h - what `build --for` would store of a level, as methods of `isoshade-lab levels` (level_methods.h). */
#ifndef ISO_LAB_LEVEL_SCENE_H
#define ISO_LAB_LEVEL_SCENE_H

#include "lab/level_methods.h"
#include "scene/scene.h"

/* A scene with the benchmark's light, for small pictures. The transfer function is borrowed. */
iso_scene iso_level_bench_scene(iso_tf tf);

/* The scalar that small pictures choose (plan/scene_levels.h), under the benchmark's light. */
iso_status iso_level_make_for_scene(const iso_level_subject *s, iso_level_shown *shown, iso_error *err);
/* The fitted scalar, whatever pictures say. */
iso_status iso_level_make_fitted(const iso_level_subject *s, iso_level_shown *shown, iso_error *err);

#endif
