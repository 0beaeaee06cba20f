/* SPDX-License-Identifier: MIT */
/* palette_kmeans.c - the default: greedy k-means++, Lloyd, then the searches of palette_search.h. */
#include <stdlib.h>
#include <string.h>

#include "palette/palette_search.h"

/* ---- seeds by splitting [linde-1980] -------------------------------------------- */

/* Doubles the number of entries, or splits the costliest ones if that is too many; runs Lloyd after each step. */
static iso_status grow_by_splitting(clusters *c, const iso_direction_set *set, iso_error *err)
{
    size_t wanted = c->count;
    iso_clusters_set_entry(c, 0, set->xyz);
    memset(c->owner, 0, c->item_count * sizeof *c->owner);
    c->count = 1;
    iso_clusters_collect(c);
    while (c->count < wanted) {
        size_t now = c->count, left = wanted - now;
        double *gain = malloc(now * sizeof *gain);
        if (!gain)
            return iso_fail(err, ISO_E_MEMORY, "palette: no memory for %zu clusters", wanted);
        float side[3];
        for (uint32_t k = 0; k < now; ++k)
            gain[k] = iso_clusters_split(c, k, side);
        for (size_t i = 0; i < now && i < left; ++i) {
            uint32_t k = extreme_cluster(gain, -1, now), fresh = (uint32_t)c->count;
            if (iso_clusters_split(c, k, side) < 0)
                break;
            gain[k] = -2;
            ++c->count;
            iso_clusters_set_entry(c, fresh, side);
            c->cluster[fresh] = (cluster){.head = NO_ITEM};
        }
        free(gain);
        /* Impossible: each cluster would have one item, but there are more items than entries. */
        if (c->count == now)
            break;
        iso_clusters_assign_all(c);
        iso_clusters_lloyd(c, 20);
    }
    return ISO_OK;
}

/* ---- fit ------------------------------------------------------------------------- */

/* Makes each direction an entry, if there are no more directions than entries. */
static iso_status one_entry_each(const iso_direction_set *set, iso_palette *palette, iso_error *err)
{
    iso_status status = iso_palette_create(palette, set->count, err);
    if (status == ISO_OK && set->count)
        memcpy(palette->xyz + 3, set->xyz, 3 * set->count * sizeof *palette->xyz);
    return status;
}

/* Swaps are tried on a set of at most this many bundles per entry, enough to find places that need entries. */
#define SEARCH_BUNDLES 32

/* Creates the finest set with few enough bundles: the more concentrated the directions, the finer its cells. */
static iso_status coarsen(const iso_direction_set *set, size_t entries, iso_direction_set *out, iso_error *err)
{
    static const int cells[] = {96, 64, 48, 32, 24, 16};
    iso_status status = ISO_OK;
    for (size_t i = 0; i < sizeof cells / sizeof *cells; ++i) {
        iso_direction_set_destroy(out);
        status = iso_direction_set_coarsen(set, cells[i], out, err);
        if (status != ISO_OK || out->count <= SEARCH_BUNDLES * entries)
            break;
    }
    return status;
}

static iso_status fit_search(clusters *c, const iso_palette_options *opt, iso_random *random,
                             const iso_progress *progress, iso_error *err)
{
    iso_status status = iso_clusters_seed_greedy(c, random, err);
    if (status != ISO_OK)
        return status;
    iso_clusters_lloyd(c, 20);
    status = iso_clusters_improve(c, opt->swap_trials, random, progress, err);
    /* The exchange considers neighbors only; this assigns each item to the nearest of all entries. */
    iso_clusters_lloyd(c, 2);
    return status;
}

/* Fits large sets: searches on a coarse set, then runs Lloyd on all. */
static iso_status fit_large(clusters *c, const iso_direction_set *set, const iso_palette_options *opt,
                            iso_random *random, const iso_progress *progress, iso_error *err)
{
    iso_direction_set coarse = {0};
    clusters few = {0};
    iso_status status = coarsen(set, c->count, &coarse, err);
    if (status == ISO_OK && coarse.count <= c->count) {
        /* All directions are in a few cells: bundling gains nothing. */
        iso_direction_set_destroy(&coarse);
        return fit_search(c, opt, random, progress, err);
    }
    TRY(status, iso_clusters_create(&few, &coarse, c->count, err));
    TRY(status, fit_search(&few, opt, random, progress, err));
    for (uint32_t k = 0; status == ISO_OK && k < c->count; ++k)
        for (int a = 0; a < 3; ++a)
            c->axis[a][k] = few.axis[a][k];
    iso_clusters_destroy(&few);
    iso_direction_set_destroy(&coarse);
    if (status == ISO_OK) {
        iso_clusters_assign_all(c);
        iso_clusters_lloyd(c, 10);
    }
    return status;
}

static iso_status fit_clusters(clusters *c, const iso_direction_set *set, const iso_palette_options *opt,
                               const iso_progress *progress, iso_error *err)
{
    iso_random random = {opt->seed};
    iso_status status = ISO_OK;
    switch (opt->method) {
    case ISO_PALETTE_KMEANS:
        return set->count > SEARCH_BUNDLES * c->count ? fit_large(c, set, opt, &random, progress, err)
                                                      : fit_search(c, opt, &random, progress, err);
    case ISO_PALETTE_LLOYD: iso_clusters_seed_random(c, &random); break;
    case ISO_PALETTE_LBG: status = grow_by_splitting(c, set, err); break;
    default: status = iso_clusters_seed_greedy(c, &random, err);
    }
    if (status == ISO_OK)
        iso_clusters_lloyd(c, 200);
    return status;
}

iso_status iso_palette_fit_kmeans(const iso_direction_set *set, const iso_palette_options *opt, iso_palette *palette,
                                  const iso_progress *progress, iso_error *err)
{
    if (set->count <= opt->directions)
        return one_entry_each(set, palette, err);
    clusters c;
    iso_status status = iso_clusters_create(&c, set, opt->directions, err);
    TRY(status, fit_clusters(&c, set, opt, progress, err));
    TRY(status, iso_palette_create(palette, opt->directions, err));
    for (size_t k = 0; status == ISO_OK && k < opt->directions; ++k)
        for (size_t a = 0; a < 3; ++a)
            palette->xyz[3 * (k + 1) + a] = c.axis[a][k];
    iso_clusters_destroy(&c);
    return status;
}
