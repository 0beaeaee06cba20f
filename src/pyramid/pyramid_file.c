/* pyramid_file.c - NAME.iso/: pyramid.json and plain NRRD files, with checksums. */
#define _GNU_SOURCE
#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/file.h"
#include "base/json.h"
#include "pyramid/pyramid.h"

#define SCHEMA "isoshade.pyramid/1"
#define MARKER "pyramid.json"
#define ALIGNMENT 64

/* One file of a level. */
typedef struct level_file {
    const char *key, *suffix;
    size_t components;
    iso_type type;
    void *data; /* float, or bytes where the key is "codes" */
} level_file;

enum { FILE_SCALAR, FILE_CODES, FILE_DIRECTIONS, FILE_MAGNITUDE, FILE_COUNT };

static void list_files(const iso_level *l, iso_code code, level_file files[FILE_COUNT])
{
    files[FILE_SCALAR] = (level_file){"scalar", "", 1, l->stored_type, l->scalar};
    files[FILE_CODES] = (level_file){"codes", "_dir", 3, iso_code_describe(code)->is_signed ? ISO_I8 : ISO_U8, l->codes};
    files[FILE_DIRECTIONS] = (level_file){"directions", "_grad", 3, ISO_F32, l->directions};
    files[FILE_MAGNITUDE] = (level_file){"magnitude", "_mag", 1, ISO_F32, l->magnitude};
}

/* The text before the samples: NRRD0004, raw, little-endian. Space origin is the
 * centre of the first voxel. A comment fills it up to a multiple of ALIGNMENT
 * bytes, so that a mapped file has its samples aligned. To be freed. */
static char *make_header(const iso_geometry *g, const level_file *f)
{
    const iso_mat3 *m = &g->index_to_world;
    iso_vec3 o = iso_geometry_to_world(g, iso_v3(0.5, 0.5, 0.5));
    const bool vector = f->components > 1;
    char *text = NULL;
    int n = asprintf(&text,
                     "NRRD0004\ntype: %s\ndimension: %d\nspace dimension: 3\nsizes: %s%zu %zu %zu\n"
                     "space directions: %s(%.17g,%.17g,%.17g) (%.17g,%.17g,%.17g) (%.17g,%.17g,%.17g)\n"
                     "centers: %scell cell cell\nkinds: %sdomain domain domain\nendian: little\nencoding: raw\n"
                     "space origin: (%.17g,%.17g,%.17g)\n",
                     iso_type_name(f->type), vector ? 4 : 3, vector ? "3 " : "", g->size[0], g->size[1], g->size[2],
                     vector ? "none " : "", m->m[0][0], m->m[1][0], m->m[2][0], m->m[0][1], m->m[1][1], m->m[2][1],
                     m->m[0][2], m->m[1][2], m->m[2][2], vector ? "??? " : "", vector ? "vector " : "", o.x, o.y, o.z);
    if (n < 0)
        return NULL;
    char *padded = NULL;
    int fill = (ALIGNMENT - (n + 4) % ALIGNMENT) % ALIGNMENT; /* "# ", the fill, two line ends */
    n = asprintf(&padded, "%s# %*s\n\n", text, fill, "");
    free(text);
    return n < 0 ? NULL : padded;
}

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

static void type_to_floats(const void *in, iso_type type, size_t count, float *out)
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

/* Writes header and samples; *hash is XXH3 of the whole file. */
static bool write_samples(FILE *file, const char *header, const level_file *f, size_t count, size_t *bytes,
                          XXH64_hash_t *hash)
{
    const bool plain = f->type == ISO_F32 || f->data == NULL || strcmp(f->key, "codes") == 0;
    const size_t width = iso_type_bytes(f->type);
    XXH3_state_t *state = XXH3_createState();
    char *chunk = malloc(CHUNK * sizeof(float));
    bool good = state && chunk;
    if (good) {
        XXH3_64bits_reset(state);
        XXH3_64bits_update(state, header, strlen(header));
        good = fputs(header, file) >= 0;
        *bytes = strlen(header) + count * width;
    }
    for (size_t at = 0; at < count && good; at += CHUNK) {
        const size_t n = count - at < CHUNK ? count - at : CHUNK;
        const char *from = chunk;
        if (plain)
            from = (const char *)f->data + at * width;
        else
            floats_to_type((const float *)f->data + at, f->type, n, chunk);
        XXH3_64bits_update(state, from, n * width);
        good = fwrite(from, width, n, file) == n;
    }
    *hash = good ? XXH3_64bits_digest(state) : 0;
    free(chunk);
    XXH3_freeState(state);
    return good;
}

