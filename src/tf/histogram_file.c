/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "base/file.h"
#include "base/manifest.h"
#include "tf/histogram.h"
#include "volume/volume.h"

static char *file_path(const char *dir, const iso_joint_key *key)
{
    const size_t level = key->level;
    const int bits = key->bits;
    char *path = NULL;
    if (key->second != ISO_SECOND_VALUE_NONE)
        return asprintf(&path, "%s/level_%zu_joint%d%c%d.nrrd", dir, level, bits,
                        key->second == ISO_SECOND_VALUE_GRADIENT ? 'g' : 'x', ISO_TF_2D_ROWS) < 0
                   ? NULL
                   : path;
    return asprintf(&path, "%s/level_%zu_joint%d.nrrd", dir, level, bits) < 0 ? NULL : path;
}

bool iso_joint_is_stored(const char *dir, const iso_joint_key *key)
{
    FREED char *path = file_path(dir, key);
    const bool is = path && iso_path_exists(path);
    return is;
}

static bool fits_32_bits(const iso_joint *j)
{
    for (size_t i = 0; i < j->entry_count; ++i)
        if (j->entry_count_of[i] > UINT32_MAX)
            return false;
    return true;
}

static bool sparse_is_smaller(const iso_joint *j)
{
    return 3 * j->entry_count < j->z.count * iso_joint_row_count(j);
}

double iso_joint_stored_bytes(const iso_joint *j)
{
    double numbers = sparse_is_smaller(j) ? 3.0 * (double)j->entry_count
                                          : (double)j->z.count * (double)iso_joint_row_count(j);
    return numbers * (fits_32_bits(j) ? 4 : 8);
}

/* Returns the geometry of bins. Axis x steps through z, axis y through s; the first sample is at (z.lo, s.lo). */
static iso_geometry bins_geometry(const iso_joint *j, bool sparse)
{
    size_t size[3] = {sparse ? 3 : j->z.count, sparse ? (j->entry_count ? j->entry_count : 1) : iso_joint_row_count(j),
                      1};
    double spacing[3] = {j->z.step, j->s.step, 1};
    iso_geometry g = iso_geometry_axis_aligned(size, spacing);
    g.origin_mm = iso_v3(j->z.lo - j->z.step / 2, j->s.lo - j->s.step / 2, 0);
    return g;
}

static void put_number(iso_volume *v, size_t at, uint64_t value)
{
    if (v->type == ISO_U32)
        ((uint32_t *)v->data)[at] = (uint32_t)value;
    else
        ((double *)v->data)[at] = (double)value;
}

static uint64_t get_number(const iso_volume *v, size_t at)
{
    return v->type == ISO_U32 ? ((const uint32_t *)v->data)[at] : (uint64_t)fmax(((const double *)v->data)[at], 0);
}

iso_status iso_joint_save(const iso_joint *j, const char *dir, size_t level, int bits, iso_error *err)
{
    bool sparse = sparse_is_smaller(j);
    iso_geometry g = bins_geometry(j, sparse);
    OWNED(iso_volume) v = {0};
    FREED char *path = file_path(dir, &(iso_joint_key){level, bits, j->second});
    NEED(path ? iso_volume_create(&v, &g, fits_32_bits(j) ? ISO_U32 : ISO_F64, path, err)
              : iso_fail(err, ISO_E_MEMORY, "joint histogram: out of memory"));
    for (size_t s = 0; s < iso_joint_row_count(j); ++s)
        for (size_t i = j->row_start[s]; i < j->row_start[s + 1]; ++i) {
            if (sparse) {
                put_number(&v, 3 * i, j->entry_z[i]);
                put_number(&v, 3 * i + 1, s);
            }
            put_number(&v, sparse ? 3 * i + 2 : s * j->z.count + j->entry_z[i], j->entry_count_of[i]);
        }
    NEED(iso_volume_save(&v, path, true, err));
    if (!iso_manifest_add(dir, iso_path_base(path))) {
        iso_remove_tree(path);
        return iso_fail(err, ISO_E_IO, "%s: cannot list the folder", path);
    }
    return ISO_OK;
}

