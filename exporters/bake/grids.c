/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bake/grids.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inputs.h"
#include "base/provenance.h"
#include "base/stamp.h"

/* Points this close to a visible one are active, with extinction 0: one point for renderers that interpolate between
 * active points only; for the density one more, because Cycles shifts grids by half a point within their active box. */
enum { RIM = 2 };
static long rim_of(iso_bake_grid grid)
{
    return grid == ISO_BAKE_DENSITY ? RIM : 1;
}

/* Data that the readers of a grid share. */
typedef struct grid_source {
    const iso_baked *baked;
    iso_bake_grid grid;
    double per_unit; /* factor of values per mm */
} grid_source;

static int channels_of(iso_bake_grid grid)
{
    return grid == ISO_BAKE_CD || grid == ISO_BAKE_EMISSION ? 3 : 1;
}

/* True for points that have a color; visible ones also have an extinction. */
static bool is_active(iso_bake_grid grid, const float *point)
{
    if (!point)
        return false;
    return grid == ISO_BAKE_DENSITY || grid == ISO_BAKE_EMISSION ? point[ISO_BAKE_EXTINCTION] > 0
                                                                 : point[ISO_BAKE_COLOR] >= 0;
}

static void take_values(const grid_source *s, const float *point, float *out)
{
    const double extinction = s->per_unit * (double)point[ISO_BAKE_EXTINCTION];
    if (s->grid == ISO_BAKE_DENSITY)
        out[0] = (float)extinction;
    if (s->grid == ISO_BAKE_TEMPERATURE)
        out[0] = point[ISO_BAKE_PLACE];
    for (int c = 0; c < 3 && channels_of(s->grid) == 3; ++c)
        out[c] = (float)((s->grid == ISO_BAKE_EMISSION ? extinction : 1) * (double)point[ISO_BAKE_COLOR + c]);
}

static void read_values(const void *user, size_t x, size_t y, size_t z, size_t count, float *out)
{
    const grid_source *s = user;
    const size_t channels = (size_t)channels_of(s->grid);
    memset(out, 0, count * channels * sizeof *out);
    for (size_t i = 0; i < count; ++i) {
        const float *point = iso_baked_point(s->baked, x + i, y, z);
        if (is_active(s->grid, point))
            take_values(s, point, out + channels * i);
    }
}

static bool is_visible(const iso_baked *b, long x, long y, long z)
{
    const long at[3] = {x, y, z};
    for (int a = 0; a < 3; ++a)
        if (at[a] < 0 || at[a] >= (long)b->geometry.size[a])
            return false;
    const float *point = iso_baked_point(b, (size_t)x, (size_t)y, (size_t)z);
    return point && point[ISO_BAKE_EXTINCTION] > 0;
}

/* True if a point of column x is visible, at most `rim` rows and planes from (y, z). */
static bool shows_in_column(const iso_baked *b, long rim, long x, long y, long z)
{
    bool any = false;
    for (long dz = -rim; dz <= rim && !any; ++dz)
        for (long dy = -rim; dy <= rim && !any; ++dy)
            any = is_visible(b, x, y + dy, z + dz);
    return any;
}

/* Marks the active points of a row. x, y, z count from the rim's first point; count is at most 8, a leaf's side. */
static void read_active(const void *user, size_t x, size_t y, size_t z, size_t count, unsigned char *out)
{
    const grid_source *s = user;
    const long rim = rim_of(s->grid);
    bool shows[8 + 2 * RIM] = {false};
    for (size_t i = 0; i < count + 2 * (size_t)rim; ++i)
        shows[i] = shows_in_column(s->baked, rim, (long)(x + i) - RIM - rim, (long)y - RIM, (long)z - RIM);
    for (size_t i = 0; i < count; ++i) {
        out[i] = 0;
        for (size_t k = 0; k <= 2 * (size_t)rim; ++k)
            out[i] = out[i] || shows[i + k];
    }
}

static double largest(const grid_source *s)
{
    const double *color = s->baked->color_max;
    const double most = color[0] > color[1] ? (color[0] > color[2] ? color[0] : color[2])
                                            : (color[1] > color[2] ? color[1] : color[2]);
    const double extinction = s->per_unit * s->baked->extinction_max;
    return s->grid == ISO_BAKE_DENSITY    ? extinction
           : s->grid == ISO_BAKE_CD       ? most
           : s->grid == ISO_BAKE_EMISSION ? extinction * most
                                          : 1;
}

static char *usda_path(const char *path)
{
    char *text = NULL;
    return asprintf(&text, "%.*s.usda", (int)(strlen(path) - strlen(".vdb")), path) < 0 ? NULL : text;
}

static iso_status check_name(const char *path, iso_error *err)
{
    return iso_path_ends_with(path, ".vdb") ? ISO_OK
                                            : iso_fail(err, ISO_E_USAGE, "--usd: -o is \"%s\", must end in .vdb", path);
}

iso_status iso_bake_guard_usda(const char *path, bool force, iso_error *err)
{
    NEED(check_name(path, err));
    FREED char *name = usda_path(path);
    NEED(name ? iso_inputs_announce(name, err) : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path));
    return iso_stamp_guard(name, force, err);
}

/* Writes the USD text file, with a stamp at its end because people edit it. */
static iso_status save_usda(const iso_baked *b, const iso_bake_request *r, const char *path, iso_error *err)
{
    ENDED_BY(iso_output_abandon) iso_output out = {0};
    FREED char *name = usda_path(path), *text = iso_bake_usda(b, r, path);
    NEED_MEMORY(name && text, err, "%s: out of memory", path);
    NEED(iso_output_begin(&out, name, err));
    NEED(iso_file_write(out.temp_path, text, strlen(text), err));
    NEED(iso_stamp_append(out.temp_path, "# ", err));
    return iso_output_commit(&out, err);
}

iso_status iso_bake_save(const iso_baked *b, const iso_bake_request *r, int level, const char *made_from,
                         const char *path, const iso_progress *progress, iso_error *err)
{
    grid_source sources[ISO_BAKE_GRIDS];
    iso_vdb_field fields[ISO_BAKE_GRIDS];
    size_t count = 0;
    if (r->usd && check_name(path, err) != ISO_OK)
        return ISO_E_USAGE;
    for (int i = 0; i < ISO_BAKE_GRIDS; ++i) {
        if (!r->has[i])
            continue;
        sources[count] = (grid_source){b, (iso_bake_grid)i, r->convention.unit_mm};
        fields[count] = (iso_vdb_field){.name = r->name[i],
                                        .meaning = iso_names_summary(&iso_bake_grid_names, (size_t)i),
                                        .channels = channels_of((iso_bake_grid)i),
                                        .read = read_values,
                                        .read_active = read_active,
                                        .user = &sources[count],
                                        .value_max = largest(&sources[count])};
        ++count;
    }
    const iso_vdb_fields all = {.geometry = &b->geometry,
                                .items = fields,
                                .count = count,
                                .rim = RIM,
                                .level = level,
                                .made_from = iso_provenance_name(made_from),
                                .values = b->level->is_optimized ? ISO_OPTIMIZED_VALUES : "",
                                .convention = r->convention,
                                .half_float = r->half,
                                .nanovdb = r->nanovdb};
    iso_status status = iso_vdb_save_fields(&all, path, progress, err);
    return status == ISO_OK && r->usd ? save_usda(b, r, path, err) : status;
}
