/* SPDX-License-Identifier: MIT */
#include "render/sampler.h"

#include <math.h>
#include <stdlib.h>

#include "encode/decode_double.h"

/* Reads linear codes of one byte per component without a copy of the level: they give the same floats. */
static void read_bytes(iso_sampler *s)
{
    s->by_bytes = true;
    for (int i = 0; i < 256; ++i) {
        const uint8_t bytes[3] = {(uint8_t)i, (uint8_t)i, (uint8_t)i};
        float decoded[3];
        double e[3];
        iso_code_decode_all(s->code, bytes, decoded, 1);
        iso_code_lattice(s->code, bytes, e);
        s->of_byte[i] = s->source == ISO_FROM_CODES ? (float)e[0] : decoded[0];
    }
}

/* Returns e of n = g / sqrt(|g|^2 + e^2). A constant level has no range, and its differences are rounding errors
 * without direction: e is tiny compared with the value, but above them. */
static double on_the_fly_eps(const iso_level *level)
{
    const double range = level->max - level->min, scale = range > 0 ? range : fmax(fabs(level->max), 1);
    return ISO_ON_THE_FLY_EPS * scale / iso_geometry_min_spacing_mm(&level->geometry);
}

iso_status iso_sampler_create(iso_sampler *s, const iso_level *level, iso_code code, iso_direction_source source,
                              iso_error *err)
{
    const iso_geometry *g = &level->geometry;
    size_t count = iso_geometry_voxel_count(g);
    *s = (iso_sampler){.level = level,
                       .code = code,
                       .source = source,
                       .gradient_to_world = iso_geometry_gradient_to_world(g),
                       .on_the_fly_eps = on_the_fly_eps(level)};
    if (source == ISO_FROM_FLOAT) {
        if (!level->directions)
            return iso_fail(err, ISO_E_RANGE, "the level holds no float directions; build with --keep-float");
        s->vectors = level->directions;
    }
    bool from_palette = source == ISO_FROM_PALETTE || source == ISO_FROM_PALETTE_NEAREST;
    if (from_palette && (!level->palette || !level->palette_index))
        return iso_fail(err, ISO_E_RANGE, "the level holds no palette, and directions from one are asked for");
    if (source == ISO_FROM_FLOAT || source == ISO_FROM_ON_THE_FLY)
        return ISO_OK;
    if (iso_code_describe(code)->is_linear && !iso_code_describe(code)->lattice && !from_palette) {
        read_bytes(s);
        return ISO_OK;
    }
    s->owned = malloc(count * 3 * sizeof *s->owned);
    NEED_MEMORY(s->owned, err, "no memory for %zu directions", count);
    s->vectors = s->owned;
    if (from_palette) {
        iso_palette_decode(level->palette, level->palette_index, s->owned, count);
        return ISO_OK;
    }
    if (source == ISO_FROM_DECODED || source == ISO_FROM_FLIPPED) {
        iso_code_decode_all(code, level->codes, s->owned, count);
        return ISO_OK;
    }
    for (size_t i = 0; i < count; ++i) {
        double e[3];
        iso_code_lattice(code, level->codes + 3 * i, e);
        for (size_t c = 0; c < 3; ++c)
            s->owned[3 * i + c] = (float)e[c];
    }
    return ISO_OK;
}

void iso_sampler_of_bricks(iso_sampler *s, const iso_brick_field *bricks, iso_level *level)
{
    *level = (iso_level){.geometry = bricks->nodes->geometry, .min = bricks->nodes->min, .max = bricks->nodes->max};
    *s = (iso_sampler){.level = level, .source = ISO_FROM_FLOAT, .bricks = bricks};
}

void iso_sampler_destroy(iso_sampler *s)
{
    if (!s)
        return;
    free(s->owned);
    *s = (iso_sampler){0};
}

/* Samples all channels of bricks. False: the sampler is not on bricks. */
static bool sample_bricks(const iso_sampler *s, iso_vec3 index, double channels[ISO_NODE_CHANNELS])
{
    if (s->bricks)
        iso_brick_sample(s->bricks, index, channels);
    return s->bricks;
}

/* The eight voxels around a point and their weights. */
typedef struct stencil {
    size_t voxel[8];
    double weight[8];
} stencil;

static stencil stencil_at(const iso_geometry *g, iso_vec3 index)
{
    const double p[3] = {index.x - 0.5, index.y - 0.5, index.z - 0.5};
    size_t at[3][2];
    double w[3][2];
    for (int a = 0; a < 3; ++a) {
        double last = (double)(g->size[a] - 1);
        double q = p[a] > 0 ? (p[a] < last ? p[a] : last) : 0;
        at[a][0] = (size_t)(int64_t)q;
        at[a][1] = at[a][0] + 1 < g->size[a] ? at[a][0] + 1 : at[a][0];
        w[a][1] = q - (double)(int64_t)at[a][0];
        w[a][0] = 1 - w[a][1];
    }
    stencil s;
    for (int c = 0; c < 8; ++c) {
        s.voxel[c] = at[0][c & 1] + g->size[0] * (at[1][c >> 1 & 1] + g->size[1] * at[2][c >> 2]);
        s.weight[c] = w[0][c & 1] * w[1][c >> 1 & 1] * w[2][c >> 2];
    }
    return s;
}

