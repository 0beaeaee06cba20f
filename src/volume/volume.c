/* SPDX-License-Identifier: MIT */
#include "volume/volume.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "base/large.h"
#include "base/names.h"
#include "base/parallel.h"
#include "base/simd.h"
#include "volume/stream.h"

static const struct {
    const char *name;
    size_t bytes;
} types[] = {
#define ISO_TYPE_ROW(name, text, ctype) [name] = {text, sizeof(ctype)},
    ISO_TYPE_LIST(ISO_TYPE_ROW)
#undef ISO_TYPE_ROW
};
static const iso_names type_names = ISO_NAMES_OF_NAMES("type", types);

const char *iso_type_name(iso_type type)
{
    return types[type].name;
}

size_t iso_type_bytes(iso_type type)
{
    return types[type].bytes;
}

iso_status iso_type_from_name(const char *name, iso_type *type, iso_error *err)
{
    size_t row = 0;
    NEED(iso_names_find(&type_names, name, &row, err));
    *type = (iso_type)row;
    return ISO_OK;
}

/* Names of files' types, besides those of iso_type. */
static const struct {
    const char *name;
    iso_type type;
    iso_form form;
} file_types[] = {{"float16", ISO_F32, ISO_FORM_HALF}, {"half", ISO_F32, ISO_FORM_HALF},
                  {"float32", ISO_F32, ISO_FORM_TYPE}, {"float64", ISO_F64, ISO_FORM_TYPE},
                  {"int64", ISO_F64, ISO_FORM_I64},    {"uint64", ISO_F64, ISO_FORM_U64}};

iso_status iso_file_type_from_name(const char *name, iso_type *type, iso_form *form, iso_error *err)
{
    char names[256];
    *form = ISO_FORM_TYPE;
    for (size_t i = 0; i < sizeof file_types / sizeof *file_types; ++i)
        if (strcmp(name, file_types[i].name) == 0) {
            *type = file_types[i].type;
            *form = file_types[i].form;
            return ISO_OK;
        }
    if (iso_type_from_name(name, type, err) == ISO_OK)
        return ISO_OK;
    return iso_fail(err, ISO_E_USAGE,
                    "unknown type \"%s\", must be one of %s, int64, uint64, float16, float32, float64", name,
                    iso_names_join(&type_names, NULL, names, sizeof names));
}

iso_status iso_volume_create(iso_volume *v, const iso_geometry *g, iso_type type, const char *name, iso_error *err)
{
    *v = (iso_volume){0};
    NEED(iso_geometry_check(g, name, err));
    size_t count = iso_geometry_voxel_count(g);
    void *data = iso_large_samples(count * iso_type_bytes(type));
    NEED_MEMORY(data, err, "%s: no memory for %zu x %zu x %zu voxels of %s (%zu bytes)", name, g->size[0], g->size[1],
                g->size[2], iso_type_name(type), count * iso_type_bytes(type));
    *v = (iso_volume){.geometry = *g, .type = type, .data = data, .notes = {.scale_slope = 1}};
    return ISO_OK;
}

void iso_volume_destroy(iso_volume *v)
{
    if (!v)
        return;
    iso_large_free(v->data);
    json_decref(v->segments);
    *v = (iso_volume){0};
}

static void to_floats(const iso_volume *v, size_t first, size_t count, float *restrict out)
{
    switch (v->type) {
/* clang-format off */
#define ISO_TYPE_CASE(name, text, ctype)                      \
    case name: {                                              \
        const ctype *restrict in = (const ctype *)v->data + first; \
        for (size_t i = 0; i < count; ++i)                    \
            out[i] = (float)in[i];                            \
        break;                                                \
    }
        /* clang-format on */
        ISO_TYPE_LIST(ISO_TYPE_CASE)
#undef ISO_TYPE_CASE
    }
}

