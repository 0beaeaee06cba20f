/* SPDX-License-Identifier: MIT */
/* raycaster.h - the OpenGL ray caster: headless, by EGL, on a GPU or in software.
 *
 * Quadrature: segments [k ds, (k+1) ds] of each ray clipped to the box, one
 * sample in the middle, 1 - exp(-sigma length); or pre-integrated, the TF's means
 * between the values at both ends (tf/integral.h); or the first hit of a value, by
 * the reference's definition (reference.h). Textures: scalar R16 where the
 * stored type has 8 or 16 bits, else R32F; directions from the 3-byte codes,
 * from floats, or on the fly. At start the texture filter is probed: where
 * 8-bit textures are filtered in 8 bits, codes travel in 16 bits, and where all are,
 * the shader filters (ISO_GL_FINE_FILTER_BITS). On llvmpipe
 * codes and a scalar of at most 16 bits are one texture, and one fetch. */
#pragma once

#include "image/image.h"
#include "scene/field.h"
#include "scene/scene.h"

typedef struct iso_gl iso_gl; /* a context with its programs */

typedef struct iso_gl_info {
    char vendor[128], renderer[128], version[128];
    int filter_bits_unorm8; /* bits that linear filtering of the format keeps, as probed */
    int filter_bits_unorm16;
    int filter_bits_float;
    char device[64]; /* "EGL device 0", "without a surface" */
    int timer_bits;  /* of its counter of nanoseconds (GL_TIME_ELAPSED); 0: it has none */
} iso_gl_info;

/* A device whose filter of floats keeps fewer bits weighs texels more coarsely than floats do: the usual GPU has 8. */
#define ISO_GL_FINE_FILTER_BITS 20

/* The device that iso_gl_create() takes where the user set one: see gl_context.c. */
#define ISO_GL_DEVICE_VARIABLE "ISOSHADE_GL_DEVICE"
/* Returns the number of EGL devices; the n-th is chosen by its number. */
size_t iso_gl_device_count(void);
/* True if a software renderer would draw: no device is set, and EGL lists only software renderers. No context is
 * made. */
bool iso_gl_is_software(void);

/* Creates a context, current on the calling thread only. shader_dir: folder that replaces the embedded shaders; or
 * NULL. ISO_E_MISSING with the devices tried if EGL gives no context. */
iso_status iso_gl_create(iso_gl **gl, const char *shader_dir, iso_error *err);
/* Creates a context on the chosen device; NULL or "": the first that is not a software renderer. */
iso_status iso_gl_create_on(iso_gl **gl, const char *device, const char *shader_dir, iso_error *err);
void iso_gl_destroy(iso_gl *gl);
iso_gl_info iso_gl_describe(const iso_gl *gl);
/* Returns the seconds of the last drawing by the device's timer, the fastest if it was repeated. Work of the driver and
 * this program is excluded. NaN: the device has no timer. */
double iso_gl_device_seconds(const iso_gl *gl);
/* Measures processor time summed over all cores from now on, instead of wall-clock time: for software GL on a shared
 * machine. */
void iso_gl_time_processor(iso_gl *gl, bool processor);

/* Leaving out bricks that the TF does not show changes no pixel by more than
 * rounding; it pays on sparse TFs and costs a little on dense ones. */
typedef enum iso_gl_skip {
    ISO_GL_SKIP_AUTO, /* where at most ISO_GL_SKIP_OCCUPIED of the bricks are occupied */
    ISO_GL_SKIP_NEVER,
    ISO_GL_SKIP_ALWAYS
} iso_gl_skip;
#define ISO_GL_SKIP_OCCUPIED 0.5

/* Measurements of an image. */
#define ISO_GL_MAX_DRAWS 16
typedef struct iso_gl_stats {
    double upload_seconds; /* until the first draw: textures made and filled, shaders compiled */
    double texture_bytes;  /* of all textures that a draw reads, by the bits that GL has for their formats */
    size_t draw_count;     /* how many of draw_seconds are filled */
    double draw_seconds[ISO_GL_MAX_DRAWS];
    double draw_processor_seconds[ISO_GL_MAX_DRAWS]; /* the same draws, over all cores */
} iso_gl_stats;

typedef struct iso_gl_options {
    iso_direction_source source; /* codes, float or on the fly; decoded uploads decoded floats */
    double step_voxels;          /* 0: the view's */
    iso_gl_skip skip;
    size_t brick_voxels;   /* a side of the skipped bricks */
    size_t repeats;        /* draws; the time is that of the fastest */
    double repeat_seconds; /* above 0: draws are repeated until they took so long; a draw of one pixel goes before
                                  * them, because drivers compile in the first one */
    iso_gl_stats *stats;   /* filled; or NULL */
    double *seconds;       /* gets the seconds of the drawing alone; or NULL */
    bool shade_table;      /* palettes: shading by a table of the entries, made again for each view and its lights, with
                            * one direction to the viewer; exact for orthographic cameras and the nearest entry,
                            * otherwise shades are filtered instead of directions */
    bool fast_filter;      /* True if the device's filter is used even if it is coarse, for timed frames; otherwise the
                            * shader filters in float, with eight fetches instead of one */
    bool preintegrated;    /* not with a 2D transfer function */
    bool exact_lookups;    /* the shader filters textures and finds the table's entry itself, at positions in double
                                  * precision; texture units take float coordinates. Slow, for validation; not with a
                                  * surface, pre-integration or a region of interest */
    const iso_surface *surface; /* its first hit instead of the integral, or NULL; exact in each cell: no step */
} iso_gl_options;
iso_gl_options iso_gl_defaults(void);

/* Uploads a level and renders it. */
iso_status iso_gl_render(iso_gl *gl, const iso_level *level, iso_code code, const iso_view *view,
                         const iso_gl_options *opt, iso_image *image, iso_error *err);
