/* SPDX-License-Identifier: MIT */
/* pyramid_file.c - NAME.iso/: pyramid.json and plain NRRD files, with checksums. */
#define _GNU_SOURCE
#include <errno.h>
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "pyramid/pyramid_layout.h"
#include "volume/segments.h"

static void floats_to_type(const float *in, iso_type type, size_t count, void *out)
{
    for (size_t i = 0; i < count; ++i) {
        switch (type) {
        case ISO_U8: ((uint8_t *)out)[i] = (uint8_t)in[i]; break;
        case ISO_I8: ((int8_t *)out)[i] = (int8_t)in[i]; break;
        case ISO_U16: ((uint16_t *)out)[i] = (uint16_t)in[i]; break;
        case ISO_I16: ((int16_t *)out)[i] = (int16_t)in[i]; break;
        default: ((float *)out)[i] = in[i]; break;
        }
    }
}

void iso_layout_to_floats(const void *in, iso_type type, size_t count, float *out)
{
    for (size_t i = 0; i < count; ++i) {
        switch (type) {
        case ISO_U8: out[i] = ((const uint8_t *)in)[i]; break;
        case ISO_I8: out[i] = ((const int8_t *)in)[i]; break;
        case ISO_U16: out[i] = ((const uint16_t *)in)[i]; break;
        case ISO_I16: out[i] = ((const int16_t *)in)[i]; break;
        default: out[i] = ((const float *)in)[i]; break;
        }
    }
}

enum { CHUNK = 1 << 16 }; /* values converted at a time */

/* Writes header and samples, and sets f->bytes and f->hash. data: floats, or bytes if f is of codes. */
static bool write_samples(FILE *file, const char *header, level_file *f, const void *data, size_t count)
{
    const bool plain = f->type == ISO_F32 || f->is_bytes;
    const size_t width = iso_type_bytes(f->type);
    XXH3_state_t *state = XXH3_createState();
    char *chunk = malloc(CHUNK * sizeof(float));
    bool good = state && chunk && fputs(header, file) >= 0;
    if (good) {
        XXH3_64bits_reset(state);
        XXH3_64bits_update(state, header, strlen(header));
        f->bytes = strlen(header) + count * width;
    }
    for (size_t at = 0; at < count && good; at += CHUNK) {
        const size_t n = count - at < CHUNK ? count - at : CHUNK;
        const char *from = plain ? (const char *)data + at * width : chunk;
        if (!plain)
            floats_to_type((const float *)data + at, f->type, n, chunk);
        XXH3_64bits_update(state, from, n * width);
        good = fwrite(from, width, n, file) == n;
    }
    f->hash = good ? XXH3_64bits_digest(state) : 0;
    free(chunk);
    XXH3_freeState(state);
    return good;
}

static iso_status save_file(const char *dir, const iso_geometry *g, size_t level, level_file *f, const void *data,
                            iso_error *err)
{
    char name[64];
    iso_layout_name(f, level, name);
    char *path = iso_path_join(dir, name), *header = iso_layout_header(g, f);
    FILE *file = path && header ? fopen(path, "wb") : NULL;
    bool good = file && write_samples(file, header, f, data, f->components * iso_geometry_voxel_count(g));
    if (file && fclose(file) != 0)
        good = false;
    free(header);
    free(path);
    return good ? ISO_OK
                : iso_fail(err, iso_errno_status(), "%s/%s: cannot be written: %s", dir, name, strerror(errno));
}

static iso_status save_into(const iso_pyramid *p, const char *dir, iso_error *err)
{
    iso_status status = ISO_OK;
    json_t *levels = json_array();
    for (size_t k = 0; k < p->level_count && status == ISO_OK; ++k) {
        const iso_level *l = &p->levels[k];
        const void *data[FILE_COUNT] = {l->scalar, l->codes, l->directions, l->magnitude, l->scale};
        level_file files[FILE_COUNT];
        iso_layout_files(&p->options, l->stored_type, files);
        files[FILE_SCALE].stored = l->scale && !l->geometry.has_no_data;
        for (int i = 0; i < FILE_COUNT && status == ISO_OK; ++i)
            if (files[i].stored)
                status = save_file(dir, &l->geometry, k, &files[i], data[i], err);
        json_t *level = iso_layout_level(&l->geometry, l->stored_type, l->min, l->max, files, k);
        iso_layout_choice(&p->options, k, level);
        json_array_append_new(levels, level);
    }
    if (status == ISO_OK)
        return iso_layout_save(dir, p->source, &p->unit, &p->options, levels, p, err);
    json_decref(levels);
    return status;
}

