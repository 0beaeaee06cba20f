/* SPDX-License-Identifier: MIT */
/* gradient.c - estimators on fields with known gradients. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "base/random.h"
#include "lab/lab.h"
#include "gradient/gradient.h"
#include "volume/synthetic.h"

enum { MARGIN = 6 };

typedef struct gradient_result {
    double order;                       /* of the mean error on smooth noise, from the grid to one twice as fine */
    double lobb_mean_deg, lobb_max_deg; /* Marschner-Lobb */
    double sphere_mean_deg, sphere_max_deg;
    double noisy_mean_deg; /* the sphere with noise */
    double ns_per_voxel;
} gradient_result;

typedef struct field_errors {
    double mean_deg, max_deg, rms; /* rms: of the vector difference, relative to the rms gradient */
} field_errors;

static double normal_deviate(uint64_t *state) /* the sum of 12 uniforms */
{
    double sum = -6;
    for (int i = 0; i < 12; ++i)
        sum += iso_xorshift_unit(state);
    return sum;
}

static iso_status sample(iso_field_kind kind, size_t n, double noise, iso_field *field, iso_volume *v, iso_error *err)
{
    const size_t size[3] = {n, n, n};
    const double spacing[3] = {1.0 / (double)n, 1.0 / (double)n, 1.0 / (double)n};
    *field = (iso_field){.kind = kind, .geometry = iso_geometry_axis_aligned(size, spacing), .seed = 7};
    iso_status status = iso_field_sample(field, ISO_F64, v, err);
    uint64_t state = 20050101;
    for (size_t i = 0; status == ISO_OK && noise > 0 && i < n * n * n; ++i)
        ((double *)v->data)[i] += noise * normal_deviate(&state);
    return status;
}

/* Averages over voxels at least MARGIN off the border. For the sphere, also that far off its kinks (the center, and the
 * distance of the faces), so that estimators with a longer reach see only smooth parts. */
static field_errors measure(const iso_field *field, const float *g, size_t n)
{
    field_errors e = {0, 0, 0};
    double squares = 0, truth = 0;
    size_t count = 0;
    for (size_t i = 0; i < n * n * n; ++i) {
        const size_t x = i % n, y = i / n % n, z = i / n / n;
        if (x < MARGIN || y < MARGIN || z < MARGIN || x + MARGIN >= n || y + MARGIN >= n || z + MARGIN >= n)
            continue;
        iso_vec3 exact, found = iso_v3(g[3 * i], g[3 * i + 1], g[3 * i + 2]);
        iso_vec3 p = iso_geometry_to_world(&field->geometry, iso_v3((double)x + 0.5, (double)y + 0.5, (double)z + 0.5));
        const double r = iso_norm(p), apart = MARGIN / (double)n;
        if (field->kind == ISO_FIELD_SPHERE && (r < 0.1 + apart || r > 0.5 - apart))
            continue;
        iso_field_value(field, p, &exact);
        iso_vec3 error = iso_sub(found, exact);
        const double angle = 57.29577951308232 * atan2(iso_norm(iso_cross(found, exact)), iso_dot(found, exact));
        squares += iso_dot(error, error);
        truth += iso_dot(exact, exact);
        e.mean_deg += angle;
        e.max_deg = fmax(e.max_deg, angle);
        ++count;
    }
    e.mean_deg /= (double)count;
    e.rms = sqrt(squares / truth);
    return e;
}

typedef struct field_case {
    iso_field_kind kind;
    size_t n;
    double noise;
} field_case;

static iso_status test_field(field_case f, iso_gradient_method method, int threads, field_errors *e, double *seconds,
                             iso_error *err)
{
    const size_t n = f.n;
    iso_field field;
    OWNED(iso_volume) v = {0};
    iso_status status = sample(f.kind, n, f.noise, &field, &v, err);
    if (status != ISO_OK)
        return status;
    FREED float *g = malloc(3 * n * n * n * sizeof *g);
    const iso_gradient_options opt = {.method = method, .threads = threads};
    *seconds = INFINITY;
    if (!g)
        status = iso_fail(err, ISO_E_MEMORY, "no memory for %zu gradients", n * n * n);
    for (int run = 0; run < 5 && status == ISO_OK; ++run) {
        const double start = iso_clock_seconds();
        status = iso_gradient_compute(&v, &opt, g, err);
        *seconds = fmin(*seconds, iso_clock_seconds() - start);
    }
    if (status == ISO_OK)
        *e = measure(&field, g, n);
    return status;
}

