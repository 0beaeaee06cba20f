/* SPDX-License-Identifier: MIT */
/* palette_fit.c - the default, k-means: greedy k-means++, Lloyd, then the searches of palette_search.h; and the
 * lattice. */
#include <string.h>

#include "base/linalg.h"
#include "palette/palette_search.h"

/* Makes each direction an entry, if there are no more directions than entries. */
static iso_status one_entry_each(const iso_direction_set *set, iso_palette *palette, iso_error *err)
{
    NEED(iso_palette_create(palette, set->count, err));
    if (set->count)
        memcpy(palette->xyz + 3, set->xyz, 3 * set->count * sizeof *palette->xyz);
    return ISO_OK;
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
    NEED(iso_clusters_seed_greedy(c, random, err));
    iso_clusters_lloyd(c, 20);
    NEED(iso_clusters_improve(c, opt->swap_trials, random, progress, err));
    /* The exchange considers neighbors only; this assigns each item to the nearest of all entries. */
    iso_clusters_lloyd(c, 2);
    return ISO_OK;
}

/* Fits large sets: searches on a coarse set, then runs Lloyd on all. */
static iso_status fit_large(clusters *c, const iso_direction_set *set, const iso_palette_options *opt,
                            iso_random *random, const iso_progress *progress, iso_error *err)
{
    OWNED(iso_direction_set) coarse = {0};
    ENDED_BY(iso_clusters_destroy) clusters few = {0};
    NEED(coarsen(set, c->count, &coarse, err));
    if (coarse.count <= c->count) /* all directions are in a few cells: bundling gains nothing */
        return fit_search(c, opt, random, progress, err);
    NEED(iso_clusters_create(&few, &coarse, c->count, err));
    NEED(fit_search(&few, opt, random, progress, err));
    for (uint32_t k = 0; k < c->count; ++k)
        for (int a = 0; a < 3; ++a)
            c->axis[a][k] = few.axis[a][k];
    iso_clusters_assign_all(c);
    iso_clusters_lloyd(c, 10);
    return ISO_OK;
}

static iso_status fit_kmeans(const iso_direction_set *set, const iso_palette_options *opt, iso_palette *palette,
                             const iso_progress *progress, iso_error *err)
{
    if (set->count <= opt->directions)
        return one_entry_each(set, palette, err);
    ENDED_BY(iso_clusters_destroy) clusters c = {0};
    iso_random random = {opt->seed};
    NEED(iso_clusters_create(&c, set, opt->directions, err));
    NEED(set->count > SEARCH_BUNDLES * c.count ? fit_large(&c, set, opt, &random, progress, err)
                                               : fit_search(&c, opt, &random, progress, err));
    return iso_clusters_to_palette(&c, palette, err);
}

/* Makes the spherical Fibonacci lattice, which does not depend on data. */
static iso_status make_lattice(size_t directions, iso_palette *palette, iso_error *err)
{
    const double golden_angle = acos(-1) * (3 - sqrt(5));
    NEED(iso_palette_create(palette, directions, err));
    for (size_t i = 0; i < directions; ++i) {
        const double z = 1 - (2 * (double)i + 1) / (double)directions, r = sqrt(1 - z * z);
        const double a = golden_angle * (double)i;
        iso_palette_put(palette, i + 1, iso_v3(r * cos(a), r * sin(a), z));
    }
    return ISO_OK;
}

iso_status iso_palette_fit(const iso_direction_set *set, const iso_palette_options *opt, iso_palette *palette,
                           const iso_progress *progress, iso_error *err)
{
    *palette = (iso_palette){0};
    if (opt->directions < 1 || opt->directions > ISO_PALETTE_MAX)
        return iso_fail(err, ISO_E_RANGE, "palette: %zu directions, must be 1 to %d", opt->directions, ISO_PALETTE_MAX);
    return opt->method == ISO_PALETTE_KMEANS ? fit_kmeans(set, opt, palette, progress, err)
                                             : make_lattice(opt->directions, palette, err);
}
