/* SPDX-License-Identifier: MIT */
#include "render/cpu/cast_made.h"

#include <assert.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

/* A brick is made under the lock of its bench, with the bench's memory. */
typedef struct bench {
    pthread_mutex_t lock;
    iso_box_codes *codes; /* NULL without light, and if the level has codes */
    float scalars[ISO_CAST_VOXELS];
    uint8_t bytes[3 * ISO_CAST_VOXELS];
} bench;

struct iso_cast_maker {
    const iso_level *level;
    iso_cast_scalars scalars;
    bool is_lit, is_signed;
    size_t brick_count[3];
    iso_cast_pool pool;
    int32_t *slots;
    size_t capacity;
    int32_t next; /* brick of the pool; 0 is never taken: lanes without a sample read it */
    size_t bench_count;
    bench *benches;
};

/* Counts the bricks with a block that can show something; all if there are no blocks. */
static size_t count_bricks(const iso_cast_maker *m, const iso_cast_blocks *b)
{
    enum { BLOCKS = ISO_CAST_BRICK >> ISO_CAST_BLOCK_SHIFT };
    const size_t *n = m->brick_count, bricks = n[0] * n[1] * n[2];
    size_t count = 0;
    FREED uint8_t *shows = b ? calloc(bricks, 1) : NULL;
    for (size_t i = 0; shows && i < b->blocks; ++i) {
        const size_t at[3] = {i % b->count[0], i / b->count[0] % b->count[1], i / (b->count[0] * b->count[1])};
        shows[at[0] / BLOCKS + n[0] * (at[1] / BLOCKS + n[1] * (at[2] / BLOCKS))] |= b->octants[i] == 0;
    }
    for (size_t i = 0; i < bricks; ++i)
        count += !shows || shows[i];
    return count;
}

static void read_scalars(const iso_level *level, const iso_cast_box *box, float *out)
{
    const size_t *n = level->geometry.size;
    for (size_t z = 0; z < box->count[2]; ++z)
        for (size_t y = 0; y < box->count[1]; ++y, out += box->count[0]) {
            const size_t row = box->first[1] + y + n[1] * (box->first[2] + z);
            iso_level_scalars(level, level->samples, box->first[0] + n[0] * row, box->count[0], out);
        }
}

static void read_codes(const iso_level *level, const iso_cast_box *box, uint8_t *out)
{
    const size_t *n = level->geometry.size, bytes = 3 * box->count[0];
    for (size_t z = 0; z < box->count[2]; ++z)
        for (size_t y = 0; y < box->count[1]; ++y, out += bytes)
            memcpy(out, level->codes + 3 * (box->first[0] + n[0] * (box->first[1] + y + n[1] * (box->first[2] + z))),
                   bytes);
}

static int32_t make_brick(iso_cast_maker *m, int32_t brick)
{
    bench *b = &m->benches[(size_t)brick % m->bench_count];
    const size_t *size = m->level->geometry.size;
    pthread_mutex_lock(&b->lock);
    int32_t slot = __atomic_load_n(m->slots + brick, __ATOMIC_RELAXED);
    if (slot < 0) {
        const iso_cast_box box = iso_cast_box_of(size, m->brick_count, (size_t)brick);
        const int32_t page = __atomic_fetch_add(&m->next, 1, __ATOMIC_RELAXED);
        assert((size_t)page < m->capacity);
        read_scalars(m->level, &box, b->scalars);
        if (m->is_lit && m->level->codes)
            read_codes(m->level, &box, b->bytes);
        else if (b->codes)
            iso_box_codes_make(b->codes, box.first, box.count, b->bytes);
        iso_cast_pool_fill(&m->pool, &m->scalars, m->is_signed, size, &box, b->scalars, b->bytes, (size_t)page);
        slot = page * ISO_CAST_VOXELS;
        __atomic_store_n(m->slots + brick, slot, __ATOMIC_RELEASE);
    }
    pthread_mutex_unlock(&b->lock);
    return slot;
}

static iso_status create_benches(iso_cast_maker *m, iso_code code, int threads, iso_error *err)
{
    const bool makes_codes = m->is_lit && !m->level->codes;
    double scale = 1;
    iso_status status = makes_codes ? iso_level_gradient_scale(m->level, &scale, err) : ISO_OK;
    const size_t count = 4 * (size_t)threads; /* more than threads: two rarely want the same */
    m->benches = status == ISO_OK ? calloc(count, sizeof *m->benches) : NULL;
    if (status == ISO_OK && !m->benches)
        status = iso_fail(err, ISO_E_MEMORY, "cpu: no memory to make bricks");
    while (status == ISO_OK && m->bench_count < count) {
        bench *b = &m->benches[m->bench_count++];
        pthread_mutex_init(&b->lock, NULL);
        if (makes_codes)
            status = iso_box_codes_create(m->level, code, scale, ISO_CAST_ROW, &b->codes, err);
    }
    return status;
}

iso_status iso_cast_make_on_demand(iso_cast_maker **maker, iso_cast *c, const iso_cast_made *of, iso_error *err)
{
    const iso_level *level = of->level;
    iso_cast_maker *m = *maker = calloc(1, sizeof *m);
    if (!m)
        return iso_fail(err, ISO_E_MEMORY, "cpu: out of memory");
    *m = (iso_cast_maker){.level = level,
                          .scalars = of->scalars,
                          .is_lit = c->normals != ISO_CAST_UNLIT,
                          .is_signed = c->is_signed,
                          .next = 1};
    size_t bricks = 1, bytes;
    for (int a = 0; a < 3; ++a) {
        c->brick_stride[a] = (int32_t)bricks;
        bricks *= m->brick_count[a] = level->geometry.size[a] / ISO_CAST_BRICK + 1;
    }
    m->slots = malloc(bricks * sizeof *m->slots);
    m->capacity = count_bricks(m, of->blocks) + 1;
    if (!m->slots || !iso_cast_pool_create(&m->pool, &m->scalars, m->is_lit, m->capacity, &bytes))
        return iso_fail(err, ISO_E_MEMORY, "cpu: no memory for %zu bricks", bricks);
    memset(m->slots, -1, bricks * sizeof *m->slots);
    memset(iso_cast_pool_array(&m->pool), 0, ISO_CAST_VOXELS * iso_cast_voxel_bytes(&m->scalars, m->is_lit));
    iso_cast_pool_use(&m->pool, c);
    c->slots = m->slots;
    c->maker = m;
    c->make_brick = make_brick;
    return create_benches(m, of->code, of->threads, err);
}

void iso_cast_maker_destroy(iso_cast_maker *m)
{
    if (!m)
        return;
    for (size_t i = 0; i < m->bench_count; ++i) {
        pthread_mutex_destroy(&m->benches[i].lock);
        iso_box_codes_destroy(m->benches[i].codes);
    }
    free(m->benches);
    free(m->slots);
    free(iso_cast_pool_array(&m->pool));
    free(m);
}

double iso_cast_maker_bytes(const iso_cast_maker *m)
{
    return (double)m->next * ISO_CAST_VOXELS * (double)iso_cast_voxel_bytes(&m->scalars, m->is_lit);
}
