/* SPDX-License-Identifier: MIT */
/* palette.h - directions in one byte (or 9 or 10 bits): an index into a table of
 * directions that is fitted to the data. The paper's method is one of src/lab/rivals.
 *
 * Entry 0 of a palette is the zero vector (no direction, or an unreliable one); the
 * others are unit directions. A voxel stores the index of the entry nearest to its
 * direction; the length is not stored.
 *
 * Papers: [bremer-2001]; [arthur-2007] (k-means++); [hartigan-1975] (exchange).
 *
 *   palette_set.c       sets of directions to fit a palette to
 *   palette_sample.c    streaming of a volume into such a set, with weights
 *   palette_fit.c       k-means++ with exchange and swaps; the Fibonacci lattice
 *   palette_assign.c    the exact nearest entry by a lookup grid
 *   palette.c           entries, errors, shading tables
 *   palette_export.c    CSV, and tables for POV-Ray and Blender */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/linalg.h"
#include "base/names.h"
#include "base/progress.h"
#include "base/status.h"
#include "gradient/gradient.h"
#include "volume/stream.h"

/* ---- direction sets --------------------------------------------------------
 * Bundles of directions: each has a unit direction, the sum of its members'
 * weights (multiplicity times importance) and the length of their weighted
 * mean, 1 if all members are equal. A bundle in the cell of entry n costs
 *     weight (1 - length (direction . n)),
 * which is exactly the members' sum of w (1 - cos). */
typedef struct iso_direction_set {
    size_t count;
    float *xyz;              /* 3 per bundle, unit */
    float *length;           /* in (0, 1] */
    double *weight;          /* > 0 */
    double undefined_weight; /* of members without a direction: they get entry 0 at no cost */
} iso_direction_set;

/* Creates a set from count vectors of any length; weights NULL: 1 each. Equal directions become one bundle. Vectors
 * that are zero, NaN or infinite are undefined; those with weight zero are left out. ISO_E_RANGE: a weight is negative
 * or not finite; ISO_E_MEMORY. */
iso_status iso_direction_set_create(iso_direction_set *set, const float *vectors, const double *weights, size_t count,
                                    iso_error *err);
void iso_direction_set_destroy(iso_direction_set *set); /* accepts empty and NULL */

/* Creates a set with fewer bundles: members in the same one of 6 cells^2 cells of a cube's surface become one. */
iso_status iso_direction_set_coarsen(const iso_direction_set *set, int cells, iso_direction_set *out, iso_error *err);

/* Pool: a field streamed into a bounded number of bundles. Directions are binned in 6 G^2
 * cells of a cube's surface, and each bin keeps the exact sum of its weighted members.
 * Every member counts, without random choice. Sums are in fixed point, so the result does
 * not depend on the order of the slabs or the number of threads. */
typedef struct iso_direction_pool iso_direction_pool;
#define ISO_POOL_CELLS 128 /* G: 98304 bins of about 0.7 degrees */
iso_status iso_direction_pool_create(iso_direction_pool **pool, int threads, iso_error *err);
void iso_direction_pool_destroy(iso_direction_pool *pool);
/* Adds count vectors of 3 floats; weights in [0, 1] (others are clamped, NaN is 0), or NULL for 1 each. */
void iso_direction_pool_add(iso_direction_pool *pool, const float *restrict vectors, const float *restrict weights,
                            size_t count);
iso_status iso_direction_pool_finish(const iso_direction_pool *pool, iso_direction_set *set, iso_error *err);

typedef struct iso_palette_weighting {
    bool by_magnitude;     /* True to weight a voxel by its gradient's magnitude; False: 1 */
    double value_span;     /* of the volume, for by_magnitude: the steepest possible gradient has weight 1 */
    const float *by_value; /* second factor: a table over the scalar, such as the TF's opacity; or NULL */
    size_t by_value_count; /* at least 2; linear between entries, the first at by_value_lo, the last at by_value_hi */
    double by_value_lo, by_value_hi;
} iso_palette_weighting;

/* Adds the gradient of each voxel to the pool. A source is read in slabs, so that memory does not grow with the volume;
 * the result is the same. weighting may be NULL: 1 for every voxel. */
iso_status iso_palette_sample_volume(iso_direction_pool *pool, const iso_volume *v,
                                     const iso_gradient_options *gradient, const iso_palette_weighting *weighting,
                                     const iso_progress *progress, iso_error *err);
iso_status iso_palette_sample_source(iso_direction_pool *pool, iso_volume_source *source,
                                     const iso_gradient_options *gradient, const iso_palette_weighting *weighting,
                                     const iso_progress *progress, iso_error *err);
/* Does the same from given directions and scalars, such as a level of a pyramid; magnitudes may be NULL: 1. */
iso_status iso_palette_sample_field(iso_direction_pool *pool, const float *vectors, const float *scalars,
                                    const float *magnitudes, size_t count, const iso_palette_weighting *weighting,
                                    iso_error *err);

/* ---- palettes -------------------------------------------------------------- */
#define ISO_PALETTE_MAX 32766 /* directions: 15 bits with the zero vector */

typedef struct iso_palette {
    size_t count; /* entries, including the zero vector */
    float *xyz;   /* 3 per entry; entry 0 is (0, 0, 0), the others are unit */
} iso_palette;

