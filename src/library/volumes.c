/* SPDX-License-Identifier: MIT */
/* volumes.c - grids and volumes of the library's interface. */
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "library/shared.h"
#include "volume/half.h"
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

static iso_geometry geometry_of_grid(const iso_grid *grid)
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
    const iso_geometry g = geometry_of_grid(grid);
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

static iso_status open_by(const char *path, const iso_volume_input *input, iso_volume **volume, iso_error *err)
{
    *volume = calloc(1, sizeof **volume);
    return *volume ? volume_or_nothing(iso_volume_input_load(path, input, *volume, err), volume) : no_memory(err);
}

iso_status iso_volume_open(const char *path, iso_volume **volume, iso_error *err)
{
    return open_by(path, &(iso_volume_input){0}, volume, err);
}

iso_status iso_volume_open_with(const char *path, const iso_open_options *options, iso_volume **volume, iso_error *err)
{
    static const iso_open_options none;
    const iso_open_options *o = options ? options : &none;
    char size[80], spacing[100];
    snprintf(size, sizeof size, "%zux%zux%zu", o->raw_size[0], o->raw_size[1], o->raw_size[2]);
    snprintf(spacing, sizeof spacing, "%.17gx%.17gx%.17g", o->spacing[0], o->spacing[1], o->spacing[2]);
    const bool is_raw = o->raw_size[0] || o->raw_size[1] || o->raw_size[2],
               is_spaced = o->spacing[0] != 0 || o->spacing[1] != 0 || o->spacing[2] != 0;
    const iso_volume_input input = {.series = (char *)o->series,
                                    .frame = (char *)o->frame,
                                    .channel = (char *)o->channel,
                                    .unit = (char *)o->unit,
                                    .spacing = is_spaced ? spacing : NULL,
                                    .raw_size = is_raw ? size : NULL,
                                    .raw_type = (char *)o->raw_type,
                                    .raw_skip_bytes = o->raw_skip_bytes > LONG_MAX ? LONG_MAX : (long)o->raw_skip_bytes,
                                    .raw_big_endian = o->raw_is_big_endian,
                                    .stored = o->stored,
                                    .labels = o->labels > 0,
                                    .no_labels = o->labels < 0,
                                    .resample = o->resample,
                                    .force_spacing = o->force_spacing,
                                    .no_data = (char *)o->no_data};
    return open_by(path, &input, volume, err);
}

/* Marks NaN as no data, and checks the samples. */
static iso_status take_no_data(iso_volume *v, iso_error *err)
{
    const size_t count = iso_geometry_voxel_count(&v->geometry);
    float *floats = v->type == ISO_F32 ? v->data : NULL;
    double *doubles = v->type == ISO_F64 ? v->data : NULL;
    for (size_t i = 0; floats && i < count; ++i)
        floats[i] = isnan(floats[i]) ? ISO_NO_DATA : floats[i];
    for (size_t i = 0; doubles && i < count; ++i)
        doubles[i] = isnan(doubles[i]) ? (double)ISO_NO_DATA : doubles[i];
    const iso_volume_stats s = iso_volume_measure(v);
    v->geometry.has_no_data = s.no_data_count > 0;
    return iso_volume_check_stats(&s, &v->geometry, "the volume from memory", err);
}

/* Converts a sample. Returns whether the stored type holds its value. */
typedef bool (*sample_conversion)(const void *from, void *to);

static bool from_bool(const void *from, void *to)
{
    *(uint8_t *)to = *(const uint8_t *)from != 0;
    return true;
}

static bool from_half(const void *from, void *to)
{
    uint16_t half;
    memcpy(&half, from, sizeof half);
    *(float *)to = iso_half_to_float(half);
    return true;
}

#define MOST_EXACT ((int64_t)1 << 53)

static bool from_int64(const void *from, void *to)
{
    int64_t value;
    memcpy(&value, from, sizeof value);
    *(double *)to = (double)value;
    return value >= -MOST_EXACT && value <= MOST_EXACT;
}

static bool from_uint64(const void *from, void *to)
{
    uint64_t value;
    memcpy(&value, from, sizeof value);
    *(double *)to = (double)value;
    return value <= MOST_EXACT;
}

