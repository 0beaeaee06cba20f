/* SPDX-License-Identifier: MIT */
#include "render/cpu/caster.h"

#include <assert.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/progress.h"
#include "brick/occupancy.h"
#include "render/cpu/cast.h"
#include "render/cpu/cast_bricks.h"
#include "render/cpu/cast_scene.h"
#include "render/cpu/cast_width.h"
#include "render/sampler.h"
#include "render/screen_reach.h"

/* ---- bricks on demand ---- */

/* Bricks that are made when a ray looks into them.
 *
 *     samples of the file's type, or a level  --bricks that rays look into-->  pool  -->  rays
 *
 * For one picture: bricks that the transfer function or an opaque part hides have neither directions nor memory. The
 * bricks have the same bits as those of a whole level, and so has the picture. */
typedef struct iso_cast_maker iso_cast_maker;

typedef struct iso_cast_made {
    const iso_level *level; /* it must outlive the maker */
    iso_code code;
    iso_cast_scalars scalars;
    const iso_cast_blocks *blocks; /* rays look only into the visible ones; NULL: into all */
    int threads;
} iso_cast_made;

/* A brick is made under the lock of its bench, with the bench's memory. */
typedef struct bench {
    pthread_mutex_t lock;
    iso_box_codes *codes; /* NULL without light, and if the level has codes */
    float scalars[ISO_CAST_VOXELS];
    uint8_t bytes[3 * ISO_CAST_VOXELS];
} bench;

struct iso_cast_maker {
    const iso_level *level;
    iso_cast_scalars scalars;
    bool is_lit, is_signed;
    size_t brick_count[3];
    iso_cast_pool pool;
    int32_t *slots;
    size_t capacity;
    int32_t next; /* brick of the pool; 0 is never taken: lanes without a sample read it */
    size_t bench_count;
    bench *benches;
};

/* Counts the bricks with a block that can show something; all if there are no blocks. */
static size_t count_bricks(const iso_cast_maker *m, const iso_cast_blocks *b)
{
    enum { BLOCKS = ISO_CAST_BRICK >> ISO_CAST_BLOCK_SHIFT };
    const size_t *n = m->brick_count, bricks = n[0] * n[1] * n[2];
    size_t count = 0;
    FREED uint8_t *shows = b ? calloc(bricks, 1) : NULL;
    for (size_t i = 0; shows && i < b->blocks; ++i) {
        const size_t at[3] = {i % b->count[0], i / b->count[0] % b->count[1], i / (b->count[0] * b->count[1])};
        shows[at[0] / BLOCKS + n[0] * (at[1] / BLOCKS + n[1] * (at[2] / BLOCKS))] |= b->octants[i] == 0;
    }
    for (size_t i = 0; i < bricks; ++i)
        count += !shows || shows[i];
    return count;
}

static void read_scalars(const iso_level *level, const iso_cast_box *box, float *out)
{
    const size_t *n = level->geometry.size;
    for (size_t z = 0; z < box->count[2]; ++z)
        for (size_t y = 0; y < box->count[1]; ++y, out += box->count[0]) {
            const size_t row = box->first[1] + y + n[1] * (box->first[2] + z);
            iso_level_scalars(level, level->samples, box->first[0] + n[0] * row, box->count[0], out);
        }
}

static void read_codes(const iso_level *level, const iso_cast_box *box, uint8_t *out)
{
    const size_t *n = level->geometry.size, bytes = 3 * box->count[0];
    for (size_t z = 0; z < box->count[2]; ++z)
        for (size_t y = 0; y < box->count[1]; ++y, out += bytes)
            memcpy(out, level->codes + 3 * (box->first[0] + n[0] * (box->first[1] + y + n[1] * (box->first[2] + z))),
                   bytes);
}

