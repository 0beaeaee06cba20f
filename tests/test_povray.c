/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
/* POV-Ray against the reference. These tests fail, not skip, without POV-Ray. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/process.h"
#include "compare/extrapolation.h"
#include "povray/df3.h"
#include "povray/povray.h"
#include "render/reference.h"
#include "test.h"

enum { pixels = 40 };

/* A smooth field in world coordinates, in [0, 1], and its gradient: waves that differ along the axes. */
static double field(iso_vec3 w, iso_vec3 *gradient)
{
    const double x = 0.11 * w.x + 0.3, y = 0.08 * w.y - 0.4, z = 0.05 * w.z + 0.9;
    *gradient = iso_v3(0.4 * 0.11 * cos(x) * cos(y) - 0.1 * 0.11 * sin(2 * x), -0.4 * 0.08 * sin(x) * sin(y),
                       -0.05 * 0.05 * sin(z));
    return 0.5 + 0.4 * sin(x) * cos(y) + 0.05 * cos(2 * x) + 0.05 * cos(z);
}

/* Samples at the voxel centres of a level, directions encoded as bytes. */
static void fill_level(iso_level *level, const iso_geometry *g, iso_type type)
{
    const size_t count = iso_geometry_voxel_count(g);
    *level = (iso_level){.geometry = *g, .stored_type = type, .min = INFINITY, .max = -INFINITY};
    level->scalar = malloc(count * sizeof(float));
    level->codes = malloc(3 * count);
    level->directions = malloc(3 * count * sizeof(float));
    for (size_t i = 0; i < count; ++i) {
        const size_t x = i % g->size[0], y = i / g->size[0] % g->size[1], z = i / g->size[0] / g->size[1];
        iso_vec3 gradient;
        double value = field(iso_geometry_to_world(g, iso_v3((double)x + 0.5, (double)y + 0.5, (double)z + 0.5)),
                             &gradient);
        const iso_vec3 d = iso_normalize(gradient);
        value = type == ISO_U16 ? round(65535 * value) : value;
        level->scalar[i] = (float)value;
        level->min = fmin(level->min, value);
        level->max = fmax(level->max, value);
        level->directions[3 * i] = (float)d.x;
        level->directions[3 * i + 1] = (float)d.y;
        level->directions[3 * i + 2] = (float)d.z;
    }
    iso_code_encode(ISO_CODE_SNORM, level->directions, level->codes, count);
}

/* Unequal sizes, and an index-to-world matrix that rotates, stretches and is unequal along every axis. */
static iso_geometry tilted(size_t nx, size_t ny, size_t nz)
{
    iso_geometry g = iso_geometry_axis_aligned((size_t[]){nx, ny, nz}, (double[]){1, 1.2, 2.5});
    const double c = cos(0.5), s = sin(0.5), c2 = cos(-0.3), s2 = sin(-0.3);
    const iso_mat3 turn = {{{c, -s * c2, s * s2}, {s, c * c2, -c * s2}, {0, s2, c2}}};
    for (int a = 0; a < 3; ++a) {
        const iso_vec3 column = iso_mul(turn, iso_column(g.index_to_world, a));
        g.index_to_world.m[0][a] = column.x;
        g.index_to_world.m[1][a] = column.y;
        g.index_to_world.m[2][a] = column.z;
    }
    g.origin_mm = iso_add(g.origin_mm, iso_v3(30, -20, 10));
    return g;
}

/* Two levels: level 0 of 16 bits, level 1 float; odd sizes, so that level 1 overhangs. */
static iso_pyramid two_levels(void)
{
    iso_pyramid p = {.options = {.code = ISO_CODE_SNORM}, .level_count = 2, .levels = calloc(2, sizeof(iso_level))};
    const iso_geometry g0 = tilted(41, 56, 33), g1 = iso_geometry_coarser(&g0);
    fill_level(&p.levels[0], &g0, ISO_U16);
    fill_level(&p.levels[1], &g1, ISO_F32);
    for (size_t i = 0; i < iso_geometry_voxel_count(&g1); ++i)
        p.levels[1].scalar[i] *= 65535;
    p.levels[1].min *= 65535;
    p.levels[1].max *= 65535;
    return p;
}

