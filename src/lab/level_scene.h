/* SPDX-License-Identifier: MIT */
/* level_scene.h - the levels of `build --for`, as methods of `isoshade-lab levels` (level_methods.h). */
#pragma once

#include "lab/level_methods.h"
#include "scene/scene.h"

/* Returns a scene with the benchmark's light, for small pictures. The transfer function is borrowed. */
iso_scene iso_level_bench_scene(iso_tf tf);

/* Shows the scalar that small pictures select (plan/scene_levels.h), under the benchmark's light. */
iso_status iso_level_make_for_scene(const iso_level_subject *s, iso_level_shown *shown, iso_error *err);
/* The same, with an optimized level (plan/optimize.h) among the candidates, by three efforts. */
iso_status iso_level_make_optimized_fast(const iso_level_subject *s, iso_level_shown *shown, iso_error *err);
iso_status iso_level_make_optimized(const iso_level_subject *s, iso_level_shown *shown, iso_error *err);
iso_status iso_level_make_optimized_best(const iso_level_subject *s, iso_level_shown *shown, iso_error *err);
/* The same by effort fast, for the benchmark's other transfer functions (level_tfs.h), shown as `render --adapt`. */
iso_status iso_level_make_for_others(const iso_level_subject *s, iso_level_shown *shown, iso_error *err);
/* Optimizes the transfer function alone, as `tf adapt --optimize`. */
iso_status iso_level_optimize_tf(const iso_level_subject *s, iso_level_shown *shown, iso_error *err);
/* Shows the fitted scalar without that selection. */
iso_status iso_level_make_fitted(const iso_level_subject *s, iso_level_shown *shown, iso_error *err);