static iso_status save_file(const char *dir, const iso_geometry *g, size_t level, const level_file *f, json_t *files,
                            iso_error *err)
{
    char name[64], digest[32];
    snprintf(name, sizeof name, "level_%zu%s.nrrd", level, f->suffix);
    char *path = iso_path_join(dir, name), *header = make_header(g, f);
    size_t bytes = 0;
    XXH64_hash_t hash = 0;
    iso_status status = ISO_OK;
    FILE *file = path && header ? fopen(path, "wb") : NULL;
    bool good = file && write_samples(file, header, f, f->components * iso_geometry_voxel_count(g), &bytes, &hash);
    if (file && fclose(file) != 0)
        good = false;
    if (good) {
        snprintf(digest, sizeof digest, "%016llx", (unsigned long long)hash);
        json_object_set_new(files, f->key, json_pack("{s:s, s:I, s:s}", "name", name, "bytes", (json_int_t)bytes,
                                                     "xxh3_64", digest));
    } else {
        status = iso_fail(err, ISO_E_IO, "%s/%s: cannot be written: %s", dir, name, strerror(errno));
    }
    free(header);
    free(path);
    return status;
}

static json_t *geometry_to_json(const iso_geometry *g)
{
    return json_pack("{s:[I,I,I], s:o, s:o, s:o}", "size", (json_int_t)g->size[0], (json_int_t)g->size[1],
                     (json_int_t)g->size[2], "index_to_world", iso_json_numbers(&g->index_to_world.m[0][0], 9),
                     "origin_mm", iso_json_numbers(&g->origin_mm.x, 3), "box_index", iso_json_numbers(g->box_index, 3));
}

static json_t *options_to_json(const iso_pyramid_options *o)
{
    return json_pack("{s:I, s:s, s:s, s:s, s:s, s:f, s:I, s:b, s:b}", "levels", (json_int_t)o->level_count,
                     "scalar_filter", iso_scalar_filter_name(o->scalar_filter), "direction_filter",
                     iso_direction_filter_name(o->direction_filter), "gradient", iso_gradient_name(o->gradient.method),
                     "code", iso_code_describe(o->code)->name, "gauss_sigma_voxels", o->gauss_sigma_voxels,
                     "gauss_radius", (json_int_t)o->gauss_radius, "keep_float", o->keep_float, "keep_magnitude",
                     o->keep_magnitude);
}