static void release(iso_pyramid *p)
{
    for (size_t k = 0; k < p->level_count; ++k) {
        free(p->levels[k].scalar);
        free(p->levels[k].codes);
        free(p->levels[k].directions);
    }
    free(p->levels);
}

static float *smooth_table(size_t count, double opaque)
{
    float *entries = malloc(4 * count * sizeof *entries);
    for (size_t i = 0; i < count; ++i) {
        const double u = (double)i / (double)(count - 1);
        entries[4 * i] = (float)(0.5 + 0.5 * sin(3 * u));
        entries[4 * i + 1] = (float)(u * u);
        entries[4 * i + 2] = (float)(1 - u);
        entries[4 * i + 3] = (float)(opaque * u * u * (3 - 2 * u));
    }
    return entries;
}

/* A camera that sees the whole box at an angle; two lights, highlights, a background. */
static iso_view oblique_view(const iso_geometry *g, bool orthographic, size_t table)
{
    iso_view v = {.width = pixels, .height = pixels * 3 / 4, .light_count = 2, .background = {0.1, 0.2, 0.4}};
    const double radius = iso_geometry_box_radius_mm(g);
    v.camera.orthographic = orthographic;
    v.camera.forward = iso_normalize(iso_v3(1, 2, -0.7));
    v.camera.right = iso_normalize(iso_cross(v.camera.forward, iso_v3(0, 0, 1)));
    v.camera.up = iso_cross(v.camera.right, v.camera.forward);
    v.camera.position = iso_madd(iso_geometry_box_center_mm(g), v.camera.forward, -4 * radius);
    v.camera.half_height = orthographic ? 0.8 * radius : 0.22;
    v.lights[0] = (iso_light){.direction = iso_normalize(iso_v3(0.2, -1, 0.6)), .intensity = 0.7};
    v.lights[1] = (iso_light){.direction = iso_normalize(iso_v3(-1, -0.3, 0.4)), .intensity = 0.3};
    v.shading = (iso_shading){.ambient = 0.3, .diffuse = 0.7, .specular = 0.2, .power = 20};
    v.tf = (iso_tf_table){.count = table, .lo = 6000, .hi = 60000, .entries = smooth_table(table, 0.05)};
    return v;
}

static double largest_difference(const iso_image *a, const iso_image *b, double *rmse)
{
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    double most = 0, sum = 0;
    const size_t count = 4 * a->width * a->height;
    for (size_t i = 0; i < count; ++i) {
        const double d = fabs((double)a->rgba[i] - (double)b->rgba[i]);
        most = d <= most ? most : d; /* NaN stays */
        sum += d * d;
    }
    *rmse = sqrt(sum / (double)count);
    return most;
}

static void progress_rises_to_one(void *user, const char *stage, double fraction)
{
    double *last = user;
    if (strstr(stage, "rendering")) {
        assert_true(fraction >= *last && fraction <= 1);
        *last = fraction;
    }
}

static void render_povray(const iso_pyramid *p, size_t level, const iso_view *view, const iso_povray_options *opt,
                          iso_image *image)
{
    double last = 0;
    const iso_progress progress = {progress_rises_to_one, &last};
    assert_ok(iso_povray_render(p, level, view, opt, image, &progress, &err));
    assert_within(last, 1, 0);
}

static void render_reference(const iso_pyramid *p, size_t level, const iso_view *view, iso_quadrature quadrature,
                             size_t intervals, double iso, iso_image *image)
{
    iso_reference_options opt = iso_reference_defaults();
    opt.quadrature = quadrature;
    opt.intervals = intervals;
    opt.iso = iso;
    assert_ok(iso_reference_render(&p->levels[level], p->options.code, view, &opt, image, NULL, &err));
}

