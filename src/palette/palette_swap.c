/* SPDX-License-Identifier: MIT */
#include "palette/palette_search.h"

#include <stdlib.h>
#include <string.h>

/* Runs two-means inside one cluster, from its most distant item and the item most distant from that. Returns by how
 * much the two resultants are longer than the one; `side` is the second entry. */
static double clusters_split(const clusters *c, uint32_t k, float side[3])
{
    const cluster *own = &c->cluster[k];
    float a[3] = {c->axis[0][k], c->axis[1][k], c->axis[2][k]}, b[3];
    if (own->head == NO_ITEM || c->next[own->head] == NO_ITEM)
        return -1;
    for (int end = 0; end < 2; ++end) {
        float least = 2;
        uint32_t farthest = own->head;
        for (uint32_t i = own->head; i != NO_ITEM; i = c->next[i]) {
            const float *u = c->u + 3 * i;
            float dot = u[0] * a[0] + u[1] * a[1] + u[2] * a[2];
            if (dot < least)
                least = dot, farthest = i;
        }
        memcpy(end ? b : a, c->u + 3 * farthest, sizeof a);
    }
    double gain = 0;
    for (int round = 0; round < 4; ++round) {
        double second[3] = {0, 0, 0}, first[3];
        for (uint32_t i = own->head; i != NO_ITEM; i = c->next[i]) {
            const float *u = c->u + 3 * i;
            float lead = u[0] * (b[0] - a[0]) + u[1] * (b[1] - a[1]) + u[2] * (b[2] - a[2]);
            double r = lead > 0 ? c->r[i] : 0;
            for (int d = 0; d < 3; ++d)
                second[d] += r * (double)u[d];
        }
        for (int d = 0; d < 3; ++d)
            first[d] = own->sum[d] - second[d];
        double first_norm = vector_norm(first), second_norm = vector_norm(second);
        if (!(first_norm > 0) || !(second_norm > 0))
            break;
        gain = first_norm + second_norm - own->norm;
        for (int d = 0; d < 3; ++d) {
            a[d] = (float)(first[d] / first_norm);
            b[d] = (float)(second[d] / second_norm);
        }
    }
    memcpy(side, b, sizeof b);
    return gain;
}

/* Returns the best entry for the item other than its own. */
static uint32_t second_best(const clusters *c, uint32_t item, float *best_dot)
{
    const cluster *own = &c->cluster[c->owner[item]];
    uint32_t best = c->owner[item];
    *best_dot = -2;
    for (uint32_t j = 0; j < own->neighbor_count; ++j) {
        float dot = clusters_dot(c, own->neighbor[j], c->u + 3 * item);
        if (dot > *best_dot)
            *best_dot = dot, best = own->neighbor[j];
    }
    return best;
}

/* Returns the loss if the entry is removed and its items go to the next best. */
static double removal_loss(const clusters *c, uint32_t k)
{
    double kept = 0;
    for (uint32_t i = c->cluster[k].head; i != NO_ITEM; i = c->next[i]) {
        float dot;
        second_best(c, i, &dot);
        kept += c->r[i] * (double)dot;
    }
    return c->cluster[k].norm - kept;
}

static void rate(palette_search *s, uint32_t k)
{
    float side[3];
    s->split_gain[k] = clusters_split(s->c, k, side);
    s->removal_loss[k] = removal_loss(s->c, k);
}

/* Removes entry k and splits `target` with it. */
static void relocate(palette_search *s, uint32_t k, uint32_t target, const float side[3])
{
    clusters *c = s->c;
    iso_search_save(s, k);
    while (c->cluster[k].head != NO_ITEM && !s->full) {
        float dot;
        uint32_t item = c->cluster[k].head;
        iso_search_move(s, item, second_best(c, item, &dot));
    }
    float middle[3] = {c->axis[0][target], c->axis[1][target], c->axis[2][target]};
    iso_clusters_set_entry(c, k, side);
    memset(c->cluster[k].sum, 0, sizeof c->cluster[k].sum);
    c->cluster[k].norm = 0;
    /* Items clearly on its side of the middle; the exchange moves the others. */
    float across[3], even = 0;
    for (int d = 0; d < 3; ++d) {
        across[d] = side[d] - middle[d];
        even += middle[d] * across[d];
    }
    for (uint32_t i = c->cluster[target].head, after; i != NO_ITEM && !s->full; i = after) {
        const float *u = c->u + 3 * i;
        after = c->next[i];
        if (u[0] * across[0] + u[1] * across[1] + u[2] * across[2] > even * 0.5f)
            iso_search_move(s, i, k);
    }
    iso_clusters_find_neighbors(c, k);
    /* Neighbors do not list k yet; it replaces their farthest neighbor. */
    cluster *own = &c->cluster[k];
    for (uint32_t j = 0; j < own->neighbor_count; ++j) {
        cluster *other = &c->cluster[own->neighbor[j]];
        bool known = false;
        for (uint32_t i = 0; i < other->neighbor_count; ++i)
            known |= other->neighbor[i] == k;
        if (!known && other->neighbor_count)
            other->neighbor[other->neighbor_count - 1] = k;
        iso_search_queue(s, own->neighbor[j]);
    }
}

