/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "povray/povray_files.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/provenance.h"
#include "base/words.h"
#include "brick/lattice.h"
#include "encode/code.h"
#include "povray/df3.h"
#include "povray/scene_parts.h"
#include "pyramid/narrow.h"
#include "scene/roi.h"

/* ---- samples of a lattice ---- */

/* A sparse lattice as samples of DF3 files, row by row, without making a dense level. */
typedef struct lattice_samples {
    const iso_lattice *lattice; /* borrowed */
    iso_code code;              /* directions are encoded and decoded, as a level's are */
    float unlit[3];             /* value of nodes without a direction */
} lattice_samples;

static lattice_samples lattice_samples_of(const iso_lattice *l, iso_code code)
{
    lattice_samples s = {.lattice = l, .code = code};
    uint8_t none[8];
    iso_code_encode(code, l->empty + 1, none, 1);
    iso_code_decode_all(code, none, s.unlit, 1);
    return s;
}

/* Blocks along a row. */
typedef struct row_blocks {
    iso_lattice_block *const *first;
    size_t in_x, in_row; /* in the first block: index of the first node, and of the row's start */
} row_blocks;

static row_blocks blocks_of(const iso_lattice *l, size_t first)
{
    const size_t *n = l->size, x = first % n[0], y = first / n[0] % n[1], z = first / (n[0] * n[1]);
    size_t in;
    iso_lattice_block *const *block = iso_lattice_block_of(l, x, y, z, &in);
    return (row_blocks){block, in % ISO_LATTICE_SIDE, in - in % ISO_LATTICE_SIDE};
}

/* Nodes of a row that lie in one block; NULL if the block has no active node. */
typedef struct block_run {
    const iso_lattice_block *block;
    size_t in, count;
} block_run;

/* Finds the run that starts at the row's node `done`. */
static block_run run_at(const row_blocks *r, size_t done, size_t count)
{
    const size_t x = (r->in_x + done) % ISO_LATTICE_SIDE, left = ISO_LATTICE_SIDE - x;
    return (block_run){r->first[(r->in_x + done) / ISO_LATTICE_SIDE], r->in_row + x,
                       left < count - done ? left : count - done};
}

/* Copies a float, or three, of each of `count` nodes from number `first` on, all in one row of the lattice's box. */
static void lattice_samples_scalars(const lattice_samples *s, size_t first, size_t count, float *restrict out)
{
    const row_blocks row = blocks_of(s->lattice, first);
    for (size_t done = 0; done < count;) {
        const block_run run = run_at(&row, done, count);
        for (size_t i = 0; i < run.count; ++i)
            out[done + i] = run.block ? run.block->nodes[run.in + i][0] : s->lattice->empty[0];
        done += run.count;
    }
}

/* Number of lit directions that are coded at once. */
enum { BATCH = 256 };
typedef struct lit_batch {
    float directions[3 * BATCH];
    size_t places[BATCH], count;
} lit_batch;

static void code_batch(iso_code code, lit_batch *b, float *restrict out)
{
    uint8_t bytes[8 * BATCH];
    iso_code_encode(code, b->directions, bytes, b->count);
    iso_code_decode_all(code, bytes, b->directions, b->count);
    for (size_t i = 0; i < b->count; ++i)
        memcpy(out + 3 * b->places[i], b->directions + 3 * i, 3 * sizeof *out);
    b->count = 0;
}

/* Codes a batch as soon as it could not hold all nodes of another block. */
static void lattice_samples_directions(const lattice_samples *s, size_t first, size_t count, float *restrict out)
{
    const row_blocks row = blocks_of(s->lattice, first);
    lit_batch b;
    b.count = 0;
    for (size_t done = 0; done < count;) {
        const block_run run = run_at(&row, done, count);
        for (size_t i = 0; i < run.count; ++i, ++done) {
            if (!run.block || run.block->use[run.in + i] != ISO_LATTICE_LIT) {
                memcpy(out + 3 * done, s->unlit, sizeof s->unlit);
                continue;
            }
            memcpy(b.directions + 3 * b.count, run.block->nodes[run.in + i] + 1, 3 * sizeof *out);
            b.places[b.count++] = done;
        }
        if (b.count + ISO_LATTICE_SIDE > BATCH)
            code_batch(s->code, &b, out);
    }
    code_batch(s->code, &b, out);
}

