/* SPDX-License-Identifier: MIT */
#include "render/brick_visible.h"

#include "brick/pack.h"

/* True if the clip planes leave a part of brick i's box. Boxes of outer bricks end at the volume's faces. */
static bool is_kept(const iso_node_levels *n, const iso_view *view, size_t i)
{
    const size_t brick[3] = {i % n->count[0], i / n->count[0] % n->count[1], i / (n->count[0] * n->count[1])};
    double lo[3], hi[3];
    for (int a = 0; a < 3; ++a) {
        lo[a] = (double)(brick[a] * n->brick_voxels) + (brick[a] > 0 ? 0.5 : 0);
        hi[a] = brick[a] + 1 < n->count[a] ? (double)((brick[a] + 1) * n->brick_voxels) + 0.5
                                           : n->geometry.box_index[a];
    }
    return iso_view_keeps(view, &n->geometry, lo, hi);
}

double iso_brick_visible(const iso_brick_field *f, const iso_view *view, const iso_tf_table *tf, const uint8_t *wanted,
                         int threads, uint8_t *restrict visible)
{
    const size_t count = iso_brick_count(f->nodes);
    size_t shown = 0;
    iso_brick_cull(f, tf, wanted, threads, visible);
    for (size_t i = 0; i < count; ++i) {
        visible[i] = visible[i] && is_kept(f->nodes, view, i);
        shown += visible[i];
    }
    return (double)shown / (double)count;
}