/* One comparison: what POV-Ray and the reference make of the same level and view. */
typedef struct comparison {
    iso_pyramid pyramid;
    iso_view view;
    size_t level;
    iso_povray_options options;
    iso_quadrature quadrature;
    iso_image image; /* POV-Ray's */
} comparison;

static comparison lock_step(size_t level, bool orthographic, size_t table)
{
    comparison c = {.pyramid = two_levels(),
                    .level = level,
                    .options = iso_povray_defaults(),
                    .quadrature = ISO_QUADRATURE_POVRAY};
    c.view = oblique_view(&c.pyramid.levels[0].geometry, orthographic, table);
    c.options.planes = 0;
    c.options.extrapolate = false;
    c.options.intervals = 60;
    return c;
}

static comparison converged(size_t level)
{
    comparison c = lock_step(level, false, 256);
    c.quadrature = ISO_QUADRATURE_CONVERGED;
    c.view.width = 24; /* the converged reference is the slow side */
    c.view.height = 18;
    c.options.intervals = 120;
    c.options.planes = 1;
    c.options.extrapolate = true;
    return c;
}

static void end_comparison(comparison *c)
{
    iso_image_destroy(&c->image);
    free(c->view.tf.entries);
    release(&c->pyramid);
}

/* The largest difference to the reference, which sees what the comparison holds now. */
static double compare(comparison *c, double *rmse)
{
    iso_image wanted;
    if (!c->image.rgba)
        render_povray(&c->pyramid, c->level, &c->view, &c->options, &c->image);
    render_reference(&c->pyramid, c->level, &c->view, c->quadrature, c->options.intervals, c->options.iso, &wanted);
    const double most = largest_difference(&c->image, &wanted, rmse);
    iso_image_destroy(&wanted);
    return most;
}

/* Half a step of POV-Ray's 16 bits is 7.6e-6, of emission up to 1.2 times that and of the background; its colours
 * and optical depths are floats. */
static const double lock_step_max = 2e-5;
/* What is left of 240 and 480 midpoint samples a ray behind extrapolation, on a TF with a continuous slope. */
static const double converged_rmse = 1e-4;

static void check_lock_step(comparison c)
{
    double rmse;
    assert_at_most(compare(&c, &rmse), lock_step_max);
    end_comparison(&c);
}

static void lock_step_agrees_in_perspective(void **state)
{
    (void)state;
    check_lock_step(lock_step(0, false, 256));
}

static void lock_step_agrees_in_orthographic_projection(void **state)
{
    (void)state;
    check_lock_step(lock_step(1, true, 256));
}

static void lock_step_agrees_with_a_table_of_4096_entries(void **state)
{
    (void)state;
    check_lock_step(lock_step(1, false, 4096));
}

static void lock_step_agrees_from_inside_the_volume(void **state)
{
    (void)state;
    comparison c = lock_step(0, false, 256);
    c.view.camera.position = iso_madd(iso_geometry_box_center_mm(&c.pyramid.levels[0].geometry), c.view.camera.right,
                                      5);
    check_lock_step(c);
}

static void lock_step_agrees_with_float_directions(void **state)
{
    (void)state;
    comparison c = lock_step(1, false, 256);
    c.options.float_directions = true;
    iso_reference_options opt = iso_reference_defaults();
    opt.quadrature = c.quadrature;
    opt.source = ISO_FROM_FLOAT;
    opt.intervals = c.options.intervals;
    iso_image wanted;
    double rmse;
    render_povray(&c.pyramid, c.level, &c.view, &c.options, &c.image);
    assert_ok(iso_reference_render(&c.pyramid.levels[1], ISO_CODE_SNORM, &c.view, &opt, &wanted, NULL, &err));
    assert_at_most(largest_difference(&c.image, &wanted, &rmse), lock_step_max);
    /* Their own reference, not the codes': half a code step turns a direction by .2 degrees. */
    assert_more_than(compare(&c, &rmse), 10 * lock_step_max);
    iso_image_destroy(&wanted);
    end_comparison(&c);
}

