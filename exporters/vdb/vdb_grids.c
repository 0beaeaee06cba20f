/* SPDX-License-Identifier: MIT */
/* vdb_grids.c - the grids of a level and of a lattice, as sources of rows. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fit/extinction_scale.h"
#include "pyramid/narrow.h"
#include "vdb/vdb_file.h"

typedef void read_row(const void *user, size_t x, size_t y, size_t z, size_t count, float *out);
typedef void read_activity(const void *user, size_t x, size_t y, size_t z, size_t count, unsigned char *out);

/* ---- rows of a level -------------------------------------------------------------- */

static size_t voxel_at(const iso_geometry *g, size_t x, size_t y, size_t z)
{
    return (z * g->size[1] + y) * g->size[0] + x;
}

static void read_scalar(const void *user, size_t x, size_t y, size_t z, size_t count, float *out)
{
    const iso_vdb_grids *s = user;
    iso_level_file_scalars(s->level, s->volume, voxel_at(&s->level->geometry, x, y, z), count, out);
}

static void read_directions(const void *user, size_t x, size_t y, size_t z, size_t count, float *out)
{
    const iso_vdb_grids *s = user;
    const uint8_t *codes = s->level->codes ? s->level->codes + 3 * voxel_at(&s->level->geometry, x, y, z)
                                           : iso_narrow_codes_at(&s->made, x, y, z);
    iso_code_decode_all(s->code, codes, out, count);
    for (size_t i = 0; i < 3 * count && s->direction_scale != 1; ++i)
        out[i] *= s->direction_scale;
}

static bool prepare_directions(void *user, const size_t first[3], const size_t end[3])
{
    return iso_narrow_codes_make(user, first, end, NULL) == ISO_OK;
}

static void read_tf_2d(const void *user, size_t x, size_t y, size_t z, size_t count, float *out)
{
    const iso_vdb_grids *s = user;
    const uint8_t *from = s->tf_2d + voxel_at(&s->level->geometry, x, y, z);
    for (size_t i = 0; i < count; ++i)
        out[i] = (float)(from[i] / 255.0);
}

static void read_log2_scale(const void *user, size_t x, size_t y, size_t z, size_t count, float *out)
{
    const iso_vdb_grids *s = user;
    const uint8_t *from = s->extinction_scale + voxel_at(&s->level->geometry, x, y, z);
    for (size_t i = 0; i < count; ++i)
        out[i] = (float)iso_extinction_scale_log2(from[i]);
}

static void read_bits(const iso_vdb_activity *a, const uint8_t *bits, const size_t first[3], size_t count,
                      unsigned char *out)
{
    for (size_t i = 0; i < count; ++i)
        out[i] = iso_vdb_activity_bit(a, bits,
                                      (const size_t[]){first[0] + i + a->skip, first[1] + a->skip, first[2] + a->skip});
}

static void read_kept(const void *user, size_t x, size_t y, size_t z, size_t count, unsigned char *out)
{
    const iso_vdb_activity *a = user;
    read_bits(a, a->kept, (const size_t[]){x, y, z}, count, out);
}

static void read_lit(const void *user, size_t x, size_t y, size_t z, size_t count, unsigned char *out)
{
    const iso_vdb_activity *a = user;
    read_bits(a, a->lit, (const size_t[]){x, y, z}, count, out);
}

/* ---- rows in reverse order --------------------------------------------------------- */

bool iso_vdb_reverses_x(const iso_geometry *g)
{
    return iso_mat3_det(g->index_to_world) < 0;
}

/* Maps index x to size - 1 - x, for a transform from the first voxel's center. */
static void reverse_x(iso_vdb_source *s)
{
    s->reversed_x = true;
    for (int r = 0; r < 3; ++r) {
        s->index_to_world[r][3] += s->index_to_world[r][0] * (double)(s->size[0] - 1);
        s->index_to_world[r][0] = -s->index_to_world[r][0];
    }
}

static void read_reversed(const void *user, size_t x, size_t y, size_t z, size_t count, float *out)
{
    const iso_vdb_reversed *r = user;
    r->read(r->user, r->width - x - count, y, z, count, out);
    for (size_t i = 0, j = count - 1; i < j; ++i, --j)
        for (size_t c = 0; c < r->channels; ++c) {
            float t = out[r->channels * i + c];
            out[r->channels * i + c] = out[r->channels * j + c];
            out[r->channels * j + c] = t;
        }
}

