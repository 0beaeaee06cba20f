/* SPDX-License-Identifier: MIT */
#include "cli/palette_sets.h"

#include <math.h>
#include <stdlib.h>

#include "pyramid/palette_level.h"
#include "tf/presets.h"

/* Makes a table of weights, the TF's opacity over one voxel; to be freed. */
static iso_status opacity_weights(const iso_palette_arguments *a, const iso_tf *tf, const iso_geometry *g,
                                  const double range[2], iso_palette_weighting *w, float **table, iso_error *err)
{
    OWNED(iso_tf_table) t = {0};
    NEED(iso_tf_tabulate(tf, range[0], range[1], g, &t, err));
    *table = malloc(t.count * sizeof **table);
    double length = iso_geometry_mean_spacing_mm(g);
    for (size_t i = 0; *table && i < t.count; ++i)
        (*table)[i] = (float)-expm1(-(double)t.entries[4 * i + 3] * length);
    w->by_value = *table;
    w->by_value_count = t.count;
    w->by_value_lo = t.lo;
    w->by_value_hi = t.hi;
    return !(*table) ? iso_fail(err, ISO_E_MEMORY, "%s: out of memory for %zu weights", a->tf, t.count) : ISO_OK;
}

/* Reads the set of a volume's directions. Plain counts need one pass over the file and little memory; weights first
 * need the volume's range. */
iso_status iso_palette_volume_set(const iso_palette_arguments *a, const char *path, iso_direction_set *set,
                                  iso_error *err)
{
    iso_gradient_options gradient = iso_gradient_defaults();
    iso_palette_weighting w = {.by_magnitude = a->by_magnitude};
    iso_progress progress = iso_cli_progress(a->cli);
    iso_direction_pool *pool = NULL;
    iso_volume_source *source = NULL;
    iso_volume v = {0};
    OWNED(iso_tf) tf = {0};
    FREED float *table = NULL;
    gradient.threads = a->cli->threads;
    iso_status status = iso_direction_pool_create(&pool, a->cli->threads, err);
    if (status == ISO_OK && !a->tf && !a->by_magnitude) {
        status = iso_volume_input_open(path, &a->input, &source, err);
        TRY(status, iso_palette_sample_source(pool, source, &gradient, &w, &progress, err));
    } else if (status == ISO_OK) {
        status = iso_volume_input_load(path, &a->input, &v, err);
        iso_volume_stats stats = {0};
        if (status == ISO_OK)
            stats = iso_volume_measure(&v);
        w.value_span = stats.max - stats.min;
        if (status == ISO_OK && a->tf)
            status = iso_tf_of_volume(a->tf, &a->request, &v, a->cli->threads, &tf, err);
        if (status == ISO_OK && a->tf)
            status = opacity_weights(a, &tf, &v.geometry, (double[]){stats.min, stats.max}, &w, &table, err);
        TRY(status, iso_palette_sample_volume(pool, &v, &gradient, &w, &progress, err));
    }
    TRY(status, iso_direction_pool_finish(pool, set, err));
    iso_source_close(source);
    iso_volume_destroy(&v);
    iso_direction_pool_destroy(pool);
    return status;
}

iso_status iso_palette_pyramid_set(const iso_palette_arguments *a, const iso_pyramid *p, size_t first, size_t last,
                                   iso_direction_set *set, iso_error *err)
{
    const iso_level *finest = &p->levels[0];
    iso_palette_weighting w = {.by_magnitude = a->by_magnitude, .value_span = finest->max - finest->min};
    iso_direction_pool *pool = NULL;
    OWNED(iso_tf) tf = {0};
    FREED float *table = NULL;
    iso_status status = iso_direction_pool_create(&pool, a->cli->threads, err);
    if (status == ISO_OK && a->tf)
        status = iso_tf_of_level(a->tf, &a->request, NULL, finest, a->cli->threads, &tf, err);
    if (status == ISO_OK && a->tf)
        status = opacity_weights(a, &tf, &finest->geometry, (double[]){finest->min, finest->max}, &w, &table, err);
    for (size_t k = first; k <= last && status == ISO_OK; ++k) {
        const iso_level *l = &p->levels[k];
        if (a->by_magnitude && !l->magnitude) {
            status = iso_fail(err, ISO_E_RANGE,
                              "--by-magnitude: level %zu has no magnitudes; build the pyramid with --keep-magnitude",
                              k);
            break;
        }
        const float *directions;
        FREED float *owned = NULL;
        status = iso_level_directions(l, p->options.code, &directions, &owned, err);
        TRY(status, iso_palette_sample_field(pool, directions, l->scalar, l->magnitude,
                                             iso_geometry_voxel_count(&l->geometry), &w, err));
    }
    TRY(status, iso_direction_pool_finish(pool, set, err));
    iso_direction_pool_destroy(pool);
    return status;
}
