/* SPDX-License-Identifier: MIT */
/* isoshade.h - libisoshade: multi-resolution volumes that keep their shading, and renderers that can be compared.
 *
 * Where to start
 *   A *volume* is a grid of numbers: a scan, a simulation, an array that a program fills. A *pyramid* is that volume at
 *   several *levels*, each with half the voxels along an axis of the one before; level 0 is the volume itself. For
 *   each voxel a pyramid keeps the value and a *direction*, the normal of the local surface, for shading. The
 *   directions of all levels come from level 0's gradients, and are stored in three bytes each (a *direction code*). A
 *   *transfer function* (TF) gives each value a color and an extinction. It can be adapted to a level, so that the
 *   level looks like the volume. A *scene* is a camera, lights, a background and a TF. It can be used with any
 *   volume.
 *
 *       iso_volume_open()  or  iso_volume_from_memory()           a volume
 *         iso_build()  or  iso_pyramid_open()                       a pyramid
 *           iso_tf_adapt()                                            a TF for one of its levels
 *           iso_render()          a level as an image; iso_metrics_measure() compares two images
 *           iso_export()          a level for OpenVDB, Blender, POV-Ray
 *           iso_pyramid_level()   the numbers themselves
 *
 *   doc/guide/library.md is a program of about sixty lines that does all of this.
 *
 * Errors     A function that can fail returns an iso_status, ISO_OK on success, and writes a message to its
 *            last parameter, an iso_error that may be NULL. It never prints, and never ends the process.
 *            After a failure the object to create is NULL (an image: empty).
 * Ownership  Handles (iso_volume *, iso_pyramid *, iso_tf *, iso_scene *) belong to the caller, who frees them with
 *            the functions whose names end in _free; these accept NULL. No function keeps its arguments: a
 *            volume may be freed once its pyramid is built. Arrays of the caller are read or filled, and not kept.
 * Threads    Several threads may read a handle at once while none changes it. Work is spread over all
 *            processor cores, or over the number that an option sets; results do not depend on it. In a forked
 *            child, the thread that forked has no other threads if it had any before; new threads have.
 * Units      Positions and lengths are millimeters, extinction is 1/mm, gradients are value per mm. Colors are linear
 *            light, 0 to 1. Arrays of voxels are stored x fastest, then y, then z; directions use the world's
 *            axes.
 * Options    Get a struct of options from its function of defaults, and change it as needed. NULL selects the
 *            defaults. Names (codes, estimators, renderers ...) are words, as on the command line; iso_choice_name()
 *            lists them.
 * Stability  Programs that were built with one version run with later ones of the same major number: handles are
 *            opaque, structs have space to grow ("reserved": zero), elements of arrays stay as they are, and
 *            statuses keep their numbers. Major number 0 means that this may still change from one minor version
 *            to the next.
 *
 * The header is C99 and C++. Link with `pkg-config --cflags --libs isoshade`. */
#ifndef ISOSHADE_H
#define ISOSHADE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- version ----------------------------------------------------------------------------------------------------- */

/* The one place of the version: the build, the manual page and the pkg-config file read it here. */
#define ISO_VERSION_MAJOR 0
#define ISO_VERSION_MINOR 3
#define ISO_VERSION_PATCH 0
#define ISO_VERSION_WORD(number) #number
#define ISO_VERSION_TEXT(major, minor, patch) \
    ISO_VERSION_WORD(major) "." ISO_VERSION_WORD(minor) "." ISO_VERSION_WORD(patch)
#define ISO_VERSION ISO_VERSION_TEXT(ISO_VERSION_MAJOR, ISO_VERSION_MINOR, ISO_VERSION_PATCH) /* "0.3.0" */
/* For #if: ISO_VERSION_NUMBER >= 3000 from 0.3.0 on. */
#define ISO_VERSION_NUMBER (1000000 * ISO_VERSION_MAJOR + 1000 * ISO_VERSION_MINOR + ISO_VERSION_PATCH)

/* Returns the version of the running library, such as "0.3.0"; ISO_VERSION is that of the header. */
const char *iso_version(void);
/* Returns the same as a number: 3000 for 0.3.0. */
int iso_version_number(void);

/* ---- errors ------------------------------------------------------------------------------------------------------ */

