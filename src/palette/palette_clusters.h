/* SPDX-License-Identifier: MIT */
/* palette_clusters.h - clusters of a direction set, for the k-means family.
 *
 * A cluster's entry is the direction of its resultant S = sum of r u over its
 * bundles (r = weight times length). Its cost is sum of weights - |S|, so that
 * the fit maximizes the sum of all |S|; that is spherical k-means. */
#pragma once

#include "base/random.h"
#include "palette/palette.h"

#define CLUSTER_NEIGHBORS 16
#define NO_ITEM UINT32_MAX

typedef struct cluster {
    double sum[3], norm; /* S and |S| */
    uint32_t head;       /* first of its items, or NO_ITEM */
    uint32_t neighbor_count;
    uint32_t neighbor[CLUSTER_NEIGHBORS]; /* nearest first */
    float neighbor_dot[CLUSTER_NEIGHBORS];
} cluster;

typedef struct clusters {
    size_t item_count, count;
    const float *u;  /* 3 per item, borrowed from the set */
    double *r;       /* weight times length */
    float *axis[3];  /* entries, planar */
    float *dots;     /* scratch, one per entry */
    uint32_t *owner; /* cluster of each item */
    uint32_t *next, *previous;
    cluster *cluster;
} clusters;

iso_status iso_clusters_create(clusters *c, const iso_direction_set *set, size_t count, iso_error *err);
void iso_clusters_destroy(clusters *c);

static inline float clusters_dot(const clusters *c, uint32_t k, const float *u)
{
    return c->axis[0][k] * u[0] + c->axis[1][k] * u[1] + c->axis[2][k] * u[2];
}
void iso_clusters_set_entry(clusters *c, uint32_t k, const float *direction);

/* Chooses the first `count` entries and each item's owner. */
iso_status iso_clusters_seed_greedy(clusters *c, iso_random *random, iso_error *err);

/* Assigns every item to the nearest of all entries. */
void iso_clusters_assign_all(clusters *c);
/* Finds the entries nearest to entry k. */
void iso_clusters_find_neighbors(clusters *c, uint32_t k);
/* Assigns and recenters until the sum of |S| grows by less than a millionth, at most `rounds` times. Entries that lose
 * all items move to the item with the largest cost. Returns the sum of |S|. */
double iso_clusters_lloyd(clusters *c, size_t rounds);
/* Rebuilds the lists of items, S and |S| from the owners. Returns the sum of |S|. */
double iso_clusters_collect(clusters *c);
iso_status iso_clusters_to_palette(const clusters *c, iso_palette *palette, iso_error *err);
