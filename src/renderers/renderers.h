/* SPDX-License-Identifier: MIT */
/* renderers.h - the table of renderers, and one call for all of them.
 *
 * A renderer is one file of this folder. It defines a struct iso_renderer_info: its name, its features, the accuracy
 * of its images, and its callbacks. ISO_RENDERER_LIST names them all. Code that lists, checks, calibrates or prints
 * renderers iterates over that table and reads the struct. No code outside this folder depends on a certain
 * renderer, except on the reference, which the others are compared with. doc/extending.md shows how to add one. */
#pragma once

#include <jansson.h>

#include "base/key.h"
#include "base/progress.h"
#include "image/image.h"
#include "pyramid/pyramid.h"
#include "render/reference.h"
#include "scene/scene.h"

typedef struct iso_renderer_info iso_renderer_info;
typedef struct iso_renderers iso_renderers;

/* ---- requests ---- */

/* Cost of an image, as measured by the renderer. */
enum { ISO_RENDER_MAX_FRAMES = 16, ISO_RENDER_MAX_SCENES = 8 };
typedef struct iso_render_stats {
    double seconds, median_seconds, most_seconds; /* the frame alone: fastest of `count`, median, slowest */
    size_t count;
    double frame_seconds[ISO_RENDER_MAX_FRAMES]; /* ascending */
    double setup_seconds; /* before the frame: texture upload; or start, export and loading of another program */
    double bytes; /* of the model: textures by their formats (GL), Blender's own figure, DF3 files; floats and codes
                   * of the reference */
    /* Converged reference: largest error of any pixel, and whether it is proved (render/reference.h); 0 for others. */
    double error;
    bool is_proved;
} iso_render_stats;

/* The options that an image depends on: type, name. Two frames are the same if all of them are equal. */
/* clang-format off */
#define ISO_FRAME_FIELDS(X)                                                                                    \
    X(const iso_renderer_info *, renderer)                                                                     \
    X(iso_direction_source, source)   /* of renderers that read one */                                         \
    X(iso_quadrature, quadrature)     /* of renderers that have several */                                     \
    X(double, step_voxels)            /* 0: the view's; for other programs their own default */                \
    X(size_t, intervals)              /* per ray, instead of a step; 0: the converged defaults */              \
    X(size_t, planes)                 /* cut each ray into pieces, with intervals */                           \
    X(bool, extrapolate)              /* with intervals */                                                     \
    X(int, samples)                   /* per pixel; 0: the default */                                          \
    X(int, seed)                      /* for random numbers */                                                 \
    X(bool, isosurface)               /* first hit of the value iso instead of the integral */                 \
    X(double, iso)                                                                                             \
    X(bool, shade_table)              /* palettes: shade the entries once instead of each sample */            \
    X(bool, exact_lookups)            /* textures at positions in double precision (render/gl/raycaster.h) */
/* clang-format on */

typedef struct iso_render_options {
#define ISO_FRAME_FIELD(type, name) type name;
    ISO_FRAME_FIELDS(ISO_FRAME_FIELD)
#undef ISO_FRAME_FIELD
    size_t repeats;          /* frames to draw, of which the last is the image ... */
    double repeat_seconds;   /* ... until they have taken this long; above 0 a warm-up frame goes first */
    bool once;               /* True for a picture whose data nobody measures: they are made as rays need them */
    bool processor_time;     /* stats: processor time of the frame over all cores instead of wall time */
    iso_render_stats *stats; /* filled; or NULL */
    int threads;
} iso_render_options;

/* A request for one image. */
typedef struct iso_render_request {
    iso_renderers *renderers;
    const iso_pyramid *pyramid;
    size_t level; /* an existing one */
    const iso_view *view;
    const iso_render_options *options;
    const iso_progress *progress;
} iso_render_request;

/* ---- renderers ---- */

