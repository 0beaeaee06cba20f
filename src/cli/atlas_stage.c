/* atlas_stage.c - small volumes of closed-form fields, seen by the CPU reference. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/random.h"
#include "cli/atlas.h"
#include "compare/metrics.h"
#include "render/reference.h"
#include "render/sampler.h"

enum { tf_entries = 512 };

iso_atlas_options iso_atlas_defaults(void)
{
    iso_atlas_options o = {.size = 48, .type = ISO_F32, .steps = 256, .build = iso_pyramid_defaults()};
    o.build.level_count = 3;
    o.build.keep_float = true;
    return o;
}

static iso_status sample(iso_volume *v, const iso_geometry *g, iso_atlas_field field, const iso_atlas_options *opt, iso_error *err)
{
    iso_random random = {.state = 1};
    iso_status status = iso_volume_create(v, g, ISO_F32, "atlas", err);
    if (status != ISO_OK)
        return status;
    float *out = v->data;
    for (size_t z = 0; z < g->size[2]; ++z)
        for (size_t y = 0; y < g->size[1]; ++y)
            for (size_t x = 0; x < g->size[0]; ++x) {
                iso_vec3 normal, index = {(double)x + 0.5, (double)y + 0.5, (double)z + 0.5};
                double value = field(iso_geometry_to_world(g, index), &normal) + opt->noise * (2 * iso_random_unit(&random) - 1);
                if (opt->type == ISO_U8)
                    value = round(value * (double)(opt->steps - 1)) / (double)(opt->steps - 1);
                *out++ = (float)value;
            }
    return ISO_OK;
}

static iso_camera oblique_camera(double half_height)
{
    iso_camera c = {.orthographic = true, .forward = iso_normalize(iso_v3(1, 2, -1.2)), .half_height = half_height};
    c.right = iso_normalize(iso_cross(c.forward, iso_v3(0, 0, 1)));
    c.up = iso_cross(c.right, c.forward);
    c.position = iso_scale(c.forward, -10);
    return c;
}

/* The box is 2 mm along its shortest edge and centred at the origin, so that fields need no scale. */
iso_status iso_atlas_stage_create(iso_atlas_stage *s, iso_atlas_field field, const iso_atlas_options *opt, iso_error *err)
{
    const size_t size[3] = {opt->size, opt->size, opt->size};
    const double spacing[3] = {2.0 / (double)opt->size, 2.0 / (double)opt->size, 2.0 / (double)opt->size};
    iso_geometry g = opt->geometry ? *opt->geometry : iso_geometry_axis_aligned(size, spacing);
    iso_volume v = {0};
    *s = (iso_atlas_stage){.field = field, .view = {.width = ISO_ATLAS_PIXELS, .height = ISO_ATLAS_PIXELS, .light_count = 1,
                                                    .step_voxels = 0.25, .shading = {0.2, 0.8, 0, 1}}};
    s->view.camera = oblique_camera(1.15);
    s->view.lights[0] = (iso_light){.direction = iso_normalize(iso_v3(-0.2, -1, 0.9)), .intensity = 1};
    iso_status status = sample(&v, &g, field, opt, err);
    if (status == ISO_OK)
        status = iso_pyramid_build(&v, "atlas", &opt->build, &s->pyramid, NULL, err);
    iso_volume_destroy(&v);
    if (status != ISO_OK)
        iso_atlas_stage_destroy(s);
    return status;
}

void iso_atlas_stage_destroy(iso_atlas_stage *s)
{
    iso_view_destroy(&s->view);
    iso_pyramid_destroy(&s->pyramid);
    *s = (iso_atlas_stage){0};
}

static iso_status set_tf(iso_atlas_stage *s, double (*extinction)(double value, const double p[3]), const double p[3], iso_error *err)
{
    iso_tf_table *t = &s->view.tf;
    free(t->entries);
    *t = (iso_tf_table){.count = tf_entries, .lo = 0, .hi = 1, .entries = malloc(tf_entries * 4 * sizeof(float))};
    if (!t->entries)
        return iso_fail(err, ISO_E_MEMORY, "atlas: no memory for a transfer function");
    for (size_t i = 0; i < tf_entries; ++i) {
        float *e = t->entries + 4 * i;
        e[0] = 0.95f, e[1] = 0.72f, e[2] = 0.5f;
        e[3] = (float)extinction((double)i / (tf_entries - 1), p);
    }
    return ISO_OK;
}

