/* SPDX-License-Identifier: MIT */
/* test_reference_exact.c - the reference's error bound and what it passes over, on random scenes and on closed
 * forms. */
#include <unistd.h>

#include "render/cell_ray.h"
#include "render/lanes.h"
#include "render/reference.h"
#include "test.h"

enum { WIDTH = 4, HEIGHT = 3, PIXELS = WIDTH * HEIGHT, MOST_ENTRIES = 64 };

typedef struct scene {
    iso_level level;
    iso_view view;
    float entries[4 * MOST_ENTRIES];
    iso_direction_source source;
} scene;

static uint64_t state_of_random;
static double random_in(double lo, double hi)
{
    state_of_random = state_of_random * 6364136223846793005u + 1442695040888963407u;
    return lo + (hi - lo) * (double)(state_of_random >> 11) * 0x1p-53;
}

/* Values in a few clumps, so that some blocks are empty; a table with gaps, steps and bends. */
static void make_scene(scene *s, uint64_t seed)
{
    state_of_random = seed * 7919 + 1;
    for (int i = 0; i < 8; ++i)
        (void)random_in(0, 1);
    const size_t size[3] = {(size_t)random_in(5, 22), (size_t)random_in(4, 12), (size_t)random_in(3, 11)};
    const double spacing[3] = {random_in(0.3, 1), random_in(0.3, 1), random_in(0.3, 1)};
    const bool empty_parts = random_in(0, 1) < 0.5;
    memset(s, 0, sizeof *s);
    s->level = (iso_level){.geometry = iso_geometry_axis_aligned(size, spacing), .stored_type = ISO_F32, .max = 1};
    s->level.labels = random_in(0, 1) < 0.15;
    const size_t count = iso_geometry_voxel_count(&s->level.geometry);
    s->level.scalar = malloc(count * sizeof(float));
    s->level.codes = malloc(3 * count);
    s->level.directions = malloc(3 * count * sizeof(float));
    const double wave = random_in(0.05, 1.5);
    for (size_t i = 0; i < count; ++i) {
        const double x = (double)(i % size[0]);
        s->level.scalar[i] = (float)(0.5 + 0.4 * sin(wave * x) + random_in(-0.1, 0.1));
        if (empty_parts && x > 6 && x < 18)
            s->level.scalar[i] = 0.05f;
        for (size_t a = 0; a < 3; ++a)
            s->level.directions[3 * i + a] = (float)random_in(a == 2 ? 0.2 : -0.5, 0.6);
    }
    iso_code_encode(ISO_CODE_FIT, s->level.directions, s->level.codes, count);
    const iso_direction_source sources[4] = {ISO_FROM_CODES, ISO_FROM_FLOAT, ISO_FROM_ON_THE_FLY, ISO_FROM_DECODED};
    s->source = sources[(int)random_in(0, s->level.labels ? 2 : 4)];
    iso_view *v = &s->view;
    const iso_vec3 forward = iso_normalize(iso_v3(random_in(-1, 1), random_in(-1, 1), random_in(-1, 1)));
    *v = (iso_view){.width = WIDTH,
                    .height = HEIGHT,
                    .light_count = (size_t)random_in(0, 3),
                    .step_voxels = 0.25,
                    .background = {0.1, 0.2, 0.3},
                    .shading = {.ambient = 0.3, .diffuse = 0.5, .specular = 0.4}};
    v->shading.power = random_in(0, 1) < 0.3 ? random_in(0.2, 5) : floor(random_in(1, 21));
    for (size_t l = 0; l < v->light_count; ++l)
        v->lights[l] = (iso_light){.direction = iso_normalize(
                                       iso_v3(random_in(-1, 1), random_in(-1, 1), random_in(-1, 1))),
                                   .intensity = 0.6};
    v->camera = (iso_camera){.orthographic = true,
                             .position = iso_scale(forward, -30),
                             .forward = forward,
                             .half_height = random_in(1, 3)};
    v->camera.right = iso_normalize(iso_cross(forward, iso_v3(0.3, 0.5, 0.8)));
    v->camera.up = iso_cross(v->camera.right, forward);
    const size_t entries = random_in(0, 1) < 0.3 ? 2 : (size_t)random_in(3, MOST_ENTRIES);
    v->tf = (iso_tf_table){.count = entries, .lo = 0, .hi = random_in(0.8, 1.2), .entries = s->entries};
    const double opaque = exp(random_in(-2, 2));
    for (size_t i = 0; i < entries; ++i)
        for (size_t c = 0; c < 4; ++c)
            s->entries[4 * i + c] = c < 3                    ? (float)random_in(0, 1)
                                    : i < entries / 4        ? 0
                                    : random_in(0, 1) < 0.25 ? 0
                                                             : (float)random_in(0, opaque);
}