/* Tries one swap. True if the total grew; otherwise all is as before. */
static bool try_swap(palette_search *s, uint32_t k, uint32_t target)
{
    clusters *c = s->c;
    float side[3];
    if (k == target || clusters_split(c, target, side) < 0)
        return false;
    const cluster before = c->cluster[k];
    s->recording = true;
    s->saved_count = s->moved_count = 0;
    s->full = false;
    relocate(s, k, target, side);
    iso_search_exchange(s, 4);
    double change = 0, size = 0;
    for (size_t i = 0; i < s->saved_count; ++i) {
        change += c->cluster[s->saved[i].k].norm - s->saved[i].norm;
        size += s->saved[i].norm;
    }
    bool better = !s->full && change > 1e-10 * size;
    if (!better) {
        iso_search_undo(s);
        c->cluster[k].neighbor_count = before.neighbor_count;
        memcpy(c->cluster[k].neighbor, before.neighbor, sizeof before.neighbor);
        memcpy(c->cluster[k].neighbor_dot, before.neighbor_dot, sizeof before.neighbor_dot);
    }
    for (size_t i = 0; i < s->saved_count; ++i) {
        s->touched[s->saved[i].k] = 0;
        if (better)
            rate(s, s->saved[i].k);
    }
    s->recording = false;
    s->full = false;
    return better;
}

/* Draws a few clusters and returns the one with the least sign * value. */
static uint32_t tournament(iso_random *random, const double *value, double sign, size_t count, int draws)
{
    uint32_t best = (uint32_t)iso_random_below(random, count);
    for (int i = 1; i < draws; ++i) {
        uint32_t k = (uint32_t)iso_random_below(random, count);
        if (sign * value[k] < sign * value[best])
            best = k;
    }
    return best;
}

static void refresh(palette_search *s)
{
    clusters *c = s->c;
    for (uint32_t k = 0; k < c->count; ++k)
        iso_clusters_find_neighbors(c, k);
    for (uint32_t k = 0; k < c->count; ++k)
        rate(s, k);
}

static void search_swaps(palette_search *s, size_t trials, iso_random *random, const iso_progress *progress)
{
    size_t count = s->c->count, since_refresh = 0;
    refresh(s);
    /* First the swaps with a gain by these figures; each improves the total, so they end. */
    for (size_t i = 0; i < count; ++i) {
        uint32_t k = extreme_cluster(s->removal_loss, 1, count), target = extreme_cluster(s->split_gain, -1, count);
        if (!(s->split_gain[target] > s->removal_loss[k]) || !try_swap(s, k, target))
            break;
    }
    for (size_t i = 0; i < trials; ++i) {
        if (++since_refresh > count) {
            refresh(s);
            since_refresh = 0;
            iso_progress_report(progress, "palette", (double)i / (double)trials);
        }
        uint32_t k = tournament(random, s->removal_loss, 1, count, 4);
        uint32_t target = tournament(random, s->split_gain, -1, count, 4);
        try_swap(s, k, target);
    }
}

static void search_destroy(palette_search *s)
{
    free(s->queued);
    free(s->list);
    free(s->next_list);
    free(s->split_gain);
    free(s->removal_loss);
    free(s->touched);
    free(s->saved);
    free(s->moved_item);
    free(s->moved_from);
}

iso_status iso_clusters_improve(clusters *c, size_t trials, iso_random *random, const iso_progress *progress,
                                iso_error *err)
{
    size_t n = c->count, capacity = 4 * c->item_count + 64;
    ENDED_BY(search_destroy) palette_search s = {.c = c, .moved_capacity = capacity};
    s.queued = calloc(n, 1);
    s.touched = calloc(n, 1);
    s.list = malloc(n * sizeof *s.list);
    s.next_list = malloc(n * sizeof *s.next_list);
    s.split_gain = malloc(n * sizeof *s.split_gain);
    s.removal_loss = malloc(n * sizeof *s.removal_loss);
    s.saved = malloc(n * sizeof *s.saved);
    s.moved_item = malloc(capacity * sizeof *s.moved_item);
    s.moved_from = malloc(capacity * sizeof *s.moved_from);
    if (!s.queued || !s.touched || !s.list || !s.next_list || !s.split_gain || !s.removal_loss || !s.saved ||
        !s.moved_item || !s.moved_from) {
        return iso_fail(err, ISO_E_MEMORY, "palette: no memory for %zu clusters of %zu bundles", n, c->item_count);
    } else {
        for (uint32_t k = 0; k < n; ++k)
            iso_clusters_find_neighbors(c, k);
        for (uint32_t k = 0; k < n; ++k)
            iso_search_queue(&s, k);
        iso_search_exchange(&s, 30);
        search_swaps(&s, trials * n, random, progress);
        for (uint32_t k = 0; k < n; ++k)
            iso_clusters_find_neighbors(c, k);
        for (uint32_t k = 0; k < n; ++k)
            iso_search_queue(&s, k);
        iso_search_exchange(&s, 30);
    }
    return ISO_OK;
}
