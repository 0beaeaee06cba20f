/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "vdb/vdb.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/parallel.h"
#include "fit/extinction_scale.h"
#include "vdb/vdb_openvdb.h"
#include "volume/unit.h"

iso_vdb_options iso_vdb_defaults(void)
{
    return (iso_vdb_options){.half_float = false, .gradient = true, .pad_voxels = 0, .creator = "isoshade"};
}

const char *iso_vdb_version(void)
{
    return iso_openvdb_version();
}

/* What the readers of vdb_openvdb.h need to know of a level. */
typedef struct level_source {
    const iso_level *level;
    iso_code code;
    const uint8_t *tf_2d, *extinction_scale;
} level_source;

static size_t voxel_at(const iso_geometry *g, size_t x, size_t y, size_t z)
{
    return (z * g->size[1] + y) * g->size[0] + x;
}

static void read_scalar(const void *user, size_t x, size_t y, size_t z, size_t count, float *out)
{
    const level_source *s = user;
    memcpy(out, s->level->scalar + voxel_at(&s->level->geometry, x, y, z), count * sizeof *out);
}

static void read_directions(const void *user, size_t x, size_t y, size_t z, size_t count, float *out)
{
    const level_source *s = user;
    iso_code_decode_all(s->code, s->level->codes + 3 * voxel_at(&s->level->geometry, x, y, z), out, count);
}

static void read_tf_2d(const void *user, size_t x, size_t y, size_t z, size_t count, float *out)
{
    const level_source *s = user;
    const uint8_t *from = s->tf_2d + voxel_at(&s->level->geometry, x, y, z);
    for (size_t i = 0; i < count; ++i)
        out[i] = (float)(from[i] / 255.0);
}

static void read_log2_scale(const void *user, size_t x, size_t y, size_t z, size_t count, float *out)
{
    const level_source *s = user;
    const uint8_t *from = s->extinction_scale + voxel_at(&s->level->geometry, x, y, z);
    for (size_t i = 0; i < count; ++i)
        out[i] = (float)iso_extinction_scale_log2(from[i]);
}

/* World of a voxel's centre: origin + index_to_world (ijk + 1/2). */
static void center_transform(const iso_geometry *g, double m[3][4])
{
    iso_vec3 first = iso_geometry_to_world(g, iso_v3(0.5, 0.5, 0.5));
    const double translation[3] = {first.x, first.y, first.z};
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c)
            m[r][c] = g->index_to_world.m[r][c];
        m[r][3] = translation[r];
    }
}

bool iso_vdb_reverses_x(const iso_geometry *g)
{
    return iso_mat3_det(g->index_to_world) < 0;
}

static iso_status fail_by_code(int code, const char *path, const iso_vdb_message *message, iso_error *err)
{
    static const iso_status statuses[] = {[ISO_OPENVDB_OK] = ISO_OK,
                                          [ISO_OPENVDB_IO] = ISO_E_IO,
                                          [ISO_OPENVDB_NO_GRID] = ISO_E_FORMAT,
                                          [ISO_OPENVDB_MEMORY] = ISO_E_MEMORY,
                                          [ISO_OPENVDB_FAILED] = ISO_E_PROGRAM};
    return iso_fail(err, statuses[code], "%s: OpenVDB: %s", path, message->text);
}

static bool suits(double voxel_mm, double unit_mm)
{
    return voxel_mm >= 1e-3 * unit_mm && voxel_mm <= 1e3 * unit_mm;
}

/* The unit of a file whose geometries are in mm: one of unit.h. */
static const char *choose_unit(const iso_geometry *g, const char *preferred, double *mm)
{
    static const char *const units[] = {"m", "um", "nm", "pm"};
    const double voxel = iso_geometry_min_spacing_mm(g);
    const char *name = "mm";
    *mm = 1;
    if (voxel >= 1e-4 && voxel <= 1e5)
        return name;
    if (preferred && iso_unit_find(preferred, mm, &name) && suits(voxel, *mm))
        return name;
    for (size_t i = 0; i < sizeof units / sizeof *units; ++i)
        if (iso_unit_find(units[i], mm, &name) && suits(voxel, *mm))
            return name;
    *mm = 1;
    return "mm";
}

