/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "pyramid/pyramid_layout.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inputs.h"
#include "base/json.h"
#include "base/provenance.h"

#define ALIGNMENT 64

void iso_layout_files(const iso_pyramid_options *opt, iso_type scalar_type, level_file files[FILE_COUNT])
{
    const iso_type codes = iso_code_describe(opt->code)->is_signed ? ISO_I8 : ISO_U8;
    files[FILE_SCALAR] =
        (level_file){.key = "scalar", .suffix = "", .components = 1, .type = scalar_type, .stored = true};
    files[FILE_CODES] = (level_file){
        .key = "codes", .suffix = "_dir", .components = 3, .type = codes, .stored = true, .is_bytes = true};
    files[FILE_DIRECTIONS] = (level_file){
        .key = "directions", .suffix = "_grad", .components = 3, .type = ISO_F32, .stored = opt->keep_float};
    files[FILE_MAGNITUDE] = (level_file){
        .key = "magnitude", .suffix = "_mag", .components = 1, .type = ISO_F32, .stored = opt->keep_magnitude};
    files[FILE_SCALE] =
        (level_file){.key = "scale", .suffix = "_scale", .components = 1, .type = ISO_U8, .is_bytes = true};
}

void iso_layout_name(const level_file *f, size_t level, char name[64])
{
    snprintf(name, 64, "level_%zu%s.nrrd", level, f->suffix);
}

iso_type iso_layout_type(iso_type input)
{
    return iso_type_bytes(input) <= 2 ? input : ISO_F32;
}

char *iso_layout_header(const iso_geometry *g, const level_file *f)
{
    const iso_mat3 *m = &g->index_to_world;
    iso_vec3 o = iso_geometry_to_world(g, iso_v3(0.5, 0.5, 0.5));
    const bool vector = f->components > 1;
    FREED char *text = NULL;
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
    return n < 0 ? NULL : padded;
}

json_t *iso_layout_geometry(const iso_geometry *g)
{
    json_t *object = json_pack("{s:[I,I,I], s:o, s:o, s:o}", "size", (json_int_t)g->size[0], (json_int_t)g->size[1],
                               (json_int_t)g->size[2], "index_to_world",
                               iso_json_numbers(&g->index_to_world.m[0][0], 9), "origin_mm",
                               iso_json_numbers(&g->origin_mm.x, 3), "box_index", iso_json_numbers(g->box_index, 3));
    if (g->is_patient)
        json_object_set_new(object, "is_patient", json_true());
    if (g->has_no_data)
        json_object_set_new(object, "has_no_data", json_true());
    return object;
}

json_t *iso_layout_options(const iso_pyramid_options *o)
{
    json_t *object = json_pack("{s:I, s:s, s:s, s:s, s:s, s:f, s:I, s:I, s:b, s:b}", "levels",
                               (json_int_t)o->level_count, "scalar_filter", iso_scalar_filter_name(o->scalar_filter),
                               "direction_filter", iso_direction_filter_name(o->direction_filter), "gradient",
                               iso_gradient_name(o->gradient.method), "code", iso_code_describe(o->code)->name,
                               "gauss_sigma_voxels", o->gauss_sigma_voxels, "gauss_radius", (json_int_t)o->gauss_radius,
                               "eq1_exponent", (json_int_t)o->eq1_exponent, "keep_float", o->keep_float,
                               "keep_magnitude", o->keep_magnitude);
    if (o->value_range[1] > o->value_range[0])
        json_object_set_new(object, "value_range", iso_json_numbers(o->value_range, 2));
    return object;
}

json_t *iso_layout_level(const iso_geometry *g, iso_type scalar_type, double min, double max,
                         const level_file files[FILE_COUNT], size_t level)
{
    json_t *list = json_object();
    for (int i = 0; i < FILE_COUNT; ++i) {
        char name[64], digest[32];
        if (!files[i].stored)
            continue;
        iso_layout_name(&files[i], level, name);
        snprintf(digest, sizeof digest, "%016llx", (unsigned long long)files[i].hash);
        json_object_set_new(list, files[i].key,
                            json_pack("{s:s, s:I, s:s}", "name", name, "bytes", (json_int_t)files[i].bytes, "xxh3_64",
                                      digest));
    }
    return json_pack("{s:o, s:s, s:f, s:f, s:o}", "geometry", iso_layout_geometry(g), "stored_type",
                     iso_type_name(scalar_type), "min", min, "max", max, "files", list);
}

