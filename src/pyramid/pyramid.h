/* SPDX-License-Identifier: MIT */
/* pyramid.h - a volume at several levels, with directions from the finest.
 *
 *     NAME.iso/pyramid.json        builder, options, geometry, checksums
 *              level_K.nrrd        scalar
 *              level_K_dir.nrrd    3 bytes per voxel, the encoded directions
 *              level_K_grad.nrrd   3 floats per voxel (keep_float)
 *              level_K_mag.nrrd    1 float per voxel, gradient magnitude per mm (keep_magnitude)
 *              level_K_scale.nrrd  1 byte per voxel, extinction scale (of some levels for a scene)
 *
 * Level 0's scalar keeps the type of the input if that has 8 or 16 bits or is float; coarser levels are float. Voxel i
 * of level k covers the fine voxels [i 2^k, (i+1) 2^k); if a size is odd, the last plane of each level is repeated. A
 * level can thus be made from the files of the next finer one. Direction d of a level: unit at level 0 (zero where the
 * gradient is zero); at coarse levels by the filter:
 *   moments  N = sum m^2 d, S = sum m^2 over the own children, carried in float
 *            from level to level; stored d = (N/|N|) L^2, L = |N| / S in [0,1].
 *   eq1      [diaz-garcia-2017] Eq. 1 as written, iterated from G0: Gaussian times
 *            magnitude, radius and sigma by option; stored unit.
 *   naive    the mean of the children's gradient vectors; stored unit.
 *   tensor   T = sum g g^T, and N; the main axis of T, on N's side, times L:
 *            opposite gradients agree on an axis although their mean vanishes.
 *   least-squares  the directions whose trilinear lookup is nearest to level 0's, weighted by m^2: some rounds towards
 *            them (doc/method/least-squares-levels.md), no longer than 1; levels above the fourth as moments.
 *   auto     each level gets moments or tensor (agreement.h).
 * magnitude: |gradient| at level 0; above, the root mean square (moments, tensor) or the length of the filtered
 * gradient (eq1, naive). scalar: mean of the 2x2x2 children, a Gaussian, or the least-squares level: of all levels of
 * its size the one whose trilinear lookup is nearest to level 0 (doc/method/least-squares-levels.md); its values can
 * lie outside level 0's range. Damped: from the means ISO_DAMPED_PART of the way to it, where at level 1 it is first
 * held to the range of each voxel's own fine voxels. */
/* Label maps: the majority label of the 2x2x2 children; ties go to the largest label. */
#pragma once

#include <math.h>

#include <jansson.h>

#include "base/names.h"
#include "base/progress.h"
#include "encode/code.h"
#include "palette/palette.h"
#include "gradient/gradient.h"
#include "volume/volume.h"

typedef enum iso_scalar_filter {
    ISO_SCALAR_MEAN,
    ISO_SCALAR_GAUSS,
    ISO_SCALAR_LEAST_SQUARES,
    ISO_SCALAR_DAMPED,
    ISO_SCALAR_MAJORITY, /* of labels, whose levels are looked up without interpolation */
    ISO_SCALAR_COUNT
} iso_scalar_filter;
/* More is nearer to level 0 in most scenes, and farther in those where least squares ring (doc/results). */
#define ISO_DAMPED_PART 0.6f

typedef enum iso_direction_filter {
    ISO_DIRECTION_MOMENTS,
    ISO_DIRECTION_EQ1,
    ISO_DIRECTION_NAIVE,
    ISO_DIRECTION_TENSOR,
    ISO_DIRECTION_LEAST_SQUARES,
    ISO_DIRECTION_COUNT,
    ISO_DIRECTION_AUTO =
        ISO_DIRECTION_COUNT /* chooses one of the filters above for each coarse level, from measured gradients */
} iso_direction_filter;

/* Choice of ISO_DIRECTION_AUTO for each coarse level, and the figures that decided it (agreement.h). */
typedef struct iso_direction_choice {
    bool is_made;
    iso_direction_filter filter[32];
    double mean_agreement[32], axis_agreement[32];
} iso_direction_choice;

