/* SPDX-License-Identifier: MIT */
/* cascade_spline.h - what cascade_spline.c (levels that are made while level 0 is fed) and cascade_spline_top.c (those
 * above the cascade's carry, made at the end) share; private to the two. */
#pragma once

#include <stdbool.h>

#include "base/parallel.h"
#include "pyramid/cascade_kernel.h"
#include "pyramid/spline_kernel.h"

enum { SPLINE_BLOCK = 8, SPLINE_APRON = 12, SPLINE_WINDOW = SPLINE_BLOCK + 2 * SPLINE_APRON };
/* Fine planes between two meetings of the threads, and fine rows of a thread's task. */
enum { SPLINE_BATCH = 32, SPLINE_ROWS = 32 };

struct spline_level {
    iso_spline_axis axis[3];
    iso_spline_row *solve[2]; /* along x and y */
    iso_spline_row *solve_z;  /* SPLINE_WINDOW of each block */
    size_t slot_count;        /* coarse planes that are kept: plane p in slot p % slot_count */
    float *slots;
    size_t tasks; /* of coarse rows; 0: made at the end, from the carry */
    float *own;   /* cascade_own.c: of damped levels; or NULL */
};

/* Working state of one call of iso_cascade_spline_feed. */
typedef struct spline_run {
    iso_cascade *c;
    const iso_planes *in;
    const iso_cascade_out *out;
    float *memory;
    size_t per_thread;
} spline_run;

static inline size_t spline_plane_floats(const spline_level *s)
{
    return s->axis[0].coarse * s->axis[1].coarse;
}

static inline float *spline_slot(const spline_level *s, size_t plane)
{
    return s->slots + plane % s->slot_count * spline_plane_floats(s);
}

static inline float *spline_scratch(const spline_run *r)
{
    return r->memory + (size_t)iso_thread_index() * r->per_thread;
}

/* cascade_own.c: of damped levels. Fine rows of plane z, added to the own voxels of coarse rows j0 .. j1 - 1. */
typedef struct own_rows {
    size_t z, j0, j1, row;
    size_t count;   /* at level 1: fine rows that are kept, 1 or 2 */
    float *sums[2]; /* ... and if so, these; at coarser levels a sum and its reduced row */
} own_rows;
bool iso_own_create(spline_level *s);
size_t iso_own_floats(const spline_level *s);
size_t iso_own_scratch(const spline_level *s);
void iso_own_begin(const spline_level *s, size_t z, size_t j0, size_t j1, float *memory, own_rows *t);
void iso_own_row(const spline_level *s, size_t y, const float *row, own_rows *t);
void iso_own_end(const spline_level *s, own_rows *t);
/* Adds a row of cells' means, for a level above the carry; a cell has `size` voxels along an edge. */
void iso_own_cells(const spline_level *s, size_t size, size_t cell_y, size_t cell_z, const float *means, size_t cells);
/* Turns a row of the least-squares solution into a damped row to store. */
void iso_own_damp(const spline_level *s, size_t y, size_t z, float *row);

/* cascade_spline_top.c */
size_t iso_cascade_cells_scratch(const iso_cascade *c);
/* Adds the fine planes z0 .. z1 - 1 to the moments in the carry. */
void iso_cascade_cells_feed(const spline_run *r, size_t z0, size_t z1);
/* Computes A^T v of a level above the carry from these moments, into the level's slots. */
void iso_cascade_cells_gather(const spline_run *r, spline_level *s);