/* Geometry in the unit of the file, which is noted. */
static void take_unit(iso_vdb_source *source, const iso_geometry *g, const iso_vdb_options *opt)
{
    source->unit = "";
    source->unit_mm = opt->unit_mm;
    if (opt->unit_mm > 0) {
        const double origin[3] = {opt->origin_mm.x, opt->origin_mm.y, opt->origin_mm.z};
        memcpy(source->origin_mm, origin, sizeof origin);
        for (int a = 0; a < 3; ++a)
            source->spacing_mm[a] *= opt->unit_mm;
        if (opt->unit_mm == 1)
            source->unit = "mm";
        return;
    }
    source->unit = choose_unit(g, opt->unit, &source->unit_mm);
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c)
            source->index_to_world[r][c] /= source->unit_mm;
}

/* Fills in what a level and a lattice have alike. */
static iso_vdb_source describe(const iso_geometry *g, const char *made_from, const iso_vdb_options *opt)
{
    iso_vdb_source source = {.half_float = opt->half_float,
                             .creator = opt->creator ? opt->creator : "isoshade",
                             .made_from = made_from ? made_from : ""};
    memcpy(source.size, g->size, sizeof source.size);
    memcpy(source.box_index, g->box_index, sizeof source.box_index);
    iso_geometry_spacing_mm(g, source.spacing_mm);
    center_transform(g, source.index_to_world);
    take_unit(&source, g, opt);
    return source;
}

/* Index x becomes size - 1 - x, for a transform from the first voxel's centre. */
static void reverse_x(iso_vdb_source *s)
{
    s->reversed_x = true;
    for (int r = 0; r < 3; ++r) {
        s->index_to_world[r][3] += s->index_to_world[r][0] * (double)(s->size[0] - 1);
        s->index_to_world[r][0] = -s->index_to_world[r][0];
    }
}

typedef void read_row(const void *user, size_t x, size_t y, size_t z, size_t count, float *out);
typedef void read_activity(const void *user, size_t x, size_t y, size_t z, size_t count, unsigned char *out);

/* Readers of rows that run the other way. */
typedef struct reversed_rows {
    read_row *read;
    read_activity *read_active;
    const void *user;
    size_t width, channels;
} reversed_rows;

static void read_reversed(const void *user, size_t x, size_t y, size_t z, size_t count, float *out)
{
    const reversed_rows *r = user;
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
    const reversed_rows *r = user;
    r->read_active(r->user, r->width - x - count, y, z, count, out);
    for (size_t i = 0, j = count - 1; i < j; ++i, --j) {
        unsigned char t = out[i];
        out[i] = out[j];
        out[j] = t;
    }
}

/* Of all grids but the first: from 0 to 1, or what bytes give. */
static void set_range(iso_vdb_source *s, bool is_log2_scale)
{
    s->value_min = is_log2_scale ? iso_extinction_scale_log2(0) : 0;
    s->value_max = is_log2_scale ? iso_extinction_scale_log2(ISO_EXTINCTION_SCALE_LAST) : 1;
    s->background = 0;
}

/* A level's grids: those that can be read. `common` is complete but for what tells them apart; its transform is
 * reversed where rows are to be. */
typedef struct level_readers {
    read_row *scalar, *directions, *tf_2d, *log2_scale;
} level_readers;

