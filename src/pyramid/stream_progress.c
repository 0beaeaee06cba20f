/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "pyramid/stream_build.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/parallel.h"
#include "pyramid/pyramid_layout.h"

#define PROGRESS_SCHEMA "isoshade.progress/2"

static void add_json(iso_key *key, const char *part, json_t *value)
{
    FREED char *text = json_dumps(value, JSON_COMPACT | JSON_ENCODE_ANY | JSON_REAL_PRECISION(17));
    iso_key_add_text(key, part, text ? text : "");
    json_decref(value);
}

iso_status iso_stream_make_key(pyramid_build *s, double scale, iso_error *err)
{
    s->key = iso_key_create();
    NEED_MEMORY(s->key, err, "out of memory");
    if (s->how->key)
        iso_key_add_all(s->key, s->how->key);
    add_json(s->key, "the volume", iso_layout_geometry(&s->header.geometry));
    add_json(s->key, "the samples' type", json_string(iso_type_name(s->header.type)));
    add_json(s->key, "the samples' range", json_real(scale));
    add_json(s->key, "the list of options", iso_layout_options(s->opt));
    return iso_key_add_surroundings(s->key, err);
}

json_t *iso_stream_describe_job(const pyramid_build *s)
{
    json_t *parts = iso_key_to_json(s->key);
    return parts ? json_pack("{s:s, s:o}", "schema", PROGRESS_SCHEMA, "key", parts) : NULL;
}

static iso_status save_progress(const pyramid_build *s, json_t *job, size_t planes, iso_error *err)
{
    json_t *ranges = json_array();
    for (size_t k = 0; k < s->out.level_count; ++k) {
        double range[2] = {0, 0};
        iso_cascade_range(s->cascade, k, &range[0], &range[1]);
        json_array_append_new(ranges, iso_json_numbers(range, 2)); /* null if there is none yet */
    }
    json_object_set_new(job, "planes", json_integer((json_int_t)planes));
    json_object_set_new(job, "ranges", ranges);
    return iso_layout_save_json(s->output.temp_path, STREAM_PROGRESS_NAME, job, err);
}

iso_status iso_stream_take_up_carry(pyramid_build *s, const char *folder, size_t z, iso_error *err)
{
    size_t plane_floats;
    float *carry = iso_cascade_carry(s->cascade, &plane_floats);
    const size_t level = iso_cascade_carry_level(s->cascade), planes = z >> level;
    if (!carry || planes == 0)
        return ISO_OK;
    FREED char *path = iso_path_join(folder, STREAM_CARRY_NAME), *data = NULL;
    size_t size = 0;
    NEED(path ? iso_file_read(path, &data, &size, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    if (size < planes * plane_floats * sizeof *carry)
        return iso_fail(err, ISO_E_FORMAT, "%s: holds less than progress.json says", path);
    memcpy(carry, data, planes * plane_floats * sizeof *carry);
    s->carry_planes = planes;
    return ISO_OK;
}

/* Takes the state that a build resumes from; false if the notes are incomplete. */
static bool take_notes(pyramid_build *s, const json_t *found, size_t *planes)
{
    const json_t *ranges = json_object_get(found, "ranges");
    *planes = (size_t)json_integer_value(json_object_get(found, "planes"));
    if (*planes == 0 || *planes > s->header.geometry.size[2] || json_array_size(ranges) != s->out.level_count)
        return false;
    for (size_t k = 0; k < s->out.level_count; ++k) {
        json_t *range = json_array_get(ranges, k);
        if (json_is_number(json_array_get(range, 0)))
            iso_cascade_set_range(s->cascade, k, json_number_value(json_array_get(range, 0)),
                                  json_number_value(json_array_get(range, 1)));
    }
    return true;
}

iso_status iso_stream_read_progress(pyramid_build *s, bool *is_same, size_t *planes, iso_error *err)
{
    char *why = s->report->not_resumed;
    FREED char *path = iso_path_join(s->output.temp_path, STREAM_PROGRESS_NAME);
    json_auto_t *found = NULL;
    iso_error failure;
    const iso_status status = path && iso_path_exists(path) ? iso_json_load(path, &found, &failure) : ISO_E_FORMAT;
    *is_same = status == ISO_OK &&
               !iso_key_differs(s->key, json_object_get(found, "key"), why, sizeof s->report->not_resumed) &&
               take_notes(s, found, planes);
    return status == ISO_E_IO ? iso_fail(err, status, "%s", failure.text) : ISO_OK;
}

/* Writes the carry up to plane z of the input. */
static iso_status write_carry(pyramid_build *s, size_t z, iso_error *err)
{
    size_t plane_floats;
    const float *carry = iso_cascade_carry(s->cascade, &plane_floats);
    const size_t planes = z >> iso_cascade_carry_level(s->cascade);
    if (!carry || planes <= s->carry_planes)
        return ISO_OK;
    NEED(iso_bigfile_write(s->carry, carry + s->carry_planes * plane_floats,
                           (planes - s->carry_planes) * plane_floats * sizeof *carry, err));
    s->carry_planes = planes;
    return iso_bigfile_sync(s->carry, err);
}

bool iso_stream_progress_is_due(pyramid_build *s)
{
    const double now = iso_clock_seconds();
    if (now - s->progress_at < s->how->save_seconds)
        return false;
    s->progress_at = now;
    return true;
}

/* Notes that all data on the disk up to plane z may be resumed from. */
iso_status iso_stream_note_progress(pyramid_build *s, json_t *job, size_t z, iso_error *err)
{
    NEED(write_carry(s, z, err));
    return save_progress(s, job, z, err);
}

static void remove_in(const char *dir, const char *name)
{
    FREED char *path = iso_path_join(dir, name);
    if (path)
        unlink(path);
}

void iso_stream_remove_progress(const pyramid_build *s)
{
    remove_in(s->output.temp_path, STREAM_PROGRESS_NAME);
    remove_in(s->output.temp_path, STREAM_CARRY_NAME);
}
