/* SPDX-License-Identifier: MIT */
#include "pyramid/value_table.h"

#include <stdlib.h>

iso_value_table iso_value_table_create(const iso_level *level, iso_value_function *of, const void *user)
{
    const iso_type type = level->stored_type;
    const bool is_small = type == ISO_U8 || type == ISO_I8 || type == ISO_U16 || type == ISO_I16;
    iso_value_table t = {.level = level, .of = of, .user = user};
    if (!is_small || !(level->min >= -32768 && level->max <= 65535))
        return t;
    t.first = type == ISO_U8 ? 0 : (int32_t)level->min;
    t.last = type == ISO_U8 ? 255 : (int32_t)level->max;
    t.results = malloc((size_t)(t.last - t.first + 1) * sizeof *t.results);
    for (int32_t value = t.first; t.results && value <= t.last; ++value)
        t.results[value - t.first] = of(user, value);
    return t;
}

void iso_value_table_destroy(iso_value_table *t)
{
    free(t->results);
    *t = (iso_value_table){0};
}

uint64_t iso_value_table_sum(const iso_value_table *t, size_t first, size_t count)
{
    enum { BLOCK = 1024 };
    const iso_level *l = t->level;
    float room[BLOCK];
    uint64_t sum = 0;
    if (!l->scalar && t->results && l->samples->type == ISO_U8 && !l->geometry.has_no_data) {
        const uint8_t *bytes = (const uint8_t *)l->samples->data + first;
        for (size_t i = 0; i < count; ++i)
            sum += t->results[bytes[i]];
        return sum;
    }
    for (size_t at = 0; at < count; at += BLOCK) {
        const size_t n = count - at < BLOCK ? count - at : BLOCK;
        const float *values = iso_level_floats(l, first + at, n, room);
        for (size_t i = 0; i < n; ++i)
            sum += iso_value_table_at(t, values[i]);
    }
    return sum;
}
