/* SPDX-License-Identifier: MIT */
#include "povray/lattice_samples.h"

#include <string.h>

iso_lattice_samples iso_lattice_samples_of(const iso_lattice *l, iso_code code)
{
    iso_lattice_samples s = {.lattice = l, .code = code};
    uint8_t none[8];
    iso_code_encode(code, l->empty + 1, none, 1);
    iso_code_decode_all(code, none, s.unlit, 1);
    return s;
}

/* Blocks along a row. */
typedef struct row_blocks {
    iso_lattice_block *const *first;
    size_t in_x, in_row; /* in the first block: index of the first node, and of the row's start */
} row_blocks;

static row_blocks blocks_of(const iso_lattice *l, size_t first)
{
    const size_t *n = l->size, x = first % n[0], y = first / n[0] % n[1], z = first / (n[0] * n[1]);
    size_t in;
    iso_lattice_block *const *block = iso_lattice_block_of(l, x, y, z, &in);
    return (row_blocks){block, in % ISO_LATTICE_SIDE, in - in % ISO_LATTICE_SIDE};
}

/* Nodes of a row that lie in one block; NULL if the block has no active node. */
typedef struct block_run {
    const iso_lattice_block *block;
    size_t in, count;
} block_run;

/* Finds the run that starts at the row's node `done`. */
static block_run run_at(const row_blocks *r, size_t done, size_t count)
{
    const size_t x = (r->in_x + done) % ISO_LATTICE_SIDE, left = ISO_LATTICE_SIDE - x;
    return (block_run){r->first[(r->in_x + done) / ISO_LATTICE_SIDE], r->in_row + x,
                       left < count - done ? left : count - done};
}

void iso_lattice_samples_scalars(const iso_lattice_samples *s, size_t first, size_t count, float *restrict out)
{
    const row_blocks row = blocks_of(s->lattice, first);
    for (size_t done = 0; done < count;) {
        const block_run run = run_at(&row, done, count);
        for (size_t i = 0; i < run.count; ++i)
            out[done + i] = run.block ? run.block->nodes[run.in + i][0] : s->lattice->empty[0];
        done += run.count;
    }
}

/* Number of lit directions that are coded at once. */
enum { BATCH = 256 };
typedef struct lit_batch {
    float directions[3 * BATCH];
    size_t places[BATCH], count;
} lit_batch;

static void code_batch(iso_code code, lit_batch *b, float *restrict out)
{
    uint8_t bytes[8 * BATCH];
    iso_code_encode(code, b->directions, bytes, b->count);
    iso_code_decode_all(code, bytes, b->directions, b->count);
    for (size_t i = 0; i < b->count; ++i)
        memcpy(out + 3 * b->places[i], b->directions + 3 * i, 3 * sizeof *out);
    b->count = 0;
}

/* Codes a batch as soon as it could not hold all nodes of another block. */
void iso_lattice_samples_directions(const iso_lattice_samples *s, size_t first, size_t count, float *restrict out)
{
    const row_blocks row = blocks_of(s->lattice, first);
    lit_batch b;
    b.count = 0;
    for (size_t done = 0; done < count;) {
        const block_run run = run_at(&row, done, count);
        for (size_t i = 0; i < run.count; ++i, ++done) {
            if (!run.block || run.block->use[run.in + i] != ISO_LATTICE_LIT) {
                memcpy(out + 3 * done, s->unlit, sizeof s->unlit);
                continue;
            }
            memcpy(b.directions + 3 * b.count, run.block->nodes[run.in + i] + 1, 3 * sizeof *out);
            b.places[b.count++] = done;
        }
        if (b.count + ISO_LATTICE_SIDE > BATCH)
            code_batch(s->code, &b, out);
    }
    code_batch(s->code, &b, out);
}

size_t iso_lattice_samples_run(const iso_lattice_samples *s, size_t first, size_t count, bool *same)
{
    const row_blocks row = blocks_of(s->lattice, first);
    size_t done = 0;
    *same = !row.first[0];
    while (done < count) {
        const block_run run = run_at(&row, done, count);
        if (!run.block != *same)
            break;
        done += run.count;
    }
    return done;
}
