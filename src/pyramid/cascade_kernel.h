/* SPDX-License-Identifier: MIT */
/* cascade_kernel.h - what the two ways of filtering share; private to the cascade. */
#ifndef ISO_PYRAMID_CASCADE_KERNEL_H
#define ISO_PYRAMID_CASCADE_KERNEL_H

#include "pyramid/cascade.h"
#include "pyramid/filter_kernel.h"

enum { MAX_LEVELS = 32, CARRY_LEVEL = 4 };

/* One filtered quantity of the wide way: the scalar, or the direction's state. */
typedef struct wide_channel {
    bool is_scalar;
    size_t components, filtered; /* planes of a slot; the first of them are sums */
    iso_taps taps;
    size_t batch;              /* fine planes at a time */
    size_t slot_count;         /* coarse planes that these touch */
    float *slots[MAX_LEVELS];  /* [k]: of level k + 1, slot_count x components planes */
} wide_channel;

struct iso_cascade {
    iso_pyramid_options opt;
    int threads;
    float unscale;
    iso_gradient_matrix matrix; /* scaled */
    size_t level_count;
    size_t size[MAX_LEVELS][3];
    float lo[MAX_LEVELS], hi[MAX_LEVELS];
    /* The tile way. */
    size_t tile_top;     /* the highest level that is made depth first from level 0 */
    size_t state_count;  /* components of the state it carries; 0: directions go the wide way */
    bool scalar_means;   /* else scalars go the wide way */
    float *carry;        /* states and scalars of level tile_top, where there are levels above it */
    /* The wide way. */
    wide_channel wide[2];
    size_t wide_count;
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
/* Rows of level k have room for one float more. */
static inline size_t row_stride(const iso_cascade *c, size_t k)
{
    return (c->size[k][0] + 1 + 15) / 16 * 16;
}
/* What emit_directions and level 0 need. */
typedef struct emit_rows {
    float *d[3], *g[3], *interleaved, *magnitude, *row, *gradient;
    uint32_t *packed;
    uint8_t *bytes;
} emit_rows;
size_t iso_emit_rows_count(const iso_cascade *c);
emit_rows iso_take_emit_rows(const iso_cascade *c, scratch *s);

/* The gradients of a row of level 0, to rows->g. */
void iso_cascade_level0_gradients(const iso_cascade *c, const iso_planes *in, size_t y, size_t z, emit_rows *rows);
/* Stores the directions of the row's gradients. */
void iso_emit_level0(const iso_cascade *c, const iso_cascade_out *out, size_t y, size_t z, emit_rows *rows);
/* Stores a row of directions of a coarse level from its state. */
void iso_emit_coarse(const iso_cascade *c, const iso_cascade_out *out, size_t k, size_t y, size_t z, const float *state,
                 size_t stride, emit_rows *rows);

/* cascade_wide.c */
iso_status iso_cascade_wide_create(iso_cascade *c, iso_error *err);
void iso_cascade_wide_destroy(iso_cascade *c);
iso_status iso_cascade_wide_feed(iso_cascade *c, const iso_planes *in, size_t z0, size_t z1, const iso_cascade_out *out, iso_error *err);

#endif
