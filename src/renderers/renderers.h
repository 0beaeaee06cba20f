/* SPDX-License-Identifier: MIT */
/* renderers.h - one call for the four renderers, as the commands use them.
 *
 * The CPU reference and the GL ray caster live in src/render, Cycles and
 * POV-Ray behind exporters/; only here they meet. The GL context is made at its
 * first use and kept. */
#ifndef ISO_RENDERERS_H
#define ISO_RENDERERS_H

#include "base/progress.h"
#include "renderers/faults.h"
#include "image/image.h"
#include "pyramid/pyramid.h"
#include "render/gl/raycaster.h"
#include "render/reference.h"
#include "scene/scene.h"

/* enum, name, how it is called in reports */
#define ISO_RENDERER_LIST(X)                        \
    X(ISO_WITH_REFERENCE, "reference", "Reference") \
    X(ISO_WITH_GL, "gl", "OpenGL ray caster")       \
    X(ISO_WITH_CYCLES, "cycles", "Blender Cycles")  \
    X(ISO_WITH_POVRAY, "povray", "POV-Ray")

typedef enum iso_renderer {
#define ISO_RENDERER_ENUM(name, text, title) name,
    ISO_RENDERER_LIST(ISO_RENDERER_ENUM)
#undef ISO_RENDERER_ENUM
    ISO_RENDERER_COUNT
} iso_renderer;

const char *iso_renderer_name(iso_renderer r);
const char *iso_renderer_title(iso_renderer r);
/* First hits of a value. */
bool iso_renderer_has_isosurfaces(iso_renderer r);
iso_status iso_renderer_from_name(const char *name, iso_renderer *r, iso_error *err);

/* "gl,povray"; NULL: all. The reference is always wanted. */
iso_status iso_renderers_from_list(const char *list, bool wanted[ISO_RENDERER_COUNT], iso_error *err);

/* What an image took, by the renderer's own account. */
typedef struct iso_render_stats {
    double seconds, median_seconds, most_seconds; /* the frame alone: the fastest of `count`, their middle, the slowest */
    size_t count;
    double frame_seconds[ISO_GL_MAX_DRAWS]; /* rising */
    double setup_seconds; /* before it: textures; or the start, the export and the reading of another program */
    double bytes;         /* that it holds of the model: textures by their formats (GL), what Blender says, DF3 files; the
                           * reference's floats and codes */
} iso_render_stats;

typedef struct iso_render_options {
    iso_renderer renderer;
    iso_direction_source source;   /* reference and GL */
    iso_quadrature quadrature;     /* reference; GL: pre-integrated, or else the midpoint */
    double step_voxels;            /* 0: the view's; for Cycles and POV-Ray their own defaults */
    size_t intervals, planes;      /* POV-Ray, and the reference in its quadrature; 0 intervals: the converged defaults */
    bool extrapolate;              /* POV-Ray, with intervals */
    int samples, seed;             /* Cycles; 0: defaults */
    bool isosurface;               /* first hit of the value iso; not Cycles */
    double iso;
    bool shade_table;              /* GL, palettes */
    bool exact_lookups;            /* GL: render/gl/raycaster.h */
    size_t repeats;                /* GL and the reference: frames, the last of which is the image ... */
    double repeat_seconds;         /* ... as long as they have taken less than this; above 0 a warm-up goes before them */
    bool processor_time;           /* stats: the frame's processor time over all cores instead of the clock's; not of Cycles */
    iso_render_stats *stats;       /* filled; or NULL */
    int threads;
} iso_render_options;
iso_render_options iso_render_defaults(iso_renderer r);

/* As if the frames of both had been drawn at once; beyond ISO_GL_MAX_DRAWS the slowest are forgotten. */
void iso_render_stats_add(iso_render_stats *stats, const iso_render_stats *more);
void iso_render_stats_of_gl(const iso_gl_stats *inside, iso_render_stats *stats);

/* Images of one scene by their options, for work that asks for the same ones again. Zeroed: empty. */
typedef struct iso_frame_cache {
    size_t count;
    iso_render_options *frames;
    iso_image *images;
} iso_frame_cache;
void iso_frame_cache_clear(iso_frame_cache *cache);

typedef struct iso_renderers {
    iso_gl *gl;
    const char *shader_dir; /* NULL: the embedded shaders */
    const iso_planted *planted; /* what spoils each image that is rendered; NULL but where faults are studied */
    iso_frame_cache *cache;     /* of iso_render_several(), while pyramid, level, view and planted stay; borrowed, or NULL */
} iso_renderers;
void iso_renderers_end(iso_renderers *r);
/* Makes r->gl if it is not there. */
iso_status iso_renderers_need_gl(iso_renderers *r, iso_error *err);

/* ISO_E_MISSING when the program or device is not there. *seconds may be NULL. */
iso_status iso_render_with(iso_renderers *r, const iso_pyramid *p, size_t level, const iso_view *view,
                           const iso_render_options *opt, iso_image *image, double *seconds,
                           const iso_progress *progress, iso_error *err);

/* Several images of one renderer that differ in step, intervals, samples and seed: images[i] is that of frames[i].
 * Cycles starts once for all. All or none are created. */
iso_status iso_render_several(iso_renderers *r, const iso_pyramid *p, size_t level, const iso_view *view,
                              const iso_render_options *frames, size_t count, iso_image *images,
                              const iso_progress *progress, iso_error *err);

/* "Blender 3.4.1", "POV-Ray 3.7.0.10", "llvmpipe ...": what answers, or why nothing does. */
iso_status iso_renderer_version(iso_renderers *r, iso_renderer which, char *text, size_t size, iso_error *err);

#endif