/* Features of a renderer, and the options that it reads; it ignores the others. */
typedef enum iso_trait {
    ISO_IS_PROGRAM = 1 << 0, /* another program: each start takes seconds, and it gets an export, which carries
                              * decoded directions. Without this trait the renderer runs in this process */
    ISO_IS_RANDOM = 1 << 1,  /* images have noise: it runs with several seeds */
    ISO_HAS_LIMIT = 1 << 2,  /* error falls with the square of the ray step */
    ISO_HAS_ISOSURFACES = 1 << 3,
    ISO_HAS_CLIP_PLANES = 1 << 4,
    ISO_HAS_2D_TFS = 1 << 5,         /* 2D transfer functions */
    ISO_HAS_ROI = 1 << 6,            /* a region of interest */
    ISO_HAS_BRICKS = 1 << 7,         /* bricks of mixed resolution (plan/cached.h) */
    ISO_HAS_PROCESSOR_TIME = 1 << 8, /* reports the processor time of a frame */
    ISO_READS_QUADRATURE = 1 << 9,
    ISO_READS_SOURCE = 1 << 10, /* directions from codes, floats, palettes ..., filtered as requested */
    ISO_READS_INTERVALS = 1 << 11,
    ISO_READS_PLANES = 1 << 12,
    ISO_READS_SAMPLES = 1 << 13,
    ISO_READS_SEED = 1 << 14,
    ISO_READS_SHADE_TABLE = 1 << 15,
    ISO_READS_EXACT_LOOKUPS = 1 << 16,
    ISO_READS_SHADERS = 1 << 17, /* iso_renderers.shader_dir */
    ISO_HAS_EXTINCTION_SCALES = 1 << 18,
    ISO_HAS_LABELS = 1 << 19, /* label maps, looked up without interpolation */
    ISO_HAS_LIGHTS = 1 << 20,
    ISO_HAS_ORTHOGRAPHIC = 1 << 21, /* orthographic cameras */
    ISO_IS_NAMED = 1 << 22,         /* takes part only if it is named */
    ISO_IS_OF_PICTURES = 1 << 23,   /* images of given scenes, made elsewhere (pictures.h) */
    ISO_IS_OF_A_USER = 1 << 24,     /* row of a renderers.json: its program may change without a new version */
    ISO_WAITS_BETWEEN = 1 << 25,    /* each image of a start begins with a wait: parallel ones end sooner */
    ISO_TAKES_A_PART = 1 << 26,     /* makes what it needs of a level that has samples alone (pyramid/narrow.h) */
} iso_trait;
#define ISO_HAS_ALL_SCENES \
    (ISO_HAS_CLIP_PLANES | ISO_HAS_2D_TFS | ISO_HAS_EXTINCTION_SCALES | ISO_HAS_ROI | ISO_HAS_LIGHTS | \
     ISO_HAS_ORTHOGRAPHIC)

/* Largest difference of an image from the reference with the same samples; 0: not checked. */
typedef struct iso_sample_error {
    double rmse, max_abs;
} iso_sample_error;

/* Lock-step: the positions of the renderer's samples are known, and the reference takes its samples there too. Only
 * the arithmetic of the renderer differs then. If the positions are not known, and its step cannot be halved to find
 * its limit (integers of 8 bits), the quadrature is ISO_QUADRATURE_CONVERGED: it is compared with the converged
 * reference, within its stated limits. */
typedef struct iso_lock_step {
    iso_quadrature quadrature;      /* of the reference, with the same samples */
    size_t intervals;               /* of both; 0: the view's step */
    iso_sample_error smooth, sharp; /* by transfer function; a steep one multiplies differences */
    const char *why;                /* cause of these limits */
    iso_sample_error exact;         /* with exact lookups, for any transfer function; zeroed: it has none */
    const char *exact_why;
    iso_sample_error rounded; /* of usual lookups that are farther off, if exact ones are within `exact` */
    const char *rounded_why;
    bool float_rays; /* True if rays may be in single precision: pictures farther off are held to its bound */
} iso_lock_step;