static int32_t make_brick(iso_cast_maker *m, int32_t brick)
{
    bench *b = &m->benches[(size_t)brick % m->bench_count];
    const size_t *size = m->level->geometry.size;
    pthread_mutex_lock(&b->lock);
    int32_t slot = __atomic_load_n(m->slots + brick, __ATOMIC_RELAXED);
    if (slot < 0) {
        const iso_cast_box box = iso_cast_box_of(size, m->brick_count, (size_t)brick);
        const int32_t page = __atomic_fetch_add(&m->next, 1, __ATOMIC_RELAXED);
        assert((size_t)page < m->capacity);
        read_scalars(m->level, &box, b->scalars);
        if (m->is_lit && m->level->codes)
            read_codes(m->level, &box, b->bytes);
        else if (b->codes)
            iso_box_codes_make(b->codes, box.first, box.count, b->bytes);
        iso_cast_pool_fill(&m->pool, &m->scalars, m->is_signed, size, &box, b->scalars, b->bytes, (size_t)page);
        slot = page * ISO_CAST_VOXELS;
        __atomic_store_n(m->slots + brick, slot, __ATOMIC_RELEASE);
    }
    pthread_mutex_unlock(&b->lock);
    return slot;
}

static iso_status create_benches(iso_cast_maker *m, iso_code code, int threads, iso_error *err)
{
    const bool makes_codes = m->is_lit && !m->level->codes;
    double scale = 1;
    iso_status status = makes_codes ? iso_level_gradient_scale(m->level, &scale, err) : ISO_OK;
    const size_t count = 4 * (size_t)threads; /* more than threads: two rarely want the same */
    m->benches = status == ISO_OK ? calloc(count, sizeof *m->benches) : NULL;
    if (status == ISO_OK && !m->benches)
        status = iso_fail(err, ISO_E_MEMORY, "cpu: no memory to make bricks");
    while (status == ISO_OK && m->bench_count < count) {
        bench *b = &m->benches[m->bench_count++];
        pthread_mutex_init(&b->lock, NULL);
        if (makes_codes)
            status = iso_box_codes_create(m->level, code, scale, ISO_CAST_ROW, &b->codes, err);
    }
    return status;
}

/* Creates a maker and sets the bricks of c, whose normals are known. ISO_E_MEMORY; destroy the maker then, too. */
static iso_status cast_make_on_demand(iso_cast_maker **maker, iso_cast *c, const iso_cast_made *of, iso_error *err)
{
    const iso_level *level = of->level;
    iso_cast_maker *m = *maker = calloc(1, sizeof *m);
    NEED_MEMORY(m, err, "cpu: out of memory");
    *m = (iso_cast_maker){.level = level,
                          .scalars = of->scalars,
                          .is_lit = c->normals != ISO_CAST_UNLIT,
                          .is_signed = c->is_signed,
                          .next = 1};
    size_t bricks = 1, bytes;
    for (int a = 0; a < 3; ++a) {
        c->brick_stride[a] = (int32_t)bricks;
        bricks *= m->brick_count[a] = level->geometry.size[a] / ISO_CAST_BRICK + 1;
    }
    m->slots = malloc(bricks * sizeof *m->slots);
    m->capacity = count_bricks(m, of->blocks) + 1;
    NEED_MEMORY(m->slots && iso_cast_pool_create(&m->pool, &m->scalars, m->is_lit, m->capacity, &bytes), err,
                "cpu: no memory for %zu bricks", bricks);
    memset(m->slots, -1, bricks * sizeof *m->slots);
    memset(iso_cast_pool_array(&m->pool), 0, ISO_CAST_VOXELS * iso_cast_voxel_bytes(&m->scalars, m->is_lit));
    iso_cast_pool_use(&m->pool, c);
    c->slots = m->slots;
    c->maker = m;
    c->make_brick = make_brick;
    return create_benches(m, of->code, of->threads, err);
}

static void cast_maker_destroy(iso_cast_maker *m)
{
    if (!m)
        return;
    for (size_t i = 0; i < m->bench_count; ++i) {
        pthread_mutex_destroy(&m->benches[i].lock);
        iso_box_codes_destroy(m->benches[i].codes);
    }
    free(m->benches);
    free(m->slots);
    free(iso_cast_pool_array(&m->pool));
    free(m);
}

/* Returns the bytes of the bricks that were made. */
static double cast_maker_bytes(const iso_cast_maker *m)
{
    return (double)m->next * ISO_CAST_VOXELS * (double)iso_cast_voxel_bytes(&m->scalars, m->is_lit);
}

enum { MOST_VOXELS = INT32_MAX - 2 * ISO_CAST_VOXELS };

iso_cpu_options iso_cpu_defaults(void)
{
    return (iso_cpu_options){.source = ISO_FROM_CODES};
}

/* ---- the machine ---- */

