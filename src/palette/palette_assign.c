/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "palette/palette.h"
#include "palette/palette_cube.h"

/* 6 * 256^2 cells of 32 bits on the cube's faces:
 *
 *     first entry | second entry << 16     first <= second; both are tried, without a branch
 *     LIST_MARK | position of a list       three or more may be nearest: around the corners of entries' regions
 *
 * A list is its length and its entries, ascending. Measured: 128^2 cells are faster by a fifth for uniform directions
 * and slower by a third to a half for those that a palette was fitted to, near which its entries are dense. */
#define GRID_LEVELS 8
#define GRID_CELLS (1 << GRID_LEVELS)
#define LIST_MARK 0x80000000u

/* Twice the rounding error of a dot product of floats of length sqrt(3), with a margin. An entry is dropped from a cell
 * only if another leads by more at all four corners; both are linear, so it leads everywhere inside. */
#define LEAD_MARGIN 2e-6f

/* x, y, z, x, y: from the largest component's axis on, the three follow in cyclic order. */
typedef struct entry {
    float c[8];
} entry;

struct iso_palette_lookup {
    size_t count;
    entry *entries;
    uint32_t *cells;
    uint16_t *lists;
    size_t list_used, list_capacity;
};

/* ---- grid, by halving --------------------------------------------------------------- */

static float dot_at(const entry *e, const double corner[3])
{
    return e->c[0] * (float)corner[0] + e->c[1] * (float)corner[1] + e->c[2] * (float)corner[2];
}

/* [u, u + size] x [v, v + size] on a face of the cube. */
typedef struct cube_cell {
    int face;
    double u, v, size;
} cube_cell;

/* Selects the parent's candidates that may be nearest somewhere in the cell. */
static size_t cell_candidates(const iso_palette_lookup *l, const cube_cell *cell, const uint16_t *from,
                              size_t from_count, uint16_t *to)
{
    const double u = cell->u, v = cell->v, size = cell->size;
    double middle[3], corner[4][3];
    iso_cube_vector(cell->face, u + 0.5 * size, v + 0.5 * size, middle);
    for (int c = 0; c < 4; ++c)
        iso_cube_vector(cell->face, u + (c & 1 ? size : 0), v + (c & 2 ? size : 0), corner[c]);
    size_t leader = from[0], count = 0;
    float best = -4;
    for (size_t i = 0; i < from_count; ++i) {
        float d = dot_at(&l->entries[from[i]], middle);
        if (d > best)
            best = d, leader = from[i];
    }
    float lead[4];
    for (int c = 0; c < 4; ++c)
        lead[c] = dot_at(&l->entries[leader], corner[c]) - LEAD_MARGIN;
    for (size_t i = 0; i < from_count; ++i) {
        const entry *e = &l->entries[from[i]];
        if (dot_at(e, corner[0]) >= lead[0] || dot_at(e, corner[1]) >= lead[1] || dot_at(e, corner[2]) >= lead[2] ||
            dot_at(e, corner[3]) >= lead[3])
            to[count++] = from[i];
    }
    return count;
}

/* Appends a list and returns its position; SIZE_MAX: no memory. */
static size_t add_list(iso_palette_lookup *l, const uint16_t *entries, size_t count)
{
    if (l->list_used + count + 1 > l->list_capacity) {
        size_t capacity = 2 * l->list_capacity + count + 4096;
        uint16_t *lists = realloc(l->lists, capacity * sizeof *lists);
        if (!lists)
            return SIZE_MAX;
        l->lists = lists;
        l->list_capacity = capacity;
    }
    size_t place = l->list_used;
    l->lists[place] = (uint16_t)count;
    memcpy(l->lists + place + 1, entries, count * sizeof *entries);
    l->list_used += count + 1;
    return place;
}

