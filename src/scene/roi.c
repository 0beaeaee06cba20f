/* SPDX-License-Identifier: MIT */
#include "scene/roi.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

iso_roi_options iso_roi_defaults(void)
{
    return (iso_roi_options){.band = ISO_ROI_BAND};
}

void iso_roi_destroy(iso_roi *f)
{
    if (!f)
        return;
    free(f->level.scalar);
    free(f->level.codes);
    free(f->level.directions);
    iso_tf_table_destroy(&f->tf);
    *f = (iso_roi){0};
}

static iso_status check(const iso_pyramid *p, size_t around, const iso_roi_options *opt, iso_error *err)
{
    if (around >= p->level_count || opt->level >= around)
        return iso_fail(err, ISO_E_RANGE, "region of interest: level %zu inside level %zu, must be finer", opt->level,
                        around);
    if (!(opt->band >= 0 && opt->band <= 64))
        return iso_fail(err, ISO_E_RANGE, "region of interest: band of %g voxels, must be 0 to 64", opt->band);
    for (int a = 0; a < 3; ++a)
        if (!(opt->lo[a] >= 0 && opt->lo[a] < opt->hi[a] && opt->hi[a] <= (double)p->levels[0].geometry.size[a]))
            return iso_fail(err, ISO_E_RANGE, "region of interest: %g to %g along axis %d, must ascend within 0 to %zu",
                            opt->lo[a], opt->hi[a], a, p->levels[0].geometry.size[a]);
    return ISO_OK;
}

/* Copies the box at `first`, `bytes` per voxel, from a level of `size`. NULL: no memory. */
static void *crop(const void *from, size_t bytes, const size_t size[3], const size_t first[3], const size_t count[3])
{
    char *out = malloc(count[0] * count[1] * count[2] * bytes);
    for (size_t z = 0; out && z < count[2]; ++z)
        for (size_t y = 0; y < count[1]; ++y)
            memcpy(out + (z * count[1] + y) * count[0] * bytes,
                   (const char *)from + (((first[2] + z) * size[1] + first[1] + y) * size[0] + first[0]) * bytes,
                   count[0] * bytes);
    return out;
}

static iso_status crop_level(const iso_level *from, const size_t first[3], const size_t count[3], iso_level *to,
                             iso_error *err)
{
    const size_t *size = from->geometry.size;
    *to = (iso_level){.geometry = from->geometry, .stored_type = from->stored_type, .min = from->min, .max = from->max};
    to->geometry.origin_mm = iso_geometry_to_world(&from->geometry,
                                                   iso_v3((double)first[0], (double)first[1], (double)first[2]));
    for (int a = 0; a < 3; ++a) {
        to->geometry.size[a] = count[a];
        to->geometry.box_index[a] = (double)count[a];
    }
    to->scalar = crop(from->scalar, sizeof *from->scalar, size, first, count);
    to->codes = crop(from->codes, 3, size, first, count);
    to->directions = from->directions ? crop(from->directions, 3 * sizeof *from->directions, size, first, count) : NULL;
    if (!to->scalar || !to->codes || (from->directions && !to->directions))
        return iso_fail(err, ISO_E_MEMORY, "region of interest: no memory for %zu x %zu x %zu voxels", count[0],
                        count[1], count[2]);
    return ISO_OK;
}

iso_status iso_roi_create(const iso_pyramid *p, size_t around, const iso_tf_table *tf, const iso_roi_options *opt,
                          iso_roi *f, iso_error *err)
{
    *f = (iso_roi){.number = opt->level, .band = opt->band};
    iso_status status = check(p, around, opt, err);
    if (status != ISO_OK)
        return status;
    const iso_level *finer = &p->levels[opt->level];
    size_t first[3], count[3];
    f->scale = ldexp(1, (int)(around - opt->level));
    for (int a = 0; a < 3; ++a) {
        const double margin = 2, size = (double)finer->geometry.size[a];
        f->lo[a] = ldexp(opt->lo[a], -(int)around);
        f->hi[a] = ldexp(opt->hi[a], -(int)around);
        double begin = fmax(floor((f->lo[a] - f->band) * f->scale) - margin, 0);
        double end = fmin(ceil((f->hi[a] + f->band) * f->scale) + margin, size);
        first[a] = (size_t)begin;
        count[a] = (size_t)(end - begin);
        f->offset[a] = begin;
    }
    f->tf = *tf;
    f->tf.entries = malloc(4 * tf->count * sizeof *tf->entries);
    if (!f->tf.entries)
        status = iso_fail(err, ISO_E_MEMORY, "region of interest: no memory for %zu entries", tf->count);
    else
        memcpy(f->tf.entries, tf->entries, 4 * tf->count * sizeof *tf->entries);
    TRY(status, crop_level(finer, first, count, &f->level, err));
    if (status != ISO_OK)
        iso_roi_destroy(f);
    return status;
}

double iso_roi_weight(const iso_roi *f, iso_vec3 index)
{
    const double p[3] = {index.x, index.y, index.z};
    double outside = 0;
    for (int a = 0; a < 3; ++a)
        outside = fmax(outside, fmax(f->lo[a] - p[a], p[a] - f->hi[a]));
    if (!(outside > 0))
        return 1;
    if (outside >= f->band)
        return 0;
    double u = 1 - outside / f->band;
    return u * u * (3 - 2 * u);
}