iso_cpu_width iso_cpu_widest(void)
{
#ifdef ISO_CAST_HAS_X86
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
        return ISO_CPU_AVX512;
    if (__builtin_cpu_supports("avx2"))
        return ISO_CPU_AVX2;
#endif
    return ISO_CPU_BASELINE;
}

const char *iso_cpu_width_name(iso_cpu_width width)
{
    switch (width) {
    case ISO_CPU_AVX512: return "AVX-512, 16 rays at a time";
    case ISO_CPU_AVX2: return "AVX2, 8 rays at a time";
    case ISO_CPU_ONE: return "a ray at a time";
    default: return "4 rays at a time";
    }
}

iso_cast_paged_tile *iso_cast_paged_tile_of(iso_cpu_width width)
{
    if (width > iso_cpu_widest())
        return NULL;
    switch (width) {
    case ISO_CPU_ONE: return iso_cast_paged_tile_1;
    case ISO_CPU_BASELINE: return iso_cast_paged_tile_4;
#ifdef ISO_CAST_HAS_X86
    case ISO_CPU_AVX2: return iso_cast_paged_tile_8;
    case ISO_CPU_AVX512: return iso_cast_paged_tile_16;
#endif
    default: return NULL;
    }
}

static iso_cast_tile *tile_of(iso_cpu_width width)
{
    if (width > iso_cpu_widest())
        return NULL;
    switch (width) {
    case ISO_CPU_ONE: return iso_cast_tile_1;
    case ISO_CPU_BASELINE: return iso_cast_tile_4;
#ifdef ISO_CAST_HAS_X86
    case ISO_CPU_AVX2: return iso_cast_tile_8;
    case ISO_CPU_AVX512: return iso_cast_tile_16;
#endif
    default: return NULL;
    }
}

/* ---- the camera and the lights ---- */

static void copy(iso_vec3 v, double out[3])
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

void iso_cast_set_camera(iso_cast *c, const iso_geometry *g, const iso_view *view, double step_mm)
{
    const iso_camera *camera = &view->camera;
    const iso_mat3 to_index = iso_mat3_inverse(g->index_to_world);
    c->width = view->width;
    c->height = view->height;
    c->orthographic = camera->orthographic;
    c->half_width = camera->half_height * (double)view->width / (double)view->height;
    c->half_height = camera->half_height;
    c->step_mm = step_mm;
    c->cells_before = 0.5;
    copy(camera->forward, c->forward);
    copy(camera->right, c->right);
    copy(camera->up, c->up);
    copy(iso_geometry_to_index(g, camera->position), c->position);
    for (int i = 0; i < 9; ++i)
        c->to_index[i] = to_index.m[i / 3][i % 3];
    for (int a = 0; a < 3; ++a)
        c->box[a] = g->box_index[a];
    c->clip_count = view->clip_count;
    for (size_t i = 0; i < view->clip_count; ++i)
        iso_clip_in_index(&view->clips[i], g, c->clips[i]);
}

void iso_cast_set_light(iso_cast *c, const iso_view *view)
{
    const iso_shading *m = &view->shading;
    c->light_count = view->light_count;
    for (size_t i = 0; i < view->light_count; ++i) {
        copy(view->lights[i].direction, c->lights[i].direction);
        c->lights[i].diffuse = (float)(view->lights[i].intensity * m->diffuse);
        c->lights[i].specular = (float)(view->lights[i].intensity * m->specular);
    }
    c->specular = m->specular > 0;
    c->ambient = (float)m->ambient;
    c->power = (float)m->power;
    for (int a = 0; a < 3; ++a)
        c->background[a] = (float)view->background[a];
}

/* ---- the volume ---- */

void iso_cast_set_code(iso_cast *c, iso_code code, bool is_lit)
{
    const iso_code_info *info = iso_code_describe(code);
    c->normals = is_lit ? ISO_CAST_LATTICE : ISO_CAST_UNLIT;
    c->is_signed = info->is_signed;
    c->decoder = info->decoder;
}

iso_status iso_cast_own(iso_cpu_scene *s, void *array, size_t bytes, iso_error *err)
{
    NEED_MEMORY(array, err, "cpu: no memory for %zu bytes of bricks", bytes);
    s->arrays[s->array_count++] = array;
    s->bytes += (double)bytes;
    return ISO_OK;
}

