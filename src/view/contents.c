/* SPDX-License-Identifier: MIT */
#include "view/contents.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/version.h"
#include "brick/pack.h"
#include "pyramid/narrow.h"
#include "tf/adapt.h"
#include "tf/histogram.h"
#include "tf/presets.h"

/* ---- plan ---- */

/* A plan's bricks as arrays of a page: the full cache of the ray caster (brick/pack.h) with 16-bit scalars
 * over the range and directions in the pyramid's code, and the position of each brick in it. */

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
    iso_status status = iso_brick_pack_create(&c->pack, plan->nodes, plan->levels, plan->drawn, ISO_VIEWER_MOST_TEXELS,
                                              0, err);
    if (status != ISO_OK)
        return status;
    if (c->pack.page_count > 1)
        return iso_fail(err, ISO_E_RANGE, "--plan: its %zu bricks need %zu textures of %d texels per side, limit 1",
                        c->pack.brick_count, c->pack.page_count, ISO_VIEWER_MOST_TEXELS);
    c->texel_count = c->pack.size[0] * c->pack.size[1] * c->pack.size[2];
    c->scalars = calloc(c->texel_count, sizeof *c->scalars);
    c->codes = calloc(c->texel_count, 3);
    brick_scratch s = {malloc(most * ISO_NODE_CHANNELS * sizeof(float)), malloc(3 * most * sizeof(float)),
                       malloc(3 * most)};
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

/* Adds "plan" to the root, and its arrays. ISO_E_RANGE: more bricks than a texture holds. ISO_E_MEMORY. */
static iso_status contents_add_plan(const iso_viewer *v, iso_contents *contents, iso_error *err)
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

/* ---- scalars ------------------------------------------------------------------------------------------------------ */

/* value = zero + number * step */
typedef struct scalar_form {
    const char *kind; /* "integer", "quantized", "float" */
    const float *values;
    double zero, step;
    size_t width; /* bytes */
} scalar_form;

static bool is_small_integer(iso_type type)
{
    return type == ISO_U8 || type == ISO_I8 || type == ISO_U16 || type == ISO_I16;
}

static scalar_form form_of(const iso_level *level, bool floats)
{
    const double range = level->max - level->min;
    scalar_form f = {.values = level->scalar, .zero = level->min};
    if ((is_small_integer(level->stored_type) || level->labels) && range <= 65535) {
        f.kind = "integer";
        f.step = 1;
        f.width = range <= 255 ? 1 : 2;
    } else if (floats) {
        f.kind = "float"; /* (value - min) / range, as in the ray caster's textures */
        f.step = range > 0 ? range : 1;
        f.width = 4;
    } else {
        f.kind = "quantized";
        f.step = range > 0 ? range / 65535 : 1;
        if (level->geometry.has_no_data) {
            f.zero = (double)iso_level_stand_in(level, ISO_STAND_IN_FILE);
            f.step = (level->max - f.zero) / 65535;
        }
        f.width = 2;
    }
    return f;
}

static uint32_t scalar_number(const void *of, size_t i, size_t c)
{
    const scalar_form *f = of;
    const bool is_none = iso_is_no_data(f->values[i]);
    const double x = is_none ? f->width < 4 ? 0 : -ISO_STAND_IN_DEVICE : ((double)f->values[i] - f->zero) / f->step;
    (void)c;
    if (f->width < 4)
        return (uint32_t)lrint(x);
    uint32_t bits;
    const float part = (float)x;
    memcpy(&bits, &part, sizeof bits);
    return bits;
}

static uint32_t code_byte(const void *of, size_t i, size_t c)
{
    return ((const uint8_t *)of)[3 * i + c];
}

static uint32_t byte(const void *of, size_t i, size_t c)
{
    (void)c;
    return ((const uint8_t *)of)[i];
}

static uint32_t word(const void *of, size_t i, size_t c)
{
    (void)c;
    return ((const uint32_t *)of)[i];
}

iso_status iso_contents_add_array(iso_contents *contents, const char *name, const iso_pack_array *array, json_t *json,
                                  iso_error *err)
{
    struct iso_contents_array *slot = &contents->arrays[contents->count];
    snprintf(slot->name, sizeof slot->name, "%s", name);
    NEED(iso_pack(array, &slot->packed, err));
    const size_t bytes = array->count * array->components * array->width;
    json_object_update_new(json,
                           json_pack("{s:s, s:I, s:I, s:I, s:b, s:I}", "array", name, "count", (json_int_t)array->count,
                                     "components", (json_int_t)array->components, "bytes", (json_int_t)array->width,
                                     "delta", slot->packed.delta, "packed", (json_int_t)slot->packed.size));
    contents->size.voxel_bytes += bytes;
    ++contents->count;
    return ISO_OK;
}

