/* SPDX-License-Identifier: MIT */
#include "lab/rivals/palettes.h"

#include <math.h>

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

/* Greedy k-means++ and Lloyd. */
static iso_status fit_greedy(const iso_direction_set *set, const iso_rival_options *opt, iso_palette *palette,
                             iso_error *err)
{
    iso_random random = {opt->fit.seed};
    ENDED_BY(iso_clusters_destroy) clusters c = {0};
    NEED(iso_clusters_create(&c, set, opt->fit.directions, err));
    NEED(iso_clusters_seed_greedy(&c, &random, err));
    iso_clusters_lloyd(&c, 200);
    return iso_clusters_to_palette(&c, palette, err);
}

/* ---- all methods --------------------------------------------------------------------- */

static iso_status fit_faces(const iso_rival_options *opt, iso_palette *palette, iso_error *err)
{
    int level = 0;
    while (iso_subdivision_faces(level + 1) <= opt->fit.directions)
        ++level;
    iso_status status = iso_palette_create(palette, iso_subdivision_faces(level), err);
    TRY(status, iso_palette_subdivide(level, palette->xyz + 3, err));
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
    NEED(iso_rival_palette_check(opt, err));
    switch (opt->method) {
    case ISO_RIVAL_KMEANSPP:
        /* With an entry for each direction there is nothing to choose. */
        return set->count <= fit.directions ? iso_palette_fit(set, &fit, palette, NULL, err)
                                            : fit_greedy(set, opt, palette, err);
    case ISO_RIVAL_KMEANS:
    case ISO_RIVAL_FIBONACCI: return iso_palette_fit(set, &fit, palette, NULL, err);
    case ISO_RIVAL_ANNEAL: return iso_rival_palette_anneal(set, opt, palette, NULL, err);
    default: return fit_faces(opt, palette, err);
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