/* Implements iso_df3_source.run: nodes of a block without active nodes are all equal. */
static size_t lattice_samples_run(const lattice_samples *s, size_t first, size_t count, bool *same)
{
    const row_blocks row = blocks_of(s->lattice, first);
    size_t done = 0;
    *same = !row.first[0];
    while (done < count) {
        const block_run run = run_at(&row, done, count);
        if (!run.block != *same)
            break;
        done += run.count;
    }
    return done;
}

/* ---- files ---- */

char *iso_povray_file_path(const char *dir, const char *name, const char *suffix)
{
    size_t size = strlen(dir) + strlen(name) + strlen(suffix) + 2;
    char *path = malloc(size);
    if (path)
        snprintf(path, size, "%s/%s%s", dir, name, suffix);
    return path;
}

iso_status iso_povray_no_memory(iso_error *err)
{
    return iso_fail(err, ISO_E_MEMORY, "povray: no memory");
}

/* Returns the coding of labels, from -32768 to 65535 (volume/labels.h), in any type. */
static iso_df3_coding label_coding(const iso_level *level)
{
    if (level->min >= 0)
        return level->max <= 255 ? (iso_df3_coding){8, 0, 255} : (iso_df3_coding){16, 0, 65535};
    return level->max <= 32767 ? (iso_df3_coding){16, -32768, 32767} : (iso_df3_coding){32, -32768, 4294934527.0};
}

/* Finds a coding of multiples of a quantum. False if 16 bits do not hold them. */
static bool quantum_coding(const iso_level *level, double quantum, iso_df3_coding *coding)
{
    const double lo = quantum > 0 ? floor(level->min / quantum) * quantum : 0;
    *coding = (iso_df3_coding){16, lo, lo + 65535 * quantum};
    return quantum > 0 && level->max <= coding->hi;
}

/* Ranges between the values and the sample of voxels without data, where interpolated values leave the range within
 * 1/16385 of a cell. 32 bits still have 2^18 samples for the range. */
enum { stand_in_ranges = 1 << 14 };

/* Uses whole samples if the type has them. */
static iso_df3_coding scalar_coding(const iso_level *level, double quantum, unsigned bits)
{
    iso_df3_coding coding;
    if (level->labels)
        return label_coding(level);
    if (level->geometry.has_no_data)
        return (iso_df3_coding){32, (double)iso_level_stand_in(level, stand_in_ranges), level->max};
    switch (level->stored_type) {
    case ISO_U8: return (iso_df3_coding){8, 0, 255};
    case ISO_I8: return (iso_df3_coding){8, -128, 127};
    case ISO_U16: return (iso_df3_coding){16, 0, 65535};
    case ISO_I16: return (iso_df3_coding){16, -32768, 32767};
    default: break;
    }
    if (quantum_coding(level, quantum, &coding))
        return coding;
    return (iso_df3_coding){bits, level->min, level->max > level->min ? level->max : level->min + 1};
}

/* Returns a coding with a whole sample for 0: 128 of 255, 32768 of 65535, 2^31 of 2^32 - 1. */
static iso_df3_coding direction_coding(unsigned bits)
{
    double half = ldexp(1, (int)bits - 1);
    return (iso_df3_coding){bits, -half / (half - 1), 1};
}

static bool is_byte_lattice(iso_code code)
{
    const iso_code_info *info = iso_code_describe(code);
    return info->is_textured && info->is_signed && info->is_linear;
}

/* Returns an upper bound of the slope of the trilinear field: in each cell, the steepest edge along each axis. */
static double steepest(const iso_level *level)
{
    const size_t *n = level->geometry.size;
    const size_t step[3] = {1, n[0], n[0] * n[1]};
    double most = 0;
    for (size_t z = 0; z + 1 < n[2] || z == 0; ++z)
        for (size_t y = 0; y + 1 < n[1] || y == 0; ++y)
            for (size_t x = 0; x + 1 < n[0] || x == 0; ++x) {
                const size_t at = x + n[0] * (y + n[1] * z);
                double square = 0;
                for (int a = 0; a < 3; ++a) {
                    const int b = (a + 1) % 3, c = (a + 2) % 3;
                    const size_t along = n[a] > 1 ? step[a] : 0, u = n[b] > 1 ? step[b] : 0, v = n[c] > 1 ? step[c] : 0;
                    const size_t edges[4] = {at, at + u, at + v, at + u + v};
                    double edge = 0;
                    for (int e = 0; e < 4; ++e)
                        edge = fmax(edge,
                                    fabs((double)level->scalar[edges[e] + along] - (double)level->scalar[edges[e]]));
                    square += edge * edge;
                }
                most = fmax(most, square);
            }
    return sqrt(most);
}