static void plant_half_voxel_shift(comparison *c)
{
    iso_geometry *g = &c->pyramid.levels[c->level].geometry;
    g->origin_mm = iso_madd(g->origin_mm, iso_column(g->index_to_world, 0), 0.5);
}

static void plant_swapped_axes(comparison *c)
{
    iso_mat3 *m = &c->pyramid.levels[c->level].geometry.index_to_world;
    for (int r = 0; r < 3; ++r) {
        const double keep = m->m[r][0];
        m->m[r][0] = m->m[r][1];
        m->m[r][1] = keep;
    }
}

static void plant_srgb_tf(comparison *c)
{
    for (size_t i = 0; i < 4 * c->view.tf.count; ++i) {
        const double v = (double)c->view.tf.entries[i];
        if (i % 4 != 3)
            c->view.tf.entries[i] = (float)(v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055);
    }
}

static void plant_light_from_the_wrong_side(comparison *c)
{
    c->view.lights[0].direction.x *= -1;
}

typedef void (*fault)(comparison *);
static const fault faults[] = {plant_half_voxel_shift, plant_swapped_axes, plant_srgb_tf,
                               plant_light_from_the_wrong_side};

/* Each fault, planted into what the reference sees, is far beyond the threshold that the clean comparison keeps. */
static void check_faults(comparison (*make)(size_t level), bool by_rmse, double threshold)
{
    comparison c = make(1);
    double rmse, most = compare(&c, &rmse);
    assert_at_most(by_rmse ? rmse : most, threshold);
    for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i) {
        comparison bad = make(1);
        bad.image = c.image;
        faults[i](&bad);
        most = compare(&bad, &rmse);
        assert_more_than(by_rmse ? rmse : most, 5 * threshold);
        bad.image = (iso_image){0};
        end_comparison(&bad);
    }
    end_comparison(&c);
}

static comparison lock_step_of_level(size_t level)
{
    return lock_step(level, false, 256);
}

static void lock_step_agrees_at_a_level_that_overhangs_and_rejects_planted_faults(void **state)
{
    (void)state;
    check_faults(lock_step_of_level, false, lock_step_max);
}

static void converged_agrees_and_rejects_planted_faults(void **state)
{
    (void)state;
    check_faults(converged, true, converged_rmse);
}

static void halving_the_intervals_quarters_the_error_and_the_limit_lies_within_its_bars(void **state)
{
    (void)state;
    comparison c = converged(1);
    iso_image images[3], limit, reference;
    double error[3], order, limit_error;
    iso_extrapolation bar;
    c.options.planes = 0;
    c.options.extrapolate = false;
    render_reference(&c.pyramid, 1, &c.view, c.quadrature, 1, 0, &reference);
    for (size_t i = 0; i < 3; ++i) {
        c.options.intervals = (size_t)30 << i;
        render_povray(&c.pyramid, c.level, &c.view, &c.options, &images[i]);
        largest_difference(&images[i], &reference, &error[i]);
    }
    assert_ok(iso_observed_order(&images[0], &images[1], &images[2], 2, &order, &err));
    assert_ok(iso_richardson(&images[1], &images[2], 2, 2, &limit, &bar, &err));
    /* Second order; where cells' borders fall between the samples is chance, and scatters it. */
    assert_within(log2(error[0] / error[1]), 2, 0.5);
    assert_within(log2(error[1] / error[2]), 2, 0.5);
    assert_within(order, 2, 0.5);
    /* Independent errors e and 4 e of the two finest would leave 1.9 e in the limit, at a bar of 1.4 e. */
    largest_difference(&limit, &reference, &limit_error);
    assert_true(iso_extrapolated_agree(limit_error, bar.error_bar, 0, 2, 1e-5));
    iso_image_destroy(&reference);
    plant_half_voxel_shift(&c);
    render_reference(&c.pyramid, 1, &c.view, c.quadrature, 1, 0, &reference);
    largest_difference(&limit, &reference, &limit_error);
    assert_false(iso_extrapolated_agree(limit_error, bar.error_bar, 0, 2, 1e-5));
    iso_image_destroy(&reference);
    for (size_t i = 0; i < 3; ++i)
        iso_image_destroy(&images[i]);
    iso_image_destroy(&limit);
    end_comparison(&c);
}

