/* SPDX-License-Identifier: MIT */
/* volumes.c - grids and volumes of the library's interface. */
#include <stdlib.h>
#include <string.h>

#include "library/shared.h"
#include "volume/input.h"

iso_grid iso_grid_of_geometry(const iso_geometry *g)
{
    iso_grid grid = {.size = {g->size[0], g->size[1], g->size[2]},
                     .box_index = {g->box_index[0], g->box_index[1], g->box_index[2]}};
    const double origin_mm[3] = {g->origin_mm.x, g->origin_mm.y, g->origin_mm.z};
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            grid.index_to_world[row][column] = g->index_to_world.m[row][column];
        grid.index_to_world[row][3] = origin_mm[row];
    }
    return grid;
}

iso_geometry iso_geometry_of_grid(const iso_grid *grid)
{
    const double(*m)[4] = grid->index_to_world;
    iso_geometry g = {.origin_mm = {m[0][3], m[1][3], m[2][3]}};
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            g.index_to_world.m[row][column] = m[row][column];
        g.size[row] = grid->size[row];
        g.box_index[row] = grid->box_index[row] > 0 ? grid->box_index[row] : (double)grid->size[row];
    }
    return g;
}

iso_grid iso_grid_axis_aligned(const size_t size[3], const double spacing_mm[3])
{
    const iso_geometry g = iso_geometry_axis_aligned(size, spacing_mm);
    return iso_grid_of_geometry(&g);
}

void iso_grid_spacing_mm(const iso_grid *grid, double spacing_mm[3])
{
    const iso_geometry g = iso_geometry_of_grid(grid);
    iso_geometry_spacing_mm(&g, spacing_mm);
}

static iso_status no_memory(iso_error *err)
{
    return iso_fail(err, ISO_E_MEMORY, "out of memory");
}

/* Frees *volume and sets it to NULL unless the status is ISO_OK. */
static iso_status volume_or_nothing(iso_status status, iso_volume **volume)
{
    if (status != ISO_OK) {
        free(*volume);
        *volume = NULL;
    }
    return status;
}

iso_status iso_volume_open(const char *path, iso_volume **volume, iso_error *err)
{
    *volume = calloc(1, sizeof **volume);
    return *volume ? volume_or_nothing(iso_volume_input_load(path, &(iso_volume_input){0}, *volume, err), volume)
                   : no_memory(err);
}

static iso_status check_finite(const iso_volume *v, iso_error *err)
{
    const iso_volume_stats s = iso_volume_measure(v);
    if (s.nonfinite_count == 0)
        return ISO_OK;
    return iso_fail(err, ISO_E_RANGE,
                    "%zu of %zu samples are NaN or infinite, none may be; the first is (%zu, %zu, %zu)",
                    s.nonfinite_count, iso_geometry_voxel_count(&v->geometry), s.first_nonfinite[0],
                    s.first_nonfinite[1], s.first_nonfinite[2]);
}

iso_status iso_volume_from_memory(const iso_grid *grid, const char *type, const void *samples, iso_volume **volume,
                                  iso_error *err)
{
    const iso_geometry g = iso_geometry_of_grid(grid);
    iso_type which = ISO_U8;
    *volume = NULL;
    iso_status status = iso_type_from_name(type, &which, err);
    if (status != ISO_OK)
        return status;
    *volume = calloc(1, sizeof **volume);
    if (!*volume)
        return no_memory(err);
    status = iso_volume_create(*volume, &g, which, "the volume from memory", err);
    if (status == ISO_OK) {
        memcpy((*volume)->data, samples, iso_geometry_voxel_count(&g) * iso_type_bytes(which));
        status = check_finite(*volume, err);
        if (status != ISO_OK)
            iso_volume_destroy(*volume);
    }
    return volume_or_nothing(status, volume);
}

iso_grid iso_volume_grid(const iso_volume *volume)
{
    return iso_grid_of_geometry(&volume->geometry);
}

void iso_volume_free(iso_volume *volume)
{
    iso_volume_destroy(volume);
    free(volume);
}