/* Integers that a renderer stores its images in. Zeroed: floats. */
typedef struct iso_render_output {
    unsigned bits;                        /* per channel */
    double (*peak)(const iso_view *view); /* color that the largest integer stands for */
    double rounding, rounding_rmse;       /* as parts of that color, in lock-step: of a value, and over the image */
    double most;                          /* brighter colors are clipped to it; 0: no clipping */
    bool half;                            /* True if values are rounded to half floats; limits grow by that */
} iso_render_output;

/* Returns the largest rounding error of half floats up to `most`: half a step of 11 bits below the next power of 2. */
double iso_half_rounding(double most);

struct iso_renderer_info {
    const char *name;               /* on command lines and in reports: "gl" */
    const char *title;              /* for people: "OpenGL ray caster" */
    const char *stages[4];          /* stages that a render reports (base/progress.h), in order, the longest last; or
                                  * none */
    const char *color;              /* of its marks in charts */
    unsigned traits;                /* iso_trait */
    unsigned quadratures;           /* 1 << iso_quadrature of each that it reads */
    iso_render_options defaults;    /* .renderer need not be set */
    double sample_seconds;          /* about, per sample of a ray: for estimates */
    double first_step_voxels;       /* start of the search for its limit; 0: derived from the transfer function */
    size_t max_intervals;           /* of a ray, or of its piece between two planes; 0: it has steps */
    size_t step_count;              /* steps with pictures, each half of the one before; 0: any step */
    size_t seeds;                   /* of a random one: the fewest that its limit is made of */
    const iso_lock_step *lock_step; /* or NULL */
    iso_render_output output;
    const char *const *programs; /* other programs: files and programs that its pictures depend on, each as
                                  * iso_key_add_dependency() takes it; ends with NULL. NULL: none */
    const char *found_in;        /* of a user's program: the renderers.json that names it; or NULL */

    const void *data;                /* private to the file that defines it, to distinguish its renderers; or NULL */
    const iso_renderer_info *beside; /* another version of the same program, to compare with; or NULL */
    /* Returns the argument of --with that selects it on a command line. NULL: its name. */
    const char *(*asked_by)(const iso_renderer_info *self);

    /* Writes its version, such as "Blender 3.4.1". ISO_E_MISSING, with the reason, if it is not installed. */
    iso_status (*version)(const iso_renderer_info *self, iso_renderers *r, char *text, size_t size, iso_error *err);
    /* Creates the image. Fills stats, except for the values that the caller measures: setup_seconds of programs, and
     * the time of the call if there is no other. */
    iso_status (*render)(const iso_render_request *request, iso_image *image, iso_render_stats *stats, iso_error *err);
    /* Draws `count` frames, from request->options on, in one start; all or none. NULL: one after the other. */
    iso_status (*render_several)(const iso_render_request *request, size_t count, iso_image *images, iso_error *err);
    /* Draws an image of each of `count` scenes, at most ISO_RENDER_MAX_SCENES, all of one size, in one start; all or
     * none. NULL: one after the other. */
    iso_status (*render_scenes)(const iso_render_request *scenes, size_t count, iso_image *images, iso_error *err);
    /* Sets the steps of `count` frames: the last to finest_voxels, each other to the double of the next, so that
     * each sample of one is halved in the next. `spare`, 1 to 4, is a factor by which the last can still be refined.
     * NULL: by step_voxels. */
    void (*ask_steps)(const iso_level *level, double finest_voxels, size_t count, double spare,
                      iso_render_options *frames);
    /* Returns the default step, in the level's smallest spacing. NULL: the view's. */
    double (*own_step)(const iso_level *level);
    /* Returns a new object for reports: how it was run (doc/reference/files-report.md, "programs"). NULL: none. */
    json_t *(*describe)(const iso_renderer_info *self);
    /* Releases its kept state (iso_renderers_kept()). May be NULL. */
    void (*end)(void *kept);
};

static inline bool iso_renderer_has(const iso_renderer_info *r, unsigned traits)
{
    return (r->traits & traits) == traits;
}