static iso_status add_scalar(const iso_level *level, bool floats, const char *name, iso_contents *contents,
                             json_t *json, iso_error *err)
{
    const scalar_form f = form_of(level, floats);
    json_t *scalar = json_pack("{s:s, s:f, s:f}", "kind", f.kind, "zero", f.zero, "step", f.step);
    json_object_set_new(json, "scalar", scalar);
    if (strcmp(f.kind, "quantized") == 0)
        contents->size.quantum = 1.0 / 65535;
    return iso_contents_add_array(contents, name,
                                  &(iso_pack_array){iso_geometry_voxel_count(&level->geometry), 1, f.width,
                                                    scalar_number, &f},
                                  scalar, err);
}

/* Adds the extinction scales of a level of which some voxels have no data (pyramid/data_share.c). */
static iso_status add_share(const iso_viewer *v, size_t k, iso_contents *contents, json_t *json, iso_error *err)
{
    const iso_level *level = &v->pyramid->levels[k];
    char name[48];
    if (!level->scale || !level->geometry.has_no_data)
        return ISO_OK;
    json_t *share = json_object();
    json_object_set_new(json, "share", share);
    snprintf(name, sizeof name, "level-%zu-share", k);
    return iso_contents_add_array(contents, name,
                                  &(iso_pack_array){iso_geometry_voxel_count(&level->geometry), 1, 1, byte,
                                                    level->scale},
                                  share, err);
}

/* ---- directions --------------------------------------------------------------------------------------------------- */

static const char *const decoder_names[] = {
    "ISO_DECODER_LINEAR",
    "ISO_DECODER_REGION48",
    "ISO_DECODER_UNIT",
    "ISO_DECODER_OCT",
};

json_t *iso_contents_code_json(iso_code code)
{
    const iso_code_info *info = iso_code_describe(code);
    return json_pack("{s:s, s:b, s:s}", "name", info->name, "signed", info->is_signed, "decoder",
                     decoder_names[info->decoder]);
}

static iso_status add_code(const iso_viewer *v, size_t k, iso_code code, iso_contents *contents, json_t *list,
                           iso_error *err)
{
    const iso_level *level = &v->pyramid->levels[k];
    const iso_code_info *info = iso_code_describe(code);
    const size_t count = iso_geometry_voxel_count(&level->geometry);
    FREED uint8_t *made = NULL;
    char name[48];
    if (code != v->pyramid->options.code) {
        if (!level->directions || !info->is_textured)
            return iso_fail(err, ISO_E_USAGE, "--code %s: the pyramid has only %s; build it with --keep-float",
                            info->name, iso_code_describe(v->pyramid->options.code)->name);
        made = malloc(3 * count);
        NEED_MEMORY(made, err, "no memory for %zu codes", count);
        iso_code_encode(code, level->directions, made, count);
    }
    snprintf(name, sizeof name, "level-%zu-%s", k, info->name);
    json_t *json = iso_contents_code_json(code);
    json_array_append_new(list, json);
    return iso_contents_add_array(contents, name, &(iso_pack_array){count, 3, 1, code_byte, made ? made : level->codes},
                                  json, err);
}

static iso_status add_codes(const iso_viewer *v, size_t k, iso_contents *contents, json_t *json, iso_error *err)
{
    json_t *list = json_array();
    json_object_set_new(json, "codes", list);
    for (size_t i = 0; i < v->code_count; ++i)
        NEED(add_code(v, k, v->codes[i], contents, list, err));
    return ISO_OK;
}

/* ---- joint histograms --------------------------------------------------------------------------------------------- */

static json_t *bins_json(const iso_bins *bins)
{
    return json_pack("{s:I, s:f, s:f}", "count", (json_int_t)bins->count, "lo", bins->lo, "step", bins->step);
}