/* Source of a layer's samples. */
typedef struct layer_reader {
    iso_code code;
    const iso_level *level;
    const iso_volume *volume; /* scalars of level 0 if it has none */
    const uint8_t *bytes;
    iso_narrow_codes *made;  /* codes made slab by slab if it has none */
    lattice_samples lattice; /* samples of the level */
} layer_reader;

/* ISO_NO_DATA lies below the coding's range: its sample is 0. */
static void read_scalars(const void *user, size_t first, size_t count, float *out)
{
    const layer_reader *r = user;
    iso_level_scalars(r->level, r->volume, first, count, out);
}

static void read_codes(const void *user, size_t first, size_t count, float *out)
{
    const layer_reader *r = user;
    iso_code_decode_all(r->code, r->level->codes + 3 * first, out, count);
}

static void read_made_codes(const void *user, size_t first, size_t count, float *out)
{
    const layer_reader *r = user;
    const size_t *n = r->level->geometry.size;
    iso_code_decode_all(r->code, iso_narrow_codes_at(r->made, first % n[0], first / n[0] % n[1], first / (n[0] * n[1])),
                        out, count);
}

static iso_status make_codes(void *user, size_t first, size_t end, iso_error *err)
{
    iso_narrow_codes *made = user;
    const size_t *n = made->volume->geometry.size;
    return iso_narrow_codes_make(made, (const size_t[]){0, 0, first}, (const size_t[]){n[0], n[1], end}, err);
}

static void read_directions(const void *user, size_t first, size_t count, float *out)
{
    const layer_reader *r = user;
    memcpy(out, r->level->directions + 3 * first, 3 * count * sizeof *out);
}

static void read_bytes(const void *user, size_t first, size_t count, float *out)
{
    const layer_reader *r = user;
    for (size_t i = 0; i < count; ++i)
        out[i] = r->bytes[first + i];
}

/* Returns the lattice that replaces the level's voxels, or NULL. A region of interest has its own. */
static const iso_lattice *lattice_of(const iso_povray_scene *s)
{
    return s->voxels->scalar ? NULL : s->options->lattice;
}

static void read_lattice_scalars(const void *user, size_t first, size_t count, float *out)
{
    lattice_samples_scalars(&((const layer_reader *)user)->lattice, first, count, out);
}

static void read_lattice_directions(const void *user, size_t first, size_t count, float *out)
{
    lattice_samples_directions(&((const layer_reader *)user)->lattice, first, count, out);
}

static size_t lattice_run(const void *user, size_t first, size_t count, bool *same)
{
    return lattice_samples_run(&((const layer_reader *)user)->lattice, first, count, same);
}

/* Writes one file per suffix. */
static iso_status write_samples(const iso_povray_scene *s, const layer_reader *r,
                                void (*read)(const void *, size_t, size_t, float *), const char *const *suffixes,
                                size_t count, const iso_df3_coding *coding, const char *dir, iso_error *err)
{
    const size_t *n = s->voxels->geometry.size;
    const size_t most = (size_t)32 << 20, planes = most / (3 * n[0] * n[1]);
    const iso_df3_source source = {.size = {n[0], n[1], n[2]},
                                   .channels = count,
                                   .read = read,
                                   .run = r->lattice.lattice ? lattice_run : NULL,
                                   .user = r,
                                   .prepare = r->made ? make_codes : NULL,
                                   .prepare_user = r->made,
                                   .planes = planes > 4 ? planes : 4};
    char *paths[ISO_DF3_MAX_CHANNELS] = {NULL};
    iso_status status = ISO_OK;
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        if (!(paths[i] = iso_povray_file_path(dir, s->name, suffixes[i])))
            status = iso_povray_no_memory(err);
    TRY(status, iso_df3_write_from(&source, (const char *const *)paths, coding, s->options->threads, err));
    for (size_t i = 0; i < count; ++i)
        free(paths[i]);
    return status;
}