static bool is_small_integer(iso_type type)
{
    return type == ISO_U8 || type == ISO_I8 || type == ISO_U16 || type == ISO_I16;
}

static bool takes_integers(const iso_level *level)
{
    return is_small_integer(level->stored_type) && level->max - level->min <= 65535 &&
           level->min == floor(level->min) && !level->made_for_scene;
}

iso_cast_scalars iso_cast_scalars_of(const iso_level *level)
{
    return (iso_cast_scalars){takes_integers(level), level->min, level->max - level->min};
}

double iso_cast_unit(const iso_cast_scalars *scalars)
{
    return scalars->are_integers ? 1 : scalars->range;
}

/* Sets the scalars if no codes are interleaved with them. */
static iso_status set_scalar(iso_cpu_scene *s, const iso_cast_grid *grid, const iso_level *level, iso_error *err)
{
    const iso_cast_scalars scalars = iso_cast_scalars_of(level);
    if (scalars.are_integers) {
        uint16_t *made = iso_cast_brick_integers(grid, &scalars, level->scalar);
        s->cast.integers = made;
        return iso_cast_own(s, made, grid->voxels * sizeof *made, err);
    }
    float *made = iso_cast_brick_floats(grid, &scalars, level->scalar);
    s->cast.floats = made;
    return iso_cast_own(s, made, grid->voxels * sizeof *made, err);
}

static iso_status set_codes(iso_cpu_scene *s, const iso_cast_grid *grid, const iso_level *level, iso_code code,
                            iso_error *err)
{
    const iso_code_info *info = iso_code_describe(code);
    const iso_cast_scalars scalars = iso_cast_scalars_of(level);
    uint32_t *made = iso_cast_brick_voxels(grid, &scalars, level->scalar, level->codes, info->is_signed);
    s->cast.voxels = made;
    return iso_cast_own(s, made, (size_t)s->cast.voxel_words * grid->voxels * sizeof *made, err);
}

static iso_status set_vectors(iso_cpu_scene *s, const iso_cast_grid *grid, const iso_sampler *sampler, iso_error *err)
{
    for (int a = 0; a < 3; ++a) {
        float *made = iso_cast_brick_component(grid, sampler, a);
        s->cast.vectors[a] = made;
        NEED(iso_cast_own(s, made, grid->voxels * sizeof *made, err));
    }
    return ISO_OK;
}

static iso_status set_directions(iso_cpu_scene *s, const iso_cast_grid *grid, const iso_level *level, iso_code code,
                                 iso_direction_source source, iso_error *err)
{
    iso_cast *c = &s->cast;
    if (source == ISO_FROM_ON_THE_FLY) {
        c->normals = ISO_CAST_ON_THE_FLY;
        return ISO_OK;
    }
    c->normals = source == ISO_FROM_FLIPPED           ? ISO_CAST_FLIPPED
                 : source == ISO_FROM_PALETTE_NEAREST ? ISO_CAST_NEAREST
                                                      : ISO_CAST_VECTORS;
    iso_sampler sampler;
    iso_status status = iso_sampler_create(&sampler, level, code, source, err);
    if (status == ISO_OK) {
        status = set_vectors(s, grid, &sampler, err);
        iso_sampler_destroy(&sampler);
    }
    return status;
}

/* Sets n = g / sqrt(|g|^2 + e^2), e = ISO_ON_THE_FLY_EPS range / spacing. g and e are divided by range / spacing. */
static void set_gradient(iso_cast *c, const iso_level *level, double unit)
{
    const double range = level->max - level->min;
    const iso_mat3 m = iso_mat3_scale(iso_geometry_gradient_to_world(&level->geometry),
                                      range > 0 ? 0.5 * unit * iso_geometry_min_spacing_mm(&level->geometry) / range
                                                : 0);
    for (int i = 0; i < 9; ++i)
        c->gradient_to_world[i] = (float)m.m[i / 3][i % 3];
    c->on_the_fly_eps = (float)ISO_ON_THE_FLY_EPS;
}

static iso_status set_bytes(iso_cpu_scene *s, const iso_cast_grid *grid, const uint8_t *bytes, const uint16_t **out,
                            iso_error *err)
{
    if (!bytes)
        return ISO_OK;
    uint16_t *made = iso_cast_brick_bytes(grid, bytes);
    *out = made;
    return iso_cast_own(s, made, grid->voxels * sizeof *made, err);
}

