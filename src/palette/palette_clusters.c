/* SPDX-License-Identifier: MIT */
#include "palette/palette_clusters.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void iso_clusters_destroy(clusters *c)
{
    free(c->r);
    for (int a = 0; a < 3; ++a)
        free(c->axis[a]);
    free(c->dots);
    free(c->owner);
    free(c->next);
    free(c->previous);
    free(c->cluster);
    *c = (clusters){0};
}

iso_status iso_clusters_create(clusters *c, const iso_direction_set *set, size_t count, iso_error *err)
{
    *c = (clusters){.item_count = set->count, .count = count, .u = set->xyz};
    if (set->count >= NO_ITEM)
        return iso_fail(err, ISO_E_RANGE, "palette: %zu bundles of directions, at most %u", set->count, NO_ITEM - 1);
    c->r = malloc(set->count * sizeof *c->r);
    for (int a = 0; a < 3; ++a)
        c->axis[a] = calloc(count, sizeof *c->axis[a]);
    c->dots = malloc(count * sizeof *c->dots);
    c->owner = calloc(set->count, sizeof *c->owner);
    c->next = malloc(set->count * sizeof *c->next);
    c->previous = malloc(set->count * sizeof *c->previous);
    c->cluster = calloc(count, sizeof *c->cluster);
    if (!c->r || !c->axis[0] || !c->axis[1] || !c->axis[2] || !c->dots || !c->owner || !c->next || !c->previous ||
        !c->cluster) {
        iso_clusters_destroy(c);
        return iso_fail(err, ISO_E_MEMORY, "palette: no memory for %zu clusters of %zu bundles", count, set->count);
    }
    for (size_t i = 0; i < set->count; ++i)
        c->r[i] = set->weight[i] * (double)set->length[i];
    return ISO_OK;
}

void iso_clusters_set_entry(clusters *c, uint32_t k, const float *direction)
{
    for (int a = 0; a < 3; ++a)
        c->axis[a][k] = direction[a];
}

/* ---- seeds -------------------------------------------------------------------------- */

/* Items in planes, so that a pass over them vectorizes. */
typedef struct greedy {
    float *x, *y, *z, *r, *best; /* best: the largest dot product with an entry so far */
    double *cumulative;
} greedy;

/* Returns the growth of the sum of r * best by an entry at u. */
static double gain_of(const greedy *g, size_t count, const float *u)
{
    double gain = 0;
    for (size_t block = 0; block < count; block += 1024) {
        size_t end = block + 1024 < count ? block + 1024 : count;
        float part = 0;
#pragma omp simd reduction(+ : part)
        for (size_t i = block; i < end; ++i) {
            float more = g->x[i] * u[0] + g->y[i] * u[1] + g->z[i] * u[2] - g->best[i];
            part += more > 0 ? g->r[i] * more : 0;
        }
        gain += (double)part;
    }
    return gain;
}

static void take_entry(clusters *c, greedy *g, uint32_t k, const float *u)
{
    iso_clusters_set_entry(c, k, u);
    for (size_t i = 0; i < c->item_count; ++i) {
        float dot = g->x[i] * u[0] + g->y[i] * u[1] + g->z[i] * u[2];
        if (dot > g->best[i]) {
            g->best[i] = dot;
            c->owner[i] = k;
        }
    }
}

/* Draws an item with a probability proportional to its cost. */
static size_t draw_item(const greedy *g, size_t count, iso_random *random)
{
    double at = iso_random_unit(random) * g->cumulative[count - 1];
    size_t lo = 0, hi = count - 1;
    while (lo < hi) {
        size_t middle = (lo + hi) / 2;
        if (g->cumulative[middle] > at)
            hi = middle;
        else
            lo = middle + 1;
    }
    return lo;
}