static void read_reversed_activity(const void *user, size_t x, size_t y, size_t z, size_t count, unsigned char *out)
{
    const iso_vdb_reversed *r = user;
    r->read_active(r->active_user, r->wide - x - count, y, z, count, out);
    for (size_t i = 0, j = count - 1; i < j; ++i, --j) {
        unsigned char t = out[i];
        out[i] = out[j];
        out[j] = t;
    }
}

static bool prepare_reversed(void *user, const size_t first[3], const size_t end[3])
{
    const iso_vdb_reversed *r = user;
    return r->prepare(r->prepare_user, (const size_t[]){r->width - end[0], first[1], first[2]},
                      (const size_t[]){r->width - first[0], end[1], end[2]});
}

/* ---- grids -------------------------------------------------------------------------- */

double iso_vdb_direction_scale(iso_code code)
{
    const iso_code_info *info = iso_code_describe(code);
    return info->is_linear && info->is_signed ? ISO_VDB_LINEAR_SCALE : 1;
}

/* True if a half float holds the value: 11 significant bits, from 2^-14 to 65504. */
static bool is_half(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    const uint32_t exponent = bits >> 23 & 0xff;
    return (bits & 0x1fff) == 0 && ((bits & 0x7fffffff) == 0 || (exponent >= 127 - 14 && exponent <= 127 + 15));
}

static bool are_halves(const iso_level *level, const iso_volume *volume)
{
    enum { BLOCK = 1024 };
    const size_t count = iso_geometry_voxel_count(&level->geometry);
    float values[BLOCK];
    if (!level->scalar && iso_type_bytes(volume->type) == 1)
        return true;
    for (size_t at = 0; at < count; at += BLOCK) {
        const size_t n = count - at < BLOCK ? count - at : BLOCK;
        iso_level_file_scalars(level, volume, at, n, values);
        for (size_t i = 0; i < n; ++i)
            if (!is_half(values[i]))
                return false;
    }
    return true;
}

/* Sets the range of all grids except the first: 0 to 1, or that of the bytes. */
static void set_range(iso_vdb_source *s, bool is_log2_scale)
{
    s->value_min = is_log2_scale ? iso_extinction_scale_log2(0) : 0;
    s->value_max = is_log2_scale ? iso_extinction_scale_log2(ISO_EXTINCTION_SCALE_LAST) : 1;
    s->background = 0;
}

/* Sources of the grids. `common` is complete except for their differences; its transform is already reversed if rows
 * are. */
typedef struct grid_readers {
    read_row *scalar, *directions, *tf_2d, *log2_scale;
    read_activity *kept, *lit;                                               /* for the scalar, for other grids */
    bool (*prepare)(void *user, const size_t first[3], const size_t end[3]); /* for directions, or NULL */
    bool reversed, half_scalar;
} grid_readers;

static void reverse_rows(iso_vdb_source *s, iso_vdb_reversed *r)
{
    *r = (iso_vdb_reversed){.read = s->read,
                            .read_active = s->read_active,
                            .user = s->user,
                            .active_user = s->active_user,
                            .prepare = s->prepare,
                            .prepare_user = s->prepare_user,
                            .width = s->size[0],
                            .wide = s->size[0] + 2 * s->pad,
                            .channels = (size_t)s->channels};
    s->prepare = r->prepare ? prepare_reversed : NULL;
    s->prepare_user = r;
    s->read = read_reversed;
    s->user = r;
    s->read_active = r->read_active ? read_reversed_activity : NULL;
    s->active_user = r;
}

static iso_status add_grids(const iso_vdb_job *job, const iso_vdb_source *common, const grid_readers *readers,
                            iso_vdb_grids *owner, iso_error *err)
{
    const struct {
        const char *base, *meaning;
        int channels;
        read_row *read;
    } grids[ISO_VDB_MAX_GRIDS] = {
        {"density", "the scalar", 1, readers->scalar},
        {"gradient", "direction of the scalar's gradient in world axes; length: how far it can be trusted, 0: none", 3,
         readers->directions},
        {"second_value", "second value of the 2D transfer function: 0 in its first row, 1 in its last", 1,
         readers->tf_2d},
        {"log2_extinction_scale", "the extinction is multiplied by 2 to the power of this", 1, readers->log2_scale}};
    enum { SCALAR, GRADIENT, SECOND_VALUE, SCALE };
    for (size_t i = 0; i < ISO_VDB_MAX_GRIDS; ++i) {
        char name[40];
        iso_vdb_source source = *common;
        if (!grids[i].read)
            continue;
        snprintf(name, sizeof name, job->plain_names ? "%s" : "%s_level_%d", grids[i].base, source.level);
        source.name = name;
        source.channels = grids[i].channels;
        source.read = grids[i].read;
        source.read_active = i == SCALAR ? readers->kept : readers->lit;
        source.meaning = grids[i].meaning;
        source.prepare = i == GRADIENT ? readers->prepare : NULL;
        source.prepare_user = &owner->made;
        source.direction_scale = i == GRADIENT ? (double)owner->direction_scale : 1;
        source.half_float = job->opt->half_float || (i == SCALAR && readers->half_scalar) ||
                            (i == GRADIENT && job->opt->half_directions);
        if (i != SCALAR)
            set_range(&source, i == SCALE);
        if (i != SCALAR)
            source.labels = NULL;
        else if (source.labels)
            source.meaning = "labels, which are looked up without interpolation";
        source.fog_volume = i == SCALAR && !source.labels && source.value_min >= 0 && source.background == 0;
        if (readers->reversed)
            reverse_rows(&source, &owner->reversed[i]);
        NEED(iso_vdb_add(job, &source, err));
    }
    return ISO_OK;
}