iso_status iso_pyramid_save(const iso_pyramid *p, const char *dir, iso_error *err)
{
    ENDED_BY(iso_output_abandon) iso_output out = {0};
    NEED(iso_output_begin_dir(&out, dir, ISO_PYRAMID_MARKER, err));
    NEED(save_into(p, out.temp_path, err));
    return iso_output_commit(&out, err);
}

/* Checks "bytes", which is for people and other programs: a file's size follows from its header and its samples. */
static iso_status check_bytes(iso_json_reader *r, const json_t *entry, const char *name, size_t bytes)
{
    size_t said = 0;
    iso_json_get_size(r, entry, "bytes", true, 0, INT64_MAX, &said);
    if (r->status == ISO_OK && said != bytes)
        r->status = iso_fail(r->err, ISO_E_FORMAT, "%s: \"bytes\" of %s is %zu, must be %zu by its size and type",
                             r->path, name, said, bytes);
    return r->status;
}

/* Reads one file, checks it, and leaves its samples as float (codes: as bytes) in *data. If data is NULL, only the
 * entry is checked. */
static iso_status load_file(const char *dir, const iso_geometry *g, const level_file *f, iso_json_reader *r,
                            const json_t *files, void **data, iso_error *err)
{
    const char *name = NULL, *digest = NULL;
    json_t *entry = iso_json_get_object(r, files, f->key, true);
    iso_json_get_string(r, entry, "name", true, &name);
    iso_json_get_string(r, entry, "xxh3_64", true, &digest);
    if (r->status != ISO_OK)
        return r->status;
    if (strchr(name, '/'))
        return iso_fail(err, ISO_E_FORMAT, "%s: the file \"%s\" does not lie in the folder", r->path, name);
    char *path = iso_path_join(dir, name), *header = iso_layout_header(g, f);
    const size_t count = f->components * iso_geometry_voxel_count(g);
    iso_status status = path && header ? check_bytes(r, entry, name, strlen(header) + count * iso_type_bytes(f->type))
                                       : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", name);
    if (status == ISO_OK && data)
        status = iso_layout_read(path, header, f, digest, count, data, err);
    free(header);
    free(path);
    return status;
}

static void geometry_from_json(iso_json_reader *r, const json_t *object, iso_geometry *g)
{
    double size[3] = {0, 0, 0};
    iso_json_get_numbers(r, object, "size", true, &(iso_json_list){size, 3, 1, 1u << 24});
    iso_json_get_numbers(r, object, "index_to_world", true,
                         &(iso_json_list){&g->index_to_world.m[0][0], 9, -DBL_MAX, DBL_MAX});
    iso_json_get_numbers(r, object, "origin_mm", true, &(iso_json_list){&g->origin_mm.x, 3, -DBL_MAX, DBL_MAX});
    iso_json_get_numbers(r, object, "box_index", true, &(iso_json_list){g->box_index, 3, 0, 1u << 24});
    iso_json_get_bool(r, object, "is_patient", false, &g->is_patient);
    iso_json_get_bool(r, object, "has_no_data", false, &g->has_no_data);
    for (int a = 0; a < 3 && r->status == ISO_OK; ++a) {
        g->size[a] = (size_t)size[a];
        if ((double)g->size[a] != size[a])
            r->status = iso_fail(r->err, ISO_E_FORMAT, "%s: \"size\" holds %g, must be whole numbers", r->path,
                                 size[a]);
    }
    TRY(r->status, iso_geometry_check(g, r->path, r->err));
    /* The box ends in the last voxel, or at its far face. */
    for (int a = 0; a < 3 && r->status == ISO_OK; ++a)
        if (!(g->box_index[a] > size[a] - 1 && g->box_index[a] <= size[a]))
            r->status = iso_fail(r->err, ISO_E_FORMAT, "%s: \"box_index\" holds %g, of %zu voxels must be in the last",
                                 r->path, g->box_index[a], g->size[a]);
}