/* name, number (also the exit code of the command that met it), meaning */
/* clang-format off */
#define ISO_STATUS_LIST(X)                                                          \
    X(ISO_OK, 0, "success")                                                         \
    X(ISO_E_DIFFERS, 1, "the comparison found a difference")                        \
    X(ISO_E_USAGE, 2, "bad command line or option value")                           \
    X(ISO_E_IO, 3, "a file could not be read or written")                           \
    X(ISO_E_FORMAT, 4, "a file's content is invalid")                               \
    X(ISO_E_RANGE, 5, "a value lies outside its limits")                            \
    X(ISO_E_MEMORY, 6, "not enough memory")                                         \
    X(ISO_E_MISSING, 7, "a needed program or device is missing")                    \
    X(ISO_E_PROGRAM, 8, "an external program or library failed")                    \
    X(ISO_E_UNTRUSTED, 9, "a renderer failed its calibration; comparison refused")  \
    X(ISO_E_CANCELED, 10, "the progress function canceled the work")
/* clang-format on */

typedef enum iso_status {
#define ISO_STATUS_ENUM(name, code, text) name = code,
    ISO_STATUS_LIST(ISO_STATUS_ENUM)
#undef ISO_STATUS_ENUM
} iso_status;

/* An error in one line: the file or option, the value and its limit. */
typedef struct iso_error {
    char text[1024];
} iso_error;

/* Returns the meaning of a status, such as "a file could not be read or written". */
const char *iso_status_text(iso_status status);

/* Receives facts that a user should read about an accepted input, such as a file that is left out. From any thread. */
typedef void (*iso_warning_callback)(void *user, const char *text);
/* Sets the function that receives warnings; NULL, as at the start: they are dropped. Each text comes once. */
void iso_warnings_to(iso_warning_callback warn, void *user);

/* Frees texts and bytes that functions return by a char ** or unsigned char **; accepts NULL. */
void iso_free(void *memory);

/* ---- names that options take ------------------------------------------------------------------------------------- */

typedef enum iso_choice {
    ISO_CHOICE_VOXEL_TYPE,       /* "uint8", "int16", "float" ... */
    ISO_CHOICE_CODE,             /* direction codes: "fit", "snorm", "region48" ... */
    ISO_CHOICE_ESTIMATOR,        /* of gradients: "central", "sobel" ... */
    ISO_CHOICE_SCALAR_FILTER,    /* "mean" ... */
    ISO_CHOICE_DIRECTION_FILTER, /* "moments", "naive" ... */
    ISO_CHOICE_SHADING,          /* sources of a renderer's directions: "codes", "float" ... */
    ISO_CHOICE_RENDERER,         /* "reference", "gl" ...: all renderers, installed or not */
    ISO_CHOICE_EXPORT,           /* "vdb", "nanovdb", "blender", "povray", "pbrt", "paraview" */
    ISO_CHOICE_TF,               /* transfer functions that fit any volume: "auto", "ct-bone" ... */
    ISO_CHOICE_VIEW              /* "iso", "front", "left" ... */
} iso_choice;

/* Returns name `number`, counted from 0; NULL after the last. */
const char *iso_choice_name(iso_choice what, size_t number);

/* ---- long work --------------------------------------------------------------------------------------------------- */

/* Receives the progress of a stage of the work, 0 to 1, from one thread at a time, several times per second. Returns
 * whether to go on. After false the call ends within a fraction of a second with ISO_E_CANCELED, and leaves nothing
 * behind; a call that is complete by then succeeds. */
typedef bool (*iso_progress_callback)(void *user, const char *stage, double fraction);

/* ---- volumes ----------------------------------------------------------------------------------------------------- */

/* Position of voxels. Index coordinates are continuous: voxel i covers [i, i + 1) and has its center at i + 1/2. */
typedef struct iso_grid {
    size_t size[3];              /* voxels along x, y, z */
    double index_to_world[3][4]; /* world mm = index_to_world (i, j, k, 1); may rotate, shear and reflect */
    double box_index[3];         /* rendered part: [0, box_index]; coarse levels may overhang it; 0: size */
    const void *reserved[4];
} iso_grid;

/* Makes a grid along the world's axes, centered at the origin. */
iso_grid iso_grid_axis_aligned(const size_t size[3], const double spacing_mm[3]);
/* Computes the lengths of a voxel's edges. */
void iso_grid_spacing_mm(const iso_grid *grid, double spacing_mm[3]);