static void free_scene(scene *s)
{
    free(s->level.scalar);
    free(s->level.codes);
    free(s->level.directions);
}

static iso_reference_result render(const scene *s, double tolerance, bool by_halving, double rgba[4 * PIXELS])
{
    iso_reference_result result = {.rgba = rgba};
    iso_reference_options opt = iso_reference_defaults();
    OWNED(iso_image) image;
    opt.source = s->source;
    opt.tolerance = opt.most_error = tolerance;
    opt.plain = by_halving;
    opt.threads = 1;
    opt.result = &result;
    assert_ok(iso_reference_render(&s->level, ISO_CODE_FIT, &s->view, &opt, &image, NULL, &err));
    return result;
}

static double largest_difference(const double *a, const double *b, size_t count)
{
    double most = 0;
    for (size_t i = 0; i < count; ++i)
        if (!(fabs(a[i] - b[i]) <= most))
            most = fabs(a[i] - b[i]);
    return most;
}

/* At loose tolerances rules of few points are off by much, and never by more than what is stated; and the bound is no
 * idle one: it comes near the error somewhere. */
TEST(no_pixel_is_farther_off_than_its_bound)
{
    double closest = 0, rgba[4 * PIXELS], exact[4 * PIXELS];
    for (uint64_t seed = 0; seed < 120; ++seed) {
        ENDED_BY(free_scene) scene s;
        make_scene(&s, seed);
        const iso_reference_result best = render(&s, 1e-10, false, exact);
        assert_true(best.is_proved);
        assert_at_most(best.error, 1.01e-10);
        for (double tolerance = 1e-1; tolerance > 1e-7; tolerance *= 1e-2) {
            const iso_reference_result loose = render(&s, tolerance, false, rgba);
            const double off = largest_difference(rgba, exact, 4 * PIXELS);
            assert_at_most(loose.error, tolerance + 2 * ISO_REFERENCE_LEFT);
            if (off > loose.error + best.error + 1e-13) /* 1e-13: rounding */
                print_message("seed %d: tolerance %g, off by %g, bound %g\n", (int)seed, tolerance, off, loose.error);
            assert_at_most(off, loose.error + best.error + 1e-13);
            closest = fmax(closest, off / loose.error);
        }
    }
    print_message("the largest error was %.3g of its bound\n", closest);
    assert_more_than(closest, 1e-4);
}

/* The same equation by sums at equal distances, halved and extrapolated, which pass over nothing. */
TEST(halving_gives_the_same_pictures)
{
    double worst = 0, rgba[4 * PIXELS], halved[4 * PIXELS];
    for (uint64_t seed = 0; seed < 30; ++seed) {
        ENDED_BY(free_scene) scene s;
        make_scene(&s, seed);
        const iso_reference_result cells = render(&s, 1e-9, false, rgba), other = render(&s, 1e-7, true, halved);
        const double off = largest_difference(rgba, halved, 4 * PIXELS);
        assert_false(other.is_proved);
        worst = fmax(worst, off);
        if (off > cells.error + 1e-6)
            print_message("seed %d: off by %g, bounds %g and %g\n", (int)seed, off, cells.error, other.error);
        assert_at_most(off, cells.error + 1e-6); /* ten times what was asked of the estimate */
    }
    print_message("the largest difference was %.3g\n", worst);
}

/* The defaults: 1e-9 for every pixel. Values, spacings and the table are exact in floats, so that nothing else is
 * off. */
