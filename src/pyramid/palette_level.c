/* SPDX-License-Identifier: MIT */
#include "pyramid/palette_level.h"

#include <stdlib.h>

iso_status iso_level_directions(const iso_level *level, iso_code code, const float **directions, float **owned,
                                iso_error *err)
{
    size_t count = iso_geometry_voxel_count(&level->geometry);
    *owned = NULL;
    *directions = level->directions;
    if (level->directions)
        return ISO_OK;
    *directions = *owned = malloc(3 * count * sizeof **owned);
    NEED_MEMORY(*owned, err, "no memory for %zu directions", count);
    iso_code_decode_all(code, level->codes, *owned, count);
    return ISO_OK;
}

iso_status iso_level_attach_palette(iso_level *level, iso_code code, const iso_palette *palette, iso_error *err)
{
    size_t count = iso_geometry_voxel_count(&level->geometry);
    uint16_t *index = malloc(count * sizeof *index);
    iso_palette_lookup *lookup = NULL;
    const float *directions;
    FREED float *owned = NULL;
    iso_status status = index ? iso_palette_lookup_create(palette, &lookup, err)
                              : iso_fail(err, ISO_E_MEMORY, "no memory for %zu palette indices", count);
    TRY(status, iso_level_directions(level, code, &directions, &owned, err));
    if (status == ISO_OK) {
        iso_palette_assign(lookup, directions, index, count);
        level->palette = palette;
        level->palette_index = index;
    } else {
        free(index);
    }
    iso_palette_lookup_destroy(lookup);
    return status;
}

void iso_level_detach_palette(iso_level *level)
{
    free((void *)level->palette_index);
    level->palette = NULL;
    level->palette_index = NULL;
}

iso_status iso_level_fit_palette(const iso_level *level, iso_code code, size_t directions, size_t swap_trials,
                                 int threads, iso_palette *palette, iso_error *err)
{
    iso_palette_options opt = iso_palette_defaults();
    OWNED(iso_direction_set) set = {0};
    iso_direction_pool *pool;
    const float *vectors;
    FREED float *owned = NULL;
    opt.directions = directions;
    opt.swap_trials = swap_trials;
    *palette = (iso_palette){0};
    NEED(iso_level_directions(level, code, &vectors, &owned, err));
    iso_status status = iso_direction_pool_create(&pool, threads, err);
    if (status == ISO_OK) {
        iso_direction_pool_add(pool, vectors, NULL, iso_geometry_voxel_count(&level->geometry));
        status = iso_direction_pool_finish(pool, &set, err);
    }
    TRY(status, iso_palette_fit(&set, &opt, palette, NULL, err));
    iso_direction_pool_destroy(pool);
    return status;
}