typedef struct iso_volume iso_volume;

/* Opens a file or a folder of slices by its content (doc/reference/formats-read.md), applying its slope and
 * intercept. NaN and the file's fill values are no data (iso_volume_samples()).
 * ISO_E_IO; ISO_E_FORMAT: not of these formats, or damaged; ISO_E_RANGE: infinite voxels, or no data;
 * ISO_E_MISSING: a program that reads such files (isoshade-itk, -arrays, -vdb) is not installed; ISO_E_MEMORY. */
iso_status iso_volume_open(const char *path, iso_volume **volume, iso_error *err);

/* Facts that a file lacks, or that choose one of its volumes. All zero: what the file says. */
typedef struct iso_open_options {
    const char *series;     /* of a folder, by number or name */
    const char *frame;      /* time step, from 0 */
    const char *channel;    /* number from 0, or name */
    const char *unit;       /* of lengths: "mm", "um" ... */
    double spacing[3];      /* in that unit; 0: the file's */
    size_t raw_size[3];     /* of a file without a header; 0: it has one */
    const char *raw_type;   /* of such a file: "uint8" ... */
    size_t raw_skip_bytes;  /* before its samples */
    bool raw_is_big_endian; /* byte order of its samples */
    bool stored;            /* True to ignore slope and intercept */
    int labels;             /* 1: a label map; -1: intensities; 0: by its samples */
    bool resample;          /* True to interpolate slices at uneven distances, */
    bool force_spacing;     /* or to take them for even */
    const char *no_data;    /* values that are none, instead of the file's: "-2000", "LO,HI", or "none" */
    const void *reserved[7];
} iso_open_options;
/* Opens a volume as iso_volume_open() does. ISO_E_USAGE also for options that contradict each other. */
iso_status iso_volume_open_with(const char *path, const iso_open_options *options, iso_volume **volume, iso_error *err);

/* Copies samples of a type (ISO_CHOICE_VOXEL_TYPE) in the machine's byte order, x fastest, without gaps; NaN is no
 * data. ISO_E_USAGE: an unknown type; ISO_E_RANGE: a size of 0, a grid without volume, infinite samples, or no data;
 * ISO_E_MEMORY. */
iso_status iso_volume_from_memory(const iso_grid *grid, const char *type, const void *samples, iso_volume **volume,
                                  iso_error *err);
/* Copies an array whose samples are strides[0], [1], [2] bytes apart along x, y and z, which may be negative; `samples`
 * points to voxel (0, 0, 0). Takes also "bool" (stored as uint8), "float16" (as float), "int64" and "uint64" (as
 * double; ISO_E_RANGE: a value beyond 2^53). */
iso_status iso_volume_from_array(const iso_grid *grid, const char *type, const void *samples,
                                 const ptrdiff_t strides[3], iso_volume **volume, iso_error *err);

iso_grid iso_volume_grid(const iso_volume *volume);
/* Returns the type of the samples. */
const char *iso_volume_type(const iso_volume *volume);
/* Returns the samples, which live as long as the volume: x fastest, without gaps. Voxels without data, which only
 * floats and doubles have, are -2^100. */
const void *iso_volume_samples(const iso_volume *volume);
/* Copies the samples as floats, one per voxel. */
void iso_volume_values(const iso_volume *volume, float *values);

/* Writes an NRRD file with attached header, its samples raw or packed by gzip. ISO_E_IO. */
iso_status iso_volume_save(const iso_volume *volume, const char *path, bool gzip, iso_error *err);

void iso_volume_free(iso_volume *volume);

/* ---- pyramids ---------------------------------------------------------------------------------------------------- */

typedef struct iso_pyramid iso_pyramid;

typedef struct iso_build_options {
    size_t levels;                  /* with level 0, 1 to 32; fewer if a level would be a single voxel */
    const char *code;               /* code of directions */
    const char *estimator;          /* of level 0's gradients */
    const char *scalar_filter;      /* makes one coarse value of eight */
    const char *direction_filter;   /* makes one coarse direction of eight */
    bool keep_float;                /* True to keep directions before encoding, too: 12 more bytes per voxel */
    bool keep_magnitude;            /* True to keep gradient magnitudes, too: 4 more bytes per voxel */
    int threads;                    /* 0: all cores */
    iso_progress_callback progress; /* or NULL */
    void *progress_user;
    const void *reserved[8];
} iso_build_options;
/* Returns the defaults: four levels, "fit", "central", "mean", "moments". */
iso_build_options iso_build_defaults(void);