/* Adds a joint histogram, in words: the number of entries of each row, then each entry's bin, then its count. */
static iso_status add_joint(const iso_viewer *v, size_t k, iso_contents *contents, json_t *json, iso_error *err)
{
    OWNED(iso_joint) joint = {0};
    const iso_joint_key key = {k, 8, ISO_SECOND_VALUE_NONE};
    char name[48];
    if (k == 0 || v->pyramid->levels[0].labels || !v->pyramid->levels[0].scalar)
        return ISO_OK;
    NEED(iso_joint_obtain(v->pyramid, v->folder, &key, v->threads, &joint, err));
    const size_t rows = joint.s.count, entries = joint.entry_count;
    FREED uint32_t *words = malloc((rows + 2 * entries + 1) * sizeof *words);
    for (size_t i = 0; words && i < rows; ++i)
        words[i] = (uint32_t)(joint.row_start[i + 1] - joint.row_start[i]);
    for (size_t i = 0; words && i < entries; ++i) {
        words[rows + i] = joint.entry_z[i];
        words[rows + entries + i] = (uint32_t)joint.entry_count_of[i];
    }
    json_t *object = json_pack("{s:o, s:o, s:I}", "z", bins_json(&joint.z), "s", bins_json(&joint.s), "entries",
                               (json_int_t)entries);
    json_object_set_new(json, "joint", object);
    snprintf(name, sizeof name, "level-%zu-joint", k);
    return words ? iso_contents_add_array(contents, name, &(iso_pack_array){rows + 2 * entries, 1, 4, word, words},
                                          object, err)
                 : iso_fail(err, ISO_E_MEMORY, "no memory for a joint histogram of %zu entries", entries);
}

/* ---- error of coarse levels -------------------------------------------------------------------------------------- */

/* Adds the errors of the level's small views (tf/small_views.h) against level 0, with the scene's transfer function and
 * with the adapted one, and whether the adapted one is better. */
static iso_status add_errors(const iso_viewer *v, size_t k, iso_small_views_fine *kept, json_t *json, iso_error *err)
{
    const iso_level *level0 = &v->pyramid->levels[0];
    iso_adapt_options opt = iso_adapt_defaults();
    iso_adapt_judgment judgment = {0};
    OWNED(iso_tf_table) table = {0}, adapted = {0};
    if (k == 0 || level0->labels || !level0->scalar || !(v->errors || k == v->first))
        return ISO_OK;
    opt.threads = v->threads;
    opt.folder = v->folder;
    opt.level_0 = kept;
    NEED(iso_tf_tabulate(&v->scene->tf, iso_pyramid_lo(v->pyramid), iso_pyramid_hi(v->pyramid), &level0->geometry,
                         &table, err));
    NEED(iso_adapt_level(v->pyramid, k, &table, &opt, &adapted, &judgment, err));
    if (judgment.seen)
        json_object_set_new(json, "seen",
                            json_pack("{s:f, s:f, s:f, s:f, s:b}", "rmse", judgment.seen_original.rmse,
                                      "ssim_dissimilarity", judgment.seen_original.ssim_dissimilarity, "rmse_adapted",
                                      judgment.seen_adapted.rmse, "ssim_dissimilarity_adapted",
                                      judgment.seen_adapted.ssim_dissimilarity, "adapting_helps",
                                      !judgment.use_original));
    return ISO_OK;
}

/* ---- levels ------------------------------------------------------------------------------------------------------- */

static json_t *geometry_json(const iso_geometry *g)
{
    json_t *rows = json_array();
    for (int i = 0; i < 3; ++i)
        json_array_append_new(rows, iso_json_numbers(g->index_to_world.m[i], 3));
    const double origin[3] = {g->origin_mm.x, g->origin_mm.y, g->origin_mm.z};
    return json_pack("{s:[I,I,I], s:o, s:o, s:o}", "size", (json_int_t)g->size[0], (json_int_t)g->size[1],
                     (json_int_t)g->size[2], "index_to_world", rows, "origin_mm", iso_json_numbers(origin, 3),
                     "box_index", iso_json_numbers(g->box_index, 3));
}

static json_t *level_json(const iso_level *level, size_t k)
{
    json_t *json = geometry_json(&level->geometry);
    json_object_update_new(json, json_pack("{s:I, s:f, s:f, s:b}", "level", (json_int_t)k, "min", level->min, "max",
                                           level->max, "labels", level->labels));
    if (level->is_optimized)
        json_object_set_new(json, "values", json_string(ISO_OPTIMIZED_VALUES));
    return json;
}

static iso_status add_level(const iso_viewer *v, size_t k, iso_small_views_fine *kept, iso_contents *contents,
                            json_t *list, iso_error *err)
{
    const iso_level *level = &v->pyramid->levels[k];
    json_t *json = level_json(level, k);
    char name[48];
    snprintf(name, sizeof name, "level-%zu-scalar", k);
    json_array_append_new(list, json);
    NEED(add_scalar(level, v->floats, name, contents, json, err));
    NEED(add_share(v, k, contents, json, err));
    NEED(add_codes(v, k, contents, json, err));
    NEED(add_joint(v, k, contents, json, err));
    return add_errors(v, k, kept, json, err);
}

