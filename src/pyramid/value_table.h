/* SPDX-License-Identifier: MIT */
/* value_table.h - a function of a level's scalar, computed once per value instead of once per voxel.
 *
 * In:  level 0 of a volume, and a function of a value.   Out: its result for each voxel, the same bits.
 * Integers of at most 16 bits have a table; other values are computed when they are asked for. */
#pragma once

#include "pyramid/narrow.h"

typedef uint32_t iso_value_function(const void *user, double value);

typedef struct iso_value_table {
    const iso_level *level;
    iso_value_function *of;
    const void *user;
    int32_t first, last; /* values with a result */
    uint32_t *results;   /* owned; NULL: no table */
} iso_value_table;

/* Creates a table for the range of the level; without memory there is none. The level and `user` must outlive it. */
iso_value_table iso_value_table_create(const iso_level *level, iso_value_function *of, const void *user);
void iso_value_table_destroy(iso_value_table *t);

static inline uint32_t iso_value_table_at(const iso_value_table *t, float value)
{
    if (t->results && value >= (float)t->first && value <= (float)t->last) {
        const int32_t whole = (int32_t)value;
        if ((float)whole == value)
            return t->results[whole - t->first];
    }
    return t->of(t->user, (double)value);
}

/* Sums the results of `count` voxels from number `first` on. */
uint64_t iso_value_table_sum(const iso_value_table *t, size_t first, size_t count);
