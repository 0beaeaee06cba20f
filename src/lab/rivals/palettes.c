/* SPDX-License-Identifier: MIT */
#include "lab/rivals/palettes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lab/rivals/palette_tables.h"
#include "palette/palette_search.h"

const char *iso_palette_rival_name(iso_palette_rival method)
{
    static const char *const names[] = {
#define RIVAL_NAME(name, text) text,
        ISO_PALETTE_RIVAL_LIST(RIVAL_NAME)
#undef RIVAL_NAME
    };
    return names[method];
}

iso_rival_options iso_rival_defaults(void)
{
    return (iso_rival_options){
        .fit = iso_palette_defaults(),
        .anneal = {.start_prob = 0.2, .temp_fac = 0.92, .cycles = 100, .steps = 10000, .move_deg = {10, 15}},
    };
}

iso_status iso_rival_palette_check(const iso_rival_options *opt, iso_error *err)
{
    const iso_anneal_options *a = &opt->anneal;
    const size_t directions = opt->fit.directions;
    if (directions < 1 || directions > ISO_PALETTE_MAX)
        return iso_fail(err, ISO_E_RANGE, "palette: %zu directions, must be 1 to %d", directions, ISO_PALETTE_MAX);
    if (opt->method == ISO_RIVAL_FACES && directions < 60)
        return iso_fail(err, ISO_E_RANGE, "palette: %zu directions, regular faces need at least 60", directions);
    if (opt->method == ISO_RIVAL_VERTICES && directions < 32)
        return iso_fail(err, ISO_E_RANGE, "palette: %zu directions, regular vertices need at least 32", directions);
    if (opt->method == ISO_RIVAL_GRID && directions < 2)
        return iso_fail(err, ISO_E_RANGE, "palette: 1 direction, the grid needs at least 2");
    if (opt->method != ISO_RIVAL_ANNEAL)
        return ISO_OK;
    if (directions < 8 || directions % 2)
        return iso_fail(err, ISO_E_RANGE, "palette: %zu directions, a tessellation needs an even number, at least 8",
                        directions);
    if (!(a->start_prob > 0 && a->start_prob < 1))
        return iso_fail(err, ISO_E_RANGE, "palette: start probability %g, must be between 0 and 1", a->start_prob);
    if (!(a->temp_fac > 0 && a->temp_fac <= 1))
        return iso_fail(err, ISO_E_RANGE, "palette: temperature factor %g, must be above 0 and at most 1", a->temp_fac);
    if (!(a->move_deg[0] > 0 && a->move_deg[0] <= a->move_deg[1] && a->move_deg[1] <= 90))
        return iso_fail(err, ISO_E_RANGE, "palette: moves by %g to %g degrees, must be above 0, ascending, at most 90",
                        a->move_deg[0], a->move_deg[1]);
    return ISO_OK;
}

/* ---- relatives of k-means ---------------------------------------------------------- */

static void seed_random(clusters *c, iso_random *random)
{
    /* Selection sampling: all sets of `count` items are equally likely. */
    size_t chosen = 0;
    for (size_t i = 0; i < c->item_count && chosen < c->count; ++i)
        if (iso_random_unit(random) * (double)(c->item_count - i) < (double)(c->count - chosen))
            iso_clusters_set_entry(c, (uint32_t)chosen++, c->u + 3 * i);
    iso_clusters_assign_all(c);
}

/* [linde-1980]: doubles the number of entries, or splits the costliest ones if that is too many; runs Lloyd after each step. */
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

static iso_status fit_relative(const iso_direction_set *set, const iso_rival_options *opt, iso_palette *palette,
                               iso_error *err)
{
    iso_random random = {opt->fit.seed};
    clusters c;
    iso_status status = iso_clusters_create(&c, set, opt->fit.directions, err);
    if (status == ISO_OK && opt->method == ISO_RIVAL_LLOYD)
        seed_random(&c, &random);
    else if (status == ISO_OK && opt->method == ISO_RIVAL_LBG)
        status = grow_by_splitting(&c, set, err);
    else if (status == ISO_OK)
        status = iso_clusters_seed_greedy(&c, &random, err);
    if (status == ISO_OK)
        iso_clusters_lloyd(&c, 200);
    TRY(status, iso_clusters_to_palette(&c, palette, err));
    iso_clusters_destroy(&c);
    return status;
}