/* Builds a pyramid. ISO_E_USAGE: unknown name; ISO_E_RANGE: option out of limits, NaN or infinity; ISO_E_MEMORY. */
iso_status iso_build(const iso_volume *volume, const iso_build_options *options, iso_pyramid **pyramid, iso_error *err);

/* Opens a folder NAME.iso (doc/reference/files-pyramid.md) and checks its checksums. ISO_E_IO, ISO_E_FORMAT,
 * ISO_E_MEMORY. */
iso_status iso_pyramid_open(const char *folder, iso_pyramid **pyramid, iso_error *err);
/* Writes a folder NAME.iso, which appears when it is complete. ISO_E_IO. */
iso_status iso_pyramid_save(const iso_pyramid *pyramid, const char *folder, iso_error *err);

size_t iso_pyramid_level_count(const iso_pyramid *pyramid);

/* A view of a level: the arrays belong to the pyramid and live as long as it does. */
typedef struct iso_level_view {
    iso_grid grid;
    double min, max;         /* of the values */
    const float *values;     /* one per voxel */
    const char *code;        /* direction code of `codes` */
    const uint8_t *codes;    /* 3 per voxel: the encoded directions */
    const float *directions; /* 3 per voxel, before encoding; NULL without keep_float */
    const float *magnitudes; /* one per voxel; NULL without keep_magnitude */
    const void *reserved[8];
} iso_level_view;
/* Gives access to one level. ISO_E_RANGE: no such level; the view is then empty. */
iso_status iso_pyramid_level(const iso_pyramid *pyramid, size_t level, iso_level_view *view, iso_error *err);

/* Decodes a level's directions: 3 floats per voxel. The length, at most 1, is the reliability; 0: undefined.
 * ISO_E_RANGE. */
iso_status iso_pyramid_directions(const iso_pyramid *pyramid, size_t level, float *directions, iso_error *err);

void iso_pyramid_free(iso_pyramid *pyramid);

/* ---- direction codes --------------------------------------------------------------------------------------------- */

/* Returns the bytes per direction: 3 for most codes, 0 for an unknown one. */
size_t iso_directions_bytes(const char *code);
/* Encodes directions of 3 floats and a length of at most 1. ISO_E_USAGE: an unknown code; ISO_E_RANGE: a
 * direction that is too long or not finite, with its number. */
iso_status iso_directions_encode(const char *code, const float *directions, size_t count, uint8_t *bytes,
                                 iso_error *err);
/* Decodes any bytes to directions, whose lengths are at most 1 except for rounding. ISO_E_USAGE. */
iso_status iso_directions_decode(const char *code, const uint8_t *bytes, size_t count, float *directions,
                                 iso_error *err);

/* ---- transfer functions ------------------------------------------------------------------------------------------ */

typedef struct iso_tf iso_tf;

typedef struct iso_tf_point {
    double value;
    double rgb_linear[3]; /* 0 to 1 */
    double opacity;       /* 0 to 1, after one unit of length */
} iso_tf_point;

/* Opens a file NAME.tf.json (doc/reference/files-scene.md), or one of another program that is complete
 * (doc/reference/tf-formats.md). ISO_E_IO, ISO_E_FORMAT, ISO_E_RANGE, ISO_E_MEMORY; ISO_E_USAGE: the file lacks a range
 * or a unit length, which options of `isoshade tf convert` supply. */
iso_status iso_tf_open(const char *path, iso_tf **tf, iso_error *err);
/* Makes a TF from at least two points of rising values; between them color and opacity are linear. Opacity refers to
 * unit_mm millimeters: extinction = -ln(1 - opacity) / unit_mm. ISO_E_RANGE, with the number of the point;
 * ISO_E_MEMORY. */
iso_status iso_tf_from_points(const iso_tf_point *points, size_t count, double unit_mm, iso_tf **tf, iso_error *err);
/* Adapts a TF to a level, so that the level looks like the volume. Returns a copy at level 0, and if adapting would not
 * be closer. ISO_E_RANGE: no such level; ISO_E_MEMORY. */
