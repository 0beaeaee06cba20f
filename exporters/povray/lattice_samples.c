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

/* Nodes of a row that lie in one block; NULL where none of the block's is active. */
typedef struct block_run {
    const iso_lattice_block *block;
    size_t in, count;
} block_run;

static block_run run_at(const iso_lattice *l, size_t first, size_t most)
{
    const size_t *n = l->size;
    block_run run;
    run.block = *iso_lattice_block_of(l, first % n[0], first / n[0] % n[1], first / (n[0] * n[1]), &run.in);
    run.count = ISO_LATTICE_SIDE - run.in % ISO_LATTICE_SIDE;
    run.count = run.count < most ? run.count : most;
    return run;
}

void iso_lattice_samples_scalars(const iso_lattice_samples *s, size_t first, size_t count, float *restrict out)
{
    const iso_lattice *l = s->lattice;
    for (size_t done = 0; done < count;) {
        const block_run run = run_at(l, first + done, count - done);
        for (size_t i = 0; i < run.count; ++i)
            out[done + i] = run.block ? run.block->nodes[run.in + i][0] : l->empty[0];
        done += run.count;
    }
}

/* Directions that are lit, to be coded at once. */
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

/* Codes a batch before it could not take all of another block's nodes. */
void iso_lattice_samples_directions(const iso_lattice_samples *s, size_t first, size_t count, float *restrict out)
{
    lit_batch b;
    b.count = 0;
    for (size_t done = 0; done < count;) {
        const block_run run = run_at(s->lattice, first + done, count - done);
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

bool iso_lattice_samples_alike(const iso_lattice_samples *s, size_t first, size_t count)
{
    for (size_t done = 0; done < count;) {
        const block_run run = run_at(s->lattice, first + done, count - done);
        if (run.block)
            return false;
        done += run.count;
    }
    return true;
}