/* ---- the table ---- */

/* The renderers, one file each, in the order in which they are listed. */
/* clang-format off */
#define ISO_RENDERER_LIST(X)   \
    X(iso_renderer_reference)  \
    X(iso_renderer_gl)         \
    X(iso_renderer_cpu)        \
    X(iso_renderer_cycles)     \
    X(iso_renderer_povray)
/* clang-format on */
#define ISO_RENDERER_EXTERN(renderer) extern const iso_renderer_info renderer;
ISO_RENDERER_LIST(ISO_RENDERER_EXTERN)
#undef ISO_RENDERER_EXTERN

enum { ISO_MAX_RENDERERS = 32 }; /* for arrays by iso_renderer_index() */
size_t iso_renderer_count(void);
const iso_renderer_info *iso_renderer_at(size_t index);
size_t iso_renderer_index(const iso_renderer_info *r);
/* Returns the reference, which the others are compared with. */
const iso_renderer_info *iso_renderers_reference(void);
/* Returns the default renderer, which is the fastest. */
const iso_renderer_info *iso_renderers_usual(void);
/* Returns the renderer that takes the place of a default one that is missing: it needs no program or device. */
const iso_renderer_info *iso_renderers_instead(void);
/* Replaces the default renderer by the CPU ray caster if OpenGL is only available in software. The CPU ray caster
 * takes the same samples in less time. The options stay if it lacks a feature of the view or the options. */
void iso_renderers_choose(const iso_pyramid *p, const iso_view *view, iso_render_options *opt);

/* Adds a renderer at the end of the table until the process ends; it is not copied. Call it before all others, from
 * one thread. ISO_E_USAGE: its name is taken; ISO_E_RANGE: the table is full. */
iso_status iso_renderers_register(const iso_renderer_info *r, iso_error *err);

/* Finds a renderer by name. ISO_E_USAGE, with the names that there are. */
iso_status iso_renderer_from_name(const char *name, const iso_renderer_info **r, iso_error *err);
/* Parses a list such as "gl,povray"; NULL: all that take part by default. Always included: the reference, renderers
 * of pictures, and other versions (`beside`) of an included program. */
iso_status iso_renderers_from_list(const char *list, bool wanted[ISO_MAX_RENDERERS], iso_error *err);

/* Fails with ISO_E_MISSING if a wanted renderer of the list is not installed, before anything is drawn. Without a list
 * clears `wanted` of such renderers, each with a warning. */
iso_status iso_renderers_find_missing(const char *list, bool wanted[ISO_MAX_RENDERERS], iso_error *err);

/* Joins the names of the renderers that have all these traits (0: all): "reference, gl and povray" with the
 * joins ", " and " and ". Returns text, cut at size. */
const char *iso_renderers_with(unsigned traits, const char *join, const char *last_join, char *text, size_t size);
/* Joins the names of those that take part by default: "reference,gl". */
const char *iso_renderers_by_default(unsigned traits, char *text, size_t size);

/* Hashes the version that a renderer reports, and its programs. Stored pictures with another hash are not used. The
 * hash is empty for programs of a user, which may change without a new version. */
iso_status iso_renderer_identify(const iso_renderer_info *r, const char *version, char hash[ISO_KEY_DIGEST_BYTES],
                                 iso_error *err);

/* ---- rendering ---- */

/* Environment variable for bench job: if set, several pictures are drawn one after the other. */
#define ISO_RENDERERS_APART "ISOSHADE_PICTURES_APART"

/* A function that may change each image after it is rendered. Zeroed: none. */
typedef struct iso_image_hook {
    iso_status (*change)(const void *user, const iso_render_request *request, iso_image *image, iso_error *err);
    const void *user;
} iso_image_hook;

