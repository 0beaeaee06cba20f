/* SPDX-License-Identifier: MIT */
/* palette_search.h - two searches that improve on Lloyd's result; private to src/palette.
 *
 *   exchange  moves one item to another cluster if the two resultants together become longer (Hartigan). With few
 *             items per entry this is well below Lloyd's optimum, since an item pulls its own entry towards itself.
 *   swap      removes the least useful entry, inserts it at the place of most gain, exchanges the neighborhood, and
 *             undoes everything unless the total improves. */
#pragma once

#include <math.h>

#include "palette/palette_clusters.h"

typedef struct saved_cluster {
    uint32_t k;
    double sum[3], norm;
    float axis[3];
} saved_cluster;

typedef struct palette_search {
    clusters *c;
    uint8_t *queued; /* clusters for the next pass */
    uint32_t *list, *next_list;
    size_t list_count, next_count;
    double *split_gain, *removal_loss; /* one per cluster */
    /* Journal of a trial. */
    bool recording;
    uint8_t *touched;
    saved_cluster *saved;
    size_t saved_count;
    uint32_t *moved_item, *moved_from;
    size_t moved_count, moved_capacity;
    bool full; /* True if the journal is full: the trial is undone */
} palette_search;

static inline double vector_norm(const double s[3])
{
    return sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
}

/* Returns |S + r u| without squares of S. */
static inline double joined_norm(const cluster *k, const float *u, double r)
{
    double s[3] = {k->sum[0] + r * (double)u[0], k->sum[1] + r * (double)u[1], k->sum[2] + r * (double)u[2]};
    return vector_norm(s);
}

/* Returns the cluster with the least sign * value. */
static inline uint32_t extreme_cluster(const double *value, double sign, size_t count)
{
    uint32_t best = 0;
    for (uint32_t k = 1; k < count; ++k)
        if (sign * value[k] < sign * value[best])
            best = k;
    return best;
}

/* ---- exchange ---- */

/* Queues cluster k for the next exchange. */
void iso_search_queue(palette_search *s, uint32_t k);
/* Saves cluster k to the journal if a trial is recorded. */
void iso_search_save(palette_search *s, uint32_t k);
void iso_search_move(palette_search *s, uint32_t item, uint32_t to);
/* Exchanges items of the queued clusters, and of those that change by it, until nothing moves. */
void iso_search_exchange(palette_search *s, size_t passes);
/* Restores all clusters to their state at the beginning of the recording. */
void iso_search_undo(palette_search *s);

/* ---- swap ---- */

/* Runs exchanges, `trials` swaps per cluster, and exchanges again. */
iso_status iso_clusters_improve(clusters *c, size_t trials, iso_random *random, const iso_progress *progress,
                                iso_error *err);