/* ---- all methods --------------------------------------------------------------------- */

static iso_status fixed_table(const iso_rival_options *opt, iso_palette *palette, iso_error *err)
{
    size_t count = opt->fit.directions;
    bool faces = opt->method == ISO_RIVAL_FACES;
    int level = 0;
    if (faces || opt->method == ISO_RIVAL_VERTICES) {
        size_t (*size)(int) = faces ? iso_subdivision_faces : iso_subdivision_vertices;
        while (size(level + 1) <= opt->fit.directions)
            ++level;
        count = size(level);
    } else if (opt->method == ISO_RIVAL_GRID) {
        count = iso_palette_grid(opt->fit.directions, NULL);
    }
    iso_status status = iso_palette_create(palette, count, err);
    if (status != ISO_OK)
        return status;
    float *xyz = palette->xyz + 3;
    if (opt->method == ISO_RIVAL_GRID)
        iso_palette_grid(opt->fit.directions, xyz);
    else if (opt->method == ISO_RIVAL_SPIRAL)
        iso_palette_spiral(count, xyz);
    else
        status = iso_palette_subdivide(level, faces, xyz, err);
    if (status != ISO_OK)
        iso_palette_destroy(palette);
    return status;
}

iso_status iso_rival_palette_fit(const iso_direction_set *set, const iso_rival_options *opt, iso_palette *palette,
                                 iso_error *err)
{
    iso_palette_options fit = opt->fit;
    *palette = (iso_palette){0};
    fit.method = opt->method == ISO_RIVAL_FIBONACCI ? ISO_PALETTE_FIBONACCI : ISO_PALETTE_KMEANS;
    iso_status status = iso_rival_palette_check(opt, err);
    if (status != ISO_OK)
        return status;
    switch (opt->method) {
    case ISO_RIVAL_KMEANSPP:
    case ISO_RIVAL_LLOYD:
    case ISO_RIVAL_LBG:
        /* With an entry for each direction there is nothing to choose. */
        return set->count <= fit.directions ? iso_palette_fit(set, &fit, palette, NULL, err)
                                            : fit_relative(set, opt, palette, err);
    case ISO_RIVAL_KMEANS:
    case ISO_RIVAL_FIBONACCI: return iso_palette_fit(set, &fit, palette, NULL, err);
    case ISO_RIVAL_ANNEAL: return iso_rival_palette_anneal(set, opt, palette, NULL, err);
    default: return fixed_table(opt, palette, err);
    }
}

/* ---- the paper's ellipsoid ----------------------------------------------------- */

/* Draws a point uniformly from the unit ball, by rejection from the cube. */
static void point_in_ball(iso_random *random, double p[3])
{
    double r2;
    do {
        for (int c = 0; c < 3; ++c)
            p[c] = 2 * iso_random_unit(random) - 1;
        r2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
    } while (r2 > 1 || r2 < 1e-12);
}

/* Draws a gradient on the surface. q uniform on the unit sphere gives the point (q_x, q_y / sqrt(15), q_z /
 * sqrt(15)) of the ellipsoid; its area grows with the gradient (q_x, sqrt(15) q_y, sqrt(15) q_z), so q is accepted
 * in proportion. */
static void gradient_on_surface(iso_random *random, double g[3])
{
    const double stretch = sqrt(15);
    double n, m;
    do {
        point_in_ball(random, g);
        n = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
        g[0] /= n;
        g[1] *= stretch / n;
        g[2] *= stretch / n;
        m = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
    } while (iso_random_unit(random) * stretch > m);
}

void iso_ellipsoid_gradients(float *vectors, size_t count, bool on_surface, uint64_t seed)
{
    iso_random random = {seed};
    for (size_t i = 0; i < count; ++i) {
        double g[3];
        if (on_surface) {
            gradient_on_surface(&random, g);
        } else {
            point_in_ball(&random, g);
            g[1] *= 15;
            g[2] *= 15;
        }
        double n = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
        for (int c = 0; c < 3; ++c)
            vectors[3 * i + (size_t)c] = (float)(g[c] / n);
    }
}