/* Fills *j from the file's numbers. ISO_E_FORMAT: sizes or order differ from those that save writes; ISO_E_MEMORY. */
static iso_status read_rows(const iso_volume *v, const char *path, const iso_bins *z, const iso_bins *s,
                            iso_second_value second, iso_joint *j, iso_error *err)
{
    const size_t *n = v->geometry.size;
    bool sparse = n[0] == 3 && z->count != 3;
    size_t cells = sparse ? n[1] : n[0] * n[1], entries = 0, last_key = 0;
    size_t second_count = second == ISO_SECOND_VALUE_NONE ? 1 : ISO_TF_2D_ROWS, rows = s->count * second_count;
    if (!sparse && (n[0] != z->count || n[1] != rows))
        return iso_fail(err, ISO_E_FORMAT, "%s: has %zu x %zu bins, must be %zu x %zu", path, n[0], n[1], z->count,
                        rows);
    for (size_t i = 0; i < cells; ++i)
        entries += get_number(v, sparse ? 3 * i + 2 : i) > 0;
    *j = (iso_joint){.z = *z, .s = *s, .second = second, .second_count = second_count, .entry_count = entries};
    j->row_start = calloc(rows + 1, sizeof *j->row_start);
    j->entry_z = malloc((entries + 1) * sizeof *j->entry_z);
    j->entry_count_of = malloc((entries + 1) * sizeof *j->entry_count_of);
    NEED_MEMORY(j->row_start && j->entry_z && j->entry_count_of, err, "%s: no memory for %zu entries", path, entries);
    for (size_t i = 0, at = 0; i < cells; ++i) {
        uint64_t count = get_number(v, sparse ? 3 * i + 2 : i);
        if (count == 0)
            continue;
        uint64_t zi = sparse ? get_number(v, 3 * i) : i % z->count,
                 si = sparse ? get_number(v, 3 * i + 1) : i / z->count;
        if (zi >= z->count || si >= rows || (at > 0 && si * z->count + zi <= last_key))
            return iso_fail(err, ISO_E_FORMAT, "%s: entry %zu is (%llu, %llu), out of order or out of range", path, i,
                            (unsigned long long)zi, (unsigned long long)si);
        last_key = (size_t)(si * z->count + zi);
        j->entry_z[at] = (uint16_t)zi;
        j->entry_count_of[at++] = count;
        j->voxel_count += count;
        ++j->row_start[si + 1];
    }
    for (size_t i = 0; i < rows; ++i)
        j->row_start[i + 1] += j->row_start[i];
    return ISO_OK;
}

iso_status iso_joint_load(const char *dir, const iso_joint_key *key, const iso_bins *z, const iso_bins *s,
                          uint64_t voxel_count, iso_joint *j, iso_error *err)
{
    *j = (iso_joint){0};
    OWNED(iso_volume) v = {0};
    FREED char *path = file_path(dir, key);
    iso_status status = path ? iso_volume_load(path, &v, err)
                             : iso_fail(err, ISO_E_MEMORY, "joint histogram: out of memory");
    if (status == ISO_OK && v.type != ISO_U32 && v.type != ISO_F64)
        status = iso_fail(err, ISO_E_FORMAT, "%s: has type %s, must be uint32 or double", path, iso_type_name(v.type));
    if (status == ISO_OK) {
        iso_vec3 first = iso_geometry_to_world(&v.geometry, iso_v3(0.5, 0.5, 0.5));
        double off = fmax(fabs(first.x - z->lo) / z->step, fabs(first.y - s->lo) / s->step);
        if (!(off < 1e-6) || fabs(v.geometry.index_to_world.m[0][0] / z->step - 1) > 1e-9 ||
            fabs(v.geometry.index_to_world.m[1][1] / s->step - 1) > 1e-9)
            status = iso_fail(err, ISO_E_FORMAT, "%s: bins have width %g from %g, must be %g from %g", path,
                              v.geometry.index_to_world.m[0][0], first.x, z->step, z->lo);
    }
    TRY(status, read_rows(&v, path, z, s, key->second, j, err));
    if (status == ISO_OK && j->voxel_count != voxel_count && !(voxel_count == 0 && j->voxel_count > 0))
        status = iso_fail(err, ISO_E_FORMAT, "%s: counts %llu voxels, level 0 has %llu", path,
                          (unsigned long long)j->voxel_count, (unsigned long long)voxel_count);
    if (status != ISO_OK)
        iso_joint_destroy(j);
    return status;
}

/* Removes a file that could not be loaded: it counts as an input, which no output replaces. */
static void remove_stored(const char *dir, const iso_joint_key *key)
{
    FREED char *path = file_path(dir, key);
    if (path)
        unlink(path);
}

iso_status iso_joint_obtain(const iso_pyramid *p, const char *dir, const iso_joint_key *key, int threads, iso_joint *j,
                            iso_error *err)
{
    const size_t level = key->level;
    const int bits = key->bits;
    const iso_second_value second = key->second;
    iso_bins z, s;
    const iso_level *fine = &p->levels[0];
    if (bits < 8 || bits > 16 || level < 1 || level >= p->level_count)
        return iso_joint_compute(p, level, bits, second, threads, j, err); /* names the value and the limit */
    iso_joint_bins(fine->min, fine->max, fine->stored_type, bits, &z, &s);
    const uint64_t count = fine->geometry.has_no_data ? 0 : iso_geometry_voxel_count(&fine->geometry);
    if (dir && iso_joint_load(dir, key, &z, &s, count, j, NULL) == ISO_OK)
        return ISO_OK;
    iso_pyramid whole = {0};
    iso_status status = ISO_OK;
    if (!fine->scalar && !dir)
        return iso_fail(err, ISO_E_RANGE, "joint histogram: no samples and no folder to read them from");
    if (!fine->scalar)
        status = iso_pyramid_load(dir, &whole, err);
    TRY(status, iso_joint_compute(fine->scalar ? p : &whole, level, bits, second, threads, j, err));
    iso_pyramid_destroy(&whole);
    if (status == ISO_OK && dir) {
        remove_stored(dir, key);
        iso_joint_save(j, dir, level, bits, NULL); /* a cache: if it fails, the next run counts again */
    }
    return status;
}