static void seed_greedy(clusters *c, greedy *g, iso_random *random)
{
    /* Arthur and Vassilvitskii's 2 + log k candidates for each entry; the best one is used. */
    size_t n = c->item_count, candidates = 2 + (size_t)log((double)c->count);
    for (uint32_t k = 0; k < c->count; ++k) {
        double total = 0;
        for (size_t i = 0; i < n; ++i) {
            /* For the first entry best is -1: all items have the same cost per weight. */
            total += c->r[i] * fmax(0, 1 - (double)g->best[i]);
            g->cumulative[i] = total;
        }
        size_t best = draw_item(g, n, random);
        double best_gain = total > 0 ? gain_of(g, n, c->u + 3 * best) : 0;
        for (size_t j = 1; j < candidates && total > 0; ++j) {
            size_t item = draw_item(g, n, random);
            double gain = gain_of(g, n, c->u + 3 * item);
            if (gain > best_gain)
                best_gain = gain, best = item;
        }
        take_entry(c, g, k, c->u + 3 * best);
    }
}

iso_status iso_clusters_seed_greedy(clusters *c, iso_random *random, iso_error *err)
{
    size_t n = c->item_count;
    FREED float *planes = malloc(5 * n * sizeof *planes);
    FREED double *cumulative = malloc(n * sizeof *cumulative);
    if (!planes || !cumulative) {
        return iso_fail(err, ISO_E_MEMORY, "palette: no memory for %zu bundles", n);
    } else {
        greedy g = {planes, planes + n, planes + 2 * n, planes + 3 * n, planes + 4 * n, cumulative};
        for (size_t i = 0; i < n; ++i) {
            g.x[i] = c->u[3 * i];
            g.y[i] = c->u[3 * i + 1];
            g.z[i] = c->u[3 * i + 2];
            g.r[i] = (float)c->r[i];
            g.best[i] = -1.001f; /* below any dot product, so that the first entry owns all */
        }
        seed_greedy(c, &g, random);
    }
    return ISO_OK;
}

/* ---- assignment ----------------------------------------------------------------------- */

static uint32_t nearest_of_all(clusters *c, const float *u)
{
    float *dots = c->dots, x = u[0], y = u[1], z = u[2];
    const float *restrict ax = c->axis[0], *restrict ay = c->axis[1], *restrict az = c->axis[2];
    for (size_t k = 0; k < c->count; ++k)
        dots[k] = ax[k] * x + ay[k] * y + az[k] * z;
    uint32_t best = 0;
    for (uint32_t k = 1; k < c->count; ++k)
        if (dots[k] > dots[best])
            best = k;
    return best;
}

void iso_clusters_assign_all(clusters *c)
{
    for (size_t i = 0; i < c->item_count; ++i)
        c->owner[i] = nearest_of_all(c, c->u + 3 * i);
}

void iso_clusters_find_neighbors(clusters *c, uint32_t k)
{
    cluster *own = &c->cluster[k];
    float *dots = c->dots, u[3] = {c->axis[0][k], c->axis[1][k], c->axis[2][k]};
    for (uint32_t j = 0; j < c->count; ++j)
        dots[j] = clusters_dot(c, j, u);
    dots[k] = -2;
    uint32_t used = 0;
    float least = -2;
    for (uint32_t j = 0; j < c->count; ++j) {
        if (dots[j] <= least && (used == CLUSTER_NEIGHBORS || j == k))
            continue;
        uint32_t at = used < CLUSTER_NEIGHBORS ? used++ : CLUSTER_NEIGHBORS - 1;
        for (; at > 0 && own->neighbor_dot[at - 1] < dots[j]; --at) {
            own->neighbor_dot[at] = own->neighbor_dot[at - 1];
            own->neighbor[at] = own->neighbor[at - 1];
        }
        own->neighbor_dot[at] = dots[j];
        own->neighbor[at] = j;
        least = used == CLUSTER_NEIGHBORS ? own->neighbor_dot[used - 1] : -2;
    }
    own->neighbor_count = used;
}

/* Returns the nearest entry to u, which was nearest to k. An entry more than twice as far from k as u is not nearer to
 * u (triangle inequality on the sphere), so the search through k's sorted neighbors ends early. */
