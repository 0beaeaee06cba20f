/* SPDX-License-Identifier: MIT */
#include "tf/histogram_verify.h"

#include <stdio.h>
#include <stdlib.h>

enum { LEAST_BITS = 8, MOST_BITS = 16, SECOND_VALUES = ISO_SECOND_VALUE_GRADIENT };

/* Counts the voxels in different bins. Both have the same voxels, so each is missing once and too many once. */
static uint64_t count_differing(const iso_joint *a, const iso_joint *b)
{
    uint64_t sum = 0;
    for (size_t row = 0; row < iso_joint_row_count(a); ++row) {
        size_t i = a->row_start[row], k = b->row_start[row];
        while (i < a->row_start[row + 1] || k < b->row_start[row + 1]) {
            const bool has_a = i < a->row_start[row + 1], has_b = k < b->row_start[row + 1];
            const bool take_a = has_a && (!has_b || a->entry_z[i] <= b->entry_z[k]),
                       take_b = has_b && (!has_a || b->entry_z[k] <= a->entry_z[i]);
            const uint64_t of_a = take_a ? a->entry_count_of[i] : 0, of_b = take_b ? b->entry_count_of[k] : 0;
            sum += of_a > of_b ? of_a - of_b : of_b - of_a;
            i += take_a;
            k += take_b;
        }
    }
    return (sum + 1) / 2;
}

static iso_status check_one(const iso_pyramid *p, const char *dir, const iso_joint_key *key, int threads,
                            iso_joint_check *check, iso_error *err)
{
    const iso_level *fine = &p->levels[0];
    iso_bins z, s;
    OWNED(iso_joint) stored = {0}, counted = {0};
    *check = (iso_joint_check){.key = *key, .voxels = iso_geometry_voxel_count(&fine->geometry)};
    iso_joint_bins(fine->min, fine->max, fine->stored_type, key->bits, &z, &s);
    if (iso_joint_load(dir, key, &z, &s, check->voxels, &stored, &check->unreadable) != ISO_OK)
        return ISO_OK;
    NEED(iso_joint_compute(p, key->level, key->bits, key->second, threads, &counted, err));
    check->differing = count_differing(&stored, &counted);
    return ISO_OK;
}

/* Lists the keys of existing files and returns their number. keys: space for all, or NULL. */
static size_t list_keys(const iso_pyramid *p, const char *dir, iso_joint_key *keys)
{
    size_t count = 0;
    for (size_t level = 1; level < p->level_count; ++level)
        for (int bits = LEAST_BITS; bits <= MOST_BITS; ++bits)
            for (int second = ISO_SECOND_VALUE_NONE; second <= SECOND_VALUES; ++second) {
                const iso_joint_key key = {level, bits, (iso_second_value)second};
                if (!iso_joint_is_stored(dir, &key))
                    continue;
                if (keys)
                    keys[count] = key;
                ++count;
            }
    return count;
}

iso_status iso_joint_verify(const iso_pyramid *p, const char *dir, int threads, iso_joint_check **checks, size_t *count,
                            const iso_progress *progress, iso_error *err)
{
    *count = list_keys(p, dir, NULL);
    FREED iso_joint_key *keys = calloc(*count + 1, sizeof *keys);
    *checks = calloc(*count + 1, sizeof **checks);
    NEED_MEMORY(keys && *checks, err, "no memory for %zu joint histograms", *count);
    list_keys(p, dir, keys);
    for (size_t i = 0; i < *count; ++i) {
        iso_progress_report(progress, "joint histograms", (double)i / (double)*count);
        NEED(check_one(p, dir, &keys[i], threads, &(*checks)[i], err));
    }
    return ISO_OK;
}

bool iso_joint_check_is_good(const iso_joint_check *check)
{
    return check->differing == 0 && !check->unreadable.text[0];
}

static const char *second_word(iso_second_value second)
{
    return second == ISO_SECOND_VALUE_DEVIATION  ? " and of the deviation"
           : second == ISO_SECOND_VALUE_GRADIENT ? " and of the gradient"
                                                 : "";
}

const char *iso_joint_check_text(const iso_joint_check *check, char *text, size_t size)
{
    char name[80];
    snprintf(name, sizeof name, "level %zu: its joint histogram of %d bits%s", check->key.level, check->key.bits,
             second_word(check->key.second));
    if (check->unreadable.text[0])
        snprintf(text, size, "%s does not belong to this pyramid: %s", name, check->unreadable.text);
    else if (check->differing > 0)
        snprintf(text, size, "%s counts %llu of %llu voxels in other bins than its levels", name,
                 (unsigned long long)check->differing, (unsigned long long)check->voxels);
    else
        snprintf(text, size, "%s counts all %llu voxels as its levels do", name, (unsigned long long)check->voxels);
    return text;
}
