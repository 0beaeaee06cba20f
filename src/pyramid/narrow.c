/* SPDX-License-Identifier: MIT */
#include "pyramid/narrow.h"

#include <stdlib.h>
#include <string.h>

#include "base/simd.h"
#include "pyramid/cascade_kernel.h"

ISO_SIMD void iso_level_scalars(const iso_level *level, const iso_volume *volume, size_t first, size_t count,
                                float *restrict out)
{
    if (level->scalar) {
        memcpy(out, level->scalar + first, count * sizeof *out);
        return;
    }
    switch (volume->type) {
/* clang-format off */
#define ISO_TYPE_CASE(name, text, ctype)                                \
    case name: {                                                        \
        const ctype *restrict in = (const ctype *)volume->data + first; \
        for (size_t i = 0; i < count; ++i)                              \
            out[i] = (float)in[i];                                      \
        break;                                                          \
    }
        /* clang-format on */
        ISO_TYPE_LIST(ISO_TYPE_CASE)
#undef ISO_TYPE_CASE
    }
}

void iso_level_file_scalars(const iso_level *level, const iso_volume *volume, size_t first, size_t count,
                            float *restrict out)
{
    iso_level_scalars(level, volume, first, count, out);
    const float stand_in = iso_level_stand_in(level, ISO_STAND_IN_FILE);
    for (size_t i = 0; level->geometry.has_no_data && i < count; ++i)
        out[i] = iso_is_no_data(out[i]) ? stand_in : out[i];
}

/* ---- codes of a box ---- */

iso_status iso_narrow_codes_begin(iso_narrow_codes *c, const iso_pyramid *p, const iso_volume *v, iso_error *err)
{
    double range = 0;
    *c = (iso_narrow_codes){.volume = v, .options = p->options};
    c->options.level_count = 1;
    c->options.keep_float = c->options.keep_magnitude = false;
    /* Level 0 does not depend on filters: these are cheap. */
    c->options.scalar_filter = ISO_SCALAR_MEAN;
    c->options.direction_filter = ISO_DIRECTION_NAIVE;
    NEED(iso_pyramid_sample_range(v, p->source, &range, err));
    c->scale = iso_cascade_scale(&v->geometry, range);
    return ISO_OK;
}

/* Widens the box by the stencil of its gradients. The box keeps enough voxels that a border never meets the opposite
 * one. */
static void widen(const iso_narrow_codes *c, const size_t first[3], const size_t end[3], size_t from[3], size_t size[3])
{
    enum { LEAST = 2 * ISO_GRADIENT_MOST_REACH };
    const size_t reach = iso_gradient_describe(c->options.gradient.method)->reach;
    for (int a = 0; a < 3; ++a) {
        const size_t n = c->volume->geometry.size[a];
        size_t to = end[a] + reach < n ? end[a] + reach : n;
        from[a] = first[a] > reach ? first[a] - reach : 0;
        if (to - from[a] < LEAST)
            to = from[a] + LEAST < n ? from[a] + LEAST : n;
        if (to - from[a] < LEAST)
            from[a] = to > LEAST ? to - LEAST : 0;
        size[a] = to - from[a];
    }
}

static void copy_box(const iso_volume *v, const size_t first[3], const size_t size[3], char *to)
{
    const size_t *n = v->geometry.size, bytes = iso_type_bytes(v->type);
    for (size_t z = 0; z < size[2]; ++z)
        for (size_t y = 0; y < size[1]; ++y, to += bytes * size[0])
            memcpy(to, (const char *)v->data + bytes * (first[0] + n[0] * (first[1] + y + n[1] * (first[2] + z))),
                   bytes * size[0]);
}

/* Returns the samples of the box; NULL: no memory. Whole planes are used in place; other boxes are copied to `*own`. */
static const void *box_samples(const iso_narrow_codes *c, void **own)
{
    const size_t *n = c->volume->geometry.size, *size = c->size, bytes = iso_type_bytes(c->volume->type);
    const char *data = c->volume->data;
    *own = NULL;
    if (size[0] == n[0] && size[1] == n[1])
        return data + bytes * n[0] * n[1] * c->first[2];
    *own = malloc(bytes * size[0] * size[1] * size[2]);
    if (*own)
        copy_box(c->volume, c->first, size, *own);
    return *own;
}

static iso_status make_codes(iso_narrow_codes *c, const void *samples, iso_error *err)
{
    const size_t *size = c->size;
    const iso_planes planes = {samples, c->volume->type, {size[0], size[1], size[2]},
                               0,       size[2],         c->volume->geometry.has_no_data};
    const iso_cascade_out out = {.codes = c->codes};
    iso_geometry g = c->volume->geometry;
    iso_cascade *cascade;
    memcpy(g.size, size, sizeof g.size);
    iso_status status = iso_cascade_create(&g, &c->options, c->scale, &cascade, err);
    TRY(status, iso_cascade_feed(cascade, &planes, 0, size[2], &out, err));
    iso_cascade_destroy(cascade);
    return status;
}