typedef struct iso_pyramid_options {
    size_t level_count; /* with level 0; fewer if a level would be a single voxel */
    iso_scalar_filter scalar_filter;
    iso_direction_filter direction_filter;
    iso_gradient_options gradient;
    iso_code code;
    double gauss_sigma_voxels; /* of the Gaussian filters, in voxels of the finer level */
    size_t gauss_radius;       /* taps along an axis: 2 * radius */
    size_t eq1_exponent;       /* of the magnitude in Eq. 1's weights: 1 in the paper; 0: a plain Gaussian */
    bool keep_float;
    bool keep_magnitude;
    int threads;
    double value_range[2];       /* of all frames of a series: the range that a fitted TF follows in each; equal: use
                                  * level 0's own */
    iso_direction_choice choice; /* with ISO_DIRECTION_AUTO; made by the build */
} iso_pyramid_options;
iso_pyramid_options iso_pyramid_defaults(void);

/* Checks the options. ISO_E_RANGE with the value and its limits. */
iso_status iso_pyramid_check_options(const iso_pyramid_options *opt, iso_error *err);

/* Returns ISO_E_RANGE if sums of values from lo to hi could overflow floats in coarse levels. */
iso_status iso_pyramid_check_values(double lo, double hi, const char *source, iso_error *err);
/* Gets the largest difference that the samples can have: from the type if that is narrow, otherwise measured.
 * ISO_E_RANGE: values that are not finite, or too large. source: for messages. */
iso_status iso_pyramid_sample_range(const iso_volume *v, const char *source, double *range, iso_error *err);

extern const iso_names iso_scalar_filter_names, iso_direction_filter_names;
const char *iso_scalar_filter_name(iso_scalar_filter f);
static inline bool iso_scalar_filter_is_spline(iso_scalar_filter f)
{
    return f == ISO_SCALAR_LEAST_SQUARES || f == ISO_SCALAR_DAMPED;
}
const char *iso_direction_filter_name(iso_direction_filter f);
/* Returns the filter of a coarse level: by the options, or chosen. */
iso_direction_filter iso_direction_filter_of(const iso_pyramid_options *opt, size_t level);
iso_status iso_scalar_filter_from_name(const char *name, iso_scalar_filter *f, iso_error *err);
iso_status iso_direction_filter_from_name(const char *name, iso_direction_filter *f, iso_error *err);

/* Bytes of iso_level.scale. */
enum {
    ISO_EXTINCTION_SCALE_ONE = 168,       /* the byte of q = 1 */
    ISO_EXTINCTION_SCALE_PER_OCTAVE = 28, /* bytes from q to 2 q */
    ISO_EXTINCTION_SCALE_LAST = 252       /* the largest byte */
};

/* Returns log2 q of a byte, or of a value between bytes. */
static inline double iso_extinction_scale_log2(double byte)
{
    return (byte - ISO_EXTINCTION_SCALE_ONE) / ISO_EXTINCTION_SCALE_PER_OCTAVE;
}
static inline double iso_extinction_scale_of(double byte)
{
    return exp2(iso_extinction_scale_log2(byte));
}

/* Returns the byte nearest to log2 q. */
static inline uint8_t iso_extinction_scale_byte(double octaves)
{
    const double byte = round(ISO_EXTINCTION_SCALE_ONE + ISO_EXTINCTION_SCALE_PER_OCTAVE * octaves);
    return (uint8_t)fmin(fmax(byte, 0), ISO_EXTINCTION_SCALE_LAST);
}