/* State of all renderers; ready if zeroed. */
struct iso_renderers {
    void *kept[ISO_MAX_RENDERERS];   /* a renderer's state between images; by iso_renderer_index() */
    const char *shader_dir;          /* NULL: the embedded shaders */
    const char *scene;               /* name of the rendered scene, for renderers that look for its pictures; or NULL */
    iso_image_hook after;            /* called for each rendered image */
    struct iso_picture_store *store; /* pictures of an interrupted job (picture_store.h); borrowed, or NULL */
    /* Draws for iso_render_several(), for work that requests the same images again; or NULL. */
    iso_status (*several)(const iso_render_request *frames, size_t count, iso_image *images, iso_error *err);
    void *several_user; /* borrowed */
};
void iso_renderers_end(iso_renderers *r);
static inline void **iso_renderers_kept(iso_renderers *r, const iso_renderer_info *of)
{
    return &r->kept[iso_renderer_index(of)];
}

iso_render_options iso_render_defaults(const iso_renderer_info *r);

/* Returns a feature that the view or an isosurface needs and the renderer lacks, such as "clip planes"; or NULL. */
const char *iso_renderer_lacks(const iso_renderer_info *r, const iso_pyramid *p, const iso_view *view, bool isosurface);
/* Returns a new list of the features that scenes may need and the renderer has, or lacks. */
json_t *iso_renderer_features(const iso_renderer_info *r, bool lacking);

/* Sets the steps of frames as iso_renderer_info.ask_steps does. */
void iso_render_ask_steps(const iso_renderer_info *r, const iso_level *level, double finest_voxels, size_t count,
                          double spare, iso_render_options *frames);
/* Returns the requested step of a frame, in the level's smallest spacing; with intervals, that of the longest ray. */
double iso_render_step_voxels(const iso_level *level, const iso_render_options *frame);
/* Returns the step that a frame is drawn with, by request or by default; INFINITY for the converged reference. */
double iso_render_taken_step_voxels(const iso_render_request *request, const iso_render_options *frame);
/* Returns the length of the longest ray through a level, in its smallest spacing. */
double iso_level_chord_voxels(const iso_level *level);

/* Renders one image. ISO_E_MISSING: the program or device is not there; ISO_E_USAGE: the renderer lacks a feature
 * that the view or the options need. *seconds may be NULL. */
iso_status iso_render_with(const iso_render_request *frame, iso_image *image, double *seconds, iso_error *err);

/* Refuses an image of r that has values that are not finite: ISO_E_PROGRAM. Validation has a row for these. */
iso_status iso_render_check_finite(const iso_renderer_info *r, const iso_image *image, iso_error *err);

/* Renders several images of one renderer that differ in step, intervals, samples and seed: images[i] is that of
 * frames->options[i]. Creates all or none. */
iso_status iso_render_several(const iso_render_request *frames, size_t count, iso_image *images, iso_error *err);

/* Renders an image of each of `count` scenes, all of one renderer (scenes[i].renderers too), at most
 * ISO_RENDER_MAX_SCENES: images[i] is that of scenes[i]. In one start if the renderer can. Creates all or none. */
iso_status iso_render_scenes(const iso_render_request *scenes, size_t count, iso_image *images, iso_error *err);

/* Joins the frames of both; of more than ISO_RENDER_MAX_FRAMES the slowest are dropped. */
void iso_render_stats_add(iso_render_stats *stats, const iso_render_stats *more);
/* Computes fastest, median and slowest of at least one frame. */
void iso_render_stats_sum_up(iso_render_stats *stats, const double *seconds, size_t count);

/* Registers the Blenders that Cycles is taken from, a list of paths or names, separated by commas:
 * "blender,/opt/blender-4.3/blender"; NULL: nothing to do. "cycles" is the installed Blender, or the first of the list.
 * Each other one is a renderer of its own, such as "cycles-4.3.2"; it is calibrated like "cycles" and also compared with
 * it. Call it before all others, from one thread. ISO_E_MISSING, ISO_E_PROGRAM: one is not installed, too old, or not
 * Blender; the message names it. ISO_E_USAGE: too many. */
iso_status iso_renderers_take_blenders(const char *list, iso_error *err);
