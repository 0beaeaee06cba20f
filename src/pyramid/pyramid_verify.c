/* SPDX-License-Identifier: MIT */
#include "pyramid/pyramid_verify.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pyramid/agreement.h"
#include "pyramid/cascade.h"
#include "pyramid/filter_kernel.h"

enum { MAX_LEVELS = 32 };

/* Levels made again, a slab at a time. */
typedef struct rebuild {
    const iso_pyramid *p;
    iso_cascade *cascade;
    iso_direction_choice choice; /* by level 0's values, where the choice was left to the build */
    size_t level_count;          /* that the options make of level 0 */
    iso_cascade_out out[MAX_LEVELS];
    iso_level_check *checks;
} rebuild;

static void end_rebuild(rebuild *r)
{
    for (size_t k = 0; k < MAX_LEVELS; ++k) {
        free(r->out[k].scalar);
        free(r->out[k].codes);
        free(r->out[k].directions);
        free(r->out[k].magnitude);
    }
    iso_cascade_destroy(r->cascade);
}

/* Finds the scale as the build does: from the type's range if the type is narrow, otherwise from the values. Only the
 * exponent counts. */
static iso_status find_scale(const iso_level *l, double *scale, iso_error *err)
{
    const size_t bytes = iso_type_bytes(l->stored_type);
    const size_t count = iso_geometry_voxel_count(&l->geometry);
    float lo = INFINITY, hi = -INFINITY;
    for (size_t i = 0; bytes > 2 && i < count; ++i)
        if (!isfinite(l->scalar[i]))
            return iso_fail(err, ISO_E_RANGE, "level 0: voxel %zu is not finite", i);
    iso_row_range(l->scalar, bytes > 2 ? count : 0, &lo, &hi);
    *scale = iso_cascade_scale(&l->geometry, bytes == 1 ? 255 : bytes == 2 ? 65535 : (double)hi - (double)lo);
    return ISO_OK;
}

static iso_status begin_rebuild(rebuild *r, size_t slab, iso_error *err)
{
    const iso_pyramid_options *opt = &r->p->options;
    iso_geometry g = r->p->levels[0].geometry;
    for (size_t k = 0; k < r->level_count; ++k) {
        const size_t planes = iso_cascade_capacity(r->cascade, k, slab), count = planes * g.size[0] * g.size[1];
        iso_cascade_out *o = &r->out[k];
        o->scalar = k > 0 ? malloc(count * sizeof(float) + 1) : NULL; /* those of level 0 are the input */
        o->codes = malloc(3 * count + 1);
        o->directions = opt->keep_float ? malloc(3 * count * sizeof(float) + 1) : NULL;
        o->magnitude = opt->keep_magnitude ? malloc(count * sizeof(float) + 1) : NULL;
        if ((k > 0 && !o->scalar) || !o->codes || (opt->keep_float && !o->directions) ||
            (opt->keep_magnitude && !o->magnitude))
            return iso_fail(err, ISO_E_MEMORY, "no memory to make %zu planes of level %zu again", planes, k);
        g = iso_geometry_coarser(&g);
    }
    return ISO_OK;
}

/* Compares voxel `at` of the level, bit by bit, with voxel `made` of the slab. Returns the name of the first stored
 * quantity that differs, or NULL. */
static const char *difference(const iso_level *l, const iso_cascade_out *o, size_t at, size_t made)
{
    if (o->scalar && !l->made_for_scene && memcmp(l->scalar + at, o->scalar + made, sizeof(float)) != 0)
        return "values";
    if (l->is_optimized)
        return NULL; /* its checksums were compared when it was loaded */
    if (memcmp(l->codes + 3 * at, o->codes + 3 * made, 3) != 0)
        return "directions";
    if (o->directions && memcmp(l->directions + 3 * at, o->directions + 3 * made, 3 * sizeof(float)) != 0)
        return "directions in floats";
    if (o->magnitude && memcmp(l->magnitude + at, o->magnitude + made, sizeof(float)) != 0)
        return "magnitudes";
    return NULL;
}

/* Compares the complete planes of a level, up to `end`. */
static void compare_planes(rebuild *r, size_t k, size_t end)
{
    const iso_level *l = &r->p->levels[k];
    const size_t *n = l->geometry.size, plane = n[0] * n[1];
    iso_level_check *check = &r->checks[k];
    for (size_t i = r->out[k].first * plane; i < end * plane; ++i) {
        const char *what = difference(l, &r->out[k], i, i - r->out[k].first * plane);
        if (!what)
            continue;
        if (check->differing++ == 0) {
            check->what = what;
            check->first[0] = i % n[0], check->first[1] = i / n[0] % n[1], check->first[2] = i / plane;
        }
    }
}

static iso_planes planes_of(const iso_level *l)
{
    const size_t *n = l->geometry.size;
    return (iso_planes){l->scalar, ISO_F32, {n[0], n[1], n[2]}, 0, n[2], l->geometry.has_no_data};
}