static void options_from_json(iso_json_reader *r, const json_t *object, iso_pyramid_options *o)
{
    const char *scalar = NULL, *direction = NULL, *gradient = NULL, *code = NULL;
    *o = iso_pyramid_defaults();
    iso_json_get_size(r, object, "levels", true, 1, 32, &o->level_count);
    iso_json_get_string(r, object, "scalar_filter", true, &scalar);
    iso_json_get_string(r, object, "direction_filter", true, &direction);
    iso_json_get_string(r, object, "gradient", true, &gradient);
    iso_json_get_string(r, object, "code", true, &code);
    iso_json_get_number(r, object, "gauss_sigma_voxels", true, 0, 100, &o->gauss_sigma_voxels);
    iso_json_get_size(r, object, "gauss_radius", true, 1, 16, &o->gauss_radius);
    const iso_json_list range = {o->value_range, 2, -1e300, 1e300};
    iso_json_get_numbers(r, object, "value_range", false, &range);
    if (r->status == ISO_OK && json_object_get(object, "value_range") && !(o->value_range[0] < o->value_range[1]))
        r->status = iso_fail(r->err, ISO_E_FORMAT, "%s: \"value_range\" is %g to %g, must have the larger one last",
                             r->path, o->value_range[0], o->value_range[1]);
    iso_json_get_size(r, object, "eq1_exponent", false, 0, 4, &o->eq1_exponent);
    iso_json_get_bool(r, object, "keep_float", true, &o->keep_float);
    iso_json_get_bool(r, object, "keep_magnitude", true, &o->keep_magnitude);
    iso_error why = {""};
    if (r->status == ISO_OK && (iso_scalar_filter_from_name(scalar, &o->scalar_filter, &why) != ISO_OK ||
                                iso_direction_filter_from_name(direction, &o->direction_filter, &why) != ISO_OK ||
                                iso_gradient_from_name(gradient, &o->gradient.method, &why) != ISO_OK ||
                                iso_code_from_name(code, &o->code, &why) != ISO_OK))
        r->status = iso_fail(r->err, ISO_E_FORMAT, "%s: %s", r->path, why.text);
    if (r->status == ISO_OK && !iso_code_describe(o->code)->is_textured)
        r->status = iso_fail(r->err, ISO_E_FORMAT, "%s: \"code\" is \"%s\", which no pyramid stores", r->path, code);
}

static iso_status load_choice(iso_json_reader *r, const json_t *entry, size_t level, iso_pyramid_options *opt)
{
    iso_direction_choice *c = &opt->choice;
    const char *name = NULL;
    if (level == 0 || opt->direction_filter != ISO_DIRECTION_AUTO)
        return ISO_OK;
    iso_json_get_string(r, entry, "direction_filter", true, &name);
    iso_json_get_number(r, entry, "mean_agreement", true, 0, 2, &c->mean_agreement[level]);
    iso_json_get_number(r, entry, "axis_agreement", true, 0, 2, &c->axis_agreement[level]);
    TRY(r->status, iso_direction_filter_from_name(name, &c->filter[level], r->err));
    if (r->status == ISO_OK && c->filter[level] != ISO_DIRECTION_MOMENTS && c->filter[level] != ISO_DIRECTION_TENSOR)
        r->status = iso_fail(r->err, ISO_E_FORMAT, "%s: level %zu: auto chooses moments or tensor, not %s", r->path,
                             level, name);
    c->is_made = r->status == ISO_OK;
    return r->status;
}

/* Parts of a pyramid to load besides pyramid.json. */
typedef enum load_what { LOAD_NO_FILE, LOAD_OUTLINE, LOAD_SAMPLES, LOAD_SCALARS, LOAD_ALL } load_what;

static bool is_wanted(load_what what, int file)
{
    /* A view of the level needs the scale, whichever way it gets the samples. */
    return what == LOAD_ALL || file == FILE_SCALE ||
           ((what == LOAD_SCALARS || what == LOAD_SAMPLES) && file == FILE_SCALAR);
}

