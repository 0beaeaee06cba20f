/* SPDX-License-Identifier: MIT */
#include "view/plan.h"

#include <math.h>
#include <stdlib.h>

#include "brick/pack.h"

/* Texture data of the brick cache. */
typedef struct brick_cache {
    iso_brick_pack pack;
    size_t texel_count;
    uint16_t *scalars;
    uint8_t *codes;
} brick_cache;

/* A brick's nodes, x fastest. */
typedef struct brick_scratch {
    float *nodes, *directions;
    uint8_t *codes;
} brick_scratch;

static iso_status put_brick(const iso_viewer *v, const iso_brick_field *f, size_t i, brick_scratch *s, brick_cache *c,
                            iso_error *err)
{
    const iso_node_levels *n = f->nodes;
    const size_t brick[3] = {i % n->count[0], i / n->count[0] % n->count[1], i / n->count[0] / n->count[1]},
                 side = iso_brick_side(n, f->levels[i]), count = side * side * side;
    const double step = n->max > n->min ? (n->max - n->min) / 65535 : 1;
    NEED(iso_brick_bake(f, brick, s->nodes, err));
    for (size_t k = 0; k < count; ++k)
        for (size_t a = 0; a < 3; ++a)
            s->directions[3 * k + a] = s->nodes[ISO_NODE_CHANNELS * k + 1 + a];
    iso_code_encode(v->codes[0], s->directions, s->codes, count);
    const float *place = c->pack.layout + 4 * i;
    for (size_t z = 0; z < side; ++z)
        for (size_t y = 0; y < side; ++y)
            for (size_t x = 0; x < side; ++x) {
                const size_t k = x + side * (y + side * z),
                             at = (size_t)place[0] + x +
                                  c->pack.size[0] * ((size_t)place[1] + y + c->pack.size[1] * ((size_t)place[2] + z));
                const double value = ((double)s->nodes[ISO_NODE_CHANNELS * k] - n->min) / step;
                c->scalars[at] = (uint16_t)lrint(fmin(fmax(value, 0), 65535));
                for (size_t a = 0; a < 3; ++a)
                    c->codes[3 * at + a] = s->codes[3 * k + a];
            }
    return ISO_OK;
}

static iso_status fill_cache(const iso_viewer *v, brick_cache *c, iso_error *err)
{
    const iso_viewer_plan *plan = v->plan;
    const iso_brick_field field = {plan->nodes, plan->levels, ISO_FACES_BAKED};
    const size_t side = iso_brick_side(plan->nodes, 0), most = side * side * side;
    iso_status status = iso_brick_pack_create(&c->pack, plan->nodes, plan->levels, plan->drawn, ISO_VIEWER_MOST_TEXELS, 0,
                                              err);
    if (status != ISO_OK)
        return status;
    if (c->pack.page_count > 1)
        return iso_fail(err, ISO_E_RANGE, "--plan: its %zu bricks need %zu textures of %d texels per side, limit 1",
                        c->pack.brick_count, c->pack.page_count, ISO_VIEWER_MOST_TEXELS);
    c->texel_count = c->pack.size[0] * c->pack.size[1] * c->pack.size[2];
    c->scalars = calloc(c->texel_count, sizeof *c->scalars);
    c->codes = calloc(c->texel_count, 3);
    brick_scratch s = {malloc(most * ISO_NODE_CHANNELS * sizeof(float)), malloc(3 * most * sizeof(float)), malloc(3 * most)};
    if (!c->scalars || !c->codes || !s.nodes || !s.directions || !s.codes)
        status = iso_fail(err, ISO_E_MEMORY, "no memory for %zu texels of a plan", c->texel_count);
    for (size_t i = 0; status == ISO_OK && i < iso_brick_count(plan->nodes); ++i)
        if (c->pack.layout[4 * i + 3] > 0)
            status = put_brick(v, &field, i, &s, c, err);
    free(s.nodes);
    free(s.directions);
    free(s.codes);
    return status;
}

static uint32_t scalar_at(const void *of, size_t i, size_t c)
{
    (void)c;
    return ((const brick_cache *)of)->scalars[i];
}
static uint32_t code_at(const void *of, size_t i, size_t c)
{
    return ((const brick_cache *)of)->codes[3 * i + c];
}
/* Returns the texel of the brick's first node (x, y, z), then 1 + its level, or 0 if it is left out. */
static uint32_t place_at(const void *of, size_t i, size_t c)
{
    const float *place = ((const brick_cache *)of)->pack.layout + 4 * i;
    return c < 3 ? (uint32_t)place[c] : place[3] > 0 ? 1 + (uint32_t)lround(-log2((double)place[3])) : 0;
}

static json_t *sizes_json(const size_t size[3])
{
    return json_pack("[I,I,I]", (json_int_t)size[0], (json_int_t)size[1], (json_int_t)size[2]);
}

static iso_status add_arrays(const iso_viewer *v, const brick_cache *cache, iso_contents *contents, json_t *json,
                             iso_error *err)
{
    const iso_node_levels *n = v->plan->nodes;
    json_t *scalar = json_pack("{s:s, s:f, s:f}", "kind", "quantized", "zero", n->min, "step",
                               n->max > n->min ? (n->max - n->min) / 65535 : 1),
           *code = iso_contents_code_json(v->codes[0]), *layout = json_object();
    json_object_set_new(json, "scalar", scalar);
    json_object_set_new(json, "codes", json_pack("[o]", code));
    json_object_set_new(json, "layout", layout);
    NEED(iso_contents_add_array(contents, "plan-scalar", &(iso_pack_array){cache->texel_count, 1, 2, scalar_at, cache},
                                scalar, err));
    NEED(iso_contents_add_array(contents, "plan-codes", &(iso_pack_array){cache->texel_count, 3, 1, code_at, cache},
                                code, err));
    return iso_contents_add_array(contents, "plan-layout", &(iso_pack_array){iso_brick_count(n), 4, 2, place_at, cache},
                                  layout, err);
}

iso_status iso_contents_add_plan(const iso_viewer *v, iso_contents *contents, iso_error *err)
{
    const iso_viewer_plan *plan = v->plan;
    brick_cache cache = {.texel_count = 0};
    iso_status status = fill_cache(v, &cache, err);
    if (status == ISO_OK) {
        json_t *json = json_pack("{s:s, s:f, s:f, s:o, s:I, s:I, s:o, s:o, s:o}", "name", plan->name, "min",
                                 plan->nodes->min, "max", plan->nodes->max, "bricks", sizes_json(plan->nodes->count),
                                 "brick_voxels", (json_int_t)plan->nodes->brick_voxels, "level_count",
                                 (json_int_t)plan->nodes->level_count, "texels", sizes_json(cache.pack.size),
                                 "predicted_rmse", iso_json_number(plan->predicted_rmse), "measured_rmse",
                                 iso_json_number(plan->measured_rmse));
        json_object_set_new(json, "drawn", json_integer((json_int_t)cache.pack.brick_count));
        json_object_set_new(contents->root, "plan", json);
        contents->size.plan_bricks = cache.pack.brick_count;
        contents->size.plan_texels = cache.texel_count;
        contents->size.quantum = 1.0 / 65535;
        status = add_arrays(v, &cache, contents, json, err);
    }
    iso_brick_pack_destroy(&cache.pack);
    free(cache.scalars);
    free(cache.codes);
    return status;
}
