/* SPDX-License-Identifier: MIT */
/* caster.h - the ray caster on the CPU: the OpenGL ray caster's samples, by packets of rays in AVX-512, AVX2 or plain
 * C.
 *
 * Quadrature: segments [k ds, (k + 1) ds] of each ray clipped to the box, one sample in the middle, 1 - exp(-sigma
 * length): the reference's midpoints. Rays are set up in double, samples stand in 32 bits of a voxel's part, all else
 * is float. The image depends neither on the number of threads nor on the instruction set, and leaving out empty space
 * changes no bit. */
#pragma once

#include "image/image.h"
#include "scene/field.h"
#include "scene/scene.h"

/* Rays at once; the widest that the machine has is the default. */
typedef enum iso_cpu_width {
    ISO_CPU_WIDEST,
    ISO_CPU_ONE = 1,
    ISO_CPU_BASELINE = 4, /* what every machine of its kind has */
    ISO_CPU_AVX2 = 8,
    ISO_CPU_AVX512 = 16
} iso_cpu_width;

typedef enum iso_cpu_skip {
    ISO_CPU_SKIP_AUTO, /* where at most ISO_CPU_SKIP_OCCUPIED of the blocks are occupied */
    ISO_CPU_SKIP_NEVER,
    ISO_CPU_SKIP_ALWAYS
} iso_cpu_skip;
#define ISO_CPU_SKIP_OCCUPIED 0.5

typedef struct iso_cpu_options {
    iso_direction_source source;
    double step_voxels; /* 0: the view's */
    iso_cpu_skip skip;
    iso_cpu_width width;
    int threads;
    bool once; /* True for a scene that is drawn once: bricks are made when rays need them, if that is possible */
} iso_cpu_options;
iso_cpu_options iso_cpu_defaults(void);

/* Returns the widest that this machine supports. */
iso_cpu_width iso_cpu_widest(void);
/* Returns a name such as "AVX-512, 16 rays at a time". */
const char *iso_cpu_width_name(iso_cpu_width width);

/* True if 31 bits can count the voxels of such a level's bricks: 1200^3 voxels fit. */
bool iso_cpu_takes(const iso_geometry *g);

/* A level and a view, ready to be drawn any number of times. */
typedef struct iso_cpu_scene iso_cpu_scene;

/* Creates a scene; level and view must outlive it. From a level that has `samples` (pyramid/narrow.h) bricks are made
 * when rays need them; directions must then be codes. ISO_E_USAGE: a region of interest. ISO_E_RANGE: a step of 0
 * or less, more than 2^31 voxels in bricks, an unsupported width, or a source missing in the level. ISO_E_MEMORY. */
iso_status iso_cpu_prepare(iso_cpu_scene **scene, const iso_level *level, iso_code code, const iso_view *view,
                           const iso_cpu_options *opt, iso_error *err);
void iso_cpu_release(iso_cpu_scene *scene); /* accepts NULL */
/* Returns the bytes that drawing a picture reads; of bricks, those made so far. */
double iso_cpu_bytes(const iso_cpu_scene *scene);
/* Fills an image of the view's size. */
void iso_cpu_draw(const iso_cpu_scene *scene, iso_image *image);

/* Draws the scene at least once and at most `most` times, until `enough` seconds have passed (0: no limit). seconds[]:
 * `most` entries, by the clock or of the processor. Returns the number of draws. */
size_t iso_cpu_draw_repeatedly(const iso_cpu_scene *scene, iso_image *image, size_t most, double enough,
                               bool processor_time, double *seconds);

/* Prepares, draws and releases a scene. */
iso_status iso_cpu_render(const iso_level *level, iso_code code, const iso_view *view, const iso_cpu_options *opt,
                          iso_image *image, iso_error *err);