/* Checks a level whose bricks are made from its samples: directions are its codes. */
static bool can_make_bricks(const iso_view *view, const iso_cpu_options *opt)
{
    return (opt->source == ISO_FROM_CODES || !iso_view_is_lit(view)) && !view->tf_2d && !view->extinction_scale;
}

static iso_status check_samples(const iso_view *view, const iso_cpu_options *opt, iso_error *err)
{
    return can_make_bricks(view, opt)
               ? ISO_OK
               : iso_fail(err, ISO_E_RANGE,
                          "cpu: other directions than codes, 2D transfer functions and scales of extinction need a "
                          "whole level");
}

/* Sets voxels, directions and channels of a whole level. */
static iso_status set_level(iso_cpu_scene *s, const iso_cast_grid *grid, const iso_level *level, iso_code code,
                            const iso_view *view, const iso_cpu_options *opt, iso_error *err)
{
    const bool is_lit = iso_view_is_lit(view), has_codes = is_lit && opt->source == ISO_FROM_CODES;
    int32_t stride = ISO_CAST_VOXELS;
    for (int a = 0; a < 3; ++a) {
        s->cast.brick_stride[a] = stride;
        stride = (int32_t)((size_t)stride * grid->count[a]);
    }
    NEED(has_codes ? set_codes(s, grid, level, code, err) : set_scalar(s, grid, level, err));
    if (is_lit && !has_codes)
        NEED(set_directions(s, grid, level, code, opt->source, err));
    if (view->tf_2d)
        NEED(set_bytes(s, grid, view->tf_2d->bytes, &s->cast.second, err));
    return set_bytes(s, grid, view->extinction_scale, &s->cast.scale, err);
}

/* ---- the transfer function ---- */

static void fill_row(const iso_tf_table *tf, double step_mm, float *out)
{
    static const int from[4] = {3, 0, 1, 2}; /* depth, red, green, blue */
    for (size_t i = 0; i < tf->count; ++i)
        for (int k = 0; k < 4; ++k) {
            const float *here = tf->entries + 4 * i + from[k], *next = i + 1 < tf->count ? here + 4 : here;
            const double scale = k == 0 ? step_mm : 1;
            out[ISO_CAST_ENTRY * i + (size_t)(2 * k)] = (float)(scale * (double)*here);
            out[ISO_CAST_ENTRY * i + (size_t)(2 * k + 1)] = (float)(scale * ((double)*next - (double)*here));
        }
}

iso_status iso_cast_own_tf(iso_cpu_scene *s, const iso_view *view, double min, double unit, iso_error *err)
{
    size_t bytes;
    float *entries = iso_cast_set_tf(&s->cast, view, min, unit, &bytes);
    return iso_cast_own(s, entries, bytes, err);
}

float *iso_cast_set_tf(iso_cast *c, const iso_view *view, double min, double unit, size_t *bytes)
{
    const iso_tf_table *tf = view->tf_2d ? &view->tf_2d->rows[0] : &view->tf;
    const size_t rows = view->tf_2d ? ISO_TF_2D_ROWS : 1, floats = rows * tf->count * ISO_CAST_ENTRY;
    float *entries = malloc(floats * sizeof *entries);
    *bytes = floats * sizeof *entries;
    if (!entries)
        return NULL;
    for (size_t row = 0; row < rows; ++row)
        fill_row(view->tf_2d ? &view->tf_2d->rows[row] : tf, c->step_mm, entries + row * tf->count * ISO_CAST_ENTRY);
    const double per_value = (double)(tf->count - 1) / (tf->hi - tf->lo);
    c->entries = entries;
    c->entry_count = (int32_t)tf->count;
    c->row_count = view->tf_2d ? ISO_TF_2D_ROWS : 0;
    c->entries_per_value = (float)(per_value * unit);
    c->first_entry = (float)(per_value * (min - tf->lo));
    return entries;
}

/* Returns a margin for float roundings: five along the way to a place, nine to a ray's exit from a cube of blocks. Each
 * is relative to the volume's length or that of the largest cube: 16 are enough. */