static iso_status add_grids(iso_vdb_file *file, const iso_vdb_source *common, const level_readers *readers,
                            bool reversed, bool plain_names, const char *path, iso_error *err)
{
    const struct {
        const char *base, *meaning;
        int channels;
        read_row *read;
    } grids[] = {{"density", "the scalar", 1, readers->scalar},
                 {"gradient",
                  "direction of the scalar's gradient in world axes; length: how far it can be trusted, 0: none", 3,
                  readers->directions},
                 {"second_value", "second value of the 2D transfer function: 0 in its first row, 1 in its last", 1,
                  readers->tf_2d},
                 {"log2_extinction_scale", "the extinction is multiplied by 2 to the power of this", 1,
                  readers->log2_scale}};
    enum { SCALE_GRID = 3 };
    for (size_t i = 0; i < sizeof grids / sizeof *grids; ++i) {
        char name[40];
        iso_vdb_source source = *common;
        if (!grids[i].read)
            continue;
        snprintf(name, sizeof name, plain_names ? "%s" : "%s_level_%d", grids[i].base, source.level);
        source.name = name;
        source.channels = grids[i].channels;
        source.read = grids[i].read;
        source.meaning = grids[i].meaning;
        if (i > 0)
            set_range(&source, i == SCALE_GRID);
        if (i > 0)
            source.labels = NULL;
        else if (source.labels)
            source.meaning = "labels, which are looked up without interpolation";
        const reversed_rows rows = {source.read, source.read_active, source.user, source.size[0],
                                    (size_t)source.channels};
        if (reversed) {
            source.user = &rows;
            source.read = read_reversed;
            source.read_active = rows.read_active ? read_reversed_activity : NULL;
        }
        iso_vdb_message message = {""};
        int code = iso_vdb_file_add(file, &source, &message);
        if (code != ISO_OPENVDB_OK)
            return fail_by_code(code, path, &message, err);
    }
    return ISO_OK;
}

/* Voxel 0 gets the index `first` along each axis, and stays where it is in the world. */
static void begin_at(iso_vdb_source *source, const long first[3])
{
    for (int a = 0; a < 3; ++a) {
        source->first[a] = first[a];
        for (int r = 0; r < 3; ++r)
            source->index_to_world[r][3] -= source->index_to_world[r][a] * (double)first[a];
    }
}

static iso_status add_level(iso_vdb_file *file, const iso_pyramid *p, size_t k, bool plain_names, const char *path,
                            const iso_vdb_options *opt, iso_error *err)
{
    const iso_level *level = &p->levels[k];
    const level_source user = {level, p->options.code, opt->tf_2d, opt->extinction_scale};
    iso_vdb_source source = describe(&level->geometry, p->source, opt);
    source.pad = opt->pad_voxels;
    source.user = &user;
    source.level = (int)k;
    source.value_min = level->min;
    source.value_max = level->max;
    const level_readers readers = {read_scalar, opt->gradient ? read_directions : NULL, opt->tf_2d ? read_tf_2d : NULL,
                                   opt->extinction_scale ? read_log2_scale : NULL};
    const bool reversed = iso_vdb_reverses_x(&level->geometry);
    if (reversed)
        reverse_x(&source);
    /* Cycles marks one voxel more on each side as its own, and up to Blender 5.1 it bounds a grid wrongly that then has
     * negative indices: parts of levels of a few voxels were not drawn (projects.blender.org, issue 141488). */
    const long first = opt->pad_voxels > 0 ? (long)opt->pad_voxels + 1 : 0;
    begin_at(&source, (const long[3]){first, first, first});
    char *segments = level->segments ? json_dumps(level->segments, JSON_COMPACT | JSON_REAL_PRECISION(6)) : NULL;
    if (level->labels)
        source.labels = segments ? segments : "[]";
    const iso_status status = add_grids(file, &source, &readers, reversed, plain_names, path, err);
    free(segments);
    return status;
}

/* ---- lattices ------------------------------------------------------------------ */

static const float *lattice_row(const iso_lattice *l, size_t x, size_t y, size_t z)
{
    return l->nodes + ISO_NODE_CHANNELS * (x + l->size[0] * (y + l->size[1] * z));
}

static void read_node_scalars(const void *user, size_t x, size_t y, size_t z, size_t count, float *out)
{
    const float *row = lattice_row(user, x, y, z);
    for (size_t i = 0; i < count; ++i)
        out[i] = row[ISO_NODE_CHANNELS * i];
}