TEST(closed_forms_hold_to_a_billionth)
{
    scene s = {.level = {.geometry = iso_geometry_axis_aligned((size_t[]){4, 4, 6}, (double[]){1, 1, 2}),
                         .stored_type = ISO_F32,
                         .max = 1},
               .entries = {0, 0, 0, 0, 1, 1, 1, 0.25f},
               .source = ISO_FROM_ON_THE_FLY};
    s.level.scalar = malloc(96 * sizeof(float));
    for (size_t i = 0; i < 96; ++i) /* 1/8 to 6/8 along z, centers 2 mm apart */
        s.level.scalar[i] = (float)(i / 16 + 1) / 8;
    s.view = (iso_view){.width = WIDTH,
                        .height = HEIGHT,
                        .shading = {.ambient = 0.25, .diffuse = 0.75, .power = 1},
                        .light_count = 1,
                        .background = {0, 0.5, 0},
                        .camera = {.orthographic = true,
                                   .position = {0, 0, -50},
                                   .forward = {0, 0, 1},
                                   .right = {1, 0, 0},
                                   .up = {0, 1, 0},
                                   .half_height = 1}};
    s.view.lights[0] = (iso_light){.direction = {1, 0, 0},
                                   .intensity = 1}; /* beside the gradient: ambient light is left */
    s.view.tf = (iso_tf_table){.count = 2, .lo = 0, .hi = 1, .entries = s.entries};
    const double k = 0.25, s0 = 0.125, s1 = 0.75, slope = (s1 - s0) / 10, root = sqrt(k / (2 * slope));
    const double front = exp(-k * s0), through = exp(-k * (s0 + s1) / 2 * 10),
                 back = exp(-k * s1); /* 1 mm, 10 mm, 1 mm */
    const double ramp = s0 - s1 * through +
                        slope * exp(k * s0 * s0 / (2 * slope)) * sqrt(acos(-1) / (2 * k * slope)) *
                            (erf(s1 * root) - erf(s0 * root));
    const double color = s0 * (1 - front) + front * (ramp + through * s1 * (1 - back)), left = front * through * back;
    for (int plain = 0; plain < 2; ++plain) {
        double rgba[4 * PIXELS];
        iso_reference_result result = {.rgba = rgba};
        iso_reference_options opt = iso_reference_defaults();
        OWNED(iso_image) image;
        opt.source = s.source;
        opt.plain = plain;
        opt.result = &result;
        assert_ok(iso_reference_render(&s.level, ISO_CODE_FIT, &s.view, &opt, &image, NULL, &err));
        const double tolerance = plain ? 1e-6 : 1e-9;
        assert_at_most(result.error, tolerance);
        for (size_t i = 0; i < PIXELS; ++i) {
            assert_within(rgba[4 * i], 0.25 * color, tolerance);
            assert_within(rgba[4 * i + 1], 0.25 * color + 0.5 * left, tolerance);
            assert_within(rgba[4 * i + 3], 1 - left, tolerance);
        }
    }
    free(s.level.scalar);
}

/* Samples at equal steps: skipping changes no bit. */
TEST(samples_in_lock_step_are_the_same_to_the_bit)
{
    for (uint64_t seed = 400; seed < 460; ++seed) {
        ENDED_BY(free_scene) scene s;
        double rgba[2][4 * PIXELS];
        make_scene(&s, seed);
        for (int plain = 0; plain < 2; ++plain) {
            iso_reference_result result = {.rgba = rgba[plain]};
            iso_reference_options opt = iso_reference_defaults();
            OWNED(iso_image) image;
            opt.quadrature = ISO_QUADRATURE_MIDPOINT;
            opt.step_voxels = 0.05 + 0.01 * (double)(seed % 60);
            opt.source = s.source;
            opt.plain = plain;
            opt.result = &result;
            assert_ok(iso_reference_render(&s.level, ISO_CODE_FIT, &s.view, &opt, &image, NULL, &err));
            assert_true(isnan(result.error));
        }
        assert_memory_equal(rgba[0], rgba[1], sizeof rgba[0]);
    }
}

/* Each instruction set that the machine has. */
TEST(instruction_sets_give_the_same_bits)
{
    iso_cell_ray_variant v[4];
    const size_t count = iso_cell_ray_variants(v);
    for (uint64_t seed = 200; seed < 230; ++seed) {
        scene s;
        make_scene(&s, seed);
        iso_sampler sampler;
        iso_shown shown;
        iso_empty_space empty;
        iso_cell_scene cells;
        assert_ok(iso_sampler_create(&sampler, &s.level, ISO_CODE_FIT, s.source, &err));
        assert_ok(iso_shown_create(&shown, &s.view.tf, NULL, &err));
        assert_ok(iso_empty_space_create(&empty, &s.level, &shown, NULL, NULL, 1, &err));
        assert_ok(iso_cell_scene_create(&cells, &sampler, &s.view, &shown, &empty, &err));
        const iso_mat3 to_index = iso_mat3_inverse(s.level.geometry.index_to_world);
        for (size_t pixel = 0; pixel < PIXELS; ++pixel) {
            const iso_ray ray = iso_camera_ray(&s.view.camera, WIDTH, HEIGHT, pixel % WIDTH, pixel / WIDTH);
            iso_cell_ray r = {iso_mul(to_index, iso_sub(ray.origin, s.level.geometry.origin_mm)),
                              iso_mul(to_index, ray.direction),
                              iso_scale(ray.direction, -1),
                              0,
                              0,
                              1e-7};
            if (!iso_view_ray(&s.view, &ray, &s.level.geometry, &r.t0, &r.t1) || !(r.t1 > r.t0))
                continue;
            double error[4];
            stretch at[4];
            for (size_t i = 0; i < count; ++i)
                if (v[i].there) {
                    at[i] = v[i].integrate(&cells, &r, &error[i]);
                    assert_memory_equal(&at[i], &at[0], sizeof at[0]);
                    assert_memory_equal(&error[i], &error[0], sizeof error[0]);
                }
        }
        iso_cell_scene_destroy(&cells);
        iso_empty_space_destroy(&empty);
        iso_shown_destroy(&shown);
        iso_sampler_destroy(&sampler);
        free_scene(&s);
    }
}

