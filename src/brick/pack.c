/* SPDX-License-Identifier: MIT */
#include "brick/pack.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "brick/occupancy.h"

static bool is_visible(const uint8_t *visible, size_t brick)
{
    return !visible || visible[brick];
}

/* Counts the visible bricks of each level; returns the coarsest level in use. */
static size_t count_by_level(const iso_node_levels *n, const uint8_t *levels, const uint8_t *visible,
                             size_t by_level[ISO_BRICK_MAX_LEVELS])
{
    size_t coarsest = 0;
    memset(by_level, 0, ISO_BRICK_MAX_LEVELS * sizeof *by_level);
    for (size_t i = 0; i < iso_brick_count(n); ++i)
        if (is_visible(visible, i)) {
            ++by_level[levels[i]];
            coarsest = levels[i] > coarsest ? levels[i] : coarsest;
        }
    return coarsest;
}

size_t iso_brick_pack_slots(const iso_node_levels *n, const uint8_t *levels, const uint8_t *visible, size_t *slot_side)
{
    size_t by_level[ISO_BRICK_MAX_LEVELS], coarsest = count_by_level(n, levels, visible, by_level), needed = 0;
    *slot_side = n->brick_voxels + ((size_t)1 << coarsest);
    for (size_t l = ISO_BRICK_MAX_LEVELS; l-- > 0;)
        needed = by_level[l] + (needed + 7) / 8;
    return needed;
}

/* Free parts of slots: at each level the rest of the last split, used in order of index. */
typedef struct free_parts {
    size_t next_slot, slot_side;
    struct {
        size_t slot, offset[3];
        int next; /* octant; 8: none left */
    } split[ISO_BRICK_MAX_LEVELS];
} free_parts;

/* Takes a part for a brick of this level: a whole slot, or the next octant of a part of the level above. */
static void take_part(free_parts *parts, size_t level, size_t *slot, size_t offset[3])
{
    if (level == 0) {
        *slot = parts->next_slot++;
        offset[0] = offset[1] = offset[2] = 0;
        return;
    }
    if (parts->split[level].next == 8) {
        take_part(parts, level - 1, &parts->split[level].slot, parts->split[level].offset);
        parts->split[level].next = 0;
    }
    int octant = parts->split[level].next++;
    *slot = parts->split[level].slot;
    for (int a = 0; a < 3; ++a)
        offset[a] = parts->split[level].offset[a] + (octant >> a & 1 ? parts->slot_side >> level : 0);
}

/* Arranges the slots of a page: first with as few unused slots as possible, then as close to a cube as possible. */
static void arrange_page(iso_brick_pack *pack, size_t count, size_t most)
{
    size_t best = SIZE_MAX, root = (size_t)ceil(cbrt((double)count));
    size_t last = 2 * root < most ? 2 * root : most;
    for (size_t x = root < last ? root : last; x <= last; ++x)
        for (size_t y = (root + 1) / 2; y <= x; ++y) {
            size_t z = (count + x * y - 1) / (x * y);
            if (z > x || x * y * z >= best)
                continue;
            best = x * y * z;
            pack->slots[0] = x, pack->slots[1] = y, pack->slots[2] = z;
        }
}

static void arrange(iso_brick_pack *pack, size_t max_side)
{
    size_t count = pack->slot_count > 0 ? pack->slot_count : 1, most = max_side / pack->slot_side;
    most = most > 0 ? most : 1;
    pack->page_count = (count - 1) / (most * most * most) + 1;
    arrange_page(pack, (count - 1) / pack->page_count + 1, most);
    for (int a = 0; a < 3; ++a)
        pack->size[a] = pack->slots[a] * pack->slot_side;
}

size_t iso_brick_pack_texels(const iso_node_levels *n, const uint8_t *levels, const uint8_t *visible, size_t max_side)
{
    iso_brick_pack pack = {0};
    pack.slot_count = iso_brick_pack_slots(n, levels, visible, &pack.slot_side);
    arrange(&pack, max_side);
    return pack.page_count * pack.size[0] * pack.size[1] * pack.size[2];
}

