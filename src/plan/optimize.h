/* SPDX-License-Identifier: MIT */
/* optimize.h - a coarse level whose pictures are nearest to those of level 0 for some scenes: its scalars, directions
 * and extinction scale, and a transfer function for each scene, found by gradient descent through a renderer
 * (render/cpu/adjoint.h).
 *
 *     truth    pictures of level 0 from random directions. Most have a light from a random direction, a quarter of them
 *              a shifted transfer function of another opacity, so that the level stands other lights and small edits.
 *     step     patches of these pictures, drawn from the level with its own ray step; their loss (patch_loss.h), also in
 *              small, with pixels as large as the level's voxels; Adam [kingma-2015] with a falling rate
 *     limits   directions of at most 1; scalars at most half a range beyond level 0's; the extinction scale's bytes
 *
 * The level keeps its size, types and format, so that all renderers and exporters take it. It is made for the
 * transfer functions of some scenes, and shown under its own one in each (tf/level_look.h). Under an entirely other one
 * it can be worse than a plain level.
 *
 * In: a pyramid in memory. Out: arrays of the level, quantized as they are stored. The same seed gives the same bytes
 * for any number of threads, but not on machines with other instruction sets. Cost: doc/results/scene-levels.md. */
#pragma once

#include <signal.h>

#include "base/progress.h"
#include "plan/level_gate.h"
#include "scene/scene.h"

/* Amount of work: none keeps levels that can be made again from level 0. */
typedef enum iso_effort {
    ISO_EFFORT_NONE,
    ISO_EFFORT_FAST,
    ISO_EFFORT_NORMAL,
    ISO_EFFORT_BEST,
    ISO_EFFORT_COUNT
} iso_effort;
extern const iso_names iso_effort_names;

/* Scenes of one level: each has at least eight pictures. */
enum { ISO_SCENES_MOST = 8 };

typedef struct iso_optimize_options {
    iso_effort effort;
    uint64_t seed;
    double rate;  /* part of the steps' length, at most 1: short steps learn less noise */
    bool only_tf; /* True: moves the transfer function alone */
    size_t scene_count;
    int threads;
    const volatile sig_atomic_t *stop; /* not 0: ends after the current step with the level so far; or NULL */
} iso_optimize_options;

typedef struct iso_optimized {
    float *scalar, *directions;        /* owned; directions: 3 per voxel, before encoding */
    uint8_t *codes, *scale;            /* owned; scale: of the extinction */
    iso_tf_table tfs[ISO_SCENES_MOST]; /* owned; of each scene */
    size_t views, pixels;              /* of training: number, and their side */
    size_t steps;                      /* done */
    double error_first, error;         /* mean loss of the first and the last twentieth of the steps */
    double seconds_truth, seconds;
} iso_optimized;

/* Makes a level for opt->scene_count scenes from how it is shown in each, `starts`: these differ in transfer functions
 * alone, and the level has the size of the pyramid's. level: at least 1. ISO_E_RANGE: nothing of the volume is visible;
 * voxels without data; a direction code that is not linear. ISO_E_MEMORY. */
iso_status iso_optimize_level(const iso_pyramid *p, size_t level, const iso_scene *scenes,
                              const iso_shown_level *starts, const iso_optimize_options *opt, iso_optimized *out,
                              const iso_progress *progress, iso_error *err);
void iso_optimized_destroy(iso_optimized *o);

/* Optimizes the transfer function of `start` alone, in long steps, and if the gate's pictures are not nearer, in short
 * ones. *tf gets it, or a copy of start's if neither is nearer. seen: of both, equal if none was. opt: its rate,
 * only_tf and scene_count are not read. Errors as above. */
iso_status iso_optimize_tf(iso_level_gate *gate, size_t level, const iso_scene *scene, const iso_shown_level *start,
                           const iso_optimize_options *opt, iso_tf_table *tf, iso_level_seen seen[2],
                           const iso_progress *progress, iso_error *err);

/* Step lengths to try, until one gives a nearer level. */
#define ISO_OPTIMIZE_RATES \
    { \
        1, 0.25 \
    }

/* Returns the bytes of buffers for level 1, and of the true pictures. */
size_t iso_optimize_bytes(const iso_geometry *level0, iso_effort effort);