iso_status iso_narrow_codes_make(iso_narrow_codes *c, const size_t first[3], const size_t end[3], iso_error *err)
{
    FREED void *own = NULL;
    widen(c, first, end, c->first, c->size);
    const size_t bytes = 3 * c->size[0] * c->size[1] * c->size[2];
    if (bytes > c->codes_bytes) {
        free(c->codes);
        c->codes = malloc(bytes);
        c->codes_bytes = c->codes ? bytes : 0;
    }
    const void *samples = c->codes ? box_samples(c, &own) : NULL;
    return samples ? make_codes(c, samples, err)
                   : iso_fail(err, ISO_E_MEMORY, "no memory for directions of %zu x %zu x %zu voxels", c->size[0],
                              c->size[1], c->size[2]);
}

void iso_narrow_codes_destroy(iso_narrow_codes *c)
{
    free(c->codes);
    *c = (iso_narrow_codes){0};
}

/* ---- codes of small boxes ---- */

enum { PLANE_ROWS = 3 + 3 + 1 + 1 }; /* floats of a voxel in `plane` below */

struct iso_box_codes {
    const iso_volume *volume;
    iso_cascade *cascade; /* of a box of `size` voxels */
    size_t size[3], reach;
    void *samples; /* owned, as the rest */
    float *scratch;
    emit_rows row, plane; /* a row of the box; directions of a plane, which are encoded together */
};

iso_status iso_level_gradient_scale(const iso_level *level, double *scale, iso_error *err)
{
    double range = 0;
    NEED(iso_pyramid_sample_range(level->samples, "level 0", &range, err));
    *scale = iso_cascade_scale(&level->geometry, range);
    return ISO_OK;
}

iso_status iso_box_codes_create(const iso_level *level, iso_code code, double scale, size_t side, iso_box_codes **out,
                                iso_error *err)
{
    iso_box_codes *b = *out = calloc(1, sizeof *b);
    NEED_MEMORY(b, err, "no memory for directions");
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.gradient.method = level->estimator;
    opt.code = code;
    opt.level_count = 1;
    b->volume = level->samples;
    b->reach = iso_gradient_describe(level->estimator)->reach;
    iso_geometry g = level->geometry;
    for (int a = 0; a < 3; ++a) {
        const size_t most = side + 2 * b->reach;
        g.size[a] = b->size[a] = most < g.size[a] ? most : g.size[a];
    }
    iso_status status = iso_cascade_create(&g, &opt, scale, &b->cascade, err);
    if (status == ISO_OK) {
        b->samples = malloc(iso_type_bytes(level->samples->type) * b->size[0] * b->size[1] * b->size[2]);
        b->scratch = malloc((iso_emit_rows_count(b->cascade) + PLANE_ROWS * (side * side + 32)) * sizeof *b->scratch);
        if (!b->samples || !b->scratch)
            status = iso_fail(err, ISO_E_MEMORY, "no memory for directions of boxes of %zu voxels a side", side);
    }
    if (status == ISO_OK) {
        scratch s = {b->scratch};
        b->row = iso_take_emit_rows(b->cascade, &s);
        for (int a = 0; a < 3; ++a)
            b->plane.d[a] = take(&s, side * side);
        b->plane.interleaved = take(&s, 3 * side * side);
        b->plane.packed = (uint32_t *)(void *)take(&s, side * side);
        b->plane.bytes = (uint8_t *)take(&s, side * side + 16);
        return ISO_OK;
    }
    iso_box_codes_destroy(b);
    *out = NULL;
    return status;
}

void iso_box_codes_destroy(iso_box_codes *b)
{
    if (!b)
        return;
    iso_cascade_destroy(b->cascade);
    free(b->samples);
    free(b->scratch);
    free(b);
}

void iso_box_codes_make(iso_box_codes *b, const size_t first[3], const size_t count[3], uint8_t *codes)
{
    const iso_geometry *g = &b->volume->geometry;
    const size_t *n = g->size, *size = b->size;
    size_t from[3];
    /* All boxes have the same size: one at a border reaches farther to the other side. */
    for (int a = 0; a < 3; ++a) {
        from[a] = first[a] > b->reach ? first[a] - b->reach : 0;
        from[a] = from[a] + size[a] <= n[a] ? from[a] : n[a] - size[a];
    }
    copy_box(b->volume, from, size, b->samples);
    const iso_planes planes = {b->samples, b->volume->type, {size[0], size[1], size[2]}, 0, size[2], g->has_no_data};
    const size_t plane = count[0] * count[1];
    for (size_t z = 0; z < count[2]; ++z, codes += 3 * plane) {
        for (size_t y = 0; y < count[1]; ++y) {
            iso_cascade_level0_gradients(b->cascade, &planes, first[1] - from[1] + y, first[2] - from[2] + z, &b->row);
            iso_unit_rows(b->row.g, size[0], b->row.d, NULL);
            for (int a = 0; a < 3; ++a)
                memcpy(b->plane.d[a] + count[0] * y, b->row.d[a] + first[0] - from[0], count[0] * sizeof(float));
        }
        iso_emit_codes(b->cascade->opt.code, plane, &b->plane);
        memcpy(codes, b->plane.bytes, 3 * plane);
    }
}