/* A block is skipped only if no value in it is visible; an empty one is skipped. */
TEST(only_blocks_without_visible_values_are_skipped)
{
    for (uint64_t seed = 300; seed < 340; ++seed) {
        scene s;
        make_scene(&s, seed);
        iso_sampler sampler;
        iso_shown shown;
        iso_empty_space empty;
        size_t passed = 0, seen = 0;
        const size_t *n = s.level.geometry.size;
        assert_ok(iso_sampler_create(&sampler, &s.level, ISO_CODE_FIT, s.source, &err));
        assert_ok(iso_shown_create(&shown, &s.view.tf, NULL, &err));
        assert_ok(iso_empty_space_create(&empty, &s.level, &shown, NULL, NULL, 1, &err));
        for (size_t i = 0; i < 4000; ++i) {
            const double p[3] = {random_in(0, (double)n[0]), random_in(0, (double)n[1]), random_in(0, (double)n[2])};
            int cell[3], lo[3], hi[3];
            for (int a = 0; a < 3; ++a)
                cell[a] = (int)floor(p[a] + 0.5);
            double rgbs[4];
            iso_reference_classify(&sampler, &s.view, iso_v3(p[0], p[1], p[2]), rgbs);
            seen += rgbs[3] > 0;
            if (!iso_empty_space_at(&empty, cell, lo, hi))
                continue;
            ++passed;
            assert_true(rgbs[3] == 0);
            for (int a = 0; a < 3; ++a)
                assert_true(lo[a] <= cell[a] && cell[a] < hi[a]);
        }
        assert_true(seen > 0 || passed > 0);
        iso_empty_space_destroy(&empty);
        iso_shown_destroy(&shown);
        iso_sampler_destroy(&sampler);
        free_scene(&s);
    }
}

/* One voxel of a grid is shown, at every place in turn: no skipped block holds a cell that it touches. */
TEST(one_voxel_is_never_passed_over)
{
    enum { NX = 6, NY = 9, NZ = 10, COUNT = NX * NY * NZ };
    static float scalar[COUNT];
    const iso_level level = {.geometry = iso_geometry_axis_aligned((size_t[]){NX, NY, NZ}, (double[]){1, 1, 1}),
                             .scalar = scalar,
                             .max = 1};
    float entries[8] = {0, 0, 0, 0, 1, 1, 1, 1};
    const iso_tf_table tf = {.count = 2, .lo = 0, .hi = 1, .entries = entries};
    OWNED(iso_shown) shown;
    assert_ok(iso_shown_create(&shown, &tf, NULL, &err));
    for (int v = 0; v < COUNT; ++v) {
        OWNED(iso_empty_space) empty;
        const int at[3] = {v % NX, v / NX % NY, v / (NX * NY)};
        scalar[v] = 1;
        assert_ok(iso_empty_space_create(&empty, &level, &shown, NULL, NULL, 1, &err));
        for (int c = 0; c < (NX + 1) * (NY + 1) * (NZ + 1); ++c) {
            const int cell[3] = {c % (NX + 1), c / (NX + 1) % (NY + 1), c / ((NX + 1) * (NY + 1))};
            int lo[3], hi[3];
            bool apart = !iso_empty_space_at(&empty, cell, lo, hi);
            for (int a = 0; a < 3 && !apart; ++a)
                apart = hi[a] <= at[a] || lo[a] > at[a] + 1;
            assert_true(apart);
        }
        scalar[v] = 0;
    }
}

/* A few voxels are visible, and rays go through edges of invisible blocks, where a place is rounded to either side of
 * both faces: they end, with the result of a ray that skips no block. A walk that goes to and fro without end raises
 * the alarm. */