/* Types of arrays that volumes do not have, and the ones that they are stored in. */
static const struct array_type {
    const char *name;
    size_t bytes;
    iso_type stored;
    sample_conversion convert;
} array_types[] = {{"bool", 1, ISO_U8, from_bool},
                   {"float16", 2, ISO_F32, from_half},
                   {"int64", 8, ISO_F64, from_int64},
                   {"uint64", 8, ISO_F64, from_uint64}};

static iso_status array_type_from_name(const char *name, struct array_type *type, iso_error *err)
{
    for (size_t i = 0; i < sizeof array_types / sizeof *array_types; ++i)
        if (strcmp(name, array_types[i].name) == 0) {
            *type = array_types[i];
            return ISO_OK;
        }
    *type = (struct array_type){.name = name};
    NEED(iso_type_from_name(name, &type->stored, err));
    type->bytes = iso_type_bytes(type->stored);
    return ISO_OK;
}

/* Copies the samples of a row, `stride` bytes apart. Returns the number of those before the first that the stored type
 * cannot hold. */
static size_t copy_row(const struct array_type *type, const char *from, ptrdiff_t stride, size_t count, char *to)
{
    const size_t bytes = iso_type_bytes(type->stored);
    if (!type->convert && stride == (ptrdiff_t)bytes) {
        memcpy(to, from, count * bytes);
        return count;
    }
    for (size_t i = 0; i < count; ++i) {
        const char *sample = from + (ptrdiff_t)i * stride;
        if (!type->convert)
            memcpy(to + i * bytes, sample, bytes);
        else if (!type->convert(sample, to + i * bytes))
            return i;
    }
    return count;
}

static iso_status copy_samples(const struct array_type *type, const char *samples, const ptrdiff_t strides[3],
                               iso_volume *v, iso_error *err)
{
    const size_t *n = v->geometry.size, bytes = iso_type_bytes(type->stored);
    for (size_t z = 0; z < n[2]; ++z)
        for (size_t y = 0; y < n[1]; ++y) {
            const char *row = samples + (ptrdiff_t)y * strides[1] + (ptrdiff_t)z * strides[2];
            const size_t done = copy_row(type, row, strides[0], n[0], (char *)v->data + (z * n[1] + y) * n[0] * bytes);
            if (done < n[0])
                return iso_fail(err, ISO_E_RANGE,
                                "sample (%zu, %zu, %zu) of type %s is beyond 2^53, which a double holds", done, y, z,
                                type->name);
        }
    return take_no_data(v, err);
}

iso_status iso_volume_from_array(const iso_grid *grid, const char *type, const void *samples,
                                 const ptrdiff_t strides[3], iso_volume **volume, iso_error *err)
{
    const iso_geometry g = geometry_of_grid(grid);
    struct array_type which;
    *volume = NULL;
    NEED(array_type_from_name(type, &which, err));
    *volume = calloc(1, sizeof **volume);
    if (!*volume)
        return no_memory(err);
    iso_status status = iso_volume_create(*volume, &g, which.stored, "the volume from memory", err);
    TRY(status, copy_samples(&which, samples, strides, *volume, err));
    if (status != ISO_OK)
        iso_volume_destroy(*volume);
    return volume_or_nothing(status, volume);
}

iso_status iso_volume_from_memory(const iso_grid *grid, const char *type, const void *samples, iso_volume **volume,
                                  iso_error *err)
{
    struct array_type which;
    *volume = NULL;
    NEED(array_type_from_name(type, &which, err));
    const size_t row = which.bytes * grid->size[0];
    return iso_volume_from_array(grid, type, samples,
                                 (ptrdiff_t[3]){(ptrdiff_t)which.bytes, (ptrdiff_t)row,
                                                (ptrdiff_t)(row * grid->size[1])},
                                 volume, err);
}

iso_grid iso_volume_grid(const iso_volume *volume)
{
    return iso_grid_of_geometry(&volume->geometry);
}

const char *iso_volume_type(const iso_volume *volume)
{
    return iso_type_name(volume->type);
}

const void *iso_volume_samples(const iso_volume *volume)
{
    return volume->data;
}

void iso_volume_values(const iso_volume *volume, float *values)
{
    iso_volume_floats(volume, values);
}

void iso_volume_free(iso_volume *volume)
{
    iso_volume_destroy(volume);
    free(volume);
}