static void place(iso_brick_pack *pack, const iso_node_levels *n, const uint8_t *levels, const uint8_t *visible)
{
    free_parts parts = {.slot_side = pack->slot_side};
    for (int l = 0; l < ISO_BRICK_MAX_LEVELS; ++l)
        parts.split[l].next = 8;
    for (size_t l = 0; l < n->level_count; ++l)
        for (size_t i = 0; i < iso_brick_count(n); ++i) {
            if (levels[i] != l || !is_visible(visible, i))
                continue;
            size_t slot, offset[3], side = iso_brick_side(n, l);
            take_part(&parts, l, &slot, offset);
            const size_t at[3] = {slot % pack->slots[0], slot / pack->slots[0] % pack->slots[1],
                                  slot / (pack->slots[0] * pack->slots[1])};
            for (int a = 0; a < 3; ++a)
                pack->layout[4 * i + (size_t)a] = (float)(at[a] * pack->slot_side + offset[a]);
            pack->layout[4 * i + 3] = ldexpf(1, -(int)l);
            ++pack->brick_count;
            pack->node_count += side * side * side;
        }
}

iso_status iso_brick_pack_create(iso_brick_pack *pack, const iso_node_levels *n, const uint8_t *levels,
                                 const uint8_t *visible, size_t max_side, size_t max_slots, iso_error *err)
{
    *pack = (iso_brick_pack){0};
    pack->slot_count = iso_brick_pack_slots(n, levels, visible, &pack->slot_side);
    arrange(pack, max_side);
    if (max_slots > 0 && pack->slot_count > max_slots)
        return iso_fail(err, ISO_E_RANGE, "bricks: need %zu slots of %zu^3, the cache has %zu", pack->slot_count,
                        pack->slot_side, max_slots);
    if (pack->page_count > ISO_BRICK_MAX_PAGES || pack->slot_side > max_side)
        return iso_fail(err, ISO_E_RANGE,
                        "bricks: need %zu cache textures of %zu x %zu x %zu, at most %d of %zu per side",
                        pack->page_count, pack->size[0], pack->size[1], pack->size[2], ISO_BRICK_MAX_PAGES, max_side);
    pack->layout = calloc(iso_brick_count(n), 4 * sizeof *pack->layout);
    NEED_MEMORY(pack->layout, err, "bricks: no memory for the layout of %zu bricks", iso_brick_count(n));
    place(pack, n, levels, visible);
    return ISO_OK;
}

void iso_brick_pack_destroy(iso_brick_pack *pack)
{
    if (!pack)
        return;
    free(pack->layout);
    *pack = (iso_brick_pack){0};
}

/* True for nodes on the faces, which may come from a coarser brick. */
static bool on_face(size_t side, size_t x, size_t y, size_t z)
{
    return x == 0 || y == 0 || z == 0 || x + 1 == side || y + 1 == side || z + 1 == side;
}

/* Copies the nodes of the brick's own level, or makes them. */
static iso_status put_own(const iso_brick_field *f, const size_t brick[3], size_t side, float *restrict out,
                          iso_error *err)
{
    const iso_node_levels *n = f->nodes;
    const size_t i = iso_brick_index(n, brick), voxels = n->brick_voxels;
    if (!n->nodes[f->levels[i]] && !n->bricks[i])
        return iso_node_levels_read(n,
                                    (const long[3]){(long)(voxels * brick[0]), (long)(voxels * brick[1]),
                                                    (long)(voxels * brick[2])},
                                    (const size_t[3]){side, side, side}, out, err);
    for (size_t z = 0; z < side; ++z)
        for (size_t y = 0; y < side; ++y)
            memcpy(out + ISO_NODE_CHANNELS * side * (y + side * z), iso_brick_own_row(f, brick, y, z),
                   ISO_NODE_CHANNELS * side * sizeof *out);
    return ISO_OK;
}

iso_status iso_brick_bake(const iso_brick_field *f, const size_t brick[3], float *restrict out, iso_error *err)
{
    const size_t side = iso_brick_side(f->nodes, f->levels[iso_brick_index(f->nodes, brick)]);
    bool foreign[ISO_BRICK_PARTS], any = false;
    const iso_status status = put_own(f, brick, side, out, err);
    iso_brick_foreign_parts(f, brick, foreign);
    for (size_t i = 0; i < ISO_BRICK_PARTS; ++i)
        any = any || foreign[i];
    if (status != ISO_OK || !any)
        return status;
    for (size_t z = 0; z < side; ++z)
        for (size_t y = 0; y < side; ++y) {
            float *row = out + ISO_NODE_CHANNELS * side * (y + side * z);
            for (size_t x = 0; x < side; x += on_face(side, 1, y, z) ? 1 : side - 1) {
                double value[ISO_NODE_CHANNELS];
                if (!foreign[iso_brick_part(side, x, y, z)])
                    continue;
                iso_brick_node(f, brick, (const size_t[3]){x, y, z}, value);
                for (size_t c = 0; c < ISO_NODE_CHANNELS; ++c)
                    row[ISO_NODE_CHANNELS * x + c] = (float)value[c];
            }
        }
    return ISO_OK;
}