/* Where a ray along `forward` enters and leaves the box, in mm behind the plane through the box's centre; false: it misses. */
static bool through_box(const iso_geometry *g, iso_vec3 aside, iso_vec3 forward, double *enters, double *leaves)
{
    const iso_vec3 start = iso_add(iso_geometry_box_center_mm(g), aside), from = iso_geometry_to_index(g, start);
    const iso_vec3 step = iso_sub(iso_geometry_to_index(g, iso_add(start, forward)), from);
    const double o[3] = {from.x, from.y, from.z}, d[3] = {step.x, step.y, step.z};
    *enters = -INFINITY, *leaves = INFINITY;
    for (int a = 0; a < 3; ++a) {
        const double t0 = -o[a] / d[a], t1 = (g->box_index[a] - o[a]) / d[a];
        *enters = fmax(*enters, fmin(t0, t1));
        *leaves = fmin(*leaves, fmax(t0, t1));
    }
    return *enters < *leaves;
}

/* Along camera->right from the centre, the ray that enters at the depth of the centre: how far aside, and what of it is in
 * the box; 0 where none does. */
static double entry_beside_the_center(const iso_geometry *g, const iso_camera *camera, double *aside)
{
    double low = 0, high = iso_geometry_box_radius_mm(g), enters, leaves, chord = 0;
    for (int i = 0; i < 100; ++i) {
        *aside = 0.5 * (low + high);
        bool hits = through_box(g, iso_scale(camera->right, *aside), camera->forward, &enters, &leaves);
        *(hits && enters <= 0 ? &low : &high) = *aside;
    }
    if (through_box(g, iso_scale(camera->right, low), camera->forward, &enters, &leaves) && fabs(enters) < 1e-9)
        chord = leaves - enters;
    return chord;
}

/* POV-Ray takes surfaces within 0.001 units for one: a box of 100 units loses the rest of rays that enter so near to a
 * cutting plane. */
static void a_plane_that_meets_the_box_where_a_ray_enters_takes_nothing_away(void **state)
{
    (void)state;
    comparison c = converged(0);
    const iso_geometry *g = &c.pyramid.levels[0].geometry;
    iso_view turned = oblique_view(g, true, 256);
    iso_camera camera = turned.camera, best = camera;
    double longest = 0, aside = 0, at;
    free(turned.tf.entries);
    for (double angle = 0; angle < 6.28; angle += 0.05) {
        camera.right = iso_add(iso_scale(turned.camera.right, cos(angle)), iso_scale(turned.camera.up, sin(angle)));
        camera.up = iso_cross(camera.right, camera.forward);
        const double chord = entry_beside_the_center(g, &camera, &at);
        if (chord > longest)
            longest = chord, aside = at, best = camera;
    }
    assert_more_than(longest, 0.1 * iso_geometry_box_radius_mm(g));
    c.view.camera = best;
    c.view.camera.position = iso_madd(best.position, best.right, aside);
    c.view.camera.half_height = 8e-7 * iso_geometry_box_radius_mm(g);
    c.view.width = 41, c.view.height = 1;
    double rmse;
    assert_at_most(compare(&c, &rmse), 1e-3); /* ten times what is left of the steps */
    end_comparison(&c);
}

