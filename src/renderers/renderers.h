/* SPDX-License-Identifier: MIT */
/* renderers.h - what is known of each renderer, and one call for all of them.
 *
 * A renderer is one file of this folder: a struct iso_renderer_info that says what it is called, what it can do, how
 * exact its images are, and how it renders. ISO_RENDERER_LIST names them all. Code that lists, checks, calibrates or
 * prints renderers iterates over that table and reads the struct. No code outside this folder asks for a certain
 * renderer, except for the reference, which the others are compared with. doc/extending.md shows how to add one. */
#ifndef ISO_RENDERERS_H
#define ISO_RENDERERS_H

#include <jansson.h>

#include "base/key.h"
#include "base/progress.h"
#include "image/image.h"
#include "pyramid/pyramid.h"
#include "render/reference.h"
#include "scene/scene.h"

typedef struct iso_renderer_info iso_renderer_info;
typedef struct iso_renderers iso_renderers;

/* ---- what is asked of a renderer ---- */

/* What an image takes, by the renderer's own account. */
enum { ISO_RENDER_MAX_FRAMES = 16, ISO_RENDER_MAX_SCENES = 8 };
typedef struct iso_render_stats {
    double seconds, median_seconds,
        most_seconds; /* the frame alone: the fastest of `count`, their middle, the slowest */
    size_t count;
    double frame_seconds[ISO_RENDER_MAX_FRAMES]; /* rising */
    double setup_seconds; /* before it: textures; or the start, the export and the reading of another program */
    double bytes; /* that it holds of the model: textures by their formats (GL), what Blender says, DF3 files; the
                           * reference's floats and codes */
    /* The converged reference: of any pixel, at most, and whether that is proved (render/reference.h); 0: others. */
    double error;
    bool is_proved;
} iso_render_stats;

/* The options that an image depends on: type, name. Two frames are the same if all of them are equal. */
/* clang-format off */
#define ISO_FRAME_FIELDS(X)                                                                                    \
    X(const iso_renderer_info *, renderer)                                                                     \
    X(iso_direction_source, source)   /* of renderers that read one */                                         \
    X(iso_quadrature, quadrature)     /* of those that have several */                                         \
    X(double, step_voxels)            /* 0: the view's; of other programs their own defaults */                \
    X(size_t, intervals)              /* of a ray, instead of a step; 0: the converged defaults */             \
    X(size_t, planes)                 /* that cut each ray, with intervals */                                  \
    X(bool, extrapolate)              /* with intervals */                                                     \
    X(int, samples)                   /* a pixel; 0: the default */                                            \
    X(int, seed)                      /* of random numbers */                                                  \
    X(bool, isosurface)               /* the first hit of the value iso instead of the integral */             \
    X(double, iso)                                                                                             \
    X(bool, shade_table)              /* palettes: shade the entries once instead of each sample */            \
    X(bool, exact_lookups)            /* textures at positions in double precision (render/gl/raycaster.h) */
/* clang-format on */

typedef struct iso_render_options {
#define ISO_FRAME_FIELD(type, name) type name;
    ISO_FRAME_FIELDS(ISO_FRAME_FIELD)
#undef ISO_FRAME_FIELD
    size_t repeats;          /* frames that are drawn, the last of which is the image ... */
    double repeat_seconds;   /* ... as long as they have taken less than this; above 0 a warm-up goes before them */
    bool processor_time;     /* stats: the frame's processor time over all cores instead of the clock's */
    iso_render_stats *stats; /* filled; or NULL */
    int threads;
} iso_render_options;

/* What is rendered, and where to. */
typedef struct iso_render_request {
    iso_renderers *renderers;
    const iso_pyramid *pyramid;
    size_t level; /* one that is there */
    const iso_view *view;
    const iso_render_options *options;
    const iso_progress *progress;
} iso_render_request;

/* ---- what is known of a renderer ---- */

