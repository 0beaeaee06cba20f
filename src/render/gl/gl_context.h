/* SPDX-License-Identifier: MIT */
/* gl_context.h - a headless OpenGL context (gl_context.c), its programs (gl_program.c) and its textures (gl_draw.c).
 *
 * The context comes from EGL through libepoxy: the requested device, or each EGL device except software
 * renderers, then the platform without a surface (Mesa's llvmpipe). Core profile, 4.3 or newer. Independent of volumes.
 *
 * Private to src/render and src/brick: commands see render/gl/raycaster.h. */
#pragma once

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <stddef.h>

#include "render/gl/raycaster.h"
#include "render/screen_reach.h"

#define ISO_GL_MAX_PROGRAMS 64

struct iso_gl {
    EGLDisplay display;
    EGLContext context;
    iso_gl_info info;
    char *shader_dir;       /* or NULL: the embedded shaders */
    const char *transition; /* text that finds the places of bricks whose samples lie inside them; or NULL */
    GLint max_texture_size, max_texture_3d_size;
    bool is_llvmpipe;    /* Mesa's software OpenGL: a fetch takes as long as its filter computes */
    double band_samples; /* of a band, after which a call can be canceled: about a tenth of a second */
    GLuint vertex_array;
    bool times_processor;     /* iso_gl_time_processor() */
    double device_seconds;    /* iso_gl_device_seconds() */
    double processor_seconds; /* of the last drawing, over all cores */
    size_t program_count;
    struct iso_gl_program {
        char *key; /* fragment file and defines */
        GLuint name;
    } programs[ISO_GL_MAX_PROGRAMS];
};

/* Makes the context current on this thread. */
iso_status iso_gl_bind(iso_gl *gl, iso_error *err);

/* Returns a program that draws a triangle over the whole target. fragment: a fragment shader's name under shaders/,
 * such as "raycast.glsl"; direction decoders and `defines` (lines "#define NAME VALUE\n") precede it. The context
 * compiles it once and keeps it. ISO_E_PROGRAM with the compiler's log. */
iso_status iso_gl_get_program(iso_gl *gl, const char *fragment, const char *defines, GLuint *program, iso_error *err);

/* Creates a 3D texture without texels: linear, clamped to the edge. ISO_E_RANGE with size and limit if it is too large
 * for this GL; ISO_E_MEMORY. */
iso_status iso_gl_create_texture_3d(const iso_gl *gl, GLenum internal_format, const size_t size[3], const char *what,
                                    GLuint *texture, iso_error *err);
/* Sets all texels of the bound texture to 0, if it is not written as a whole. A filter may reach beyond the written
 * texels, by a rounding: a NaN there would be a NaN in the picture. */
iso_status iso_gl_clear_texture_3d(const size_t size[3], iso_error *err);
/* Creates a texture of one texel per brick, nearest: the distance to the nearest occupied brick (brick/occupancy.h). */
iso_status iso_gl_create_occupancy(const iso_gl *gl, const size_t count[3], const uint8_t *distance, GLuint *texture,
                                   iso_error *err);
/* Creates a 2D texture, nearest, from floats in RGBA. */
iso_status iso_gl_create_texture_rgba32f(const iso_gl *gl, size_t width, size_t height, const float *rgba,
                                         GLuint *texture, iso_error *err);

/* The parts of a picture that are drawn: tiles that can show anything, while the others are the background. A call that
 * can be canceled draws bands of tiles, and reports after each. */
typedef struct iso_gl_cover {
    const iso_screen_reach *screen; /* or NULL: all are drawn */
    const double *background;       /* 3 */
    double ray_samples;             /* the most of a ray; 0: the picture is drawn at once */
} iso_gl_cover;

/* Draws the program over a width x height float target and reads it back, first
 * row first; *seconds (may be NULL) is the drawing alone. Textures and uniforms
 * are the caller's. ISO_E_CANCELED: rgba is unchanged. */
iso_status iso_gl_draw(iso_gl *gl, GLuint program, size_t width, size_t height, iso_gl_cover cover, float *rgba,
                       double *seconds, iso_error *err);

/* Number of draws of a program: `count` times (0: once) while they have taken less than `seconds` (0: all; otherwise
 * after a draw of one pixel). */
typedef struct iso_gl_repeats {
    size_t count;
    double seconds;
    iso_gl_cover cover;
} iso_gl_repeats;

/* Adds the draws to the stats; *least (may be NULL) is the fastest. Repeated draws are for their time: each is drawn at
 * once. */
iso_status iso_gl_draw_repeatedly(iso_gl *gl, GLuint program, const iso_gl_repeats *repeats, iso_image *image,
                                  double *least, iso_gl_stats *stats, iso_error *err);

/* True if the shader filters textures itself: the device's filter is coarse and fast_filter is not set. */
bool iso_gl_filters_by_hand(const iso_gl *gl, bool fast_filter);

/* Returns a texture's bytes, from the bits that GL reports for its format; 0 for the name 0. */
double iso_gl_texture_bytes(GLenum target, GLuint texture);

/* Returns ISO_E_PROGRAM or ISO_E_MEMORY if GL has an error pending. what: the work done, for the message. */
iso_status iso_gl_check(const char *what, iso_error *err);