void iso_volume_row(const iso_volume *v, size_t y, size_t z, float *restrict row)
{
    const size_t *n = v->geometry.size;
    to_floats(v, (z * n[1] + y) * n[0], n[0], row);
}

void iso_volume_floats(const iso_volume *v, float *restrict out)
{
    const size_t *n = v->geometry.size;
    size_t plane = n[0] * n[1];
#pragma omp parallel for schedule(static) num_threads(iso_threads(0))
    for (size_t z = 0; z < n[2]; ++z)
        to_floats(v, z * plane, plane, out + z * plane);
}

/* A volume is measured in this many runs of planes for any number of threads, so that sums do not depend on it. */
#define RUNS 64

typedef struct run_stats {
    double min, max, sum;
    size_t nonfinite_count, first_nonfinite, no_data_count;
} run_stats;

/* clang-format off */
#define MEASURE_INTEGERS(suffix, ctype)                                                                   \
    ISO_SIMD static void measure_##suffix(const ctype *in, size_t count, run_stats *s)                    \
    {                                                                                                     \
        enum { PART = 16384 }; /* their sum has 31 bits */                                                \
        int64_t sum = 0;                                                                                  \
        ctype min = in[0], max = in[0];                                                                   \
        for (size_t at = 0; at < count; at += PART) {                                                     \
            const size_t n = count - at < PART ? count - at : PART;                                       \
            int32_t part = 0;                                                                             \
            for (size_t i = at; i < at + n; ++i) {                                                        \
                min = in[i] < min ? in[i] : min;                                                          \
                max = in[i] > max ? in[i] : max;                                                          \
                part += in[i];                                                                            \
            }                                                                                             \
            sum += part;                                                                                  \
        }                                                                                                 \
        *s = (run_stats){.min = (double)min, .max = (double)max, .sum = (double)sum};                     \
    }
/* clang-format on */
MEASURE_INTEGERS(u8, uint8_t)
MEASURE_INTEGERS(i8, int8_t)
MEASURE_INTEGERS(u16, uint16_t)
MEASURE_INTEGERS(i16, int16_t)

/* Measures samples of 8 or 16 bits, whose sum is exact in any order. False: other types, or none. */
static bool measure_small(const iso_volume *v, size_t first, size_t count, run_stats *s)
{
    if (count == 0)
        return false;
    switch (v->type) {
    case ISO_U8: measure_u8((const uint8_t *)v->data + first, count, s); return true;
    case ISO_I8: measure_i8((const int8_t *)v->data + first, count, s); return true;
    case ISO_U16: measure_u16((const uint16_t *)v->data + first, count, s); return true;
    case ISO_I16: measure_i16((const int16_t *)v->data + first, count, s); return true;
    default: return false;
    }
}

static run_stats measure_samples(const iso_volume *v, size_t first, size_t count)
{
    run_stats s = {.min = INFINITY, .max = -INFINITY};
    if (measure_small(v, first, count, &s))
        return s;
    switch (v->type) {
/* clang-format off */
#define ISO_TYPE_CASE(name, text, ctype)                      \
    case name: {                                              \
        const ctype *in = (const ctype *)v->data + first;     \
        for (size_t i = 0; i < count; ++i) {                  \
            double value = (double)in[i];                     \
            if (!isfinite(value)) {                           \
                if (s.nonfinite_count++ == 0)                 \
                    s.first_nonfinite = first + i;            \
                continue;                                     \
            }                                                 \
            if (value == (double)ISO_NO_DATA) {               \
                ++s.no_data_count;                            \
                continue;                                     \
            }                                                 \
            s.min = value < s.min ? value : s.min;            \
            s.max = value > s.max ? value : s.max;            \
            s.sum += value;                                   \
        }                                                     \
        break;                                                \
    }
        /* clang-format on */
        ISO_TYPE_LIST(ISO_TYPE_CASE)
#undef ISO_TYPE_CASE
    }
    return s;
}