/* What a renderer can do, and which options it reads; it ignores the others. */
typedef enum iso_trait {
    ISO_IS_PROGRAM = 1 << 0, /* started for its images, which takes seconds, and given an export, which carries
                                      * decoded directions; else it runs in this process */
    ISO_IS_RANDOM = 1 << 1,  /* its images have noise: it is run with several seeds */
    ISO_HAS_LIMIT = 1 << 2,  /* its error falls with the square of its ray step */
    ISO_HAS_ISOSURFACES = 1 << 3,
    ISO_HAS_CLIP_PLANES = 1 << 4,
    ISO_HAS_2D_TFS = 1 << 5,         /* 2D transfer functions */
    ISO_HAS_ROI = 1 << 6,            /* a region of interest */
    ISO_HAS_BRICKS = 1 << 7,         /* bricks of mixed resolution (plan/cached.h) */
    ISO_HAS_PROCESSOR_TIME = 1 << 8, /* tells that of a frame */
    ISO_READS_QUADRATURE = 1 << 9,
    ISO_READS_SOURCE = 1 << 10, /* takes directions from codes, floats, palettes ..., filtered as asked */
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
    ISO_HAS_ORTHOGRAPHIC = 1 << 21, /* cameras */
    ISO_IS_NAMED = 1 << 22,         /* takes part where it is named, and never by default */
    ISO_IS_OF_PICTURES = 1 << 23,   /* made elsewhere, of scenes as they are (pictures.h) */
    ISO_IS_OF_A_USER = 1 << 24,     /* a row of a renderers.json: what it starts may change and its version stay */
    ISO_WAITS_BETWEEN = 1 << 25,    /* one start's pictures each begin with a wait: side by side they end sooner */
} iso_trait;
#define ISO_HAS_ALL_SCENES \
    (ISO_HAS_CLIP_PLANES | ISO_HAS_2D_TFS | ISO_HAS_EXTINCTION_SCALES | ISO_HAS_ROI | ISO_HAS_LIGHTS | \
     ISO_HAS_ORTHOGRAPHIC)

/* How far an image may be from the reference with the same samples; 0: not checked. */
typedef struct iso_sample_error {
    double rmse, max_abs;
} iso_sample_error;

/* Lock-step: the places of the renderer's samples are known, and the reference takes its samples there too. What
 * differs then is only how exactly the renderer computes. Where they are not known, and its step cannot be halved to find
 * its limit (integers of 8 bits), the quadrature is ISO_QUADRATURE_CONVERGED: it is held to the reference itself, within
 * what it states of itself. */
typedef struct iso_lock_step {
    iso_quadrature quadrature;      /* of the reference, which has the same samples */
    size_t intervals;               /* that both are asked for; 0: the view's step */
    iso_sample_error smooth, sharp; /* by the transfer function; where it is steep it multiplies differences */
    const char *why;                /* the cause of these */
    iso_sample_error exact;         /* with exact lookups, of any transfer function; zeroed: it has none */
    const char *exact_why;
    iso_sample_error rounded; /* of the usual lookups where they are farther, but exact ones are within `exact` */
    const char *rounded_why;
} iso_lock_step;

/* The integers that a renderer stores its images in. Zeroed: floats. */
typedef struct iso_render_output {
    unsigned bits;                        /* a channel */
    double (*peak)(const iso_view *view); /* the color that the largest integers stand for */
    double rounding, rounding_rmse;       /* of that color, in lock-step: of a value, and over the image */
    double most;                          /* what they end at: brighter colors are clipped to it; 0: at nothing */
} iso_render_output;

struct iso_renderer_info {
    const char *name;      /* on command lines and in reports: "gl" */
    const char *title;     /* for people: "OpenGL ray caster" */
    const char *stages[4]; /* that a render reports (base/progress.h), in order; the last takes longest; or none */
    const char *color;     /* of its marks in charts */
    unsigned traits;       /* iso_trait */
    unsigned quadratures;  /* 1 << iso_quadrature of those that it reads */
    iso_render_options defaults;    /* .renderer need not be set */
    double sample_seconds;          /* about, of each sample of a ray: for estimates */
    double first_step_voxels;       /* where the search for its limit begins; 0: where the transfer function says */
    size_t max_intervals;           /* of a ray, or of its piece between two planes; 0: it has steps */
    size_t step_count;              /* of its pictures, each step half of the one before; 0: as fine as is asked */
    size_t seeds;                   /* of a random one: as many as its limit is made of at least */
    const iso_lock_step *lock_step; /* or NULL */
    iso_render_output output;
    const char *const *programs; /* of other programs: what its pictures depend on besides this program, each as
                                  * iso_key_add_dependency() takes it; ends with NULL. NULL: nothing */
    const char *found_in;        /* of a program that the user brought: the renderers.json that names it; or NULL */