TEST(rays_along_edges_of_empty_blocks_end)
{
    enum { N = 32, COUNT = N * N * N, RAYS = 200000 };
    static float scalar[COUNT];
    float entries[8] = {0, 0, 0, 0, 1, 0.5f, 0.2f, 1};
    const iso_level level = {.geometry = iso_geometry_axis_aligned((size_t[]){N, N, N}, (double[]){1, 1, 1}),
                             .scalar = scalar,
                             .max = 1};
    const iso_view view = {.tf = {.count = 2, .lo = 0, .hi = 1, .entries = entries},
                           .shading = {.ambient = 1},
                           .step_voxels = 0.25};
    OWNED(iso_sampler) sampler;
    OWNED(iso_shown) shown;
    iso_empty_space empty, unknown = {.cells = {N + 1, N + 1, N + 1}};
    OWNED(iso_cell_scene) cells, all;
    iso_cell_ray_variant v[4];
    state_of_random = 5;
    for (int i = 0; i < 6; ++i)
        scalar[(size_t)random_in(0, COUNT)] = 1;
    assert_more_than((double)iso_cell_ray_variants(v), 0);
    assert_ok(iso_sampler_create(&sampler, &level, ISO_CODE_FIT, ISO_FROM_ON_THE_FLY, &err));
    assert_ok(iso_shown_create(&shown, &view.tf, NULL, &err));
    assert_ok(iso_empty_space_create(&empty, &level, &shown, NULL, NULL, 1, &err));
    assert_ok(iso_cell_scene_create(&cells, &sampler, &view, &shown, &empty, &err));
    assert_ok(iso_cell_scene_create(&all, &sampler, &view, &shown, &unknown, &err));
    alarm(120);
    for (int i = 0; i < RAYS; ++i) {
        const int along = i % 3;
        const double back = random_in(60, 300);
        double at[3], way[3], error[2], t0 = 0, t1 = INFINITY;
        for (int a = 0; a < 3; ++a) {
            at[a] = a == along ? random_in(0, N) : 4 * floor(random_in(1, N / 4)) - 0.5;
            way[a] = random_in(-1, 1);
        }
        const double length = sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
        for (int a = 0; a < 3; ++a) { /* the part in the box */
            way[a] /= length;
            at[a] -= back * way[a];
            t0 = fmax(t0, fmin(-at[a] / way[a], (N - at[a]) / way[a]));
            t1 = fmin(t1, fmax(-at[a] / way[a], (N - at[a]) / way[a]));
        }
        const iso_vec3 direction = iso_v3(way[0], way[1], way[2]);
        const iso_cell_ray ray = {iso_v3(at[0], at[1], at[2]), direction, iso_scale(direction, -1), t0, t1, 1e-9};
        const stretch passing = v[0].integrate(&cells, &ray, &error[0]), whole = v[0].integrate(&all, &ray, &error[1]);
        for (int c = 0; c < 3; ++c)
            assert_within(passing.color[c], whole.color[c], 1e-11);
        assert_within(exp(-passing.depth), exp(-whole.depth), 1e-11);
    }
    alarm(0);
    iso_empty_space_destroy(&empty);
}

/* An interval that ends on an entry that shows nothing stays empty; a bit farther it does not. */
TEST(intervals_end_at_the_entries_that_show_nothing)
{
    float entries[4 * 6] = {0};
    entries[4 * 3 + 3] = 1; /* shown: values above 2/5 and below 4/5 */
    const iso_tf_table tf = {.count = 6, .lo = 0, .hi = 5, .entries = entries};
    iso_shown s;
    assert_ok(iso_shown_create(&s, &tf, NULL, &err));
    assert_false(iso_shown_entries(&s, -3, 2));
    assert_true(iso_shown_entries(&s, -3, 2.001));
    assert_true(iso_shown_entries(&s, 3, 3));
    assert_true(iso_shown_entries(&s, 3.999, 9));
    assert_false(iso_shown_entries(&s, 4, 9));
    assert_false(iso_shown_values(&s, 0, 0));
    assert_true(iso_shown_values(&s, 0, 2)); /* widened by what a sum of products is rounded by */
    entries[4 * 5 + 3] = 1;
    iso_shown_destroy(&s);
    assert_ok(iso_shown_create(&s, &tf, NULL, &err));
    assert_true(iso_shown_entries(&s, 7, 9)); /* beyond the table its last entry holds */
    iso_shown_destroy(&s);
}

TEST(the_exponential_is_right_to_its_last_digits)
{
    for (int i = 0; i < 20000; ++i) {
        const double x = -40 + i * 0.0037;
        const lanes eight = lanes_exp(lanes_all(x));
        assert_true(eight[3] == lane_exp(x));
        assert_at_most(fabs(lane_exp(x) / exp(x) - 1), 5e-16);
    }
}

TEST_MAIN(NULL, NULL)
