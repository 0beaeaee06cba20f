/* SPDX-License-Identifier: MIT */
/* level_gate.h - judges how near ways to show a coarse level are to level 0.
 *
 * Pictures in random directions, half of them with the scene's own lights and half with another one; with pixels of
 * about a fine voxel, and the same averaged down, so that a pixel is a coarse voxel. Levels are optimized (optimize.h)
 * with others of these views. */
#pragma once

#include "base/random.h"
#include "image/image.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

enum { ISO_LEVEL_GATE_VIEWS = 8 };

/* A level, and how it is shown. */
typedef struct iso_shown_level {
    const iso_level *level;
    const iso_tf_table *tf;
    const uint8_t *scale; /* of its extinction (fit/extinction_scale.h); or NULL */
} iso_shown_level;

typedef struct iso_level_seen {
    double of_view[ISO_LEVEL_GATE_VIEWS];                                  /* 1 - SSIM over the foreground */
    double ssim_dissimilarity, rmse, small_ssim_dissimilarity, small_rmse; /* means; small: averaged down */
} iso_level_seen;

/* The views, and level 0 in them. */
typedef struct iso_level_gate {
    const iso_pyramid *p;
    int threads;
    int view_count;  /* 0: of no use */
    double rounding; /* of an edit: 1 - SSIM of level 0's own pictures in the 8 bits of a display, mean */
    iso_view views[ISO_LEVEL_GATE_VIEWS];
    iso_image truth[ISO_LEVEL_GATE_VIEWS];
} iso_level_gate;

/* Draws level 0. Close a gate after a failure, too. ISO_E_MEMORY. */
iso_status iso_level_gate_open(iso_level_gate *gate, const iso_pyramid *p, const iso_scene *scene, int threads,
                               iso_error *err);
void iso_level_gate_close(iso_level_gate *gate);

/* Edits after which an optimized level has to be no worse than a plain one: the transfer function is shifted, or has
 * another opacity. Each is judged in half of the views. */
enum { ISO_LEVEL_GATE_EDITS = 4 };
/* True if an optimized level, whose 1 - SSIM after an edit is `edited`, is not worse than the level as built: by at
 * most ISO_LEVEL_GATE_GAIN, or by no more than a display's rounding, half a step, moves a picture. Distances are
 * sqrt(1 - SSIM): it grows as errors do, and comes near a metric [brunet-2012]. */
bool iso_level_gate_stands(double built, double edited, double rounding);
/* Adds shift times the range to the transfer function's values, and multiplies its opacity. ISO_E_MEMORY. */
iso_status iso_gate_edit_tf(const iso_pyramid *p, const iso_tf *tf, double shift, double factor, iso_tf *edited,
                            iso_error *err);
/* Opens a gate for each edit of the scene. Those that leave no transfer function have no views. ISO_E_MEMORY. */
iso_status iso_level_gate_open_edits(iso_level_gate gates[ISO_LEVEL_GATE_EDITS], const iso_pyramid *p,
                                     const iso_scene *scene, int threads, iso_error *err);

/* Returns the bytes of the pictures of a scene's gates. */
size_t iso_level_gate_bytes(const iso_geometry *level0, bool with_edits);

/* Draws a level and compares it. ISO_E_MEMORY. */
iso_status iso_level_gate_look(iso_level_gate *gate, size_t level, const iso_shown_level *shown, iso_level_seen *seen,
                               iso_error *err);

/* A built level is replaced if 1 - SSIM is less by this part of it, RMSE is not more by ISO_LEVEL_GATE_RMSE_LOSS, and
 * no view is farther by ISO_ADAPT_WORST_VIEW (tf/adapt.h). Smaller differences are not significant. */
#define ISO_LEVEL_GATE_GAIN 0.02
#define ISO_LEVEL_GATE_RMSE_LOSS 0.15
bool iso_level_gate_is_better(const iso_level_seen *built, const iso_level_seen *other);
/* True if an optimized level, which nothing makes again, may replace those that are best for each of `count` scenes. In
 * both sizes, over the scenes, its 1 - SSIM is less by ISO_LEVEL_GATE_GAIN and its RMSE is not more; in no scene is any
 * of these more by ISO_LEVEL_GATE_GAIN. */
bool iso_level_gate_is_nearer(const iso_level_seen *best, const iso_level_seen *optimized, size_t count);

/* Returns the side of pictures whose pixels are 1.1 fine voxels. */
size_t iso_gate_picture_side(const iso_geometry *level0);

/* Averages squares of 2^level pixels. ISO_E_MEMORY. */
iso_status iso_gate_minify(const iso_image *from, size_t level, iso_image *to, iso_error *err);

/* Makes a view of a random direction, in the scene's projection, with pixels of about a fine voxel. own_light: with the
 * scene's lights, otherwise one from a random direction. */
iso_status iso_gate_random_view(const iso_pyramid *p, const iso_scene *scene, bool own_light, iso_random *r,
                                iso_view *view, iso_error *err);