    const void *data; /* of the file that made it: what tells it apart from others that this file made; or NULL */
    const iso_renderer_info
        *beside; /* another version of the same program, which it is compared with as well; or NULL */
    /* What follows --with on the command line of a render by it. NULL: its name. */
    const char *(*asked_by)(const iso_renderer_info *self);

    /* Its version, such as "Blender 3.4.1". ISO_E_MISSING when it is not there, with the reason. */
    iso_status (*version)(const iso_renderer_info *self, iso_renderers *r, char *text, size_t size, iso_error *err);
    /* Creates the image. Fills stats, but for what the caller sees by itself: setup_seconds of programs, and the time where
     * there is none but that of the call. */
    iso_status (*render)(const iso_render_request *request, iso_image *image, iso_render_stats *stats, iso_error *err);
    /* `count` frames, from request->options on, by one start; all or none. NULL: one after the other. */
    iso_status (*render_several)(const iso_render_request *request, size_t count, iso_image *images, iso_error *err);
    /* A picture of each of `count` scenes, at most ISO_RENDER_MAX_SCENES, all of one size, by one start; all or none. NULL: one
     * after the other. */
    iso_status (*render_scenes)(const iso_render_request *scenes, size_t count, iso_image *images, iso_error *err);
    /* Asks `count` frames for steps, the last for finest_voxels and each other for the double of the next, so that all
     * samples of one are halved into those of the next; and so that the last can be halved `spare` times more, a factor
     * of 1 to 4. NULL: by step_voxels. */
    void (*ask_steps)(const iso_level *level, double finest_voxels, size_t count, double spare,
                      iso_render_options *frames);
    /* The step that it takes where a frame asks for none, in the level's smallest spacing. NULL: the view's. */
    double (*own_step)(const iso_level *level);
    /* What a report says of how it was run: a new object (doc/reference/files-report.md, "programs"). NULL: nothing. */
    json_t *(*describe)(const iso_renderer_info *self);
    /* Releases what it keeps (iso_renderers_kept()). May be NULL. */
    void (*end)(void *kept);
};

static inline bool iso_renderer_has(const iso_renderer_info *r, unsigned traits)
{
    return (r->traits & traits) == traits;
}

/* ---- the table ---- */

/* The renderers: a file each, in the order in which they are listed. */
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
/* The reference, which the others are compared with. */
const iso_renderer_info *iso_renderers_truth(void);
/* The renderer that is used where none is named: the fastest. */
const iso_renderer_info *iso_renderers_usual(void);
/* Where none was named and OpenGL has nothing but software: the CPU ray caster instead, which has the same samples in less
 * time, if it has all that the view and the options ask for. Else the options stay as they are. */
void iso_renderers_choose(const iso_pyramid *p, const iso_view *view, iso_render_options *opt);

/* Adds a renderer at the end of the table, for as long as the process runs; it is not copied. Before any other call, by
 * one thread. ISO_E_USAGE: its name is taken; ISO_E_RANGE: the table is full. */
iso_status iso_renderers_register(const iso_renderer_info *r, iso_error *err);

/* ISO_E_USAGE, with the names that there are. */
iso_status iso_renderer_from_name(const char *name, const iso_renderer_info **r, iso_error *err);
/* "gl,povray"; NULL: all that need not be named. The reference is always wanted, pictures that were brought, and what stands
 * beside one that is. */
iso_status iso_renderers_from_list(const char *list, bool wanted[ISO_MAX_RENDERERS], iso_error *err);

/* The names of those that have all these traits (0: of all), joined: "reference, gl and povray" by ", " and " and ".
 * Returns text, which is cut where it is too long. */
const char *iso_renderers_with(unsigned traits, const char *join, const char *last_join, char *text, size_t size);
/* Those of them that take part where none is named: "reference,gl". */
const char *iso_renderers_by_default(unsigned traits, char *text, size_t size);

/* Hashes the version that a renderer reports, and its programs. Stored pictures with another hash are not taken.
 * Empty for programs of a user, whose files are not known: they may change in any way while their version stays. */