static iso_status load_level(iso_json_reader *r, const char *dir, load_what what, const json_t *entry,
                             const iso_pyramid_options *opt, iso_level *l)
{
    iso_error *err = r->err;
    const char *type = NULL;
    level_file files[FILE_COUNT];
    geometry_from_json(r, iso_json_get_object(r, entry, "geometry", true), &l->geometry);
    iso_json_get_string(r, entry, "stored_type", true, &type);
    iso_json_get_number(r, entry, "min", true, -ISO_MOST_VALUE, ISO_MOST_VALUE, &l->min);
    iso_json_get_number(r, entry, "max", true, -ISO_MOST_VALUE, ISO_MOST_VALUE, &l->max);
    if (r->status == ISO_OK && !(l->min <= l->max))
        r->status = iso_fail(err, ISO_E_FORMAT, "%s: \"min\" is %g, more than \"max\", %g", r->path, l->min, l->max);
    json_t *list = iso_json_get_object(r, entry, "files", true);
    TRY(r->status, iso_type_from_name(type, &l->stored_type, err));
    if (r->status == ISO_OK && iso_type_bytes(l->stored_type) > 2 && l->stored_type != ISO_F32)
        r->status = iso_fail(err, ISO_E_FORMAT, "%s: \"stored_type\" is \"%s\", must be of 8 or 16 bits, or float",
                             r->path, type);
    if (r->status != ISO_OK)
        return r->status;
    void *data[FILE_COUNT] = {NULL};
    iso_status status = ISO_OK;
    iso_layout_files(opt, l->stored_type, files);
    files[FILE_SCALAR].is_kept = what == LOAD_SAMPLES;
    files[FILE_SCALE].stored = json_object_get(list, files[FILE_SCALE].key) != NULL;
    for (int i = 0; i < FILE_COUNT && status == ISO_OK && what != LOAD_NO_FILE; ++i)
        if (files[i].stored)
            status = load_file(dir, &l->geometry, &files[i], r, list, is_wanted(what, i) ? &data[i] : NULL, err);
    l->labels = opt->scalar_filter == ISO_SCALAR_MAJORITY;
    l->scalar = data[FILE_SCALAR];
    l->codes = data[FILE_CODES];
    l->directions = data[FILE_DIRECTIONS];
    l->magnitude = data[FILE_MAGNITUDE];
    l->scale = data[FILE_SCALE];
    return status;
}

/* Marks the levels that were made for a scene. fit/level_scalar.h parses the details. */
static void mark_levels(iso_pyramid *p)
{
    const json_t *levels = json_object_get(p->made_for, "levels"), *entry;
    size_t i;
    json_array_foreach (levels, i, entry) {
        const json_int_t level = json_integer_value(json_object_get(entry, "level"));
        const char *scalar = json_string_value(json_object_get(entry, "scalar"));
        if (level > 0 && (size_t)level < p->level_count && scalar && strcmp(scalar, "as-built") != 0)
            p->levels[level].made_for_scene = true;
        if (level > 0 && (size_t)level < p->level_count && scalar && strcmp(scalar, "optimized") == 0) {
            p->levels[level].is_optimized = true;
            p->levels[level].build_seconds = json_number_value(
                json_object_get(json_object_get(entry, "optimized"), "seconds"));
        }
        if (level > 0 && (size_t)level < p->level_count)
            p->levels[level].edits_are_scaled = json_is_true(json_object_get(entry, "edits_are_scaled"));
    }
}

/* Moves level 0's samples, read in their own type, into the pyramid's volume. */
static iso_status take_samples(iso_pyramid *p, iso_error *err)
{
    iso_level *l = &p->levels[0];
    p->volume = malloc(sizeof *p->volume);
    NEED_MEMORY(p->volume, err, "%s: out of memory", p->source);
    *p->volume = (iso_volume){.geometry = l->geometry, .type = l->stored_type, .data = l->scalar};
    l->scalar = NULL;
    l->samples = p->volume;
    l->estimator = p->options.gradient.method;
    return ISO_OK;
}