static iso_status measure_method(iso_gradient_method method, size_t n, double noise, int threads, gradient_result *r,
                                 iso_error *err)
{
    field_errors coarse, fine, lobb, sphere, noisy;
    double seconds;
    NEED(test_field((field_case){ISO_FIELD_NOISE, n, 0}, method, threads, &coarse, &seconds, err));
    NEED(test_field((field_case){ISO_FIELD_MARSCHNER_LOBB, n, 0}, method, threads, &lobb, &seconds, err));
    NEED(test_field((field_case){ISO_FIELD_SPHERE, n, 0}, method, threads, &sphere, &seconds, err));
    NEED(test_field((field_case){ISO_FIELD_SPHERE, n, noise}, method, threads, &noisy, &seconds, err));
    NEED(test_field((field_case){ISO_FIELD_NOISE, 2 * n, 0}, method, threads, &fine, &seconds, err));
    *r = (gradient_result){log2(coarse.rms / fine.rms),
                           lobb.mean_deg,
                           lobb.max_deg,
                           sphere.mean_deg,
                           sphere.max_deg,
                           noisy.mean_deg,
                           1e9 * seconds / (8 * (double)(n * n * n))};
    return ISO_OK;
}

static void report(const iso_cli *cli, size_t n, double noise, const gradient_result results[ISO_GRADIENT_COUNT])
{
    json_t *root = iso_cli_json(cli), *list = json_array(), *options = json_object_get(root, "options");
    json_object_set_new(options, "size", json_integer((json_int_t)n));
    json_object_set_new(options, "noise", json_real(noise));
    if (!cli->json)
        printf("%-13s %6s %21s %19s %11s %9s\n%-13s %6s %10s %10s %10s %8s %11s %9s\n", "", "", "Marschner-Lobb",
               "sphere", "and noise", "ns", "estimator", "order", "mean deg", "max deg", "mean deg", "max deg",
               "mean deg", "per voxel");
    for (int i = 0; i < ISO_GRADIENT_COUNT; ++i) {
        const gradient_result *r = &results[i];
        const char *name = iso_gradient_name((iso_gradient_method)i);
        if (!cli->json)
            printf("%-13s %6.2f %10.3f %10.2f %10.4f %8.3f %11.3f %9.2f\n", name, r->order, r->lobb_mean_deg,
                   r->lobb_max_deg, r->sphere_mean_deg, r->sphere_max_deg, r->noisy_mean_deg, r->ns_per_voxel);
        json_array_append_new(list, json_pack("{s:s, s:f, s:f, s:f, s:f, s:f, s:f, s:f}", "name", name, "order",
                                              r->order, "marschner_lobb_mean_error_deg", r->lobb_mean_deg,
                                              "marschner_lobb_max_error_deg", r->lobb_max_deg, "sphere_mean_error_deg",
                                              r->sphere_mean_deg, "sphere_max_error_deg", r->sphere_max_deg,
                                              "noisy_sphere_mean_error_deg", r->noisy_mean_deg, "ns_per_voxel",
                                              r->ns_per_voxel));
    }
    json_object_set_new(root, "estimators", list);
    if (cli->json)
        iso_cli_print_json(root);
    else
        json_decref(root);
}

typedef struct gradient_options {
    int size;
    double noise;
} gradient_options;

static const iso_option options[] = {
    {"size", 0, "use N voxels along each axis", "N", ISO_IN(gradient_options, size), .flags = ISO_SHOWN, .least = 32,
     .most = 512},
    {"noise", 0, "set the noise's standard deviation (range 1 from center to face)", "S",
     ISO_IN(gradient_options, noise), .flags = ISO_SHOWN, .most = 1},
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    const gradient_options *o = values;
    gradient_result results[ISO_GRADIENT_COUNT];
    for (int i = 0; i < ISO_GRADIENT_COUNT; ++i)
        NEED(measure_method((iso_gradient_method)i, (size_t)o->size, o->noise, cli->threads, &results[i], err));
    report(cli, (size_t)o->size, o->noise, results);
    return ISO_OK;
}

const iso_command iso_lab_gradient = {
    .name = "gradient",
    .summary = "gradient estimators: order of convergence, angles on known fields, speed",
    .usage = "[options]",
    .details = "The order is that of the error on smooth noise, from a grid of --size to one twice as fine.",
    .examples = "  isoshade-lab gradient --size 32\n",
    ISO_COMMAND_OPTIONS(gradient_options, options, .size = 40, .noise = 0.01),
    .run = run,
};