void iso_layout_choice(const iso_pyramid_options *opt, size_t level, json_t *object)
{
    const iso_direction_choice *c = &opt->choice;
    if (level == 0 || opt->direction_filter != ISO_DIRECTION_AUTO || !c->is_made)
        return;
    json_object_update_new(object, json_pack("{s:s, s:f, s:f}", "direction_filter",
                                             iso_direction_filter_name(c->filter[level]), "mean_agreement",
                                             c->mean_agreement[level], "axis_agreement", c->axis_agreement[level]));
}

static iso_status save_text(const char *dir, const char *name, const char *text, iso_error *err)
{
    FREED char *path = iso_path_join(dir, name);
    return path && text ? iso_file_write(path, text, strlen(text), err)
                        : iso_fail(err, ISO_E_MEMORY, "%s: no memory for %s", dir, name);
}

enum { DUMP_FLAGS = JSON_INDENT(2) | JSON_REAL_PRECISION(17) };

iso_status iso_layout_save_json(const char *dir, const char *name, const json_t *root, iso_error *err)
{
    FREED char *text = json_dumps(root, DUMP_FLAGS);
    return save_text(dir, name, text, err);
}

/* ---- the checksum of pyramid.json: of its text with these zeros in the checksum's place ---- */

static const char no_checksum[] = "0000000000000000";
enum { CHECKSUM_DIGITS = sizeof no_checksum - 1 };

/* Returns the last place in text where the digits stand as a word of JSON; or NULL. */
static char *find_digits(char *text, const char *digits)
{
    char word[CHECKSUM_DIGITS + 3], *found = NULL;
    snprintf(word, sizeof word, "\"%s\"", digits);
    for (char *at = strstr(text, word); at; at = strstr(at + 1, word))
        found = at + 1;
    return found;
}

static void put_checksum(char *text, size_t size, char *place)
{
    char digits[CHECKSUM_DIGITS + 1];
    memcpy(place, no_checksum, CHECKSUM_DIGITS);
    snprintf(digits, sizeof digits, "%016llx", (unsigned long long)XXH3_64bits(text, size));
    memcpy(place, digits, CHECKSUM_DIGITS);
}

iso_status iso_layout_load(const char *path, json_t **root, iso_error *err)
{
    char *place;
    FREED char *text = NULL;
    size_t size;
    *root = NULL;
    iso_status status = iso_inputs_note(path, err);
    TRY(status, iso_file_read(path, &text, &size, err));
    TRY(status, iso_json_parse(path, text, size, root, err));
    if (status != ISO_OK)
        return status;
    const char *said = json_string_value(json_object_get(*root, "xxh3_64")), *schema = NULL;
    iso_json_reader r = {.path = path, .err = err};
    iso_json_get_string(&r, *root, "schema", true, &schema);
    if (r.status != ISO_OK)
        status = r.status;
    else if (strcmp(schema, ISO_PYRAMID_SCHEMA) != 0)
        status = iso_fail(err, ISO_E_FORMAT, "%s: schema \"%s\", must be \"%s\"", path, schema, ISO_PYRAMID_SCHEMA);
    else if (!said || strlen(said) != CHECKSUM_DIGITS || !(place = find_digits(text, said)))
        status = iso_fail(err, ISO_E_FORMAT,
                          "%s: has no checksum of itself (xxh3_64); build the pyramid again",
                          path);
    else {
        put_checksum(text, size, place);
        if (strncmp(place, said, CHECKSUM_DIGITS) != 0)
            status = iso_fail(err, ISO_E_FORMAT, "%s: was changed since it was written: checksum %.16s, it says %s",
                              path, place, said);
    }
    if (status != ISO_OK) {
        json_decref(*root);
        *root = NULL;
    }
    return status;
}

iso_status iso_layout_save(const char *dir, const char *source, const iso_pyramid_unit *unit,
                           const iso_pyramid_options *opt, json_t *levels, const iso_pyramid *of, iso_error *err)
{
    json_auto_t *root = json_pack("{s:s, s:s, s:s, s:o, s:o}", "schema", ISO_PYRAMID_SCHEMA, "source",
                                  iso_provenance_name(source), "built_by", "isoshade " ISO_VERSION, "options",
                                  iso_layout_options(opt), "levels", levels);
    if (root && unit->name[0])
        json_object_set_new(root, "unit", json_pack("{s:s, s:f}", "name", unit->name, "mm", unit->mm));
    if (root && of && of->segments)
        json_object_set(root, "segments", of->segments);
    if (root && of && of->made_for)
        json_object_set(root, "made_for", of->made_for);
    json_object_set_new(root, "xxh3_64", json_string(no_checksum));
    FREED char *text = root ? json_dumps(root, DUMP_FLAGS) : NULL;
    if (text)
        put_checksum(text, strlen(text), find_digits(text, no_checksum));
    return save_text(dir, ISO_PYRAMID_MARKER, text, err);
}