static void read_node_directions(const void *user, size_t x, size_t y, size_t z, size_t count, float *out)
{
    const float *row = lattice_row(user, x, y, z);
    for (size_t i = 0; i < count; ++i)
        memcpy(out + 3 * i, row + ISO_NODE_CHANNELS * i + 1, 3 * sizeof *out);
}

static void read_node_activity(const void *user, size_t x, size_t y, size_t z, size_t count, unsigned char *out)
{
    const iso_lattice *l = user;
    memcpy(out, l->active + x + l->size[0] * (y + l->size[1] * z), count);
}

static iso_status add_lattice(iso_vdb_file *file, const iso_lattice *l, const char *made_from, bool plain_names,
                              const char *path, const iso_vdb_options *opt, iso_error *err)
{
    iso_vdb_source source = describe(&l->geometry, made_from, opt);
    source.user = l;
    source.level = (int)l->level;
    source.value_min = l->min;
    source.value_max = l->max;
    source.background = (float)l->background;
    source.read_active = read_node_activity;
    const bool reversed = iso_vdb_reverses_x(&l->geometry);
    if (reversed)
        reverse_x(&source);
    /* Index 0 is the volume's first node, wherever the lattice begins; reversed, it is -1, and bricks still begin where
     * leaves do. */
    const long x = reversed ? -l->first[0] - (long)l->size[0] : l->first[0];
    begin_at(&source, (const long[3]){x, l->first[1], l->first[2]});
    const level_readers readers = {read_node_scalars, opt->gradient ? read_node_directions : NULL, NULL, NULL};
    return add_grids(file, &source, &readers, reversed, plain_names, path, err);
}

static iso_status check_levels(const iso_pyramid *p, size_t first, size_t count, const char *path,
                               const iso_vdb_options *opt, iso_error *err)
{
    if (count == 0 || first >= p->level_count || count > p->level_count - first)
        return iso_fail(err, ISO_E_RANGE, "%s: levels %zu to %zu, the pyramid has levels 0 to %zu", path, first,
                        first + count - 1, p->level_count - 1);
    if (opt->tf_2d && count != 1)
        return iso_fail(err, ISO_E_RANGE, "%s: a 2D transfer function with %zu levels, it belongs to one", path, count);
    if (opt->extinction_scale && count != 1)
        return iso_fail(err, ISO_E_RANGE, "%s: an extinction scale with %zu levels, it belongs to one", path, count);
    const size_t limit = 64;
    if (opt->pad_voxels > limit)
        return iso_fail(err, ISO_E_RANGE, "%s: a rim of %zu voxels, at most %zu", path, opt->pad_voxels, limit);
    for (int a = 0; a < 3; ++a)
        if (p->levels[first].geometry.size[a] > INT_MAX - 2 * limit)
            return iso_fail(err, ISO_E_RANGE, "%s: %zu voxels along an axis, OpenVDB takes at most %zu", path,
                            p->levels[first].geometry.size[a], INT_MAX - 2 * limit);
    return ISO_OK;
}

/* What to save: levels of a pyramid, or lattices. */
typedef struct save_job {
    const iso_pyramid *pyramid;
    size_t first;
    const iso_lattice *lattices;
    const char *made_from;
    size_t count;
} save_job;

