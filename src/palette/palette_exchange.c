/* SPDX-License-Identifier: MIT */
#include "palette/palette_search.h"

#include <string.h>

void iso_search_queue(palette_search *s, uint32_t k)
{
    if (s->queued[k])
        return;
    s->queued[k] = 1;
    s->next_list[s->next_count++] = k;
}

void iso_search_save(palette_search *s, uint32_t k)
{
    if (!s->recording || s->touched[k])
        return;
    s->touched[k] = 1;
    saved_cluster *save = &s->saved[s->saved_count++];
    *save = (saved_cluster){.k = k, .norm = s->c->cluster[k].norm};
    for (int a = 0; a < 3; ++a) {
        save->sum[a] = s->c->cluster[k].sum[a];
        save->axis[a] = s->c->axis[a][k];
    }
}

static void unlink_item(clusters *c, uint32_t item)
{
    uint32_t before = c->previous[item], after = c->next[item];
    if (before == NO_ITEM)
        c->cluster[c->owner[item]].head = after;
    else
        c->next[before] = after;
    if (after != NO_ITEM)
        c->previous[after] = before;
}

static void link_item(clusters *c, uint32_t item, uint32_t k)
{
    cluster *own = &c->cluster[k];
    c->owner[item] = k;
    c->previous[item] = NO_ITEM;
    c->next[item] = own->head;
    if (own->head != NO_ITEM)
        c->previous[own->head] = item;
    own->head = item;
}

static void add_to_sum(clusters *c, uint32_t k, uint32_t item, double sign)
{
    cluster *own = &c->cluster[k];
    for (size_t a = 0; a < 3; ++a)
        own->sum[a] += sign * c->r[item] * (double)c->u[3 * item + a];
    own->norm = vector_norm(own->sum);
    for (int a = 0; a < 3 && own->norm > 0; ++a)
        c->axis[a][k] = (float)(own->sum[a] / own->norm);
}

void iso_search_move(palette_search *s, uint32_t item, uint32_t to)
{
    clusters *c = s->c;
    uint32_t from = c->owner[item];
    if (s->recording) {
        if (s->moved_count == s->moved_capacity) {
            s->full = true;
            return;
        }
        s->moved_item[s->moved_count] = item;
        s->moved_from[s->moved_count++] = from;
    }
    iso_search_save(s, from);
    iso_search_save(s, to);
    unlink_item(c, item);
    link_item(c, item, to);
    add_to_sum(c, from, item, -1);
    add_to_sum(c, to, item, 1);
    iso_search_queue(s, from);
    iso_search_queue(s, to);
}

/* Returns the cluster in which the item makes the two resultants longest; its own if no other is better. */
static uint32_t best_exchange(const clusters *c, uint32_t item)
{
    uint32_t from = c->owner[item], best = from;
    const cluster *own = &c->cluster[from];
    const float *u = c->u + 3 * item;
    double r = c->r[item];
    double loss = own->norm - joined_norm(own, u, -r);
    double most = loss * (1 + 1e-9) + 1e-12 * own->norm; /* moves due to rounding alone would never end */
    float threshold = (float)(most / r);
    for (uint32_t j = 0; j < own->neighbor_count; ++j) {
        uint32_t k = own->neighbor[j];
        float dot = clusters_dot(c, k, u);
        double along = c->cluster[k].norm + r * (double)dot;
        /* |S + ru| - |S| is at most r dot + r^2 (1 - dot^2) / (2 (|S| + r dot)). */
        if (along > 0 && dot + (float)(0.5 * r * (1.000001 - (double)(dot * dot)) / along) + 1e-6f < threshold)
            continue;
        double gain = joined_norm(&c->cluster[k], u, r) - c->cluster[k].norm;
        if (gain > most)
            most = gain, best = k;
    }
    return best;
}

void iso_search_exchange(palette_search *s, size_t passes)
{
    clusters *c = s->c;
    for (size_t pass = 0; pass < passes && s->next_count && !s->full; ++pass) {
        uint32_t *list = s->list;
        s->list = s->next_list;
        s->list_count = s->next_count;
        s->next_list = list;
        s->next_count = 0;
        for (size_t i = 0; i < s->list_count; ++i)
            s->queued[s->list[i]] = 0;
        for (size_t i = 0; i < s->list_count && !s->full; ++i)
            for (uint32_t item = c->cluster[s->list[i]].head, after; item != NO_ITEM && !s->full; item = after) {
                after = c->next[item];
                uint32_t to = best_exchange(c, item);
                if (to != c->owner[item])
                    iso_search_move(s, item, to);
            }
    }
    for (size_t i = 0; i < s->next_count; ++i)
        s->queued[s->next_list[i]] = 0;
    s->next_count = 0;
}

void iso_search_undo(palette_search *s)
{
    clusters *c = s->c;
    for (size_t i = s->moved_count; i-- > 0;) {
        unlink_item(c, s->moved_item[i]);
        link_item(c, s->moved_item[i], s->moved_from[i]);
    }
    for (size_t i = 0; i < s->saved_count; ++i) {
        const saved_cluster *save = &s->saved[i];
        memcpy(c->cluster[save->k].sum, save->sum, sizeof save->sum);
        c->cluster[save->k].norm = save->norm;
        iso_clusters_set_entry(c, save->k, save->axis);
    }
}