/* With 17 digits, so that the geometry is read back as it was. */
static iso_status save_json(const char *dir, const json_t *root, iso_error *err)
{
    char *path = iso_path_join(dir, MARKER), *text = json_dumps(root, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    iso_status status = path && text ? iso_file_write(path, text, strlen(text), err)
                                     : iso_fail(err, ISO_E_MEMORY, "%s: no memory for %s", dir, MARKER);
    free(text);
    free(path);
    return status;
}

static iso_status save_into(const iso_pyramid *p, const char *dir, iso_error *err)
{
    iso_status status = ISO_OK;
    json_t *levels = json_array();
    for (size_t k = 0; k < p->level_count && status == ISO_OK; ++k) {
        const iso_level *l = &p->levels[k];
        level_file list[FILE_COUNT];
        json_t *files = json_object();
        list_files(l, p->options.code, list);
        for (int i = 0; i < FILE_COUNT && status == ISO_OK; ++i)
            if (list[i].data)
                status = save_file(dir, &l->geometry, k, &list[i], files, err);
        json_array_append_new(levels, json_pack("{s:o, s:s, s:f, s:f, s:o}", "geometry", geometry_to_json(&l->geometry),
                                                "stored_type", iso_type_name(l->stored_type), "min", l->min, "max",
                                                l->max, "files", files));
    }
    json_t *root = json_pack("{s:s, s:s, s:o, s:o}", "schema", SCHEMA, "source", p->source, "options",
                             options_to_json(&p->options), "levels", levels);
    if (status == ISO_OK)
        status = save_json(dir, root, err);
    json_decref(root);
    return status;
}

iso_status iso_pyramid_save(const iso_pyramid *p, const char *dir, iso_error *err)
{
    iso_output out;
    iso_status status = iso_output_begin_dir(&out, dir, MARKER, err);
    if (status != ISO_OK)
        return status;
    status = save_into(p, out.temp_path, err);
    if (status == ISO_OK)
        return iso_output_commit(&out, err);
    iso_output_abandon(&out);
    return status;
}

/* Reads one file, checks it, and leaves its samples as float (codes: as bytes) in f->data. */
static iso_status load_file(const char *dir, const iso_geometry *g, level_file *f, iso_json_reader *r, const json_t *files,
                            iso_error *err)
{
    const char *name = NULL, *digest = NULL;
    json_t *entry = iso_json_get_object(r, files, f->key, true);
    iso_json_get_string(r, entry, "name", true, &name);
    iso_json_get_string(r, entry, "xxh3_64", true, &digest);
    if (r->status != ISO_OK)
        return r->status;
    if (strchr(name, '/'))
        return iso_fail(err, ISO_E_FORMAT, "%s: the file \"%s\" does not lie in the folder", r->path, name);
    const size_t count = f->components * iso_geometry_voxel_count(g), width = iso_type_bytes(f->type);
    char *path = iso_path_join(dir, name), *header = make_header(g, f), *bytes = NULL;
    size_t size = 0;
    iso_status status = path && header ? iso_file_read(path, &bytes, &size, err)
                                       : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", name);
    const size_t header_bytes = header ? strlen(header) : 0;
    char found[32] = "";
    if (status == ISO_OK && size != header_bytes + count * width)
        status = iso_fail(err, ISO_E_FORMAT, "%s: %zu bytes, must be %zu by pyramid.json", path, size,
                          header_bytes + count * width);
    if (status == ISO_OK)
        snprintf(found, sizeof found, "%016llx", (unsigned long long)XXH3_64bits(bytes, size));
    if (status == ISO_OK && strcmp(found, digest) != 0)
        status = iso_fail(err, ISO_E_FORMAT, "%s: checksum %s, pyramid.json says %s", path, found, digest);
    if (status == ISO_OK && memcmp(bytes, header, header_bytes) != 0)
        status = iso_fail(err, ISO_E_FORMAT, "%s: its NRRD header is not the one that pyramid.json describes", path);
    const bool codes = strcmp(f->key, "codes") == 0;
    if (status == ISO_OK && !(f->data = malloc(codes ? count : count * sizeof(float))))
        status = iso_fail(err, ISO_E_MEMORY, "%s: no memory for %zu samples", path, count);
    if (status == ISO_OK && codes)
        memcpy(f->data, bytes + header_bytes, count);
    else if (status == ISO_OK) {
        memmove(bytes, bytes + header_bytes, count * width); /* aligned */
        type_to_floats(bytes, f->type, count, f->data);
    }
    free(bytes);
    free(header);
    free(path);
    return status;
}

static void geometry_from_json(iso_json_reader *r, const json_t *object, iso_geometry *g)
{
    double size[3] = {0, 0, 0};
    iso_json_get_numbers(r, object, "size", true, 3, 1, 1u << 24, size);
    iso_json_get_numbers(r, object, "index_to_world", true, 9, -DBL_MAX, DBL_MAX, &g->index_to_world.m[0][0]);
    iso_json_get_numbers(r, object, "origin_mm", true, 3, -DBL_MAX, DBL_MAX, &g->origin_mm.x);
    iso_json_get_numbers(r, object, "box_index", true, 3, 0, 1u << 24, g->box_index);
    for (int a = 0; a < 3 && r->status == ISO_OK; ++a)
        g->size[a] = (size_t)size[a];
    if (r->status == ISO_OK)
        r->status = iso_geometry_check(g, r->path, r->err);
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
    iso_json_get_bool(r, object, "keep_float", true, &o->keep_float);
    iso_json_get_bool(r, object, "keep_magnitude", true, &o->keep_magnitude);
    iso_error why = {""};
    if (r->status == ISO_OK && (iso_scalar_filter_from_name(scalar, &o->scalar_filter, &why) != ISO_OK ||
                                iso_direction_filter_from_name(direction, &o->direction_filter, &why) != ISO_OK ||
                                iso_gradient_from_name(gradient, &o->gradient.method, &why) != ISO_OK ||
                                iso_code_from_name(code, &o->code, &why) != ISO_OK))
        r->status = iso_fail(r->err, ISO_E_FORMAT, "%s: %s", r->path, why.text);
}

static iso_status load_level(iso_json_reader *r, const char *dir, const json_t *entry, const iso_pyramid_options *opt,
                             iso_level *l, iso_error *err)
{
    const char *type = NULL;
    level_file files[FILE_COUNT];
    geometry_from_json(r, iso_json_get_object(r, entry, "geometry", true), &l->geometry);
    iso_json_get_string(r, entry, "stored_type", true, &type);
    iso_json_get_number(r, entry, "min", true, -FLT_MAX, FLT_MAX, &l->min);
    iso_json_get_number(r, entry, "max", true, -FLT_MAX, FLT_MAX, &l->max);
    json_t *list = iso_json_get_object(r, entry, "files", true);
    if (r->status == ISO_OK)
        r->status = iso_type_from_name(type, &l->stored_type, err);
    if (r->status == ISO_OK && iso_type_bytes(l->stored_type) > 2 && l->stored_type != ISO_F32)
        r->status = iso_fail(err, ISO_E_FORMAT, "%s: \"stored_type\" is \"%s\", must be of 8 or 16 bits, or float", r->path,
                             type);
    if (r->status != ISO_OK)
        return r->status;
    list_files(l, opt->code, files);
    iso_status status = load_file(dir, &l->geometry, &files[FILE_SCALAR], r, list, err);
    l->scalar = files[FILE_SCALAR].data;
    if (status == ISO_OK)
        status = load_file(dir, &l->geometry, &files[FILE_CODES], r, list, err);
    l->codes = files[FILE_CODES].data;
    if (status == ISO_OK && opt->keep_float)
        status = load_file(dir, &l->geometry, &files[FILE_DIRECTIONS], r, list, err);
    l->directions = files[FILE_DIRECTIONS].data;
    if (status == ISO_OK && opt->keep_magnitude)
        status = load_file(dir, &l->geometry, &files[FILE_MAGNITUDE], r, list, err);
    l->magnitude = files[FILE_MAGNITUDE].data;
    return status;
}

static iso_status load_levels(iso_json_reader *r, const char *dir, const json_t *root, iso_pyramid *out, iso_error *err)
{
    const char *schema = NULL, *source = NULL;
    iso_json_get_string(r, root, "schema", true, &schema);
    if (r->status == ISO_OK && strcmp(schema, SCHEMA) != 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: schema \"%s\", must be \"%s\"", r->path, schema, SCHEMA);
    iso_json_get_string(r, root, "source", true, &source);
    options_from_json(r, iso_json_get_object(r, root, "options", true), &out->options);
    json_t *levels = iso_json_get_array(r, root, "levels", true);
    if (r->status != ISO_OK)
        return r->status;
    const size_t count = json_array_size(levels);
    if (count < 1 || count > 32)
        return iso_fail(err, ISO_E_FORMAT, "%s: \"levels\" holds %zu levels, must be 1 to 32", r->path, count);
    out->source = strdup(source);
    out->levels = calloc(count, sizeof *out->levels);
    out->level_count = count;
    if (!out->source || !out->levels)
        return iso_fail(err, ISO_E_MEMORY, "%s: no memory for %zu levels", dir, count);
    for (size_t k = 0; k < count; ++k) {
        iso_status status = load_level(r, dir, json_array_get(levels, k), &out->options, &out->levels[k], err);
        if (status != ISO_OK)
            return status;
        if (k == 0)
            continue;
        iso_geometry wanted = iso_geometry_coarser(&out->levels[k - 1].geometry);
        if (memcmp(wanted.size, out->levels[k].geometry.size, sizeof wanted.size) != 0)
            return iso_fail(err, ISO_E_FORMAT, "%s: the sizes of level %zu are not half of the finer level's", r->path, k);
    }
    return ISO_OK;
}

iso_status iso_pyramid_load(const char *dir, iso_pyramid *out, iso_error *err)
{
    *out = (iso_pyramid){0};
    char *path = iso_path_join(dir, MARKER);
    json_t *root = NULL;
    if (!path)
        return iso_fail(err, ISO_E_MEMORY, "%s: out of memory", dir);
    iso_status status = iso_json_load(path, &root, err);
    if (status == ISO_OK) {
        iso_json_reader r = {.path = path, .err = err};
        status = load_levels(&r, dir, root, out, err);
    }
    json_decref(root);
    free(path);
    if (status != ISO_OK)
        iso_pyramid_destroy(out);
    return status;
}

bool iso_pyramid_is_one(const char *path)
{
    char *marker = iso_path_join(path, MARKER);
    bool is = marker && iso_path_is_dir(path) && iso_path_exists(marker);
    free(marker);
    return is;
}
