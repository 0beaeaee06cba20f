/* SPDX-License-Identifier: MIT */
#include "volume/labels.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "volume/segments.h"

/* Range of values that are found by a table, others by a hash; the number of changes after which intensities are
 * certain; and the largest distance of two labels in a transfer function (doc/reference/label-maps.md). */
enum { LOWEST = -32768, VALUE_COUNT = 32768 + 65536, KNOWN_AFTER = 20000, ROOM = ISO_LABELS_MAX_COUNT + 1,
       FAR_COUNT = 8192, MOST_APART = 16383 };

typedef struct label_probe {
    uint16_t id[VALUE_COUNT]; /* 0: not seen; others by the order of appearance, from 1 */
    struct far_value {
        double value;
        uint16_t id;
    } far[FAR_COUNT];         /* values beyond `id` */
    double value[ROOM + 1];   /* of an id */
    size_t count;
    uint32_t changes[ROOM + 1][ROOM + 1]; /* from id to id, of neighbors along an axis */
    size_t changed;                       /* all of them */
    size_t once, twice;
    bool is_known; /* not to be labels */
    bool has_too_many, reads_all;
    size_t size[3];
    uint16_t *plane[3]; /* ids of this plane and the two before it */
} label_probe;

/* Returns the id of a value, to be set if it is 0. The table is never full: there are fewer values. */
static uint16_t *id_of(label_probe *p, double value)
{
    if (value >= LOWEST && value < LOWEST + VALUE_COUNT)
        return &p->id[(size_t)(value - LOWEST)];
    size_t at = (size_t)((uint64_t)(int64_t)value * 0x9E3779B97F4A7C15u >> 51);
    while (p->far[at].id != 0 && p->far[at].value != value)
        at = (at + 1) % FAR_COUNT;
    p->far[at].value = value;
    return &p->far[at].id;
}

static bool take_ids(label_probe *p, const iso_volume *plane, uint16_t *ids)
{
    const size_t n = p->size[0] * p->size[1];
/* clang-format off */
#define ISO_LABEL_CASE(name, text, ctype)                                           \
    case name:                                                                      \
        for (size_t i = 0; i < n; ++i) {                                            \
            const double value = (double)((const ctype *)plane->data)[i];           \
            uint16_t *id = id_of(p, value);                                         \
            if (*id == 0) {                                                         \
                if (p->count == ROOM - 1)                                           \
                    return false;                                                   \
                *id = (uint16_t)++p->count;                                         \
                p->value[*id] = value;                                              \
            }                                                                       \
            ids[i] = *id;                                                           \
        }                                                                           \
        break;
    /* clang-format on */
    switch (plane->type) {
        ISO_TYPE_LIST(ISO_LABEL_CASE)
    }
#undef ISO_LABEL_CASE
    return true;
}

static void look_at_three(label_probe *p, uint16_t a, uint16_t b, uint16_t c)
{
    const int changes = (a != b) + (b != c);
    p->once += changes == 1;
    p->twice += changes == 2;
    if (b != c) {
        ++p->changes[b][c];
        ++p->changed;
    }
}

static void look_at_plane(label_probe *p, size_t z)
{
    const size_t nx = p->size[0], ny = p->size[1];
    const uint16_t *now = p->plane[0], *before = p->plane[1], *first = p->plane[2];
    for (size_t y = 0; y < ny; ++y)
        for (size_t x = 0; x < nx; ++x) {
            const uint16_t *at = now + y * nx + x;
            if (x >= 2)
                look_at_three(p, at[-2], at[-1], at[0]);
            if (y >= 2)
                look_at_three(p, at[-2 * (ptrdiff_t)nx], at[-(ptrdiff_t)nx], at[0]);
            if (z >= 2)
                look_at_three(p, first[y * nx + x], before[y * nx + x], at[0]);
        }
}