iso_status iso_renderer_identify(const iso_renderer_info *r, const char *version, char hash[ISO_KEY_DIGEST_BYTES],
                                 iso_error *err);

/* ---- rendering ---- */

/* Environment: set, requests for several pictures draw them one after the other. For bench job. */
#define ISO_RENDERERS_APART "ISOSHADE_PICTURES_APART"

/* A function that may change each image after it is rendered; it is told of what. Zeroed: none. */
typedef struct iso_image_hook {
    iso_status (*change)(const void *user, const iso_render_request *request, iso_image *image, iso_error *err);
    const void *user;
} iso_image_hook;

/* Images of one scene by their options, for work that asks for the same ones again. Zeroed: empty. */
typedef struct iso_frame_cache {
    size_t count;
    iso_render_options *frames;
    iso_image *images;
} iso_frame_cache;
void iso_frame_cache_clear(iso_frame_cache *cache);

/* Zeroed, it is ready. */
struct iso_renderers {
    void
        *kept[ISO_MAX_RENDERERS]; /* what a renderer keeps between images, such as a context; by iso_renderer_index() */
    const char *shader_dir;       /* NULL: the embedded shaders */
    const char *scene;            /* the name of what is rendered, for those that look for pictures of it; or NULL */
    iso_image_hook after;         /* of each image that is rendered */
    struct iso_picture_store *store; /* pictures of a job that was interrupted (picture_store.h); borrowed, or NULL */
    iso_frame_cache *cache; /* of iso_render_several(), while pyramid, level, view and hook stay; borrowed, or NULL */
};
void iso_renderers_end(iso_renderers *r);
static inline void **iso_renderers_kept(iso_renderers *r, const iso_renderer_info *of)
{
    return &r->kept[iso_renderer_index(of)];
}

iso_render_options iso_render_defaults(const iso_renderer_info *r);

/* What the view or an isosurface needs and the renderer does not have, such as "clip planes"; or NULL. */
const char *iso_renderer_lacks(const iso_renderer_info *r, const iso_pyramid *p, const iso_view *view, bool isosurface);

/* Asks frames for steps as iso_renderer_info.ask_steps does. */
void iso_render_ask_steps(const iso_renderer_info *r, const iso_level *level, double finest_voxels, size_t count,
                          double spare, iso_render_options *frames);
/* The step that a frame asks for, of the longest ray where it has intervals. */
double iso_render_step_voxels(const iso_level *level, const iso_render_options *frame);
/* The step that a frame of the request is drawn by, whoever chose it; INFINITY of the converged reference. */
double iso_render_taken_step_voxels(const iso_render_request *request, const iso_render_options *frame);
/* The longest ray through a level, in its smallest spacing. */
double iso_level_chord_voxels(const iso_level *level);

/* One image. ISO_E_MISSING when the program or device is not there; ISO_E_USAGE when the renderer does not have what the
 * view or the options ask for. *seconds may be NULL. */
iso_status iso_render_with(const iso_render_request *frame, iso_image *image, double *seconds, iso_error *err);

/* ISO_E_PROGRAM where a picture of r holds values that are no numbers. Validation has a row for such a picture; who asks for
 * one picture is told. */
iso_status iso_render_check_finite(const iso_renderer_info *r, const iso_image *image, iso_error *err);

/* Several images of one renderer that differ in step, intervals, samples and seed: images[i] is that of
 * frames->options[i]. All or none are created. */
iso_status iso_render_several(const iso_render_request *frames, size_t count, iso_image *images, iso_error *err);

/* An image of each of `count` scenes, all of one renderer (scenes[i].renderers too), at most ISO_RENDER_MAX_SCENES: images[i] is
 * that of scenes[i]. By one start where the renderer can. All or none are created. */
iso_status iso_render_scenes(const iso_render_request *scenes, size_t count, iso_image *images, iso_error *err);

/* Joins the frames of both; of more than ISO_RENDER_MAX_FRAMES the slowest are dropped. */
void iso_render_stats_add(iso_render_stats *stats, const iso_render_stats *more);
/* The fastest, the middle and the slowest of at least one frame. */
void iso_render_stats_sum_up(iso_render_stats *stats, const double *seconds, size_t count);

#endif