void iso_vdb_begin_at(iso_vdb_source *source, const long first[3])
{
    for (int a = 0; a < 3; ++a) {
        source->first[a] = first[a];
        for (int r = 0; r < 3; ++r)
            source->index_to_world[r][3] -= source->index_to_world[r][a] * (double)first[a];
    }
}

iso_status iso_vdb_add_level(const iso_vdb_job *job, const iso_pyramid *p, size_t k, const iso_vdb_shown *shown,
                             iso_vdb_grids *grids, iso_error *err)
{
    const iso_level *level = &p->levels[k];
    const iso_vdb_options *opt = job->opt;
    const iso_code code = p->options.code;
    *grids = (iso_vdb_grids){.level = level,
                             .volume = opt->volume,
                             .code = code,
                             .tf_2d = opt->tf_2d,
                             .extinction_scale = !opt->extinction_scale && level->geometry.has_no_data
                                                     ? level->scale
                                                     : opt->extinction_scale,
                             .direction_scale = opt->half_directions ? (float)iso_vdb_direction_scale(code) : 1};
    iso_vdb_source source = iso_vdb_describe(&level->geometry, p->source, opt);
    source.pad = opt->pad_voxels;
    source.user = grids;
    source.active_user = &grids->activity;
    source.level = (int)k;
    source.value_min = level->min;
    source.value_max = level->max;
    const bool sparse = shown && !level->labels;
    if (sparse) {
        NEED(iso_vdb_activity_create(&grids->activity, level, opt->volume, shown, opt->pad_voxels, opt->threads, err));
        source.background = grids->activity.background;
    }
    const bool makes_codes = opt->gradient && !level->codes;
    if (makes_codes)
        NEED(iso_narrow_codes_begin(&grids->made, p, opt->volume, err));
    const grid_readers readers = {.scalar = read_scalar,
                                  .directions = opt->gradient ? read_directions : NULL,
                                  .tf_2d = opt->tf_2d ? read_tf_2d : NULL,
                                  .log2_scale = grids->extinction_scale ? read_log2_scale : NULL,
                                  .kept = sparse ? read_kept : NULL,
                                  .lit = sparse ? read_lit : NULL,
                                  .prepare = makes_codes ? prepare_directions : NULL,
                                  .reversed = iso_vdb_reverses_x(&level->geometry),
                                  .half_scalar = are_halves(level, opt->volume) && is_half(source.background)};
    if (readers.reversed)
        reverse_x(&source);
    /* Cycles adds one voxel on each side. Up to Blender 5.1 it bounds grids with negative indices wrongly, so that
     * parts of small levels were not drawn (projects.blender.org, issue 141488). */
    const long first = opt->pad_voxels > 0 ? (long)opt->pad_voxels + 1 : 0;
    iso_vdb_begin_at(&source, (const long[3]){first, first, first});
    FREED char *segments = level->segments ? json_dumps(level->segments, JSON_COMPACT | JSON_REAL_PRECISION(6)) : NULL;
    if (level->labels)
        source.labels = segments ? segments : "[]";
    return add_grids(job, &source, &readers, grids, err);
}

void iso_vdb_grids_destroy(iso_vdb_grids *grids)
{
    iso_vdb_activity_destroy(&grids->activity);
    iso_narrow_codes_destroy(&grids->made);
}

/* ---- lattices ------------------------------------------------------------------ */

