/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

#include "render/sampler.h"
#include "validate/measured.h"

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

iso_status iso_validate_angles(const iso_validation *v, const iso_pyramid *p, size_t level, iso_direction_source source,
                               iso_level_angles *out, iso_error *err)
{
    enum { wanted = 100000 };
    iso_sampler fine, coarse = {0};
    const iso_geometry *g = &v->pyramid->levels[0].geometry;
    size_t count = 0, total = iso_geometry_voxel_count(g), stride = total / wanted | 1;
    double *angles = malloc((total / stride + 1) * sizeof *angles), sum = 0;
    *out = (iso_level_angles){NAN, NAN};
    iso_status status = iso_sampler_create(&fine, &v->pyramid->levels[0], v->pyramid->options.code, ISO_FROM_CODES,
                                           err);
    if (status == ISO_OK)
        status = iso_sampler_create(&coarse, &p->levels[level], p->options.code, source, err);
    if (status == ISO_OK && !angles)
        status = iso_fail(err, ISO_E_MEMORY, "no memory for the angles of %zu voxels", total / stride);
    for (size_t i = 0; i < total && status == ISO_OK; i += stride) {
        iso_vec3 at = {(double)(i % g->size[0]) + 0.5, (double)(i / g->size[0] % g->size[1]) + 0.5,
                       (double)(i / (g->size[0] * g->size[1])) + 0.5};
        double rgbs[4];
        iso_tf_lookup(&v->view->tf, (double)v->pyramid->levels[0].scalar[i], rgbs);
        iso_vec3 a = iso_sample_normal(&fine, at);
        if (rgbs[3] <= 0 || iso_norm(a) < 0.5)
            continue;
        iso_vec3 b = iso_normalize(iso_sample_normal(&coarse, iso_scale(at, 1 / (double)((size_t)1 << level))));
        /* No direction at all counts as a right angle. */
        double angle = acos(fmin(fmax(iso_dot(iso_normalize(a), b), -1), 1)) * (180 / 3.14159265358979323846);
        angles[count++] = angle;
        sum += angle;
    }
    if (count > 0) {
        qsort(angles, count, sizeof *angles, compare_doubles);
        out->mean = sum / (double)count;
        out->p95 = angles[(size_t)(0.95 * (double)(count - 1))];
    }
    free(angles);
    iso_sampler_destroy(&fine);
    iso_sampler_destroy(&coarse);
    return status;
}