static float margin_of(const iso_geometry *g)
{
    double most = ISO_OCTANT_MOST << ISO_CAST_BLOCK_SHIFT;
    for (int a = 0; a < 3; ++a)
        most = fmax(most, (double)(g->size[a] + 2 * ISO_CAST_OUTER));
    return (float)(16 * 0x1p-24 * most);
}

iso_status iso_cast_use_blocks(iso_cpu_scene *s, const iso_geometry *g, const iso_view *view, iso_cast_blocks *b,
                               iso_error *err)
{
    iso_cast *c = &s->cast;
    const iso_screen_blocks blocks = {b->octants,
                                      {b->count[0], b->count[1], b->count[2]},
                                      1 << ISO_CAST_BLOCK_SHIFT,
                                      -c->cells_before};
    const iso_status status = iso_screen_reach_create(&s->reach, g, view, &blocks, err);
    for (int a = 0; a < 3; ++a)
        c->block_count[a] = (int32_t)b->count[a];
    c->blocks = (int32_t)b->blocks;
    c->octants = b->octants;
    c->cells = (const int32_t *)b->cells;
    c->margin = margin_of(g);
    c->reach_mm = s->reach.mm;
    c->reach_columns = s->reach.columns;
    iso_status owned = iso_cast_own(s, b->octants, ISO_OCTANTS * b->blocks, err);
    if (owned == ISO_OK)
        owned = iso_cast_own(s, b->cells, 2 * sizeof *b->cells * b->blocks, err);
    *b = (iso_cast_blocks){0};
    return status == ISO_OK ? owned : status;
}

/* True if bricks are made on demand: there is nothing else, or it takes less time. */
static bool makes_bricks(const iso_level *level, const iso_view *view, const iso_cpu_options *opt)
{
    return !level->scalar || (opt->once && !level->labels && can_make_bricks(view, opt));
}

/* Finds empty space, and sets bricks that are made on demand. */
static iso_status set_blocks(iso_cpu_scene *s, const iso_level *level, iso_code code, const iso_view *view,
                             const iso_cpu_options *opt, iso_error *err)
{
    const bool looks = opt->skip != ISO_CPU_SKIP_NEVER;
    OWNED(iso_tf_table) envelope = {0};
    OWNED(iso_cast_blocks) blocks = {0};
    if (view->tf_2d)
        NEED(iso_tf_2d_envelope(view->tf_2d, &envelope, err));
    if (looks)
        NEED(iso_cast_blocks_create(&blocks, level, view->tf_2d ? &envelope : &view->tf, s->threads, err));
    const bool skips = looks && (opt->skip == ISO_CPU_SKIP_ALWAYS || blocks.occupied <= ISO_CPU_SKIP_OCCUPIED);
    if (makes_bricks(level, view, opt))
        NEED(cast_make_on_demand(&s->maker, &s->cast,
                                 &(iso_cast_made){level, code, iso_cast_scalars_of(level), skips ? &blocks : NULL,
                                                  s->threads},
                                 err));
    return skips ? iso_cast_use_blocks(s, &level->geometry, view, &blocks, err) : ISO_OK;
}

/* ---- all of it ---- */

bool iso_cpu_takes(const iso_geometry *g)
{
    return iso_cast_grid_of(g, 1).voxels <= MOST_VOXELS;
}

static iso_status check(const iso_view *view, const iso_cast_grid *grid, double step_voxels, iso_error *err)
{
    if (view->roi)
        return iso_fail(err, ISO_E_USAGE, "cpu: a region of interest is rendered by the reference and by OpenGL");
    if (!(step_voxels > 0 && isfinite(step_voxels)))
        return iso_fail(err, ISO_E_RANGE, "cpu: step %g voxels, must be above 0", step_voxels);
    if (grid->voxels > MOST_VOXELS)
        return iso_fail(err, ISO_E_RANGE,
                        "cpu: %zu voxels in bricks, at most %d; take a coarser level, or bricks of a pyramid on disk",
                        grid->voxels, (int)MOST_VOXELS);
    return ISO_OK;
}