static iso_status write_directions(const iso_pyramid *p, const iso_povray_scene *s, const char *dir,
                                   const iso_progress *progress, iso_error *err)
{
    static const char *const suffixes[3] = {"_dx.df3", "_dy.df3", "_dz.df3"};
    const iso_lattice *lattice = lattice_of(s);
    const bool floats = s->options->float_directions, makes = !floats && !lattice && !s->voxels->codes;
    OWNED(iso_narrow_codes) made = {0};
    layer_reader r = {.code = p->options.code, .level = s->voxels, .made = makes ? &made : NULL};
    if (lattice)
        r.lattice = lattice_samples_of(lattice, r.code);
    iso_progress_report(progress, "povray: writing DF3", 0.25);
    if (makes)
        NEED(iso_narrow_codes_begin(&made, p, s->options->volume, err));
    return write_samples(s, &r,
                         lattice  ? read_lattice_directions
                         : floats ? read_directions
                         : makes  ? read_made_codes
                                  : read_codes,
                         suffixes, 3, &s->direction, dir, err);
}

/* Returns the entries of all rows; the caller frees them. */
static float *tf_2d_rows(const iso_tf_2d *tf_2d)
{
    const size_t row = 4 * tf_2d->rows[0].count;
    float *rows = malloc(ISO_TF_2D_ROWS * row * sizeof *rows);
    for (size_t c = 0; rows && c < ISO_TF_2D_ROWS; ++c)
        memcpy(rows + c * row, tf_2d->rows[c].entries, row * sizeof *rows);
    return rows;
}

/* Writes one byte per voxel to a separate file. */
static iso_status write_bytes(const iso_povray_scene *s, const uint8_t *bytes, const char *suffix, const char *dir,
                              iso_error *err)
{
    const iso_df3_coding coding = {8, 0, 255};
    return write_samples(s, &(layer_reader){.bytes = bytes}, read_bytes, &suffix, 1, &coding, dir, err);
}

static iso_status write_tf_tables(const iso_povray_scene *s, const char *dir, iso_error *err)
{
    static const char *const suffix[4] = {"_tf_red.df3", "_tf_green.df3", "_tf_blue.df3", "_tf_extinction.df3"};
    const iso_tf_2d *tf_2d = s->tf_2d;
    FREED float *rows = tf_2d ? tf_2d_rows(tf_2d) : NULL;
    if (tf_2d && !rows)
        return iso_povray_no_memory(err);
    double most[4] = {s->peak_color, s->peak_color, s->peak_color, s->peak_extinction};
    iso_status status = tf_2d ? write_bytes(s, tf_2d->bytes, "_second.df3", dir, err) : ISO_OK;
    for (size_t c = 0; c < 4 && status == ISO_OK; ++c) {
        if (!iso_povray_needs_tables(s, c < 3))
            continue;
        const iso_df3_coding coding = {32, 0, most[c]};
        const size_t size[2] = {s->tf->count, rows ? ISO_TF_2D_ROWS : 1};
        FREED char *path = iso_povray_file_path(dir, s->name, suffix[c]);
        status = path ? iso_df3_write_table(path, size, rows ? rows : s->tf->entries, 4, c, &coding, err)
                      : iso_povray_no_memory(err);
    }
    return status;
}

static iso_status write_text(const iso_povray_scene *s, const char *dir, const char *suffix,
                             void (*write)(FILE *, const iso_povray_scene *), iso_error *err)
{
    FREED char *path = iso_povray_file_path(dir, s->name, suffix);
    FILE *file = path ? fopen(path, "w") : NULL;
    if (file) {
        write(file, s);
        bool failed = ferror(file) != 0;
        if (fclose(file) != 0 || failed)
            return iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", path, strerror(errno));
    } else {
        NEED(path ? iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", path, strerror(errno))
                  : iso_povray_no_memory(err));
    }
    return ISO_OK;
}

/* Describes a scene. level: voxels of the pyramid's level or of a region of interest; tf: the transfer function's table
 * or envelope. */
static iso_povray_scene describe(const iso_pyramid *p, size_t number, const iso_level *level, const iso_view *view,
                                 const iso_tf_table *tf, const char *name, const iso_povray_options *opt)
{
    const iso_geometry *g = &p->levels[number].geometry;
    iso_povray_scene s = {.name = name,
                          .unit = &p->unit,
                          .level = number,
                          .geometry = g,
                          .voxels = level,
                          .lattice_scale = 1,
                          .view = view,
                          .tf = tf,
                          .options = opt};
    iso_words_copy_line(iso_provenance_title(p->source), s.source, sizeof s.source);
    s.scalar = scalar_coding(level, opt->quantum, opt->df3_bits);
    s.direction = direction_coding(!opt->float_directions && is_byte_lattice(p->options.code) ? 8 : opt->df3_bits);
    s.center_mm = iso_geometry_box_center_mm(g);
    s.units_per_mm = 0.5 * ISO_POVRAY_UNITS_ACROSS / iso_geometry_box_radius_mm(g);
    iso_povray_measure_peaks(&s);
    /* 1 % margin: the solver rounds, and divides by it. A constant field has slope 0. */
    if (opt->isosurface)
        s.max_gradient = fmax(1.01 * steepest(level) / (s.scalar.hi - s.scalar.lo), 1e-6);
    return s;
}