typedef struct iso_level {
    iso_geometry geometry;
    iso_type stored_type;      /* of the scalar on disk */
    float *scalar;             /* NULL in an outline, and if `samples` has it */
    const iso_volume *samples; /* borrowed: the volume that holds the level's scalars (narrow.h); NULL if the level
                                * holds them */
    iso_gradient_method estimator; /* of directions that are made from `samples` */
    uint8_t *codes;            /* 3 bytes per voxel; NULL in an outline, and if they are made from `samples` */
    float *directions;         /* 3 floats per voxel before encoding, or NULL */
    float *magnitude;          /* 1 float per voxel, or NULL */
    uint8_t *scale;            /* of the extinction (fit/extinction_scale.h), 1 byte per voxel, of a level that was made
                                * for a scene, or of one with has_no_data (data_share.c); or NULL */
    double min, max;           /* of the scalar */
    bool labels;               /* looked up without interpolation: the value of the voxel that holds a point */
    const json_t *segments;    /* borrowed: the pyramid's */
    bool made_for_scene;       /* True if the scalar is not from the pyramid's filter; iso_pyramid.made_for describes
                                * it */
    bool is_optimized;         /* True if the directions are not either: found for one scene (plan/optimize.h). Exports
                                * then note ISO_OPTIMIZED_VALUES */
    double build_seconds;      /* of an optimized level; or 0 */
    bool edits_are_scaled;     /* True if it looks best adapted and with a new extinction scale under an edited TF */
    /* For renders from a palette: borrowed, neither stored nor freed here; NULL, or one index per voxel. */
    const iso_palette *palette;
    const uint16_t *palette_index;
} iso_level;

#define ISO_OPTIMIZED_VALUES "optimized for pictures of one scene, no data"

/* Unit of the lengths in a volume's file. All lengths in the pyramid are in mm. */
typedef struct iso_pyramid_unit {
    char name[16]; /* "" if the file names none */
    double mm;
} iso_pyramid_unit;

typedef struct iso_pyramid {
    iso_pyramid_options options;
    char *source; /* source of the volume, such as its file */
    iso_pyramid_unit unit;
    char built_by[64]; /* "isoshade 0.2.0" */
    size_t level_count;
    iso_level *levels;
    iso_volume *volume; /* owned: level 0's samples, of iso_pyramid_begin() (narrow.h); or NULL */
    json_t *segments;  /* owned: names and colors of a label map's labels (volume/segments.h); or NULL */
    json_t *made_for;  /* owned: the scene that levels were made for, and how (doc/reference/files-pyramid.md); or NULL */
} iso_pyramid;

/* Returns the unit in a volume's notes. */
iso_pyramid_unit iso_pyramid_unit_of(const iso_volume_notes *notes);

/* Builds all levels. ISO_E_RANGE: options outside their limits, non-finite voxels. */
iso_status iso_pyramid_build(const iso_volume *v, const char *source, const iso_pyramid_options *opt, iso_pyramid *out,
                             const iso_progress *progress, iso_error *err);
void iso_pyramid_destroy(iso_pyramid *p);

/* Returns an end of the range that a fitted TF follows: of the series, or of level 0. */
double iso_pyramid_lo(const iso_pyramid *p);
double iso_pyramid_hi(const iso_pyramid *p);

/* Returns the finest level with samples in memory; level 0 if none has. */
const iso_level *iso_pyramid_finest(const iso_pyramid *p);
/* Returns ISO_E_RANGE unless the pyramid has the level. path: starts the message, or NULL. */
iso_status iso_pyramid_check_level(const iso_pyramid *p, const char *path, size_t level, iso_error *err);

/* iso_pyramid_save() writes a directory NAME.iso, complete or absent: in the library's header. */
/* Loads all files and checks the sizes and the checksums that pyramid.json states. */
iso_status iso_pyramid_load(const char *dir, iso_pyramid *out, iso_error *err);
/* Loads the files of the levels from `first` on; of the others only the outline. */
iso_status iso_pyramid_load_from(const char *dir, size_t first, iso_pyramid *out, iso_error *err);
/* Loads pyramid.json without samples: levels' scalar, codes and the rest are NULL. */
iso_status iso_pyramid_load_outline(const char *dir, iso_pyramid *out, iso_error *err);
/* Loads the outline and the levels' scalars, which transfer functions need. */
iso_status iso_pyramid_load_scalars(const char *dir, iso_pyramid *out, iso_error *err);
/* Loads level 0 as iso_pyramid_begin() has it (narrow.h): its samples alone, in their own type, and outlines of coarse
 * levels. All of a pyramid with labels or with voxels without data. */
iso_status iso_pyramid_load_begun(const char *dir, iso_pyramid *out, iso_error *err);
/* True if path is a directory with a pyramid.json. */
bool iso_pyramid_is_one(const char *path);