static iso_status fill(iso_cpu_scene *s, const iso_level *level, iso_code code, const iso_view *view,
                       const iso_cpu_options *opt, iso_error *err)
{
    const iso_geometry *g = &level->geometry;
    const iso_cast_grid grid = iso_cast_grid_of(g, opt->threads);
    const double step_voxels = opt->step_voxels > 0 ? opt->step_voxels : view->step_voxels;
    NEED(check(view, &grid, step_voxels, err));
    const iso_cast_scalars scalars = iso_cast_scalars_of(level);
    const double unit = iso_cast_unit(&scalars);
    for (int a = 0; a < 3; ++a)
        s->cast.size[a] = (int32_t)g->size[a];
    iso_cast_set_camera(&s->cast, g, view, step_voxels * iso_geometry_min_spacing_mm(iso_view_step_geometry(view, g)));
    iso_cast_set_light(&s->cast, view);
    iso_cast_set_code(&s->cast, code, iso_view_is_lit(view));
    s->cast.labels = level->labels;
    s->cast.has_integers = scalars.are_integers;
    s->cast.voxel_words = iso_cast_voxel_words(&scalars);
    set_gradient(&s->cast, level, unit);
    NEED(makes_bricks(level, view, opt) ? check_samples(view, opt, err)
                                        : set_level(s, &grid, level, code, view, opt, err));
    NEED(iso_cast_own_tf(s, view, level->min, unit, err));
    return set_blocks(s, level, code, view, opt, err);
}

iso_status iso_cast_begin(iso_cpu_scene **scene, iso_cpu_width width, int threads, iso_error *err)
{
    iso_cpu_scene *s = *scene = calloc(1, sizeof *s);
    NEED_MEMORY(s, err, "cpu: out of memory");
    s->threads = iso_threads(threads);
    s->tile = tile_of(width ? width : iso_cpu_widest());
    return s->tile ? ISO_OK
                   : iso_fail(err, ISO_E_RANGE, "cpu: this machine does not cast %d rays at a time", (int)width);
}

iso_status iso_cpu_prepare(iso_cpu_scene **scene, const iso_level *level, iso_code code, const iso_view *view,
                           const iso_cpu_options *opt, iso_error *err)
{
    iso_status status = iso_cast_begin(scene, opt->width, opt->threads, err);
    TRY(status, fill(*scene, level, code, view, opt, err));
    if (status != ISO_OK) {
        iso_cpu_release(*scene);
        *scene = NULL;
    }
    return status;
}

void iso_cpu_release(iso_cpu_scene *s)
{
    if (!s)
        return;
    for (size_t i = 0; i < s->array_count; ++i)
        free(s->arrays[i]);
    iso_screen_reach_destroy(&s->reach);
    cast_maker_destroy(s->maker);
    free(s);
}

double iso_cpu_bytes(const iso_cpu_scene *s)
{
    return s->bytes + (s->maker ? cast_maker_bytes(s->maker) : 0);
}

void iso_cpu_draw(const iso_cpu_scene *s, iso_image *image)
{
    const size_t columns = (s->cast.width + ISO_CAST_TILE - 1) / ISO_CAST_TILE,
                 rows = (s->cast.height + ISO_CAST_TILE - 1) / ISO_CAST_TILE;
    const iso_progress *progress = iso_progress_current();
#pragma omp parallel for schedule(dynamic) num_threads(s->threads)
    for (size_t i = 0; i < columns * rows; ++i)
        if (!iso_progress_poll(progress))
            s->tile(&s->cast, i % columns * ISO_CAST_TILE, i / columns * ISO_CAST_TILE, image->rgba);
}

size_t iso_cpu_draw_repeatedly(const iso_cpu_scene *s, iso_image *image, size_t most, double enough,
                               bool processor_time, double *seconds)
{
    double sum = 0, (*clock)(void) = processor_time ? iso_cpu_seconds : iso_clock_seconds;
    size_t count = 0;
    do {
        const double start = clock();
        iso_cpu_draw(s, image);
        sum += seconds[count++] = clock() - start;
    } while (count < most && (!(enough > 0) || sum < enough));
    return count;
}

iso_status iso_cpu_render(const iso_level *level, iso_code code, const iso_view *view, const iso_cpu_options *opt,
                          iso_image *image, iso_error *err)
{
    iso_cpu_scene *scene;
    *image = (iso_image){0};
    iso_status status = iso_cpu_prepare(&scene, level, code, view, opt, err);
    TRY(status, iso_image_create(image, view->width, view->height, err));
    if (status == ISO_OK)
        iso_cpu_draw(scene, image);
    iso_cpu_release(scene);
    return status;
}