void iso_povray_release(iso_povray_prepared *s)
{
    iso_tf_table_destroy(&s->envelope);
    free(s->roi_name);
}

iso_status iso_povray_prepare(const iso_pyramid *p, size_t level, const iso_view *view, const char *name,
                              const iso_povray_options *opt, iso_povray_prepared *s, iso_error *err)
{
    const iso_roi *f = opt->isosurface ? NULL : view->roi;
    *s = (iso_povray_prepared){.pyramid = p};
    const iso_tf_2d *tf_2d = opt->isosurface ? NULL : view->tf_2d; /* a surface uses the color of the view's 1D TF */
    iso_status status = tf_2d ? iso_tf_2d_envelope(tf_2d, &s->envelope, err) : ISO_OK;
    if (status == ISO_OK && f && asprintf(&s->roi_name, "%s_roi", name) < 0) {
        s->roi_name = NULL;
        status = iso_povray_no_memory(err);
    }
    if (status != ISO_OK) {
        iso_povray_release(s);
        return status;
    }
    s->scene = describe(p, level, &p->levels[level], view, tf_2d ? &s->envelope : &view->tf, name, opt);
    s->scene.tf_2d = tf_2d;
    s->scene.extinction_scale = opt->isosurface ? NULL : view->extinction_scale;
    if (f) {
        s->roi = describe(p, level, &f->level, view, &f->tf, s->roi_name, opt);
        s->roi.is_roi = true;
        s->roi.lattice_scale = f->scale;
        memcpy(s->roi.lattice_offset, f->offset, sizeof f->offset);
        s->scene.roi = &s->roi;
        s->scene.peak = fmax(s->scene.peak, s->roi.peak);
    }
    return ISO_OK;
}

/* Writes the data of one layer: values, directions, and tables if the TF needs them. */
static iso_status write_layer(const iso_pyramid *p, const iso_povray_scene *s, const char *dir,
                              const iso_progress *progress, iso_error *err)
{
    static const char *const suffix = "_scalar.df3";
    const iso_lattice *lattice = lattice_of(s);
    layer_reader r = {.level = s->voxels, .volume = s->options->volume};
    if (lattice)
        r.lattice = lattice_samples_of(lattice, p->options.code);
    NEED(write_samples(s, &r, lattice ? read_lattice_scalars : read_scalars, &suffix, 1, &s->scalar, dir, err));
    NEED(write_directions(p, s, dir, progress, err));
    if (!s->options->isosurface)
        NEED(write_tf_tables(s, dir, err));
    return s->extinction_scale ? write_bytes(s, s->extinction_scale, "_scale.df3", dir, err) : ISO_OK;
}

iso_status iso_povray_write_files(const iso_povray_prepared *s, const char *dir, const iso_progress *progress,
                                  iso_error *err)
{
    iso_progress_report(progress, "povray: writing DF3", 0);
    iso_status status = write_layer(s->pyramid, &s->scene, dir, progress, err);
    if (status == ISO_OK && s->scene.roi)
        status = write_layer(s->pyramid, s->scene.roi, dir, progress, err);
    if (status == ISO_OK && iso_povray_has_editable_map(&s->scene))
        status = write_text(&s->scene, dir, "_tf.inc", iso_povray_write_map, err);
    if (status == ISO_OK && s->scene.roi && iso_povray_has_editable_map(s->scene.roi))
        status = write_text(s->scene.roi, dir, "_tf.inc", iso_povray_write_map, err);
    TRY(status, write_text(&s->scene, dir, ".inc", iso_povray_write_include, err));
    TRY(status, write_text(&s->scene, dir, ".pov", iso_povray_write_scene, err));
    TRY(status, write_text(&s->scene, dir, ".ini", iso_povray_write_ini, err));
    iso_progress_report(progress, "povray: writing DF3", 1);
    return status;
}