/* Takes the next plane; false if no more are needed. */
static bool feed(label_probe *p, const iso_volume *plane, size_t z)
{
    uint16_t *oldest = p->plane[2];
    p->plane[2] = p->plane[1];
    p->plane[1] = p->plane[0];
    p->plane[0] = oldest;
    p->has_too_many = p->is_known = !take_ids(p, plane, oldest);
    if (p->is_known)
        return false;
    look_at_plane(p, z);
    p->is_known = !p->reads_all && p->once + p->twice > KNOWN_AFTER &&
                  (double)p->twice > 2 * ISO_LABELS_MAX_TWICE * (double)(p->once + p->twice);
    return !p->is_known;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Returns the part of all changes that goes to the next existing value. */
static double part_to_next(label_probe *p, double sorted[ROOM])
{
    double next = 0;
    memcpy(sorted, p->value + 1, p->count * sizeof *sorted);
    qsort(sorted, p->count, sizeof *sorted, by_value);
    for (size_t i = 0; i + 1 < p->count; ++i) {
        const uint16_t a = *id_of(p, sorted[i]), b = *id_of(p, sorted[i + 1]);
        next += (double)p->changes[a][b] + (double)p->changes[b][a];
    }
    return p->changed > 0 ? next / (double)p->changed : 0;
}

static void conclude(label_probe *p, size_t voxels, iso_label_facts *f)
{
    const double all = (double)(p->once + p->twice);
    f->count = p->count;
    f->twice = all > 0 ? (double)p->twice / all : 0;
    f->next = part_to_next(p, f->value);
    if (p->count > 0) {
        const double lo = f->value[0], hi = f->value[p->count - 1];
        f->is_far = lo < LOWEST || hi >= LOWEST + VALUE_COUNT;
        f->is_sparse = f->is_far || hi - lo > MOST_APART;
    }
    f->has_too_many = p->has_too_many;
    f->is_map = !p->is_known && p->count >= ISO_LABELS_MIN_COUNT && p->count <= ISO_LABELS_MAX_COUNT &&
                p->count * ISO_LABELS_MIN_VOXELS <= voxels && f->twice <= ISO_LABELS_MAX_TWICE &&
                f->next <= ISO_LABELS_MAX_NEXT;
}

static void destroy(label_probe *p)
{
    for (int i = 0; p && i < 3; ++i)
        free(p->plane[i]);
    free(p);
}

static label_probe *create(const iso_geometry *g, bool all)
{
    label_probe *p = calloc(1, sizeof *p);
    bool well = p != NULL;
    for (int i = 0; well && i < 3; ++i)
        well = (p->plane[i] = calloc(g->size[0] * g->size[1], sizeof *p->plane[i])) != NULL;
    if (well) {
        memcpy(p->size, g->size, sizeof p->size);
        p->reads_all = all;
        return p;
    }
    destroy(p);
    return NULL;
}

static iso_status no_memory(iso_error *err)
{
    return iso_fail(err, ISO_E_MEMORY, "no memory to look for labels");
}

iso_status iso_labels_look(iso_volume_source *source, bool all, iso_label_facts *facts, iso_error *err)
{
    iso_volume plane = *iso_source_volume(source);
    const size_t *n = plane.geometry.size;
    *facts = (iso_label_facts){0};
    if (plane.type == ISO_F32 || plane.type == ISO_F64)
        return ISO_OK;
    label_probe *p = create(&plane.geometry, all);
    plane.data = malloc(n[0] * n[1] * iso_type_bytes(plane.type));
    iso_status status = p && plane.data ? ISO_OK : no_memory(err);
    for (size_t z = 0; z < n[2] && status == ISO_OK; ++z) {
        status = iso_source_read(source, 1, plane.data, err);
        if (status != ISO_OK || !feed(p, &plane, z))
            break;
    }
    if (status == ISO_OK)
        conclude(p, iso_geometry_voxel_count(&plane.geometry), facts);
    free(plane.data);
    destroy(p);
    return status;
}

iso_status iso_labels_look_at(const iso_volume *v, bool all, iso_label_facts *facts, iso_error *err)
{
    const size_t *n = v->geometry.size, bytes = n[0] * n[1] * iso_type_bytes(v->type);
    *facts = (iso_label_facts){0};
    if (v->type == ISO_F32 || v->type == ISO_F64)
        return ISO_OK;
    label_probe *p = create(&v->geometry, all);
    iso_volume plane = *v;
    if (!p)
        return no_memory(err);
    for (size_t z = 0; z < n[2]; ++z) {
        plane.data = (char *)v->data + z * bytes;
        if (!feed(p, &plane, z))
            break;
    }
    conclude(p, iso_geometry_voxel_count(&v->geometry), facts);
    destroy(p);
    return ISO_OK;
}

/* ---- numbers instead of values ---- */

/* Returns the number of value i: 0 becomes 0, and no other value does. */
static int number_of(const iso_label_facts *f, size_t i)
{
    size_t below = 0;
    while (below < f->count && f->value[below] < 0)
        ++below;
    const bool has_zero = below < f->count && f->value[below] == 0;
    return (int)i - (int)below + (i >= below && !has_zero);
}

json_t *iso_labels_names(const iso_label_facts *f, const json_t *given)
{
    json_t *list = json_array();
    for (size_t i = 0; i < f->count; ++i) {
        const long value = (long)f->value[i];
        const json_t *named = iso_segments_find(given, value);
        char name[24];
        if (value == 0 && !named)
            continue;
        snprintf(name, sizeof name, "%ld", value);
        json_t *segment = named ? json_deep_copy(named) : json_pack("{s:s}", "name", name);
        json_object_set_new(segment, "label", json_integer(number_of(f, i)));
        json_object_set_new(segment, "id", json_integer(value));
        json_array_append_new(list, segment);
    }
    return list;
}

void iso_labels_number(iso_volume *v, const iso_label_facts *f)
{
    const size_t count = iso_geometry_voxel_count(&v->geometry);
    int16_t *out = v->data; /* not wider than the samples, so that each is read before its place is written */
    double last = NAN;
    int number = 0;
/* clang-format off */
#define ISO_NUMBER_CASE(name, text, ctype)                                                                \
    case name:                                                                                            \
        for (size_t i = 0; i < count; ++i) {                                                              \
            ctype sample;                                                                                 \
            memcpy(&sample, (const char *)v->data + i * sizeof sample, sizeof sample);                    \
            const double value = (double)sample;                                                          \
            if (value != last) {                                                                          \
                const double *at = bsearch(&value, f->value, f->count, sizeof *f->value, by_value);       \
                number = at ? number_of(f, (size_t)(at - f->value)) : 0;                                  \
                last = value;                                                                             \
            }                                                                                             \
            const int16_t label = (int16_t)number;                                                        \
            memcpy((char *)out + i * sizeof label, &label, sizeof label);                                 \
        }                                                                                                 \
        break;
    /* clang-format on */
    switch (v->type) {
        ISO_TYPE_LIST(ISO_NUMBER_CASE)
    }
#undef ISO_NUMBER_CASE
    json_t *names = iso_labels_names(f, v->segments);
    json_decref(v->segments);
    v->segments = names;
    v->type = ISO_I16;
}