static iso_status run(rebuild *r, size_t slab, const iso_progress *progress, iso_error *err)
{
    const iso_level *l = &r->p->levels[0];
    const size_t nz = l->geometry.size[2];
    const iso_planes planes = planes_of(l);
    for (size_t z = 0; z < nz; z += slab) {
        const size_t end = z + slab < nz ? z + slab : nz;
        iso_progress_report(progress, "levels", (double)z / (double)nz);
        for (size_t k = 0; k < r->level_count; ++k)
            r->out[k].first = iso_cascade_complete(r->cascade, k, z);
        NEED(iso_cascade_feed(r->cascade, &planes, z, end, r->out, err));
        for (size_t k = 0; k < r->p->level_count; ++k)
            compare_planes(r, k, iso_cascade_complete(r->cascade, k, end));
    }
    return ISO_OK;
}

static bool is_same_geometry(const iso_geometry *a, const iso_geometry *b)
{
    bool same = memcmp(a->size, b->size, sizeof a->size) == 0 &&
                memcmp(a->box_index, b->box_index, sizeof a->box_index) == 0 &&
                memcmp(&a->origin_mm, &b->origin_mm, sizeof a->origin_mm) == 0;
    return same && memcmp(&a->index_to_world, &b->index_to_world, sizeof a->index_to_world) == 0;
}

/* True if auto made the same choice from the same figures. */
static bool is_same_choice(const rebuild *r, size_t k)
{
    const iso_direction_choice *a = &r->p->options.choice, *b = &r->choice;
    return !b->is_made || (a->filter[k] == b->filter[k] && a->mean_agreement[k] == b->mean_agreement[k] &&
                           a->axis_agreement[k] == b->axis_agreement[k]);
}

/* Compares the properties of each level as a whole. */
static void compare_levels(rebuild *r)
{
    iso_geometry g = r->p->levels[0].geometry;
    for (size_t k = 0; k < r->p->level_count; ++k) {
        const iso_level *l = &r->p->levels[k];
        iso_level_check *check = &r->checks[k];
        double lo, hi;
        iso_cascade_range(r->cascade, k, &lo, &hi);
        const char *what = !is_same_geometry(&g, &l->geometry)                    ? "geometry"
                           : !l->made_for_scene && (lo != l->min || hi != l->max) ? "range"
                           : !is_same_choice(r, k)                                ? "direction filter"
                                                                                  : NULL;
        if (what && !check->what) {
            check->what = what;
            check->differing = check->voxels;
        }
        g = iso_geometry_coarser(&g);
    }
}

iso_status iso_pyramid_verify(const iso_pyramid *p, int threads, iso_level_check *checks, const iso_progress *progress,
                              iso_error *err)
{
    rebuild r = {.p = p, .checks = checks};
    iso_pyramid_options opt = p->options;
    double scale = 1;
    opt.threads = threads;
    opt.level_count = p->level_count;
    for (size_t k = 0; k < p->level_count; ++k)
        checks[k] = (iso_level_check){.voxels = iso_geometry_voxel_count(&p->levels[k].geometry),
                                      .is_not_remade = p->levels[k].is_optimized};
    r.level_count = iso_cascade_level_count(&p->levels[0].geometry, &opt);
    if (r.level_count != p->level_count)
        return iso_fail(err, ISO_E_FORMAT, "the pyramid has %zu levels, a volume of its size at most %zu",
                        p->level_count, r.level_count);
    iso_status status = find_scale(&p->levels[0], &scale, err);
    const iso_planes planes = planes_of(&p->levels[0]);
    TRY(status, iso_agreement_choose_for(&planes, &p->levels[0].geometry, scale, &opt, progress, err));
    r.choice = opt.direction_filter == ISO_DIRECTION_AUTO ? opt.choice : (iso_direction_choice){0};
    TRY(status, iso_cascade_create(&p->levels[0].geometry, &opt, scale, &r.cascade, err));
    const size_t slab = status == ISO_OK ? iso_cascade_step(r.cascade) * 4 : 1;
    TRY(status, begin_rebuild(&r, slab, err));
    TRY(status, run(&r, slab, progress, err));
    if (status == ISO_OK)
        compare_levels(&r);
    end_rebuild(&r);
    return status;
}

const char *iso_level_check_text(const iso_level_check *check, size_t level, char *text, size_t size)
{
    if (!check->what && check->is_not_remade)
        snprintf(text, size, "level %zu: all %zu voxels have the checksum of the optimized level; it is not remade",
                 level, check->voxels);
    else if (!check->what)
        snprintf(text, size, "level %zu: all %zu voxels are made from level 0", level, check->voxels);
    else if (strcmp(check->what, "geometry") == 0 || strcmp(check->what, "range") == 0 ||
             strcmp(check->what, "direction filter") == 0)
        snprintf(text, size, "level %zu: its %s is not that of the level made from level 0", level, check->what);
    else
        snprintf(text, size,
                 "level %zu: %zu of %zu voxels are not made from level 0, the first is (%zu, %zu, %zu), by its %s",
                 level, check->differing, check->voxels, check->first[0], check->first[1], check->first[2],
                 check->what);
    return text;
}
