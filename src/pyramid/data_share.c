/* SPDX-License-Identifier: MIT */
/* data_share.c - coarse voxels that only partly have data. Their value is the mean of the part, and their extinction is
 * scaled by its share of the voxel: a scale of one half where every second fine voxel has none. Shares are means of
 * eight, like the levels, so sizes that are odd repeat their last plane. */
#include <stdlib.h>
#include <string.h>

#include "pyramid/filter_kernel.h"
#include "pyramid/narrow.h"
#include "pyramid/pyramid_layout.h"

/* The shares of a level: numbers, or those of level 0, which are 0 or 1. */
typedef struct level_shares {
    const iso_level *level;
    const iso_volume *volume; /* level 0's samples, if it has none */
    const float *numbers;
} level_shares;

static void read_row(const level_shares *s, size_t y, size_t z, float *row)
{
    const size_t *n = s->level->geometry.size, first = (z * n[1] + y) * n[0];
    if (s->numbers) {
        memcpy(row, s->numbers + first, n[0] * sizeof *row);
        return;
    }
    iso_level_scalars(s->level, s->volume, first, n[0], row);
    for (size_t i = 0; i < n[0]; ++i)
        row[i] = iso_is_no_data(row[i]) ? 0 : 1;
}

/* Computes the shares of the next level. rows: memory of three rows of n[0] + 1. */
static void average(const level_shares *s, const size_t size[3], float *rows, float *out)
{
    const size_t *n = s->level->geometry.size;
    float *sum[2] = {rows, rows + n[0] + 1}, *row = rows + 2 * (n[0] + 1);
    for (size_t i = 0; i < size[1] * size[2]; ++i) {
        const size_t y = 2 * (i % size[1]), z = 2 * (i / size[1]);
        for (size_t half = 0; half < 2; ++half) {
            const size_t at = z + half < n[2] ? z + half : z;
            read_row(s, y, at, sum[half]);
            read_row(s, y + 1 < n[1] ? y + 1 : y, at, row);
            iso_accumulate_row(row, n[0], sum[half], true);
        }
        iso_mean_row(sum[0], sum[1], n[0], out + i * size[0]);
    }
}

/* Gives the level its bytes, or none if all its voxels with data have it wholly. Without data nothing shows, so that
 * byte is any. */
static bool store(iso_level *l, const float *shares)
{
    const size_t count = iso_geometry_voxel_count(&l->geometry);
    bool is_partial = false;
    for (size_t i = 0; i < count && !is_partial; ++i)
        is_partial = shares[i] > 0 && shares[i] < 1;
    if (!is_partial)
        return true;
    l->scale = malloc(count);
    for (size_t i = 0; l->scale && i < count; ++i)
        l->scale[i] = iso_extinction_scale_byte(shares[i] > 0 ? log2((double)shares[i]) : 0);
    return l->scale != NULL;
}

iso_status iso_pyramid_scale_by_share(iso_pyramid *p, const iso_volume *volume, iso_error *err)
{
    float *numbers = NULL;
    bool well = true;
    if (!p->levels[0].geometry.has_no_data || p->levels[0].labels)
        return ISO_OK;
    for (size_t k = 1; k < p->level_count && well; ++k) {
        const level_shares finer = {&p->levels[k - 1], volume, numbers};
        const size_t *size = p->levels[k].geometry.size;
        float *own = malloc(iso_geometry_voxel_count(&p->levels[k].geometry) * sizeof *own),
              *rows = malloc(3 * (p->levels[k - 1].geometry.size[0] + 1) * sizeof *rows);
        well = own && rows;
        if (well)
            average(&finer, size, rows, own);
        well = well && (p->levels[k].scale || store(&p->levels[k], own));
        free(rows);
        free(numbers);
        numbers = own;
    }
    free(numbers);
    return well ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "%s: no memory for shares of voxels with data", p->source);
}