/* Fills the cells [column, column + n) x [row, row + n) of a face. `from` is followed by space for the levels below. */
static bool fill_cells(iso_palette_lookup *l, int face, int column, int row, int n, const uint16_t *from,
                       size_t from_count)
{
    const double scale = 2.0 / GRID_CELLS;
    uint16_t *own = (uint16_t *)from + from_count;
    const cube_cell cell = {face, column * scale - 1, row * scale - 1, n * scale};
    size_t count = cell_candidates(l, &cell, from, from_count, own);
    if (count > 2 && n > 1) {
        int half = n / 2;
        return fill_cells(l, face, column, row, half, own, count) &&
               fill_cells(l, face, column + half, row, half, own, count) &&
               fill_cells(l, face, column, row + half, half, own, count) &&
               fill_cells(l, face, column + half, row + half, half, own, count);
    }
    uint32_t value = own[0] | (uint32_t)own[count - 1] << 16;
    if (count > 2) {
        size_t place = add_list(l, own, count);
        if (place >= LIST_MARK)
            return false;
        value = LIST_MARK | (uint32_t)place;
    }
    for (int r = row; r < row + n; ++r)
        for (int c = column; c < column + n; ++c)
            l->cells[(face * GRID_CELLS + r) * GRID_CELLS + c] = value;
    return true;
}

iso_status iso_palette_lookup_create(const iso_palette *palette, iso_palette_lookup **lookup, iso_error *err)
{
    *lookup = NULL;
    iso_palette_lookup *l = calloc(1, sizeof *l);
    /* Each level of the recursion stores at most all entries. */
    uint16_t *candidates = malloc((GRID_LEVELS + 2) * palette->count * sizeof *candidates);
    bool good = l && candidates;
    if (good) {
        l->count = palette->count;
        l->entries = calloc(palette->count, sizeof *l->entries);
        l->cells = calloc((size_t)6 * GRID_CELLS * GRID_CELLS + 1, sizeof *l->cells); /* the last cell: no direction */
        good = l->entries && l->cells;
    }
    for (size_t i = 0; good && i < palette->count; ++i)
        for (size_t c = 0; c < 5; ++c)
            l->entries[i].c[c] = palette->xyz[3 * i + c % 3];
    for (size_t i = 1; good && i < palette->count; ++i)
        candidates[i - 1] = (uint16_t)i;
    /* A palette with the zero vector alone leaves all cells 0. */
    for (int face = 0; face < 6 && good && palette->count > 1; ++face)
        good = fill_cells(l, face, 0, 0, GRID_CELLS, candidates, palette->count - 1);
    free(candidates);
    if (!good) {
        iso_palette_lookup_destroy(l);
        return iso_fail(err, ISO_E_MEMORY, "palette: no memory for the lookup grid of %zu entries", palette->count);
    }
    *lookup = l;
    return ISO_OK;
}

void iso_palette_lookup_destroy(iso_palette_lookup *l)
{
    if (!l)
        return;
    free(l->entries);
    free(l->cells);
    free(l->lists);
    free(l);
}

size_t iso_palette_lookup_bytes(const iso_palette_lookup *l)
{
    return l->count * sizeof *l->entries + (size_t)6 * GRID_CELLS * GRID_CELLS * sizeof *l->cells +
           l->list_used * sizeof *l->lists;
}

/* ---- query -------------------------------------------------------------------------- */

/* Directions are processed in blocks: the projection vectorizes, the lookup has no branches that depend on the data,
 * and the few that need a list are done at the block's end. */
#define BLOCK 256

typedef struct block {
    float sign[BLOCK], u[BLOCK], v[BLOCK];
    int32_t axis[BLOCK], cell[BLOCK]; /* cell -1: no direction */
    int32_t waiting[BLOCK];
} block;

/* iso_cube_project and iso_cube_cell without branches. Comparisons with NaN could trap; the compiler vectorizes the
 * loop only if it may ignore that. */
