/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "tf/level_look.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"

static const char where[] = "pyramid.json";

/* Returns the part of made_for or of a level's entry that is of one scene. */
static const json_t *part_of(const json_t *object, size_t scene)
{
    return scene == 0 ? object : json_array_get(json_object_get(object, "others"), scene - 1);
}

size_t iso_level_scene_count(const iso_pyramid *p)
{
    return p->made_for ? 1 + json_array_size(json_object_get(p->made_for, "others")) : 0;
}

char *iso_level_scene_names(const iso_pyramid *p)
{
    char *names = strdup("");
    for (size_t i = 0; i < iso_level_scene_count(p) && names; ++i) {
        const char *name = json_string_value(json_object_get(part_of(p->made_for, i), "scene"));
        char *longer = NULL;
        if (asprintf(&longer, "%s%s%s", names, i > 0 ? ", " : "", name ? name : "a scene without a name") < 0)
            longer = NULL;
        free(names);
        names = longer;
    }
    return names;
}

iso_status iso_level_scene_tf(const iso_pyramid *p, size_t scene, iso_tf_table *tf, iso_error *err)
{
    iso_json_reader r = {.path = where, .err = err};
    OWNED(iso_tf) own = {0};
    *tf = (iso_tf_table){0};
    const json_t *object = iso_json_get_object(&r, part_of(p->made_for, scene), "tf", true);
    NEED(r.status);
    NEED(iso_tf_from_json(object, where, &own, err));
    return iso_tf_tabulate(&own, iso_pyramid_lo(p), iso_pyramid_hi(p), &p->levels[0].geometry, tf, err);
}

/* Returns the level's entry; NULL: it was not made for a scene. */
static const json_t *find_entry(const iso_pyramid *p, size_t level)
{
    const json_t *entry;
    size_t i;
    json_array_foreach (json_object_get(p->made_for, "levels"), i, entry)
        if ((size_t)json_integer_value(json_object_get(entry, "level")) == level)
            return entry;
    return NULL;
}

static iso_status read_table(const json_t *object, iso_tf_table *tf, iso_error *err)
{
    iso_json_reader r = {.path = where, .err = err};
    double range[2] = {0, 1};
    iso_json_get_numbers(&r, object, "range", true, &(iso_json_list){range, 2, -1e300, 1e300});
    const json_t *entries = iso_json_get_array(&r, object, "entries", true);
    const size_t numbers = json_array_size(entries);
    if (r.status == ISO_OK &&
        !(range[0] < range[1] && numbers >= 8 && numbers % 4 == 0 && numbers <= 4 * (size_t)ISO_TF_MOST_ENTRIES))
        return iso_fail(err, ISO_E_FORMAT, "%s: a level's table has %zu numbers from %g to %g", where, numbers,
                        range[0], range[1]);
    *tf = (iso_tf_table){.count = numbers / 4, .lo = range[0], .hi = range[1]};
    tf->entries = r.status == ISO_OK ? malloc(numbers * sizeof *tf->entries) : NULL;
    if (!tf->entries)
        return r.status != ISO_OK ? r.status : iso_fail(err, ISO_E_MEMORY, "no memory for %zu entries", tf->count);
    for (size_t i = 0; i < numbers; ++i) {
        const json_t *number = json_array_get(entries, i);
        const double v = json_number_value(number), most = i % 4 == 3 ? ISO_TF_MOST_EXTINCTION : 1;
        if (!json_is_number(number) || !(v >= 0 && v <= most))
            return iso_fail(err, ISO_E_FORMAT, "%s: number %zu of a level's table must be 0 to %g", where, i, most);
        tf->entries[i] = (float)v;
    }
    return ISO_OK;
}

iso_status iso_level_look(const iso_pyramid *p, size_t level, const iso_tf_table *tf, iso_tf_table *own, bool *found,
                          iso_error *err)
{
    const json_t *entry = find_entry(p, level), *table = NULL;
    bool matches = false;
    iso_status status = ISO_OK;
    *own = (iso_tf_table){0};
    for (size_t i = 0; i < iso_level_scene_count(p) && entry && status == ISO_OK && !matches; ++i) {
        iso_tf_table made_for = {0};
        status = iso_level_scene_tf(p, i, &made_for, err);
        matches = status == ISO_OK && iso_tf_table_equals(&made_for, tf);
        table = json_object_get(part_of(entry, i), "tf");
        iso_tf_table_destroy(&made_for);
    }
    if (status == ISO_OK && matches)
        status = table ? read_table(table, own, err) : iso_tf_table_copy(tf, own, err);
    if (found)
        *found = matches;
    if (status != ISO_OK)
        iso_tf_table_destroy(own);
    return status;
}

const uint8_t *iso_level_own_scale(const iso_pyramid *p, size_t level, const iso_tf_table *tf)
{
    OWNED(iso_tf_table) own = {0};
    bool found = false;
    if (!p->levels[level].scale || p->levels[level].geometry.has_no_data)
        return p->levels[level].scale;
    const iso_status status = iso_level_look(p, level, tf, &own, &found, NULL);
    return status == ISO_OK && found ? p->levels[level].scale : NULL;
}

json_t *iso_level_look_to_json(const iso_tf_table *own)
{
    json_t *entries = json_array();
    for (size_t i = 0; i < 4 * own->count; ++i)
        json_array_append_new(entries, json_real((double)own->entries[i]));
    return json_pack("{s:[f, f], s:o}", "range", own->lo, own->hi, "entries", entries);
}
