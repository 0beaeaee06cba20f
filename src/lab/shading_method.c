/* SPDX-License-Identifier: MIT */
#include "lab/shading_method.h"

#include <math.h>

#include "base/random.h"

/* Normalizes directions; zero stays zero. */
static void drop_lengths(iso_pyramid *p)
{
    for (size_t k = 1; k < p->level_count; ++k) {
        iso_level *l = &p->levels[k];
        const size_t count = iso_geometry_voxel_count(&l->geometry);
        for (size_t i = 0; i < count; ++i) {
            float *d = l->directions + 3 * i;
            const float length = sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            for (int c = 0; c < 3; ++c)
                d[c] = length > 0 ? d[c] / length : 0;
        }
        iso_code_encode(p->options.code, l->directions, l->codes, count);
    }
}

iso_status iso_shading_build(const iso_shading_method *m, const iso_volume *v, const char *name, size_t level_count,
                             int threads, iso_pyramid *p, iso_error *err)
{
    iso_pyramid_options build = iso_pyramid_defaults();
    build.level_count = level_count;
    build.direction_filter = m->filter;
    build.gauss_radius = m->radius ? m->radius : build.gauss_radius;
    build.gauss_sigma_voxels = m->sigma > 0 ? m->sigma : build.gauss_sigma_voxels;
    build.eq1_exponent = m->plain ? 0 : m->exponent ? m->exponent : build.eq1_exponent;
    build.keep_float = m->unit;
    build.threads = threads;
    iso_status status = iso_pyramid_build(v, name, &build, p, NULL, err);
    if (status == ISO_OK && m->unit)
        drop_lengths(p);
    return status;
}

/* Adds normal noise [box-1958]. */
static void add_noise(iso_volume *v, double deviation)
{
    iso_random random = {1};
    float *values = v->data;
    for (size_t i = 0; i < iso_geometry_voxel_count(&v->geometry); ++i) {
        const double radius = sqrt(-2 * log(1 - iso_random_unit(&random)));
        values[i] += (float)(deviation * radius * cos(6.283185307179586 * iso_random_unit(&random)));
    }
}

iso_status iso_shading_sample(iso_field_kind kind, size_t n, double noise, iso_field *field, iso_volume *v,
                              iso_error *err)
{
    *field = (iso_field){.kind = kind,
                         .seed = 1,
                         .geometry = iso_geometry_axis_aligned((size_t[]){n, n, n}, (double[]){1, 1, 1})};
    iso_status status = iso_field_sample(field, ISO_F32, v, err);
    if (status == ISO_OK && noise > 0)
        add_noise(v, noise);
    return status;
}