iso_status iso_tf_adapt(const iso_tf *tf, const iso_pyramid *pyramid, size_t level, iso_tf **adapted, iso_error *err);
/* Looks up red, green, blue and extinction per mm of values, as renderers of this pyramid do. A TF whose range is
 * "fit" takes its range from the pyramid's level 0. ISO_E_RANGE, ISO_E_MEMORY. */
iso_status iso_tf_evaluate(const iso_tf *tf, const iso_pyramid *pyramid, const double *values, size_t count,
                           double (*rgb_extinction)[4], iso_error *err);
/* Suggests a TF for a pyramid: from a preset (ISO_CHOICE_TF) or a file; NULL: "auto", by its values. ISO_E_USAGE: an
 * unknown preset; also what iso_tf_open() returns. */
iso_status iso_tf_suggest(const iso_pyramid *pyramid, const char *name, iso_tf **tf, iso_error *err);
/* Copies at most `most` points, and returns how many there are. */
size_t iso_tf_points(const iso_tf *tf, iso_tf_point *points, size_t most);
/* Returns the text of its file, to be freed by iso_free(). */
iso_status iso_tf_text(const iso_tf *tf, char **json, iso_error *err);
/* Makes a TF from such a text. ISO_E_FORMAT, ISO_E_RANGE, ISO_E_MEMORY. */
iso_status iso_tf_from_text(const char *json, iso_tf **tf, iso_error *err);
/* Writes NAME.tf.json. ISO_E_IO. */
iso_status iso_tf_save(const iso_tf *tf, const char *path, iso_error *err);
void iso_tf_free(iso_tf *tf);

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

typedef struct iso_scene iso_scene;

/* Opens a file NAME.scene.json (doc/reference/files-scene.md). ISO_E_IO, ISO_E_FORMAT, ISO_E_RANGE, ISO_E_MEMORY. */
iso_status iso_scene_open(const char *path, iso_scene **scene, iso_error *err);
/* Makes a scene from the text of such a file. TF files that it names are relative to the current folder. */
iso_status iso_scene_from_text(const char *json, iso_scene **scene, iso_error *err);
/* Parts of an automatic scene. All zero: chosen for the volume. */
typedef struct iso_look_options {
    const char *tf;       /* preset or file; NULL: "auto" */
    const char *view;     /* ISO_CHOICE_VIEW, or "AZ,EL" in degrees; NULL: "front" of a patient, otherwise "iso" */
    double zoom;          /* .01 to 1000, enlarges the middle of the picture; 0: 1 */
    size_t width, height; /* 0: 512 */
    const void *reserved[8];
} iso_look_options;
/* Makes the scene of a first picture: the camera frames the visible part of the volume. ISO_E_USAGE: an unknown name;
 * also what iso_tf_open() returns. */
iso_status iso_scene_automatic(const iso_pyramid *pyramid, const iso_look_options *look, iso_scene **scene,
                               iso_error *err);
/* Replaces parts of a scene: the keys of a scene file's object, such as {"background": [1, 1, 1]}; null removes a key.
 * After a failure the scene is unchanged. ISO_E_FORMAT, ISO_E_RANGE, ISO_E_MEMORY. */
iso_status iso_scene_set(iso_scene *scene, const char *json, iso_error *err);
/* Replaces the scene's TF by a copy. ISO_E_MEMORY. */
iso_status iso_scene_set_tf(iso_scene *scene, const iso_tf *tf, iso_error *err);
/* Returns the text of its file, to be freed by iso_free(), with the TF in it. */
iso_status iso_scene_text(const iso_scene *scene, char **json, iso_error *err);
/* Writes NAME.scene.json. ISO_E_IO. */
iso_status iso_scene_save(const iso_scene *scene, const char *path, iso_error *err);
/* Returns the scene's own TF, which lives as long as the scene. */
const iso_tf *iso_scene_tf(const iso_scene *scene);
void iso_scene_free(iso_scene *scene);

/* ---- images ------------------------------------------------------------------------------------------------------ */

/* Linear light, color multiplied by alpha; the first row is the top one. All zero is empty. */
typedef struct iso_image {
    size_t width, height;
    float *rgba;   /* 4 per pixel; owned, freed by iso_image_destroy() */
    int origin[2]; /* first column and row of an EXR's display window; 0, 0 for other formats */
    const void *reserved[4];
} iso_image;