static void an_isosurface_is_the_first_hit_of_the_reference(void **state)
{
    (void)state;
    comparison c = lock_step(0, false, 256);
    c.quadrature = ISO_QUADRATURE_FIRST_HIT;
    c.options.isosurface = true;
    c.options.iso = 39000;
    double rmse;
    /* As in lock-step; the hit is found to 1e-6 of a box of 100. */
    assert_at_most(compare(&c, &rmse), lock_step_max);
    size_t hits = 0;
    for (size_t i = 0; i < c.image.width * c.image.height; ++i)
        hits += c.image.rgba[4 * i + 3] > 0.5f;
    assert_more_than((double)hits, 300);
    c.options.iso += 65; /* a thousandth of the range */
    assert_more_than(compare(&c, &rmse), 10 * lock_step_max);
    end_comparison(&c);
}

/* A level whose value is 1 - |p| and whose directions are radial, in a cube of 2 mm. */
static iso_level sphere_level(size_t n)
{
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){n, n, n},
                                                     (double[]){2.0 / (double)n, 2.0 / (double)n, 2.0 / (double)n});
    const size_t count = n * n * n;
    iso_level level = {.geometry = g, .stored_type = ISO_F32, .min = -1, .max = 1};
    level.scalar = malloc(count * sizeof(float));
    level.codes = calloc(3, count);
    level.directions = malloc(3 * count * sizeof(float));
    for (size_t i = 0; i < count; ++i) {
        const iso_vec3 p = iso_geometry_to_world(&g, iso_v3((double)(i % n) + 0.5, (double)(i / n % n) + 0.5,
                                                            (double)(i / n / n) + 0.5));
        const iso_vec3 d = iso_normalize(p);
        level.scalar[i] = (float)(1 - iso_norm(p));
        level.directions[3 * i] = (float)d.x;
        level.directions[3 * i + 1] = (float)d.y;
        level.directions[3 * i + 2] = (float)d.z;
    }
    return level;
}

/* The mean error of the pixels well inside a sphere of radius 0.6, against its closed form. */
static double sphere_error(size_t n)
{
    iso_level level = sphere_level(n);
    iso_pyramid p = {.options = {.code = ISO_CODE_SNORM}, .level_count = 1, .levels = &level};
    static float white[8] = {1, 1, 1, 1, 1, 1, 1, 1};
    iso_view view = oblique_view(&level.geometry, false, 2);
    free(view.tf.entries);
    view.tf = (iso_tf_table){.count = 2, .lo = 0, .hi = 1, .entries = white};
    view.camera.half_height = 0.1;
    iso_povray_options opt = iso_povray_defaults();
    opt.isosurface = true;
    opt.iso = 0.4;
    opt.float_directions = true;
    iso_image image;
    double sum = 0;
    size_t count = 0;
    render_povray(&p, 0, &view, &opt, &image);
    for (size_t i = 0; i < image.width * image.height; ++i) {
        const iso_ray ray = iso_camera_ray(&view.camera, view.width, view.height, i % view.width, i / view.width);
        const double b = iso_dot(ray.origin, ray.direction), c = iso_dot(ray.origin, ray.origin) - 0.36;
        if (b * b - c < 0.2 * 0.36)
            continue; /* towards the silhouette errors of the hit grow without bound */
        const iso_vec3 hit = iso_madd(ray.origin, ray.direction, -b - sqrt(b * b - c));
        const iso_vec3 normal = iso_scale(hit, 1 / 0.6 / sqrt(1 + 1 / (127.0 * 127)));
        double shade = view.shading.ambient;
        for (size_t l = 0; l < 2; ++l) {
            const iso_vec3 half = iso_normalize(iso_sub(view.lights[l].direction, ray.direction));
            shade += view.lights[l].intensity *
                     (view.shading.diffuse * fabs(iso_dot(normal, view.lights[l].direction)) +
                      view.shading.specular * pow(fabs(iso_dot(normal, half)), view.shading.power));
        }
        sum += fabs((double)image.rgba[4 * i] - shade);
        assert_within((double)image.rgba[4 * i + 3], 1, 0);
        ++count;
    }
    assert_more_than((double)count, 100);
    iso_image_destroy(&image);
    free(level.scalar);
    free(level.codes);
    free(level.directions);
    return sum / (double)count;
}

