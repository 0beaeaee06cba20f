/* SPDX-License-Identifier: MIT */
#include "brick/store.h"

#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "brick/pack.h"

static size_t bytes_of(const iso_node_levels *n, size_t level)
{
    size_t side = iso_brick_side(n, level);
    return side * side * side * ISO_NODE_CHANNELS * sizeof(float);
}

static void coordinates(const iso_node_levels *n, size_t i, size_t brick[3])
{
    brick[0] = i % n->count[0];
    brick[1] = i / n->count[0] % n->count[1];
    brick[2] = i / (n->count[0] * n->count[1]);
}

/* True if values on the faces of a brick of unchanged level may have changed. */
static bool neighbors_changed(const iso_brick_store *store, const iso_brick_field *f, size_t i)
{
    const iso_node_levels *n = f->nodes;
    size_t at[3], lo[3], hi[3];
    coordinates(n, i, at);
    for (int a = 0; a < 3; ++a) {
        lo[a] = at[a] > 0 ? at[a] - 1 : 0;
        hi[a] = at[a] + 1 < n->count[a] ? at[a] + 1 : at[a];
    }
    for (size_t z = lo[2]; z <= hi[2]; ++z)
        for (size_t y = lo[1]; y <= hi[1]; ++y)
            for (size_t x = lo[0]; x <= hi[0]; ++x) {
                size_t j = iso_brick_index(n, (const size_t[3]){x, y, z});
                uint8_t before = store->levels[j], now = f->levels[j];
                if (before != now && (before > f->levels[i] || now > f->levels[i]))
                    return true;
            }
    return false;
}

static iso_status begin(iso_brick_store *store, const iso_brick_field *f, iso_error *err)
{
    size_t count = iso_brick_count(f->nodes);
    if (store->bricks)
        return store->brick_count == count
                   ? ISO_OK
                   : iso_fail(err, ISO_E_RANGE, "bricks: the store has %zu bricks, the field has %zu",
                              store->brick_count, count);
    store->brick_count = count;
    store->bricks = calloc(count, sizeof *store->bricks);
    store->levels = malloc(count);
    NEED_MEMORY(store->bricks && store->levels, err, "bricks: no memory for a store of %zu bricks", count);
    memcpy(store->levels, f->levels, count);
    return ISO_OK;
}

iso_status iso_brick_store_update(iso_brick_store *store, const iso_brick_field *f, const uint8_t *drawn, int threads,
                                  size_t *baked, iso_error *err)
{
    size_t done = 0;
    int failed = 0;
    iso_status status = begin(store, f, err);
#pragma omp parallel for schedule(dynamic) num_threads(iso_threads(threads)) reduction(+ : done, failed)
    for (size_t i = 0; i < (status == ISO_OK ? store->brick_count : 0); ++i) {
        bool same_level = store->levels[i] == f->levels[i];
        if (store->bricks[i] && drawn[i] && same_level && !neighbors_changed(store, f, i))
            continue;
        if (!same_level || !drawn[i]) {
            free(store->bricks[i]);
            store->bricks[i] = NULL;
        }
        if (!drawn[i])
            continue;
        size_t brick[3];
        coordinates(f->nodes, i, brick);
        if (!store->bricks[i])
            store->bricks[i] = malloc(bytes_of(f->nodes, f->levels[i]));
        const bool good = store->bricks[i] && iso_brick_bake(f, brick, store->bricks[i], NULL) == ISO_OK;
        done += good;
        failed += !good;
    }
    if (status == ISO_OK && failed)
        status = iso_fail(err, ISO_E_MEMORY, "bricks: no memory for the nodes of %d bricks", failed);
    if (status != ISO_OK) {
        iso_brick_store_destroy(store);
        return status;
    }
    memcpy(store->levels, f->levels, store->brick_count);
    if (baked)
        *baked = done;
    return ISO_OK;
}

void iso_brick_store_destroy(iso_brick_store *store)
{
    if (!store)
        return;
    for (size_t i = 0; store->bricks && i < store->brick_count; ++i)
        free(store->bricks[i]);
    free(store->bricks);
    free(store->levels);
    *store = (iso_brick_store){0};
}

bool iso_brick_store_equal(const iso_brick_store *a, const iso_brick_store *b, const iso_node_levels *n)
{
    if (a->brick_count != b->brick_count)
        return false;
    for (size_t i = 0; i < a->brick_count; ++i)
        if (!a->bricks[i] != !b->bricks[i] ||
            (a->bricks[i] &&
             (a->levels[i] != b->levels[i] || memcmp(a->bricks[i], b->bricks[i], bytes_of(n, a->levels[i])) != 0)))
            return false;
    return true;
}
