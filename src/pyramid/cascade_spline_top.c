/* SPDX-License-Identifier: MIT */
/* cascade_spline_top.c - least-squares levels above the cascade's carry (cascade.h).
 *
 * Their sums reach over more planes than slabs have. Of each cell of s^3 fine voxels, s = 2^(level of the carry), the
 * carry keeps eight moments, of 1 and the place from 0 to 1 along each axis. The tent of a level above is linear on
 * each cell, as its knots lie on the cells' borders: so its sums are made of the moments, exactly. */
#include <string.h>

#include "pyramid/cascade_spline.h"

enum { MOMENTS = 8 }; /* number 4 mz + 2 my + mx, 1 for the first moment along the axis */

static size_t cell_size(const iso_cascade *c)
{
    return (size_t)1 << c->tile_top;
}

/* Returns the floats of a fine row of whole cells. Scratch has such a row, its two sums along y, and their moments
 * along x. */
static size_t padded_row(const iso_cascade *c)
{
    return c->size[c->tile_top][0] * cell_size(c);
}

size_t iso_cascade_cells_scratch(const iso_cascade *c)
{
    return 5 * padded_row(c) + 64;
}

size_t iso_cascade_cells_floats(const iso_cascade *c)
{
    return iso_scalar_filter_is_spline(c->opt.scalar_filter)
               ? MOMENTS * c->size[c->tile_top][0] * c->size[c->tile_top][1]
               : 0;
}

/* Returns moment m of a row of cells. */
static float *cell_row(const iso_cascade *c, size_t y, size_t z, size_t m)
{
    const size_t *n = c->size[c->tile_top];
    size_t plane;
    float *carry = iso_cascade_carry((iso_cascade *)c, &plane);
    return carry + (z + 1) * plane - iso_cascade_cells_floats(c) + (m * n[1] + y) * n[0];
}

/* Adds the fine plane z to the moments of a row of cells. */
static void sum_cells(const spline_run *r, size_t cell_y, size_t z)
{
    const iso_cascade *c = r->c;
    const size_t s = cell_size(c), padded = padded_row(c), cells = c->size[c->tile_top][0], cell_z = z / s;
    const size_t end = (cell_y + 1) * s < c->size[0][1] ? (cell_y + 1) * s : c->size[0][1];
    float *row = spline_scratch(r), *sums = row + padded, *halves = sums + 2 * padded;
    const double place_z = ((double)(z % s) + 0.5) / (double)s;
    memset(row, 0, 3 * padded * sizeof *row);
    for (size_t y = cell_y * s; y < end; ++y) {
        iso_planes_row(r->in, y, z, row);
        iso_add_weighted_row((float)(1 / (double)s), row, padded, sums);
        iso_add_weighted_row((float)(((double)(y % s) + 0.5) / (double)(s * s)), row, padded, sums + padded);
    }
    for (size_t my = 0; my < 2; ++my) {
        const float *of_x[2];
        iso_spline_moments(sums + my * padded, padded, s, halves, &of_x[0], &of_x[1]);
        for (size_t m = 0; m < 4; ++m) { /* 2 mz + mx */
            float *to = cell_row(c, cell_y, cell_z, (m & 2) * 2 + 2 * my + (m & 1));
            if (z % s == 0)
                memset(to, 0, cells * sizeof *to);
            iso_add_weighted_row((float)((m & 2 ? place_z : 1) / (double)s), of_x[m & 1], cells, to);
        }
    }
}

void iso_cascade_cells_feed(const spline_run *r, size_t z0, size_t z1)
{
#pragma omp parallel for schedule(static) num_threads(r->c->threads)
    for (size_t y = 0; y < r->c->size[r->c->tile_top][1]; ++y)
        for (size_t z = z0; z < z1; ++z)
            sum_cells(r, y, z);
}

/* Adds a row of cells to coarse rows: reduced along x, for each pair of moments along y and z. */
static void gather_row(const spline_run *r, spline_level *s, size_t cell_y, size_t cell_z)
{
    const iso_cascade *c = r->c;
    const size_t size = cell_size(c), nx = s->axis[0].coarse, cells = c->size[c->tile_top][0];
    float *reduced = spline_scratch(r); /* [2 mz + my] */
    iso_spline_part of_x[2], of_y[2], of_z[2];
    memset(reduced, 0, 4 * nx * sizeof *reduced);
    for (size_t x = 0; x < cells; ++x)
        for (int i = iso_spline_cell(&s->axis[0], size, x, of_x) - 1; i >= 0; --i)
            for (size_t m = 0; m < 4; ++m)
                reduced[m * nx + of_x[i].j] += of_x[i].by_t * cell_row(c, cell_y, cell_z, 2 * m)[x] +
                                               of_x[i].by_u * cell_row(c, cell_y, cell_z, 2 * m + 1)[x];
    const int count_y = iso_spline_cell(&s->axis[1], size, cell_y, of_y),
              count_z = iso_spline_cell(&s->axis[2], size, cell_z, of_z);
    for (int i = 0; i < count_z; ++i)
        for (int k = 0; k < count_y; ++k) {
            float *to = spline_slot(s, of_z[i].j) + of_y[k].j * nx;
            iso_add_weighted_row(of_z[i].by_t * of_y[k].by_t, reduced, nx, to);
            iso_add_weighted_row(of_z[i].by_t * of_y[k].by_u, reduced + nx, nx, to);
            iso_add_weighted_row(of_z[i].by_u * of_y[k].by_t, reduced + 2 * nx, nx, to);
            iso_add_weighted_row(of_z[i].by_u * of_y[k].by_u, reduced + 3 * nx, nx, to);
        }
}

void iso_cascade_cells_gather(const spline_run *r, spline_level *s)
{
    const size_t *cells = r->c->size[r->c->tile_top];
    memset(s->slots, 0, s->slot_count * spline_plane_floats(s) * sizeof *s->slots);
    if (s->own)
        memset(s->own, 0, iso_own_floats(s) * sizeof *s->own);
    for (size_t z = 0; z < cells[2]; ++z)
        for (size_t y = 0; y < cells[1]; ++y) {
            gather_row(r, s, y, z);
            if (s->own)
                iso_own_cells(s, cell_size(r->c), y, z, cell_row(r->c, y, z, 0), cells[0]);
        }
}