/* A key and a text for a file's header. */
typedef struct iso_image_note {
    const char *key, *value;
} iso_image_note;

/* Makes a black, transparent image. ISO_E_RANGE: a size of 0, or one that cannot be addressed; ISO_E_MEMORY. */
iso_status iso_image_create(iso_image *image, size_t width, size_t height, iso_error *err);
void iso_image_destroy(iso_image *image); /* accepts empty and NULL */

/* Writes OpenEXR, 32-bit float, channels A B G R. The notes end with a NULL key, or are NULL.
 * ISO_E_IO. */
iso_status iso_image_save_exr(const iso_image *image, const char *path, const iso_image_note *notes, iso_error *err);
/* Reads a flat single-part EXR with R, G, B or gray Y (A = 1 if absent), converted to Rec. 709 primaries. The image is
 * the file's display window: its pixels outside the data window are 0, and data outside the display window are dropped.
 * ISO_E_IO, ISO_E_FORMAT, ISO_E_MEMORY. */
iso_status iso_image_load_exr(const char *path, iso_image *image, iso_error *err);
/* Writes 8-bit sRGB, opaque, with colors multiplied by exposure. ISO_E_IO. */
iso_status iso_image_save_png(const iso_image *image, const char *path, double exposure, iso_error *err);
/* Return such a file as bytes, to be freed by iso_free(). */
iso_status iso_image_png(const iso_image *image, double exposure, unsigned char **bytes, size_t *size,
                         iso_error *err);
iso_status iso_image_exr(const iso_image *image, unsigned char **bytes, size_t *size, iso_error *err);
/* Reads PNG of 1 to 16 bits into linear light, multiplied by alpha. ISO_E_IO, ISO_E_FORMAT, ISO_E_MEMORY. */
iso_status iso_image_load_png(const char *path, iso_image *image, iso_error *err);

/* ---- comparison -------------------------------------------------------------------------------------------------- */

/* Differences between two images, over the four channels of all pixels. FLIP (how visible they are when the
 * images alternate) and SSIM (structure; 1 if equal) compare the images as a screen would show them. */
typedef struct iso_metrics {
    double rmse, max_abs, p99_abs; /* p99: 99 % of pixels differ by less in every channel */
    double psnr_db;                /* peak 1; infinite for equal images */
    double ssim, flip_mean;
    size_t nonfinite_count; /* pixels with NaN or infinity in either image; above 0 all metrics are NaN */
    size_t worst[2];        /* column and row of max_abs */
    double reserved[8];
} iso_metrics;
/* Compares two images. ISO_E_RANGE: empty images, other sizes or origins. Test `max_abs <= limit`: NaN never passes. */
iso_status iso_metrics_measure(const iso_image *a, const iso_image *b, iso_metrics *metrics, iso_error *err);

/* A region of interest: a finer level inside a box, blended into the level that is rendered around it. */
typedef struct iso_region {
    double lo[3], hi[3]; /* the box, in voxels of level 0 */
    size_t level;        /* inside */
    double band;         /* blended around the box, 0 to 64 voxels of the level there; 0: a hard edge */
    const void *reserved[4];
} iso_region;
/* Returns a region with full resolution inside, and a band of 2 voxels. */
iso_region iso_region_of(const double lo[3], const double hi[3]);

/* ---- rendering --------------------------------------------------------------------------------------------------- */

typedef struct iso_frame_options {
    const char *renderer; /* "reference": exact and slow; others are faster, or other programs */
    size_t level;
    size_t width, height;           /* 0: the scene's */
    const iso_tf *tf;               /* NULL: the scene's */
    const char *shading;            /* source of directions; for "reference" and "gl" */
    double step_voxels;             /* step along rays, in smallest voxel spacings; 0: the renderer's most exact step */
    int samples, seed;              /* for "cycles"; 0: its defaults */
    int threads;                    /* 0: all cores */
    iso_progress_callback progress; /* or NULL */
    void *progress_user;
    bool adapt;                     /* True to adapt the TF to the level */
    bool extinction_scale;          /* True to scale the extinction of a coarse level's voxels, for their opacity */
    const iso_region *region;       /* or NULL */
    const void *reserved[6];
} iso_frame_options;
/* Returns the defaults: level 0 with "reference", the scene unchanged. */
iso_frame_options iso_frame_defaults(void);