static uint32_t nearest_from(clusters *c, uint32_t k, const float *u)
{
    const cluster *own = &c->cluster[k];
    float best_dot = clusters_dot(c, k, u);
    if (best_dot <= 0)
        return nearest_of_all(c, u);
    float reach = 2 * best_dot * best_dot - 1 - 1e-5f; /* cos of twice the angle, minus the rounding error */
    uint32_t best = k;
    for (uint32_t j = 0; j < own->neighbor_count; ++j) {
        if (own->neighbor_dot[j] < reach)
            return best;
        float dot = clusters_dot(c, own->neighbor[j], u);
        if (dot > best_dot)
            best_dot = dot, best = own->neighbor[j];
    }
    return own->neighbor_count + 1 < c->count ? nearest_of_all(c, u) : best;
}

double iso_clusters_collect(clusters *c)
{
    for (size_t k = 0; k < c->count; ++k) {
        memset(c->cluster[k].sum, 0, sizeof c->cluster[k].sum);
        c->cluster[k].head = NO_ITEM;
    }
    for (size_t i = c->item_count; i-- > 0;) {
        cluster *own = &c->cluster[c->owner[i]];
        for (int a = 0; a < 3; ++a)
            own->sum[a] += c->r[i] * (double)c->u[3 * i + (size_t)a];
        c->next[i] = own->head;
        c->previous[i] = NO_ITEM;
        if (own->head != NO_ITEM)
            c->previous[own->head] = (uint32_t)i;
        own->head = (uint32_t)i;
    }
    double total = 0;
    for (size_t k = 0; k < c->count; ++k) {
        cluster *own = &c->cluster[k];
        own->norm = sqrt(own->sum[0] * own->sum[0] + own->sum[1] * own->sum[1] + own->sum[2] * own->sum[2]);
        total += own->norm;
        for (int a = 0; a < 3 && own->norm > 0; ++a)
            c->axis[a][k] = (float)(own->sum[a] / own->norm);
    }
    return total;
}

/* Moves an entry without items to the item with the largest cost. True if there was one. */
static bool fill_empty(clusters *c)
{
    bool any = false;
    for (uint32_t k = 0; k < c->count; ++k) {
        if (c->cluster[k].head != NO_ITEM)
            continue;
        size_t worst = 0;
        double worst_cost = -1;
        for (size_t i = 0; i < c->item_count; ++i) {
            double cost = c->r[i] * (1 - (double)clusters_dot(c, c->owner[i], c->u + 3 * i));
            bool alone = c->cluster[c->owner[i]].head == i && c->next[i] == NO_ITEM;
            if (cost > worst_cost && !alone)
                worst_cost = cost, worst = i;
        }
        if (worst_cost < 0)
            return any;
        c->owner[worst] = k;
        iso_clusters_collect(c);
        any = true;
    }
    return any;
}

double iso_clusters_lloyd(clusters *c, size_t rounds)
{
    double total = iso_clusters_collect(c);
    for (size_t round = 0; round < rounds; ++round) {
        if (fill_empty(c))
            total = iso_clusters_collect(c);
        for (uint32_t k = 0; k < c->count; ++k)
            iso_clusters_find_neighbors(c, k);
        for (size_t i = 0; i < c->item_count; ++i)
            c->owner[i] = nearest_from(c, c->owner[i], c->u + 3 * i);
        double before = total;
        total = iso_clusters_collect(c);
        if (!(total - before > 1e-9 * total))
            break;
    }
    return total;
}

iso_status iso_clusters_to_palette(const clusters *c, iso_palette *palette, iso_error *err)
{
    NEED(iso_palette_create(palette, c->count, err));
    for (size_t k = 0; k < c->count; ++k)
        for (size_t a = 0; a < 3; ++a)
            palette->xyz[3 * (k + 1) + a] = c->axis[a][k];
    return ISO_OK;
}