/* Adds the second volume, without directions. */
static iso_status add_overlay(const iso_viewer *v, iso_contents *contents, iso_error *err)
{
    json_t *json = level_json(v->overlay, 0);
    json_object_set_new(json, "codes", json_array());
    json_object_set_new(json, "has_no_data", json_boolean(v->overlay->geometry.has_no_data));
    json_object_set_new(contents->root, "overlay", json_pack("{s:s, s:o}", "name", v->overlay_title, "level", json));
    return add_scalar(v->overlay, v->floats, "overlay-scalar", contents, json, err);
}

/* ---- presets of transfer functions ------------------------------------------------------------------------------- */

static iso_status add_presets(const iso_viewer *v, json_t *root, iso_error *err)
{
    const iso_level *level0 = &v->pyramid->levels[0], *seen = iso_pyramid_finest(v->pyramid);
    FREED iso_survey *survey = NULL;
    json_t *list = json_array();
    json_object_set_new(root, "presets", list);
    if (seen->labels || !seen->scalar)
        return ISO_OK;
    NEED(iso_survey_make(seen, v->threads, &survey, err));
    for (size_t row = 0; row < iso_tf_preset_names.count; ++row) {
        OWNED(iso_tf) tf = {0};
        const char *name = iso_names_name(&iso_tf_preset_names, row);
        NEED(iso_tf_of_level(name, &(iso_tf_request){0}, survey, level0, v->threads, &tf, err));
        json_array_append_new(list, json_pack("{s:s, s:s, s:o}", "name", name, "summary",
                                              iso_names_summary(&iso_tf_preset_names, row), "tf", iso_tf_to_json(&tf)));
    }
    return ISO_OK;
}

iso_status iso_contents_make(const iso_viewer *v, const iso_progress *progress, iso_contents *contents, iso_error *err)
{
    const iso_geometry *level0 = &v->pyramid->levels[0].geometry;
    memset(contents, 0, sizeof *contents);
    json_t *levels = json_array(), *codes = json_array();
    json_t *root = contents->root = json_pack("{s:s, s:s, s:s, s:s, s:[f,f], s:f, s:b, s:b, s:b, s:b, s:o, s:o, s:o}",
                                              "schema", "isoshade.view/1", "title", v->title, "input",
                                              v->input ? v->input : v->title, "made_by", "isoshade " ISO_VERSION,
                                              "value_range", iso_pyramid_lo(v->pyramid), iso_pyramid_hi(v->pyramid),
                                              "mean_spacing_mm", iso_geometry_mean_spacing_mm(level0), "is_patient",
                                              level0->is_patient, "has_no_data", level0->has_no_data, "compact",
                                              v->compact, "adapted", v->adapted, "scene", iso_scene_to_json(v->scene),
                                              "levels", levels, "codes", codes);
    json_object_set_new(root, "geometry", geometry_json(level0));
    if (v->value_unit && v->value_unit[0])
        json_object_set_new(root, "value_unit", json_string(v->value_unit));
    if (v->pyramid->segments)
        json_object_set(root, "segments", v->pyramid->segments);
    for (size_t i = 0; i < v->code_count; ++i)
        json_array_append_new(codes, json_string(iso_code_describe(v->codes[i])->name));
    iso_small_views_fine kept = {0}; /* small views of level 0 */
    iso_status status = add_presets(v, root, err);
    for (size_t n = v->last + 1; n-- > v->first && status == ISO_OK;) {
        iso_progress_report(progress, "pack", (double)(v->last - n) / (double)(v->last + 1));
        status = add_level(v, n, &kept, contents, levels, err);
        contents->first_count = n == v->last ? contents->count : contents->first_count;
    }
    iso_small_views_fine_destroy(&kept);
    if (status == ISO_OK && v->overlay)
        status = add_overlay(v, contents, err);
    if (status == ISO_OK && v->plan)
        status = contents_add_plan(v, contents, err);
    if (status != ISO_OK)
        iso_contents_destroy(contents);
    return status;
}

void iso_contents_destroy(iso_contents *contents)
{
    for (size_t i = 0; i < contents->count; ++i)
        free(contents->arrays[i].packed.bytes);
    json_decref(contents->root);
    memset(contents, 0, sizeof *contents);
}