/* Returns the range of a brick's own nodes, measured before if possible. */
static iso_node_range range_of(const iso_brick_field *f, const size_t brick[3])
{
    const size_t i = iso_brick_index(f->nodes, brick);
    const iso_node_range *ranges = f->nodes->ranges[f->levels[i]];
    return ranges ? ranges[i]
                  : iso_own_nodes_range(iso_brick_own_nodes(f, brick), iso_brick_side(f->nodes, f->levels[i]));
}

/* Widens the range by all nodes of coarser neighbors that the brick's face nodes may be interpolated from. */
static void widen_by_coarser(float range[2], const iso_brick_field *f, const size_t brick[3])
{
    const iso_node_levels *n = f->nodes;
    const uint8_t level = f->levels[iso_brick_index(n, brick)];
    for (size_t i = 0; i < 27; ++i) {
        const size_t step[3] = {i % 3, i / 3 % 3, i / 9};
        size_t at[3];
        bool there = true;
        for (int a = 0; a < 3; ++a) {
            at[a] = brick[a] + step[a] - 1; /* below 0 wraps around to a large index */
            there = there && at[a] < n->count[a];
        }
        if (!there || f->levels[iso_brick_index(n, at)] <= level)
            continue;
        const iso_node_range coarser = range_of(f, at);
        range[0] = fminf(range[0], coarser.whole[0]);
        range[1] = fmaxf(range[1], coarser.whole[1]);
    }
}

/* Bakes the scalars of the faces alone. Without memory the brick counts as visible. */
static bool baked_shows(const iso_brick_field *f, const iso_tf_table *tf, const size_t brick[3], const float inner[2])
{
    const iso_node_levels *n = f->nodes;
    const size_t i = iso_brick_index(n, brick), side = iso_brick_side(n, f->levels[i]);
    const bool is_missing = !n->nodes[f->levels[i]] && !n->bricks[i];
    bool shows = is_missing && iso_brick_make(n, i, ISO_BRICK_SCALARS, NULL) != ISO_OK;
    double min = (double)inner[0], max = (double)inner[1];
    for (size_t z = 0; z < side && !shows; ++z) {
        for (size_t y = 0; y < side; ++y)
            for (size_t x = 0; x < side; x += on_face(side, 1, y, z) ? 1 : side - 1) {
                double value[ISO_NODE_CHANNELS];
                iso_brick_node(f, brick, (const size_t[3]){x, y, z}, value);
                min = value[0] < min ? value[0] : min;
                max = value[0] > max ? value[0] : max;
            }
        shows = iso_tf_shows(tf, min, max);
    }
    if (is_missing)
        iso_brick_forget(n, i);
    return shows;
}

/* True if any value in the brick is visible; all values lie between those of its nodes. For most bricks the inner
 * nodes, or a wider range for the faces, decide it without baking. */
bool iso_brick_shows(const iso_brick_field *f, const iso_tf_table *tf, const size_t brick[3])
{
    const iso_node_range own = range_of(f, brick);
    float wide[2] = {own.whole[0], own.whole[1]};
    if (!iso_brick_has_foreign_nodes(f, brick))
        return iso_tf_shows(tf, (double)wide[0], (double)wide[1]);
    if (own.inner[0] <= own.inner[1] && iso_tf_shows(tf, (double)own.inner[0], (double)own.inner[1]))
        return true;
    widen_by_coarser(wide, f, brick);
    return iso_tf_shows(tf, (double)wide[0], (double)wide[1]) && baked_shows(f, tf, brick, own.inner);
}

void iso_brick_cull(const iso_brick_field *f, const iso_tf_table *tf, const uint8_t *wanted, int threads,
                    uint8_t *restrict visible)
{
    const iso_node_levels *n = f->nodes;
    const size_t count = iso_brick_count(n);
#pragma omp parallel for schedule(dynamic, 16) num_threads(iso_threads(threads))
    for (size_t i = 0; i < count; ++i) {
        const size_t brick[3] = {i % n->count[0], i / n->count[0] % n->count[1], i / (n->count[0] * n->count[1])};
        visible[i] = (!wanted || wanted[i]) && iso_brick_shows(f, tf, brick);
    }
}