iso_volume_stats iso_volume_measure(const iso_volume *v)
{
    const size_t *n = v->geometry.size;
    size_t plane = n[0] * n[1], count = plane * n[2];
    run_stats runs[RUNS];
#pragma omp parallel for schedule(static) num_threads(iso_threads(0)) if (count > 65536)
    for (size_t r = 0; r < RUNS; ++r) {
        size_t z0 = n[2] * r / RUNS, z1 = n[2] * (r + 1) / RUNS;
        runs[r] = measure_samples(v, z0 * plane, (z1 - z0) * plane);
    }
    iso_volume_stats total = {.min = INFINITY, .max = -INFINITY};
    double sum = 0;
    for (size_t r = 0; r < RUNS; ++r) {
        if (total.nonfinite_count == 0 && runs[r].nonfinite_count > 0) {
            total.first_nonfinite[0] = runs[r].first_nonfinite % n[0];
            total.first_nonfinite[1] = runs[r].first_nonfinite / n[0] % n[1];
            total.first_nonfinite[2] = runs[r].first_nonfinite / plane;
        }
        total.nonfinite_count += runs[r].nonfinite_count;
        total.no_data_count += runs[r].no_data_count;
        total.min = fmin(total.min, runs[r].min);
        total.max = fmax(total.max, runs[r].max);
        sum += runs[r].sum;
    }
    const size_t counted = count - total.nonfinite_count - total.no_data_count;
    total.mean = counted > 0 ? sum / (double)counted : NAN;
    return total;
}

iso_status iso_volume_check_stats(const iso_volume_stats *s, const iso_geometry *g, const char *path, iso_error *err)
{
    const size_t count = iso_geometry_voxel_count(g);
    if (s->nonfinite_count > 0)
        return iso_fail(err, ISO_E_RANGE,
                        "%s: %zu of %zu voxels are NaN or infinite, none may be; the first is (%zu, %zu, %zu)", path,
                        s->nonfinite_count, count, s->first_nonfinite[0], s->first_nonfinite[1], s->first_nonfinite[2]);
    return s->no_data_count < count ? ISO_OK
                                    : iso_fail(err, ISO_E_RANGE, "%s: none of its %zu voxels has data", path, count);
}

/* Reads all planes of a source, then closes it. */
iso_status iso_volume_load_source(iso_volume_source *source, const char *path, iso_volume *v, iso_error *err)
{
    const iso_volume *header = iso_source_volume(source);
    iso_volume_notes notes = header->notes;
    json_t *segments = json_incref(header->segments);
    iso_status status = iso_volume_create(v, &header->geometry, header->type, path, err);
    TRY(status, iso_source_read(source, v->geometry.size[2], v->data, err));
    iso_source_close(source);
    if (status == ISO_OK && (v->type == ISO_F32 || v->type == ISO_F64)) {
        const iso_volume_stats s = iso_volume_measure(v);
        status = iso_volume_check_stats(&s, &v->geometry, path, err);
        v->geometry.has_no_data = s.no_data_count > 0;
    }
    if (status != ISO_OK) {
        json_decref(segments);
        iso_volume_destroy(v);
        return status;
    }
    v->notes = notes;
    v->segments = segments;
    return ISO_OK;
}

iso_status iso_volume_load(const char *path, iso_volume *v, iso_error *err)
{
    *v = (iso_volume){0};
    iso_volume_source *source;
    NEED(iso_source_open(path, &source, err));
    return iso_volume_load_source(source, path, v, err);
}

iso_status iso_volume_save(const iso_volume *v, const char *path, bool gzip, iso_error *err)
{
    iso_volume_sink *sink;
    NEED(iso_sink_open(path, v, gzip, &sink, err));
    iso_status status = iso_sink_write(sink, v->geometry.size[2], v->data, err);
    if (status == ISO_OK)
        return iso_sink_commit(sink, err);
    iso_sink_abandon(sink);
    return status;
}