__attribute__((optimize("no-trapping-math"))) static void project_block(const float *restrict vectors,
                                                                        block *restrict b, int count)
{
    const float half = 0.5f * GRID_CELLS;
#pragma omp simd
    for (int i = 0; i < count; ++i) {
        float x = vectors[3 * i], y = vectors[3 * i + 1], z = vectors[3 * i + 2];
        float ax = fabsf(x), ay = fabsf(y), az = fabsf(z);
        float lead = ay > ax ? ay : ax;
        float most = az > lead ? az : lead;
        int32_t y_leads = ay > ax, z_leads = az > lead;
        float major = ay > ax ? y : x, second = ay > ax ? z : y, third = ay > ax ? x : z;
        major = z_leads ? z : major;
        second = z_leads ? x : second;
        third = z_leads ? y : third;
        int32_t axis = z_leads ? 2 : y_leads;
        float u = second / most, v = third / most, sum = fabsf(u) + fabsf(v) + most * 0;
        int32_t known = (most > 0) & (sum <= 2), negative = major < 0;
        u = known ? u : 0;
        v = known ? v : 0;
        int32_t column = (int32_t)((u + 1) * half), row = (int32_t)((v + 1) * half);
        column = column < GRID_CELLS ? column : GRID_CELLS - 1;
        row = row < GRID_CELLS ? row : GRID_CELLS - 1;
        int32_t cell = ((2 * axis + negative) * GRID_CELLS + row) * GRID_CELLS + column;
        b->sign[i] = negative ? -1.0f : 1.0f;
        b->u[i] = u;
        b->v[i] = v;
        b->axis[i] = axis;
        b->cell[i] = known ? cell : 6 * GRID_CELLS * GRID_CELLS;
    }
}

static inline float entry_dot(const iso_palette_lookup *l, const block *b, int i, uint32_t entry_index)
{
    const float *c = l->entries[entry_index].c + b->axis[i];
    return c[0] * b->sign[i] + c[1] * b->u[i] + c[2] * b->v[i];
}

static uint32_t best_of_list(const iso_palette_lookup *l, const block *b, int i, uint32_t place)
{
    const uint16_t *list = l->lists + place;
    uint32_t best = list[1];
    float best_dot = entry_dot(l, b, i, best);
    for (uint32_t j = 2; j <= list[0]; ++j) {
        float d = entry_dot(l, b, i, list[j]);
        best = d > best_dot ? list[j] : best;
        best_dot = d > best_dot ? d : best_dot;
    }
    return best;
}

static void assign_block(const iso_palette_lookup *l, const float *restrict vectors, uint16_t *restrict index, block *b,
                         int count)
{
    int waiting = 0;
    project_block(vectors, b, count);
    for (int i = 0; i < count; ++i) {
        uint32_t cell = l->cells[b->cell[i]];
        uint32_t listed = cell >> 31;
        b->waiting[waiting] = i;
        waiting += (int)listed;
        cell = listed ? 0 : cell;
        uint32_t first = cell & 0xffff, second = cell >> 16;
        index[i] = (uint16_t)(entry_dot(l, b, i, second) > entry_dot(l, b, i, first) ? second : first);
    }
    for (int i = 0; i < waiting; ++i) {
        int at = b->waiting[i];
        index[at] = (uint16_t)best_of_list(l, b, at, l->cells[b->cell[at]] & ~LIST_MARK);
    }
}

void iso_palette_assign(const iso_palette_lookup *l, const float *restrict vectors, uint16_t *restrict index,
                        size_t count)
{
    block b;
    for (size_t i = 0; i < count; i += BLOCK)
        assign_block(l, vectors + 3 * i, index + i, &b, (int)(count - i < BLOCK ? count - i : BLOCK));
}

void iso_palette_assign8(const iso_palette_lookup *l, const float *restrict vectors, uint8_t *restrict index,
                         size_t count)
{
    block b;
    uint16_t wide[BLOCK];
    for (size_t i = 0; i < count; i += BLOCK) {
        int n = (int)(count - i < BLOCK ? count - i : BLOCK);
        assign_block(l, vectors + 3 * i, wide, &b, n);
        for (int j = 0; j < n; ++j)
            index[i + (size_t)j] = (uint8_t)wide[j];
    }
}

void iso_palette_decode(const iso_palette *palette, const uint16_t *restrict index, float *restrict vectors,
                        size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        size_t entry_index = index[i] < palette->count ? index[i] : 0;
        memcpy(vectors + 3 * i, palette->xyz + 3 * entry_index, 3 * sizeof *vectors);
    }
}