/* Returns the voxel that holds the point, or the nearest one if it is outside of the grid. */
static size_t voxel_at(const iso_geometry *g, iso_vec3 index)
{
    const double p[3] = {index.x, index.y, index.z};
    size_t at = 0;
    for (int a = 2; a >= 0; --a) {
        double last = (double)(g->size[a] - 1);
        at = at * g->size[a] + (size_t)(p[a] > 0 ? (p[a] < last ? p[a] : last) : 0);
    }
    return at;
}

double iso_sample_scalar(const iso_sampler *s, iso_vec3 index)
{
    double node[ISO_NODE_CHANNELS];
    if (sample_bricks(s, index, node))
        return node[0];
    if (s->level->labels)
        return (double)s->level->scalar[voxel_at(&s->level->geometry, index)];
    stencil at = stencil_at(&s->level->geometry, index);
    double value = 0;
    for (int c = 0; c < 8; ++c) {
        const float corner = s->level->scalar[at.voxel[c]];
        if (iso_is_no_data(corner) && at.weight[c] > 0)
            return (double)ISO_NO_DATA;
        value += at.weight[c] * (double)corner;
    }
    return value;
}

double iso_sample_bytes(const iso_sampler *s, const uint8_t *bytes, iso_vec3 index)
{
    stencil at = stencil_at(&s->level->geometry, index);
    double value = 0;
    for (int c = 0; c < 8; ++c)
        value += at.weight[c] * (double)bytes[at.voxel[c]];
    return value;
}

void iso_sample_floats(const iso_sampler *s, const float *values, size_t channels, iso_vec3 index, double *out)
{
    const stencil at = stencil_at(&s->level->geometry, index);
    for (size_t k = 0; k < channels; ++k)
        out[k] = 0;
    for (int c = 0; c < 8; ++c)
        for (size_t k = 0; k < channels; ++k)
            out[k] += at.weight[c] * (double)values[at.voxel[c] * channels + k];
}

/* Returns the filtered scalar at a place, or the one at p if there is no data. */
static double sample_beside(const iso_sampler *s, iso_vec3 p, double x, double y, double z)
{
    const double value = iso_sample_scalar(s, iso_v3(p.x + x, p.y + y, p.z + z));
    return value == (double)ISO_NO_DATA ? iso_sample_scalar(s, p) : value;
}

/* Computes the normal by central differences of the filtered scalar, one voxel to each side. */
static iso_vec3 normal_on_the_fly(const iso_sampler *s, iso_vec3 p)
{
    iso_vec3 index_gradient = {
        0.5 * (sample_beside(s, p, 1, 0, 0) - sample_beside(s, p, -1, 0, 0)),
        0.5 * (sample_beside(s, p, 0, 1, 0) - sample_beside(s, p, 0, -1, 0)),
        0.5 * (sample_beside(s, p, 0, 0, 1) - sample_beside(s, p, 0, 0, -1)),
    };
    iso_vec3 g = iso_mul(s->gradient_to_world, index_gradient);
    return iso_scale(g, 1 / sqrt(iso_dot(g, g) + s->on_the_fly_eps * s->on_the_fly_eps));
}

static iso_vec3 normal_of_voxel(const iso_sampler *s, size_t voxel)
{
    float v[3];
    iso_sampler_vector(s, voxel, v);
    double d[3] = {(double)v[0], (double)v[1], (double)v[2]}, n[3];
    iso_code_normal(d, n);
    return iso_v3(n[0], n[1], n[2]);
}

/* Filters directions, with those flipped that oppose the one of the largest weight times length. */
static iso_vec3 flipped_direction(const iso_sampler *s, const stencil *at)
{
    iso_vec3 d[8], pivot = {0, 0, 0}, sum = {0, 0, 0};
    double most = 0;
    for (int c = 0; c < 8; ++c) {
        float v[3];
        iso_sampler_vector(s, at->voxel[c], v);
        d[c] = iso_v3((double)v[0], (double)v[1], (double)v[2]);
        const double count = at->weight[c] * iso_norm(d[c]);
        if (count > most) {
            most = count;
            pivot = d[c];
        }
    }
    for (int c = 0; c < 8; ++c)
        sum = iso_madd(sum, d[c], at->weight[c] * iso_flip_sign(d[c], pivot));
    return sum;
}

iso_vec3 iso_sample_normal(const iso_sampler *s, iso_vec3 index)
{
    double node[ISO_NODE_CHANNELS], normal[3];
    if (sample_bricks(s, index, node)) {
        iso_code_normal(node + 1, normal);
        return iso_v3(normal[0], normal[1], normal[2]);
    }
    if (!s->vectors && !s->by_bytes)
        return normal_on_the_fly(s, index);
    if (s->source == ISO_FROM_PALETTE_NEAREST)
        return normal_of_voxel(s, voxel_at(&s->level->geometry, index));
    stencil at = stencil_at(&s->level->geometry, index);
    if (s->source == ISO_FROM_FLIPPED)
        return iso_shading_normal(flipped_direction(s, &at));
    double e[3] = {0}, n[3];
    for (int c = 0; c < 8; ++c) {
        float v[3];
        iso_sampler_vector(s, at.voxel[c], v);
        for (size_t a = 0; a < 3; ++a)
            e[a] += at.weight[c] * (double)v[a];
    }
    if (s->source == ISO_FROM_CODES) {
        double d[3];
        iso_code_decode(s->code, e, d);
        iso_code_normal(d, n);
    } else {
        iso_code_normal(e, n);
    }
    return iso_v3(n[0], n[1], n[2]);
}
