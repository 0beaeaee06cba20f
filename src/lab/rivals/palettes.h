/* SPDX-License-Identifier: MIT */
/* palettes.h - the palettes of [bremer-2001] and their rivals; palette/palette.h has the product's.
 *
 * Papers: [bremer-2001] (annealing of a tessellation); [van-gelder-1996] (regular subdivision); [arthur-2007]
 * (k-means++).
 *
 *   palettes.c          the choice of a method; k-means++; the paper's ellipsoid
 *   palette_tables.c    regular subdivision
 *   palette_anneal.c    the paper's method, on the triangulation of palette_mesh.c */
#pragma once

#include "palette/palette.h"

/* clang-format off */
/* enum, name; doc/results/palettes.md describes them */
#define ISO_PALETTE_RIVAL_LIST(X) \
    X(ISO_RIVAL_KMEANS, "kmeans") /* the product's */ \
    X(ISO_RIVAL_KMEANSPP, "kmeans++") /* greedy k-means++ and Lloyd */ \
    X(ISO_RIVAL_ANNEAL, "anneal") /* annealing of a tessellation [bremer-2001] */ \
    X(ISO_RIVAL_FACES, "faces") /* regular subdivision, triangle normals (60, 240, 960, 3840) */ \
    X(ISO_RIVAL_FIBONACCI, "fibonacci") /* the product's lattice */
/* clang-format on */

typedef enum iso_palette_rival {
#define ISO_RIVAL_ENUM(name, text) name,
    ISO_PALETTE_RIVAL_LIST(ISO_RIVAL_ENUM)
#undef ISO_RIVAL_ENUM
        ISO_RIVAL_COUNT
} iso_palette_rival;
const char *iso_palette_rival_name(iso_palette_rival method);

/* Parameters of the paper, with its names. */
typedef struct iso_anneal_options {
    double start_prob; /* probability, at first, to accept a move that costs the mean change */
    double temp_fac;   /* cooling after each cycle */
    size_t cycles, steps;
    double move_deg[2]; /* least and largest angle by which a vertex moves */
} iso_anneal_options;

typedef struct iso_rival_options {
    iso_palette_rival method;
    iso_palette_options fit; /* entries, seed and swaps; its method is ignored */
    iso_anneal_options anneal;
} iso_rival_options;
iso_rival_options iso_rival_defaults(void);

/* Fits a palette. Fitted methods give each direction an entry if there are fewer than entries. Fixed tables and anneal
 * keep their structure for any data: faces use the largest level not above the number of entries, anneal
 * needs an even number. ISO_E_RANGE: options outside their limits; ISO_E_MEMORY. */
iso_status iso_rival_palette_fit(const iso_direction_set *set, const iso_rival_options *opt, iso_palette *palette,
                                 iso_error *err);

/* The tessellation of a palette by anneal; the normals of its triangles are the entries 1, 2, ... */
typedef struct iso_tessellation {
    size_t vertex_count, face_count;
    double *vertices;     /* 3 each, unit */
    uint32_t (*faces)[3]; /* counter-clockwise from outside */
    double start_temperature, end_temperature;
    size_t moves, refused, accepted; /* refused: would violate the triangulation's conditions */
    double assigned_norm1;           /* error minimized by annealing: each direction belongs to its triangle */
} iso_tessellation;
void iso_tessellation_destroy(iso_tessellation *t); /* accepts empty and NULL */

/* Fits by anneal. *tessellation is destroyed by the caller; NULL: not returned. */
iso_status iso_rival_palette_anneal(const iso_direction_set *set, const iso_rival_options *opt, iso_palette *palette,
                                    iso_tessellation *tessellation, iso_error *err);

/* Checks the options. ISO_E_RANGE: outside their limits. */
iso_status iso_rival_palette_check(const iso_rival_options *opt, iso_error *err);

/* Computes the paper's test set: gradients of x^2 + 15 y^2 + 15 z^2 at random points, in
 * the unit ball or on the ellipsoid (3 floats each, unit). */
void iso_ellipsoid_gradients(float *vectors, size_t count, bool on_surface, uint64_t seed);
