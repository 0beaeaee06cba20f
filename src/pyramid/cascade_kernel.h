/* SPDX-License-Identifier: MIT */
/* cascade_kernel.h - declarations shared by cascade.c (filters that read only the children), cascade_gauss.c (Gaussian
 * filters), cascade_spline.c (least squares) and cascade_weighted.c (least-squares directions); private to the four. */
#pragma once

#include "pyramid/agreement.h"
#include "pyramid/cascade.h"
#include "pyramid/filter_kernel.h"

enum { MAX_LEVELS = 32, CARRY_LEVEL = 4 };

/* One quantity that has a Gaussian filter: the scalar, or the direction's state (filter_kernel.h). */
typedef struct gauss_channel {
    bool is_scalar;
    size_t components, filtered; /* planes of a slot; the first of them are sums */
    iso_taps taps;
    size_t batch;             /* fine planes at a time */
    size_t slot_count;        /* coarse planes that these touch */
    float *slots[MAX_LEVELS]; /* [k]: of level k + 1, slot_count x components planes */
} gauss_channel;

/* A least-squares level (cascade_spline.c). */
typedef struct spline_level spline_level;
/* Least-squares directions of a level (cascade_weighted.c). */
typedef struct weighted_level weighted_level;

struct iso_cascade {
    iso_pyramid_options opt;
    int threads;
    float unscale;
    iso_gradient_matrix matrix; /* scaled */
    size_t level_count;
    size_t size[MAX_LEVELS][3];
    float lo[MAX_LEVELS], hi[MAX_LEVELS];
    /* Filters that read only the children, tile by tile. */
    size_t tile_top;    /* the highest level that is made depth first from level 0 */
    size_t state_count; /* components of the state it carries; 0: directions have a Gaussian filter */
    bool scalar_means;  /* True if scalars are means or majorities; otherwise they have a filter of their own */
    bool majority;      /* of labels */
    bool are_apart;     /* True if the four rows of a mean are kept, instead of their sums: of labels, and of voxels of
                         * which some have no data */
    float *carry;       /* states and scalars of level tile_top, if there are levels above it */
    bool only_sums_up;  /* nothing is chosen yet: the levels' agreement is measured, nothing is stored */
    iso_agreement agreement[MAX_LEVELS];
    /* Gaussian filters, plane by plane (cascade_gauss.c). */
    gauss_channel gauss[2];
    size_t gauss_count;
    spline_level *spline; /* [k] of level k >= 1; NULL: scalars have another filter */
    weighted_level *weighted; /* [k] of level k >= 1 up to tile_top; NULL: directions have another filter */
};

/* Rows of one thread: floats of scratch, cut up by take(). */
typedef struct scratch {
    float *at;
} scratch;
static inline float *take(scratch *s, size_t count)
{
    float *piece = s->at;
    s->at += (count + 15) / 16 * 16;
    return piece;
}
/* Returns the floats from one row of level k to the next: one more than the row has, rounded up to 16. */
static inline size_t row_stride(const iso_cascade *c, size_t k)
{
    return (c->size[k][0] + 1 + 15) / 16 * 16;
}
/* Scratch rows for storing directions and for level 0. */
typedef struct emit_rows {
    float *d[3], *g[3], *interleaved, *magnitude, *row, *gradient;
    uint32_t *packed;
    uint8_t *bytes;
} emit_rows;
size_t iso_emit_rows_count(const iso_cascade *c);
emit_rows iso_take_emit_rows(const iso_cascade *c, scratch *s);

/* Computes the gradients of a row of level 0, to rows->g. */
void iso_cascade_level0_gradients(const iso_cascade *c, const iso_planes *in, size_t y, size_t z, emit_rows *rows);
/* Encodes n directions of rows->d to rows->bytes. True if rows->interleaved has the directions, too. */
bool iso_emit_codes(iso_code code, size_t n, emit_rows *rows);
/* Stores the directions of the row's gradients. */
void iso_emit_level0(const iso_cascade *c, const iso_cascade_out *out, size_t y, size_t z, emit_rows *rows);
/* Stores a row of directions of a coarse level from its state. */
void iso_emit_coarse(const iso_cascade *c, const iso_cascade_out *out, size_t k, size_t y, size_t z,
                     iso_state_row state, emit_rows *rows);

/* Stores the row of directions rows->d of a coarse level, and no magnitude. */
void iso_emit_directions(const iso_cascade *c, const iso_cascade_out *out, size_t k, size_t y, size_t z,
                         emit_rows *rows);

/* cascade_gauss.c */
iso_status iso_cascade_gauss_create(iso_cascade *c, iso_error *err);
void iso_cascade_gauss_destroy(iso_cascade *c);
iso_status iso_cascade_gauss_feed(iso_cascade *c, const iso_planes *in, size_t z0, size_t z1,
                                  const iso_cascade_out *out, iso_error *err);
/* Returns the first plane of level 0 that planes incomplete after z planes depend on, through the Gaussian filters. */
size_t iso_cascade_gauss_from(const iso_cascade *c, size_t z);

/* cascade_spline.c. Only create, floats, cells_floats and destroy may be called if c->spline is NULL. */
iso_status iso_cascade_spline_create(iso_cascade *c, iso_error *err);
void iso_cascade_spline_destroy(iso_cascade *c);
size_t iso_cascade_spline_floats(const iso_cascade *c);
/* Returns the floats at the end of a plane of the carry that this filter uses (cascade_spline_top.c). */
size_t iso_cascade_cells_floats(const iso_cascade *c);
/* Returns how many planes of a level are complete after feeding up to z, and how many fewer they may be than without
 * this filter. */
size_t iso_cascade_spline_complete(const iso_cascade *c, size_t level, size_t z);
size_t iso_cascade_spline_lag(void);
/* Returns the first plane of level 0 that planes of the level from `complete` on depend on. */
size_t iso_cascade_spline_from(const iso_cascade *c, size_t level, size_t complete);
iso_status iso_cascade_spline_feed(iso_cascade *c, const iso_planes *in, size_t z0, size_t z1,
                                   const iso_cascade_out *out, iso_error *err);

/* cascade_weighted.c: functions as in cascade_spline.c. Its levels have moments until they are made. */
iso_status iso_cascade_weighted_create(iso_cascade *c, iso_error *err);
void iso_cascade_weighted_destroy(iso_cascade *c);
size_t iso_cascade_weighted_floats(const iso_cascade *c);
size_t iso_cascade_weighted_complete(const iso_cascade *c, size_t level, size_t z);
size_t iso_cascade_weighted_lag(void);
size_t iso_cascade_weighted_from(const iso_cascade *c, size_t level, size_t complete);
iso_status iso_cascade_weighted_feed(iso_cascade *c, const iso_planes *in, size_t z0, size_t z1,
                                     const iso_cascade_out *out, iso_error *err);