static void an_isosurface_of_a_sphere_converges_with_the_square_of_the_spacing(void **state)
{
    (void)state;
    const double coarse = sphere_error(16), fine = sphere_error(32);
    /* Trilinear interpolation of |p| and of p / |p|: second order in a spacing of a tenth of the radius. */
    assert_at_most(fine, 1e-3);
    assert_more_than(coarse / fine, 3);
}

static uint32_t big_endian(const char *bytes, size_t count)
{
    uint32_t value = 0;
    for (size_t i = 0; i < count; ++i)
        value = value << 8 | (uint8_t)bytes[i];
    return value;
}

static void df3_files_are_big_endian_with_a_rim_of_edge_values(void **state)
{
    (void)state;
    char *dir = iso_make_temp_dir(), *path = iso_path_join(dir, "a.df3"), *data;
    const size_t size[3] = {4, 3, 2};
    float values[24];
    for (int i = 0; i < 24; ++i)
        values[i] = (float)(1000 * (i / 12) + 100 * (i / 4 % 3) + i % 4);
    for (unsigned bits = 8; bits <= 32; bits *= 2) {
        const iso_df3_coding coding = {bits, 0, bits == 8 ? 2550 : bits == 16 ? 65535 : 4294967295.0};
        size_t bytes;
        assert_ok(iso_df3_write(path, size, values, 1, 0, &coding, &err));
        assert_ok(iso_file_read(path, &data, &bytes, &err));
        assert_int_equal(bytes, 6 + 6 * 5 * 4 * bits / 8);
        assert_int_equal(big_endian(data, 2), 6);
        assert_int_equal(big_endian(data + 2, 2), 5);
        assert_int_equal(big_endian(data + 4, 2), 4);
        for (int z = 0; z < 4; ++z)
            for (int y = 0; y < 5; ++y)
                for (int x = 0; x < 6; ++x) {
                    const int cx = x < 1   ? 0
                                   : x > 4 ? 3
                                           : x - 1,
                              cy = y < 1   ? 0
                                   : y > 3 ? 2
                                           : y - 1,
                              cz = z < 2 ? 0 : 1;
                    const double value = 1000 * cz + 100 * cy + cx;
                    const uint32_t sample = big_endian(data + 6 + (size_t)((z * 5 + y) * 6 + x) * bits / 8, bits / 8);
                    assert_int_equal(sample, (uint32_t)(bits == 8 ? floor(value / 10 + 0.5) : value));
                }
        free(data);
    }
    const iso_df3_coding coding = {8, 0, 1};
    assert_status(iso_df3_write(path, (size_t[]){65534, 1, 1}, values, 1, 0, &coding, &err), ISO_E_RANGE);
    iso_remove_tree(dir);
    free(path);
    free(dir);
}

static void an_exported_folder_renders_where_it_lies(void **state)
{
    (void)state;
    comparison c = lock_step(1, true, 300);
    char *base = iso_make_temp_dir(), *dir = iso_path_join(base, "two words"), *program;
    assert_ok(iso_povray_export(&c.pyramid, 1, &c.view, dir, &c.options, NULL, &err));
    static const char *const names[] = {"two_words.pov",        "two_words.inc",    "two_words.ini",
                                        "two_words_scalar.df3", "two_words_dx.df3", "two_words_dy.df3",
                                        "two_words_dz.df3"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        char *path = iso_path_join(dir, names[i]);
        assert_true(iso_path_exists(path));
        free(path);
    }
    assert_ok(iso_process_find("povray", "povray", &program, &err));
    const char *argv[] = {program, "two_words.ini", NULL};
    const iso_process_options options = {.directory = dir};
    assert_ok(iso_process_run(argv, &options, &err));
    char *png = iso_path_join(dir, "two_words.png");
    assert_true(iso_path_exists(png));
    /* The same name again replaces it; a folder of something else stays. */
    assert_ok(iso_povray_export(&c.pyramid, 0, &c.view, dir, &c.options, NULL, &err));
    assert_false(iso_path_exists(png));
    assert_status(iso_povray_export(&c.pyramid, 0, &c.view, base, &c.options, NULL, &err), ISO_E_IO);
    iso_remove_tree(base);
    free(png);
    free(program);
    free(dir);
    free(base);
    end_comparison(&c);
}