/* Renders an image. ISO_E_USAGE: an unknown name, an option that the renderer does not support; ISO_E_RANGE: no such
 * level, an option outside its limits; ISO_E_MISSING: no such program or graphics device; ISO_E_PROGRAM;
 * ISO_E_CANCELED. While other programs run, SIGINT, SIGTERM and SIGHUP end them and the call fails, unless this program
 * handles those signals: its progress function cancels then. */
iso_status iso_render(const iso_pyramid *pyramid, const iso_scene *scene, const iso_frame_options *options,
                      iso_image *image, iso_error *err);

/* ---- plans ------------------------------------------------------------------------------------------------------- */

typedef struct iso_plan_options {
    double error;                   /* largest RMSE of each picture, 1e-6 to 1 */
    double memory_bytes;            /* instead: limit of all bricks; 0: none */
    size_t levels;                  /* with level 0, 1 to log2(brick_voxels) + 1 */
    size_t brick_voxels;            /* along a side, a power of two, 2 to 64 */
    size_t views;                   /* 1 to 360: the scene's, and others turned around its up axis by equal angles */
    size_t width, height;           /* 0: the scene's */
    int threads;                    /* 0: all cores */
    iso_progress_callback progress; /* or NULL */
    void *progress_user;
    const void *reserved[8];
} iso_plan_options;
/* Returns the defaults: an error of 1/255, 4 levels, bricks of 16 voxels, one view. */
iso_plan_options iso_plan_defaults(void);

/* The smallest model that a scene needs: bricks omitted, coarse or fine. Free it by iso_plan_result_destroy(). */
typedef struct iso_plan_result {
    size_t brick_count, drawn_count;
    double bytes, full_bytes; /* of the drawn bricks, and of all at level 0 */
    double predicted_rmse;
    double measured_rmse; /* of the view in which it is the largest */
    double blank_rmse;    /* of an empty picture; if it is near the measured one, the plan shows almost nothing */
    char *json;           /* a plan file (doc/reference/files-chart.md), for iso_export_options and `isoshade export` */
    const void *reserved[8];
} iso_plan_result;
/* Plans for a scene, and verifies the plan by rendering. ISO_E_USAGE: a label map, a pyramid that was built for a
 * scene; ISO_E_RANGE: no plan is within the error or the memory, an option is outside its limits; ISO_E_MEMORY;
 * ISO_E_CANCELED. */
iso_status iso_plan(const iso_pyramid *pyramid, const iso_scene *scene, const iso_plan_options *options,
                    iso_plan_result *plan, iso_error *err);
void iso_plan_result_destroy(iso_plan_result *plan); /* accepts empty and NULL */

/* ---- export ------------------------------------------------------------------------------------------------------ */

typedef struct iso_export_options {
    size_t level;                   /* first level */
    size_t level_count;             /* number of levels in one file; for "vdb", "nanovdb" and "blender" */
    size_t width, height;           /* of the scene's images; 0: the scene's */
    const iso_tf *tf;               /* NULL: the scene's */
    bool half_float;                /* for "vdb": smaller and less exact */
    int threads;                    /* 0: all cores */
    iso_progress_callback progress; /* or NULL */
    void *progress_user;
    bool adapt;                     /* True to adapt the TF to each level; for targets with a scene */
    bool extinction_scale;          /* True to scale the extinction of coarse voxels, for their opacity; needs a scene */
    const iso_region *region;       /* or NULL; for "blender" and "povray" */
    const char *plan;               /* text of a plan made with the same TF; or NULL; for "vdb", "nanovdb", "povray" ... */
    const void *reserved[5];
} iso_export_options;
/* Returns the defaults: only level 0. */
iso_export_options iso_export_defaults(void);

/* Exports levels. Target "vdb": a file NAME.vdb with the grids "density" and "gradient"; scene may be NULL. "nanovdb":
 * NAME.nvdb, the same grids. "blender": NAME.blend, and its grids next to it; needs Blender. "povray": a folder with
 * scene and densities. "pbrt": a folder with a scene whose medium is baked for that scene. ISO_E_USAGE: an
 * unknown target, a missing scene, an option that the target does not have; ISO_E_RANGE; ISO_E_IO; ISO_E_MISSING;
 * ISO_E_PROGRAM. */