/* first: the finest level whose files are looked at. With LOAD_SAMPLES: those of level 0 alone. */
static iso_status load_levels(iso_json_reader *r, const char *dir, load_what what, size_t first, const json_t *root,
                              iso_pyramid *out)
{
    iso_error *err = r->err;
    const char *source = NULL, *built_by = "";
    iso_json_get_string(r, root, "source", true, &source);
    iso_json_get_string(r, root, "built_by", true, &built_by);
    options_from_json(r, iso_json_get_object(r, root, "options", true), &out->options);
    out->unit.mm = 1;
    json_t *unit = iso_json_get_object(r, root, "unit", false), *levels = iso_json_get_array(r, root, "levels", true);
    if (unit) {
        const char *name = "";
        iso_json_get_string(r, unit, "name", true, &name);
        iso_json_get_number(r, unit, "mm", true, ISO_LEAST_MM, ISO_MOST_MM, &out->unit.mm);
        snprintf(out->unit.name, sizeof out->unit.name, "%s", name);
    }
    out->segments = json_incref(iso_json_get_array(r, root, "segments", false));
    out->made_for = json_incref(iso_json_get_object(r, root, "made_for", false));
    iso_segments_check(r, out->segments);
    iso_json_check_texts(r, "made_for", out->made_for);
    if (r->status != ISO_OK)
        return r->status;
    const size_t count = json_array_size(levels);
    if (count < 1 || count > 32)
        return iso_fail(err, ISO_E_FORMAT, "%s: \"levels\" holds %zu levels, must be 1 to 32", r->path, count);
    out->source = strdup(source);
    snprintf(out->built_by, sizeof out->built_by, "%s", built_by ? built_by : "");
    out->levels = calloc(count, sizeof *out->levels);
    out->level_count = count;
    NEED_MEMORY(out->source && out->levels, err, "%s: no memory for %zu levels", r->path, count);
    mark_levels(out);
    for (size_t k = 0; k < count; ++k) {
        const load_what of_level = k < first ? LOAD_NO_FILE : what == LOAD_SAMPLES && k > 0 ? LOAD_OUTLINE : what;
        NEED(load_level(r, dir, of_level, json_array_get(levels, k), &out->options, &out->levels[k]));
        NEED(load_choice(r, json_array_get(levels, k), k, &out->options));
        if (k == 0)
            continue;
        iso_geometry wanted = iso_geometry_coarser(&out->levels[k - 1].geometry);
        if (memcmp(wanted.size, out->levels[k].geometry.size, sizeof wanted.size) != 0)
            return iso_fail(err, ISO_E_FORMAT, "%s: the sizes of level %zu are not half of the finer level's", r->path,
                            k);
    }
    iso_pyramid_share_segments(out);
    if (first > 0 && out->levels[0].geometry.has_no_data)
        return iso_fail(err, ISO_E_RANGE,
                        "%s: some voxels have no data, so coarse levels need level 0; view --errors reads it", r->path);
    if (what == LOAD_SAMPLES)
        return take_samples(out, err);
    return what == LOAD_OUTLINE ? ISO_OK : iso_pyramid_scale_by_share(out, NULL, err);
}

static iso_status load(const char *dir, load_what what, size_t first, iso_pyramid *out, iso_error *err)
{
    *out = (iso_pyramid){0};
    char *path = iso_path_join(dir, ISO_PYRAMID_MARKER);
    json_t *root = NULL;
    NEED_MEMORY(path, err, "%s: out of memory", dir);
    iso_status status = iso_layout_load(path, &root, err);
    if (status == ISO_OK) {
        iso_json_reader r = {.path = path, .err = err};
        status = load_levels(&r, dir, what, first, root, out);
    }
    json_decref(root);
    free(path);
    if (status != ISO_OK)
        iso_pyramid_destroy(out);
    return status;
}

iso_status iso_pyramid_load(const char *dir, iso_pyramid *out, iso_error *err)
{
    return load(dir, LOAD_ALL, 0, out, err);
}

iso_status iso_pyramid_load_from(const char *dir, size_t first, iso_pyramid *out, iso_error *err)
{
    return load(dir, LOAD_ALL, first, out, err);
}

iso_status iso_pyramid_load_outline(const char *dir, iso_pyramid *out, iso_error *err)
{
    return load(dir, LOAD_OUTLINE, 0, out, err);
}

iso_status iso_pyramid_load_begun(const char *dir, iso_pyramid *out, iso_error *err)
{
    NEED(load(dir, LOAD_OUTLINE, 0, out, err));
    const bool may_begin = !out->levels[0].labels && !out->levels[0].geometry.has_no_data;
    iso_pyramid_destroy(out);
    return load(dir, may_begin ? LOAD_SAMPLES : LOAD_ALL, 0, out, err);
}

iso_status iso_pyramid_load_scalars(const char *dir, iso_pyramid *out, iso_error *err)
{
    return load(dir, LOAD_SCALARS, 0, out, err);
}

bool iso_pyramid_is_one(const char *path)
{
    FREED char *marker = iso_path_join(path, ISO_PYRAMID_MARKER);
    return marker && iso_path_is_dir(path) && iso_path_exists(marker);
}