static iso_status save(const save_job *job, const char *path, const iso_vdb_options *opt, const iso_progress *progress,
                       iso_error *err)
{
    iso_output out = {0};
    iso_status status = iso_output_begin(&out, path, err);
    if (status != ISO_OK)
        return status;
    iso_vdb_file *file = iso_vdb_file_create();
    if (!file)
        status = iso_fail(err, ISO_E_MEMORY, "%s: OpenVDB cannot be started", path);
    for (size_t i = 0; i < job->count && status == ISO_OK; ++i) {
        iso_progress_report(progress, "OpenVDB grids", (double)i / (double)(job->count + 1));
        status = job->pyramid ? add_level(file, job->pyramid, job->first + i, job->count == 1, path, opt, err)
                              : add_lattice(file, &job->lattices[i], job->made_from, job->count == 1, path, opt, err);
    }
    if (status == ISO_OK) {
        iso_vdb_message message = {""};
        int code = iso_vdb_file_write(file, out.temp_path, &message);
        if (code != ISO_OPENVDB_OK)
            status = fail_by_code(code, path, &message, err);
    }
    iso_vdb_file_destroy(file);
    if (status == ISO_OK)
        status = iso_output_commit(&out, err);
    iso_output_abandon(&out);
    iso_progress_report(progress, "OpenVDB grids", 1);
    return status;
}

iso_status iso_vdb_save(const iso_pyramid *p, size_t first, size_t count, const char *path, const iso_vdb_options *opt,
                        const iso_progress *progress, iso_error *err)
{
    iso_status status = check_levels(p, first, count, path, opt, err);
    const save_job job = {.pyramid = p, .first = first, .count = count};
    return status == ISO_OK ? save(&job, path, opt, progress, err) : status;
}

iso_status iso_vdb_save_lattices(const iso_lattice *lattices, size_t count, const char *made_from, const char *path,
                                 const iso_vdb_options *opt, const iso_progress *progress, iso_error *err)
{
    const save_job job = {.lattices = lattices, .count = count, .made_from = made_from};
    return save(&job, path, opt, progress, err);
}

iso_status iso_vdb_measure(const char *path, iso_vdb_stats *stats, iso_error *err)
{
    iso_vdb_message message = {""};
    struct stat about;
    *stats = (iso_vdb_stats){0};
    if (stat(path, &about) != 0)
        return iso_fail(err, ISO_E_IO, "%s: no such file", path);
    double start = iso_clock_seconds();
    int code = iso_openvdb_measure(path, &stats->active_voxels, &stats->memory_bytes, &message);
    stats->read_seconds = iso_clock_seconds() - start;
    stats->file_bytes = (size_t)about.st_size;
    return code == ISO_OPENVDB_OK ? ISO_OK : fail_by_code(code, path, &message, err);
}

iso_status iso_vdb_load_grid(const char *path, const char *grid, int channels, const size_t size[3], float *out,
                             iso_geometry *geometry, iso_error *err)
{
    if (channels != 1 && channels != 3)
        return iso_fail(err, ISO_E_RANGE, "%s: %d channels, a grid has 1 or 3", path, channels);
    if (!iso_path_exists(path))
        return iso_fail(err, ISO_E_IO, "%s: no such file", path);
    iso_vdb_grid_info info;
    iso_vdb_message message = {""};
    int code = iso_openvdb_read(path, grid, channels, size, out, &info, &message);
    if (code == ISO_OPENVDB_IO) /* the file is there, so it is its content */
        return iso_fail(err, ISO_E_FORMAT, "%s: cannot be read as OpenVDB: %s", path, message.text);
    if (code != ISO_OPENVDB_OK)
        return fail_by_code(code, path, &message, err);
    if (!geometry)
        return ISO_OK;
    *geometry = (iso_geometry){.size = {size[0], size[1], size[2]}};
    memcpy(geometry->box_index, info.box_index, sizeof info.box_index);
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
            geometry->index_to_world.m[r][c] = info.unit_mm * info.index_to_world[r][c];
    iso_vec3 half = iso_mul(geometry->index_to_world, iso_v3(0.5, 0.5, 0.5));
    const iso_vec3 first = iso_v3(info.index_to_world[0][3], info.index_to_world[1][3], info.index_to_world[2][3]);
    const iso_vec3 origin = iso_v3(info.origin_mm[0], info.origin_mm[1], info.origin_mm[2]);
    geometry->origin_mm = iso_sub(iso_madd(origin, first, info.unit_mm), half);
    return iso_geometry_check(geometry, path, err);
}