iso_status iso_export(const iso_pyramid *pyramid, const iso_scene *scene, const char *target, const char *path,
                      const iso_export_options *options, iso_error *err);
/* Returns the file of a target that writes one ("vdb", "nanovdb") as bytes, to be freed by iso_free(). */
iso_status iso_export_bytes(const iso_pyramid *pyramid, const iso_scene *scene, const char *target,
                            const iso_export_options *options, unsigned char **bytes, size_t *size, iso_error *err);

/* ---- viewer ------------------------------------------------------------------------------------------------------ */

typedef struct iso_page_options {
    const char *title;              /* NULL: "volume" */
    size_t most_voxels;             /* of the finest level of the page; 0: 32 million */
    int threads;                    /* 0: all cores */
    bool compact;                   /* true: starts with the picture alone, for frames in other pages */
    iso_progress_callback progress; /* or NULL */
    void *progress_user;
    const void *reserved[8];
} iso_page_options;
/* Makes an interactive page: one HTML text, to be freed by iso_free(). scene NULL: automatic. ISO_E_USAGE: a direction
 * code that textures cannot filter; ISO_E_IO: no folder for temporary files; ISO_E_MEMORY; ISO_E_CANCELED. */
iso_status iso_view_page(const iso_pyramid *pyramid, const iso_scene *scene, const iso_page_options *options,
                         char **html, iso_error *err);

/* ---- validation -------------------------------------------------------------------------------------------------- */

/* A picture that a renderer of the caller is to draw. All pointers are valid during the call. */
typedef struct iso_frame_request {
    size_t width, height;
    double step_mm;          /* along rays: samples in the middle of [k step, (k + 1) step] from the eye */
    iso_grid grid;           /* of the level */
    const float *values;     /* one per voxel */
    const float *directions; /* 3 per voxel; NULL: no light is visible */
    const char *json;        /* camera, lights, shading, TF ...: request.json (doc/reference/files-request.md) */
    const char *scene;       /* its name: "calibration-slab" ... */
    size_t level;
    const void *reserved[8];
} iso_frame_request;

/* Draws a request: 4 floats per pixel, linear light over the background, color multiplied by alpha, top row first.
 * Returns whether it was drawn; after false validation ends with ISO_E_PROGRAM. One call at a time. */
typedef bool (*iso_render_callback)(void *user, const iso_frame_request *request, float *rgba);

/* A renderer of the caller. */
typedef struct iso_own_renderer {
    const char *name; /* letters, digits and "-" */
    iso_render_callback render;
    void *user;
} iso_own_renderer;

typedef struct iso_validate_options {
    const iso_scene *scene;            /* NULL: automatic */
    const iso_own_renderer *renderers; /* of the caller */
    size_t renderer_count;
    const char *with;                  /* others by name: "gl,povray"; NULL: none */
    const char *folder;                /* for the report, index.html and its files; NULL: the page alone is returned */
    size_t levels;                     /* 0: 4, or 3 if quick */
    size_t width, height;              /* 0: the scene's */
    bool quick;                        /* True for smaller images and fewer views; the default */
    iso_progress_callback progress;    /* or NULL */
    void *progress_user;
    const void *reserved[8];
} iso_validate_options;
/* Returns the defaults: quick, one level, the reference alone. */
iso_validate_options iso_validate_defaults(void);

/* Result of a validation; free it by iso_validation_result_destroy(). */
typedef struct iso_validation_result {
    bool agrees;        /* True if each renderer passed its calibrations and each comparison */
    char summary[1024]; /* one line: the result, or the first failure */
    char *json, *html;  /* report.json and index.html */
    const void *reserved[8];
} iso_validation_result;
/* Validates renderers with a volume, and its levels. Runs the program `isoshade`. ISO_E_MISSING: it is not installed;
 * ISO_E_USAGE: an unknown renderer; ISO_E_PROGRAM: a renderer failed; ISO_E_RANGE; ISO_E_IO; ISO_E_CANCELED. */
iso_status iso_validate(const iso_volume *volume, const iso_validate_options *options, iso_validation_result *verdict,
                        iso_error *err);
void iso_validation_result_destroy(iso_validation_result *verdict);

#ifdef __cplusplus
}
#endif

#endif