static void options_outside_their_limits_are_refused(void **state)
{
    (void)state;
    comparison c = lock_step(0, false, 256);
    iso_image image;
    const iso_povray_options good = c.options;
    iso_povray_options bad = good;
    assert_status(iso_povray_render(&c.pyramid, 2, &c.view, &good, &image, NULL, &err), ISO_E_RANGE);
    bad.intervals = 256;
    assert_status(iso_povray_render(&c.pyramid, 0, &c.view, &bad, &image, NULL, &err), ISO_E_RANGE);
    bad = good;
    bad.planes = 101;
    assert_status(iso_povray_render(&c.pyramid, 0, &c.view, &bad, &image, NULL, &err), ISO_E_RANGE);
    bad = good;
    bad.df3_bits = 12;
    assert_status(iso_povray_render(&c.pyramid, 0, &c.view, &bad, &image, NULL, &err), ISO_E_RANGE);
    end_comparison(&c);
}

static void a_missing_program_is_named(void **state)
{
    (void)state;
    comparison c = lock_step(1, false, 256);
    iso_image image;
    char version[32];
    setenv("ISOSHADE_POVRAY", "/no/such/povray", 1);
    assert_status(iso_povray_render(&c.pyramid, 1, &c.view, &c.options, &image, NULL, &err), ISO_E_MISSING);
    assert_status(iso_povray_version(version, sizeof version, &err), ISO_E_MISSING);
    setenv("ISOSHADE_POVRAY", "/bin/false", 1);
    assert_status(iso_povray_version(version, sizeof version, &err), ISO_E_PROGRAM);
    assert_status(iso_povray_render(&c.pyramid, 1, &c.view, &c.options, &image, NULL, &err), ISO_E_PROGRAM);
    unsetenv("ISOSHADE_POVRAY");
    assert_ok(iso_povray_version(version, sizeof version, &err));
    assert_true(strncmp(version, "3.", 2) == 0);
    end_comparison(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lock_step_agrees_in_perspective),
        cmocka_unit_test(lock_step_agrees_in_orthographic_projection),
        cmocka_unit_test(lock_step_agrees_with_a_table_of_4096_entries),
        cmocka_unit_test(lock_step_agrees_from_inside_the_volume),
        cmocka_unit_test(lock_step_agrees_with_float_directions),
        cmocka_unit_test(lock_step_agrees_at_a_level_that_overhangs_and_rejects_planted_faults),
        cmocka_unit_test(converged_agrees_and_rejects_planted_faults),
        cmocka_unit_test(halving_the_intervals_quarters_the_error_and_the_limit_lies_within_its_bars),
        cmocka_unit_test(a_plane_that_meets_the_box_where_a_ray_enters_takes_nothing_away),
        cmocka_unit_test(an_isosurface_is_the_first_hit_of_the_reference),
        cmocka_unit_test(an_isosurface_of_a_sphere_converges_with_the_square_of_the_spacing),
        cmocka_unit_test(df3_files_are_big_endian_with_a_rim_of_edge_values),
        cmocka_unit_test(an_exported_folder_renders_where_it_lies),
        cmocka_unit_test(options_outside_their_limits_are_refused),
        cmocka_unit_test(a_missing_program_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