static double above(double value, const double p[3]) { return p[2] * fmin(fmax((value - p[0]) / (p[1] - p[0]), 0), 1); }
static double band(double value, const double p[3]) { return p[2] * fmax(1 - fabs(value - p[0]) / p[1], 0); }

iso_status iso_atlas_show_above(iso_atlas_stage *s, double lo, double hi, double extinction, iso_error *err)
{
    return set_tf(s, above, (const double[3]){lo, hi, extinction}, err);
}

iso_status iso_atlas_show_band(iso_atlas_stage *s, double middle, double half_width, double extinction, iso_error *err)
{
    return set_tf(s, band, (const double[3]){middle, half_width, extinction}, err);
}

iso_status iso_atlas_render(const iso_atlas_stage *s, size_t level, iso_direction_source source, double step_voxels,
                            iso_image *image, iso_error *err)
{
    iso_reference_options opt = iso_reference_defaults();
    opt.source = source;
    opt.tolerance = 1e-5; /* pictures of 8 bits */
    opt.quadrature = step_voxels > 0 ? ISO_QUADRATURE_MIDPOINT : ISO_QUADRATURE_CONVERGED;
    opt.step_voxels = step_voxels;
    return iso_reference_render(&s->pyramid.levels[level], s->pyramid.options.code, &s->view, &opt, image, NULL, err);
}

static iso_vec3 center_of(const iso_geometry *g, size_t i)
{
    return iso_v3((double)(i % g->size[0]) + 0.5, (double)(i / g->size[0] % g->size[1]) + 0.5,
                  (double)(i / (g->size[0] * g->size[1])) + 0.5);
}

iso_status iso_atlas_render_truth(iso_atlas_stage *s, size_t level, iso_image *image, iso_error *err)
{
    iso_level *l = &s->pyramid.levels[level];
    size_t count = iso_geometry_voxel_count(&l->geometry);
    float *kept = l->directions, *closed = malloc(count * 3 * sizeof *closed);
    if (!closed)
        return iso_fail(err, ISO_E_MEMORY, "atlas: no memory for %zu directions", count);
    for (size_t i = 0; i < count; ++i) {
        iso_vec3 n;
        s->field(iso_geometry_to_world(&l->geometry, center_of(&l->geometry, i)), &n);
        closed[3 * i] = (float)n.x, closed[3 * i + 1] = (float)n.y, closed[3 * i + 2] = (float)n.z;
    }
    l->directions = closed;
    iso_status status = iso_atlas_render(s, level, ISO_FROM_FLOAT, 0.25, image, err);
    l->directions = kept;
    free(closed);
    return status;
}

iso_status iso_atlas_angle(const iso_atlas_stage *s, size_t level, iso_direction_source source, double *degrees, iso_error *err)
{
    const iso_level *l = &s->pyramid.levels[level];
    iso_sampler sampler;
    double sum = 0;
    size_t count = 0;
    *degrees = NAN;
    iso_status status = iso_sampler_create(&sampler, l, s->pyramid.options.code, source, err);
    for (size_t i = 0; status == ISO_OK && i < iso_geometry_voxel_count(&l->geometry); ++i) {
        iso_vec3 normal, at = center_of(&l->geometry, i);
        double rgbs[4];
        iso_tf_lookup(&s->view.tf, (double)l->scalar[i], rgbs);
        s->field(iso_geometry_to_world(&l->geometry, at), &normal);
        if (rgbs[3] <= 0 || iso_norm(normal) == 0)
            continue;
        double c = fabs(iso_dot(iso_normalize(normal), iso_normalize(iso_sample_normal(&sampler, at))));
        sum += acos(fmin(c, 1)) * (180 / 3.14159265358979323846);
        ++count;
    }
    if (count > 0)
        *degrees = sum / (double)count;
    iso_sampler_destroy(&sampler);
    return status;
}

iso_status iso_atlas_rmse(const iso_image *a, const iso_image *b, double *rmse, iso_error *err)
{
    iso_metrics m;
    iso_status status = iso_metrics_measure(a, b, &m, err);
    *rmse = status == ISO_OK ? m.rmse : NAN;
    return status;
}
