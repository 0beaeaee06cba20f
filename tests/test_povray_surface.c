/* SPDX-License-Identifier: MIT */
/* Isosurfaces and planes in POV-Ray against the reference. */
#include <math.h>
#include <stdlib.h>

#include "povray_scenes.h"

/* Where a ray along `forward` enters and leaves the box, in mm behind the plane through the box's center; false: it
 * misses. */
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

/* Along camera->right from the center, the ray that enters at the depth of the center: how far aside, and what of it is
 * in the box; 0 where none does. */
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
TEST(a_plane_that_meets_the_box_where_a_ray_enters_takes_nothing_away)
{
    ENDED_BY(end_comparison) comparison c = converged(0);
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
}

TEST(an_isosurface_is_the_first_hit_of_the_reference)
{
    ENDED_BY(end_comparison) comparison c = lock_step(0, false, 256);
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

TEST(an_isosurface_of_a_sphere_converges_with_the_square_of_the_spacing)
{
    const double coarse = sphere_error(16), fine = sphere_error(32);
    /* Trilinear interpolation of |p| and of p / |p|: second order in a spacing of a tenth of the radius. */
    assert_at_most(fine, 1e-3);
    assert_more_than(coarse / fine, 3);
}

TEST_MAIN(NULL, NULL)