/* Counts the nodes of `count` from (x, y, z) on that lie in one block; `in`: the first one's place in the block. */
static size_t run_of(const iso_lattice *l, size_t x, size_t y, size_t z, size_t count, const iso_lattice_block **block,
                     size_t *in)
{
    *block = *iso_lattice_block_of(l, x, y, z, in);
    const size_t left = ISO_LATTICE_SIDE - *in % ISO_LATTICE_SIDE;
    return left < count ? left : count;
}

static void read_node_scalars(const void *user, size_t x, size_t y, size_t z, size_t count, float *out)
{
    const iso_vdb_grids *s = user;
    const iso_lattice_block *block;
    for (size_t i = 0, in; i < count;)
        for (size_t run = run_of(s->lattice, x + i, y, z, count - i, &block, &in); run > 0; --run, ++in)
            out[i++] = block ? block->nodes[in][0] : s->lattice->empty[0];
}

static void read_node_directions(const void *user, size_t x, size_t y, size_t z, size_t count, float *out)
{
    const iso_vdb_grids *s = user;
    const iso_lattice_block *block;
    for (size_t i = 0, in; i < count;)
        for (size_t run = run_of(s->lattice, x + i, y, z, count - i, &block, &in); run > 0; --run, ++in, ++i)
            for (size_t c = 0; c < 3; ++c)
                out[3 * i + c] = block ? s->direction_scale * block->nodes[in][1 + c] : 0;
}

static void read_use(const iso_lattice *l, const size_t at[3], size_t count, iso_lattice_use least, unsigned char *out)
{
    const iso_lattice_block *block;
    for (size_t i = 0, in; i < count;)
        for (size_t run = run_of(l, at[0] + i, at[1], at[2], count - i, &block, &in); run > 0; --run, ++in)
            out[i++] = block && block->use[in] >= (uint8_t)least;
}

static void read_node_activity(const void *user, size_t x, size_t y, size_t z, size_t count, unsigned char *out)
{
    read_use(((const iso_vdb_grids *)user)->lattice, (const size_t[]){x, y, z}, count, ISO_LATTICE_HALO, out);
}

static void read_node_light(const void *user, size_t x, size_t y, size_t z, size_t count, unsigned char *out)
{
    read_use(((const iso_vdb_grids *)user)->lattice, (const size_t[]){x, y, z}, count, ISO_LATTICE_LIT, out);
}

/* True if values are whole numbers of bytes and no node lies between samples. */
static bool lattice_is_half(const iso_lattice *l)
{
    for (size_t i = 0; i < l->block_count[0] * l->block_count[1] * l->block_count[2]; ++i)
        for (size_t k = 0; l->blocks[i] && k < ISO_LATTICE_CUBE; ++k)
            if (!is_half(l->blocks[i]->nodes[k][0]))
                return false;
    return true;
}

/* Returns a multiple of the leaf size and of the coarsest bricks' size that makes all indices of a lattice positive. */
static long beginning(long first, long cells)
{
    const long margin = first - 2; /* Cycles adds a voxel on each side */
    return margin < 0 ? cells * ((-margin + cells - 1) / cells) : 0;
}

iso_status iso_vdb_add_lattice(const iso_vdb_job *job, const iso_lattice *l, const char *made_from,
                               iso_vdb_grids *grids, iso_error *err)
{
    enum { LEAF = 8 };
    const iso_vdb_options *opt = job->opt;
    *grids = (iso_vdb_grids){.lattice = l,
                             .direction_scale = opt->half_directions ? (float)ISO_VDB_LINEAR_SCALE : 1};
    iso_vdb_source source = iso_vdb_describe(&l->geometry, made_from, opt);
    source.user = source.active_user = grids;
    source.level = (int)l->level;
    source.value_min = l->min;
    source.value_max = l->max;
    source.background = (float)l->background;
    const bool reversed = iso_vdb_reverses_x(&l->geometry);
    if (reversed)
        reverse_x(&source);
    /* Bricks start at leaf borders: the volume's first node, which is the last one along a reversed x, gets a multiple
     * of 8 as its index. Not 0, because a rim lies before it, and Cycles bounds grids with negative indices wrongly. */
    long first[3] = {reversed ? -l->first[0] - (long)l->size[0] : l->first[0], l->first[1], l->first[2]};
    for (int a = 0; a < 3; ++a)
        first[a] += beginning(first[a], LEAF);
    iso_vdb_begin_at(&source, first);
    const grid_readers readers = {.scalar = read_node_scalars,
                                  .directions = opt->gradient ? read_node_directions : NULL,
                                  .kept = read_node_activity,
                                  .lit = read_node_light,
                                  .reversed = reversed,
                                  .half_scalar = opt->half_directions && lattice_is_half(l)};
    return add_grids(job, &source, &readers, grids, err);
}
