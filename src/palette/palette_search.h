/* SPDX-License-Identifier: MIT */
/* palette_search.h - two searches that go on where Lloyd stops; private to the fit.
 *
 *   exchange  one item moves to another cluster when the two resultants together become longer (Hartigan): with
 *             few items an entry this is well below Lloyd's optimum, since an item pulls its own entry towards it.
 *   swap      the entry that is missed least is taken away and set where it gains most, the neighborhood is
 *             exchanged, and all is undone unless the total improved. */
#ifndef ISO_PALETTE_SEARCH_H
#define ISO_PALETTE_SEARCH_H

#include <math.h>

#include "palette/palette_clusters.h"
#include "palette/palette_fit.h"

typedef struct saved_cluster {
    uint32_t k;
    double sum[3], norm;
    float axis[3];
} saved_cluster;

typedef struct palette_search {
    clusters *c;
    uint8_t *queued; /* clusters that the next pass looks at */
    uint32_t *list, *next_list;
    size_t list_count, next_count;
    double *split_gain, *removal_loss; /* a cluster */
    /* The journal of a trial. */
    bool recording;
    uint8_t *touched;
    saved_cluster *saved;
    size_t saved_count;
    uint32_t *moved_item, *moved_from;
    size_t moved_count, moved_capacity;
    bool full; /* the journal ran out: the trial is undone */
} palette_search;

static inline double vector_norm(const double s[3])
{
    return sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
}

/* |S + r u| without a square of S. */
static inline double joined_norm(const cluster *k, const float *u, double r)
{
    double s[3] = {k->sum[0] + r * (double)u[0], k->sum[1] + r * (double)u[1], k->sum[2] + r * (double)u[2]};
    return vector_norm(s);
}

/* The cluster of the least sign * value. */
static inline uint32_t extreme_cluster(const double *value, double sign, size_t count)
{
    uint32_t best = 0;
    for (uint32_t k = 1; k < count; ++k)
        if (sign * value[k] < sign * value[best])
            best = k;
    return best;
}

/* ---- exchange ---- */

/* The next exchange looks at cluster k. */
void iso_search_queue(palette_search *s, uint32_t k);
/* Into the journal, where a trial is recorded. */
void iso_search_save(palette_search *s, uint32_t k);
void iso_search_move(palette_search *s, uint32_t item, uint32_t to);
/* Exchanges inside the queued clusters, and those that change by it, until nothing moves. */
void iso_search_exchange(palette_search *s, size_t passes);
/* All clusters become what they were when the recording began. */
void iso_search_undo(palette_search *s);

/* ---- swap ---- */

/* Two means inside one cluster, from its most distant item and the one most distant from that. Returns how much
 * longer the two resultants are than the one; `side` is the second entry. */
double iso_clusters_split(const clusters *c, uint32_t k, float side[3]);
/* Exchanges, `trials` swaps a cluster, and exchanges. */
iso_status iso_clusters_improve(clusters *c, size_t trials, iso_random *random, const iso_progress *progress,
                                iso_error *err);

#endif