iso_status iso_palette_create(iso_palette *palette, size_t direction_count, iso_error *err);
void iso_palette_destroy(iso_palette *palette);
/* Sets an entry to the direction of a vector. */
void iso_palette_put(iso_palette *palette, size_t entry, iso_vec3 direction);
/* Returns the number of bits of an index. */
int iso_palette_bits(const iso_palette *palette);

/* enum, name, help */
#define ISO_PALETTE_METHOD_LIST(X) \
    X(ISO_PALETTE_KMEANS, "kmeans", "k-means++, Lloyd, exchange of single members, swaps of useless entries") \
    X(ISO_PALETTE_FIBONACCI, "fibonacci", "the spherical Fibonacci lattice")

typedef enum iso_palette_method {
#define ISO_PALETTE_ENUM(name, text, help) name,
    ISO_PALETTE_METHOD_LIST(ISO_PALETTE_ENUM)
#undef ISO_PALETTE_ENUM
        ISO_PALETTE_METHOD_COUNT
} iso_palette_method;

const char *iso_palette_method_name(iso_palette_method method);
extern const iso_names iso_palette_method_names;
iso_status iso_palette_method_from_name(const char *name, iso_palette_method *method, iso_error *err);

typedef struct iso_palette_options {
    iso_palette_method method;
    size_t directions; /* entries without the zero vector; 254 leaves one code of a byte unused */
    uint64_t seed;
    size_t swap_trials; /* kmeans: swaps tried per entry, after those with a certain gain */
} iso_palette_options;
iso_palette_options iso_palette_defaults(void);

/* Fits a palette. kmeans: with fewer distinct directions than entries each direction gets an entry; without directions
 * the palette is the zero vector alone. ISO_E_RANGE: the number of entries; ISO_E_MEMORY. */
iso_status iso_palette_fit(const iso_direction_set *set, const iso_palette_options *opt, iso_palette *palette,
                           const iso_progress *progress, iso_error *err);

/* ---- nearest entry ----------------------------------------------------------
 * A grid on the cube's surface lists, for each cell, all entries that are nearest for
 * some direction inside it. So the answer is exact: the entry with the largest dot
 * product in float, of equal ones the lowest. */
typedef struct iso_palette_lookup iso_palette_lookup;
iso_status iso_palette_lookup_create(const iso_palette *palette, iso_palette_lookup **lookup, iso_error *err);
void iso_palette_lookup_destroy(iso_palette_lookup *lookup);
size_t iso_palette_lookup_bytes(const iso_palette_lookup *lookup);
/* Assigns count vectors of any length; zero, NaN and infinite ones get entry 0. */
void iso_palette_assign(const iso_palette_lookup *lookup, const float *restrict vectors, uint16_t *restrict index,
                        size_t count);
/* Does the same in bytes, for palettes of at most 256 entries. */
void iso_palette_assign8(const iso_palette_lookup *lookup, const float *restrict vectors, uint8_t *restrict index,
                         size_t count);
/* Converts indices to directions. Indices beyond the palette give the zero vector. */
void iso_palette_decode(const iso_palette *palette, const uint16_t *restrict index, float *restrict vectors,
                        size_t count);

/* ---- errors and use ---------------------------------------------------------- */
typedef struct iso_palette_error {
    double norm1;         /* sum of w (1 - cos) */
    double norm2;         /* sqrt(sum of w |g - n|^2) = sqrt(2 norm1), by the paper's Eq. 1 */
    double norm2_printed; /* sqrt(norm1 / 2), as printed in the paper's Table 1 */
    double rms_deg;       /* of the angle, from the mean of 1 - cos */
    double max_deg;       /* over the bundles */
} iso_palette_error;
/* Measures the error with each bundle at its nearest entry; 0 for an empty set. */
iso_status iso_palette_measure(const iso_direction_set *set, const iso_palette *palette, iso_palette_error *error,
                               iso_error *err);

/* Writes files, complete or not at all; `note` becomes a comment.
 *   CSV     index,x,y,z with a header line
 *   POV     #declare NAME_Count and NAME = array[count] { <x, y, z>, ... }
 *   Python  NAME = [(x, y, z), ...], and a function that creates a float image of count x 1 in Blender */
iso_status iso_palette_save_csv(const iso_palette *palette, const char *path, iso_error *err);
iso_status iso_palette_load_csv(const char *path, iso_palette *palette, iso_error *err);
iso_status iso_palette_save_povray(const iso_palette *palette, const char *path, const char *note, iso_error *err);
iso_status iso_palette_save_python(const iso_palette *palette, const char *path, const char *note, iso_error *err);

typedef struct iso_palette_light {
    double toward[3]; /* unit vector towards the light */
    double intensity;
} iso_palette_light;
typedef struct iso_palette_shading {
    double ambient, diffuse, specular, power;
    const iso_palette_light *lights;
    size_t light_count;
    double toward_viewer[3]; /* one direction for all entries: a viewer far away */
} iso_palette_shading;
/* Computes a shading table, as in the papers: one value per entry,
 *     ambient + sum of intensity (diffuse |n.l| + specular |n.h|^power).
 * A moved light needs `count` new values instead of one per voxel. Entry 0 is ambient. */
void iso_palette_shade(const iso_palette *palette, const iso_palette_shading *s, float *restrict shade);
