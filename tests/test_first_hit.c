/* SPDX-License-Identifier: MIT */
/* First-hit isosurfaces by OpenGL: the reference's hits, on one texture and on bricks, and no steps where bricks
 * meet. */
#include "brick_scene.h"
#include "gl.h"

#include "render/gl/bricks_gl.h"

static double iso; /* the surface */

static iso_camera orthographic(iso_vec3 position, iso_vec3 forward, iso_vec3 up, double half_height)
{
    iso_camera c = {.orthographic = true, .position = position, .forward = forward, .half_height = half_height};
    c.right = iso_normalize(iso_cross(forward, up));
    c.up = iso_cross(c.right, c.forward);
    return c;
}

static void enlarge(iso_scene *file)
{
    file->width = 96, file->height = 80;
}

static void make_scene(brick_scene *s, size_t level_count)
{
    make_changed_brick_scene(s, ISO_FIELD_MARSCHNER_LOBB, level_count, enlarge);
    iso = s->level.min + 0.6 * (s->level.max - s->level.min);
}

/* Of pixels that both hit, by their largest component; and those that one alone hits. */
typedef struct hits {
    double worst, p99;
    size_t hits, apart;
} hits;

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static hits compare(const iso_image *a, const iso_image *b)
{
    hits d = {0};
    const size_t count = a->width * a->height;
    double *each = calloc(count, sizeof *each);
    assert_non_null(each);
    for (size_t i = 0; i < count; ++i) {
        const float *p = a->rgba + 4 * i, *q = b->rgba + 4 * i;
        if (!(p[3] == q[3])) {
            ++d.apart;
            continue;
        }
        if (p[3] < 0.5f)
            continue;
        double worst = 0;
        for (int c = 0; c < 3; ++c) {
            double e = fabs((double)p[c] - (double)q[c]);
            worst = e <= worst ? worst : e;
        }
        each[d.hits++] = worst;
    }
    qsort(each, d.hits, sizeof *each, ascending);
    if (d.hits) {
        d.worst = each[d.hits - 1];
        d.p99 = each[(size_t)(0.99 * (double)(d.hits - 1))];
    }
    free(each);
    return d;
}

static const char *const output_names[] = {"color", "position", "normal"};

/* Both renderers on the same field: bricks, or a level of the pyramid. */
static hits measure(brick_scene *s, const iso_brick_field *bricks, size_t level, iso_surface_output output,
                    double gl_iso)
{
    iso_surface surface = {.iso = gl_iso, .output = output};
    iso_reference_options exact = iso_reference_defaults();
    OWNED(iso_image) a, b;
    exact.quadrature = ISO_QUADRATURE_FIRST_HIT;
    exact.iso = iso;
    exact.output = output;
    if (bricks) {
        iso_gl_brick_options opt = iso_gl_brick_defaults();
        opt.cache_bits = 32;
        opt.surface = &surface;
        assert_ok(iso_gl_render_bricks(gl, bricks, &s->view, &opt, &a, NULL, &err));
        assert_ok(iso_reference_render_bricks(bricks, &s->view, &exact, &b, NULL, &err));
    } else {
        iso_gl_options opt = iso_gl_defaults();
        opt.surface = &surface;
        assert_ok(iso_gl_render(gl, &s->pyramid.levels[level], ISO_CODE_SNORM, &s->view, &opt, &a, &err));
        assert_ok(iso_reference_render(&s->pyramid.levels[level], ISO_CODE_SNORM, &s->view, &exact, &b, NULL, &err));
    }
    hits d = compare(&a, &b);
    if (getenv("ISOSHADE_TEST_VERBOSE"))
        printf("%s %s: %zu hits, worst %.2e, 99 %% %.2e, %zu apart\n", bricks ? "bricks" : "level",
               output_names[output], d.hits, d.worst, d.p99, d.apart);
    return d;
}

TEST(hits_on_one_texture_are_the_reference_s)
{
    ENDED_BY(destroy_brick_scene) brick_scene s;
    make_scene(&s, 2);
    for (size_t level = 0; level < 2; ++level) {
        hits d = measure(&s, NULL, level, ISO_SURFACE_POSITION, iso);
        /* Places are floats: 1e-5 voxels, times up to ten where the surface is glancing; more in single pixels. */
        assert_at_most(d.p99, 1e-4);
        assert_at_most(d.worst, 1e-2);
        assert_more_than((double)d.hits, 1000);
        assert_at_most((double)d.apart, 3); /* rays that graze */
        d = measure(&s, NULL, level, ISO_SURFACE_COLOR, iso);
        assert_at_most(d.p99, 2e-5);
        assert_at_most(d.worst, 2e-3);
    }
    assert_at_most(measure(&s, NULL, 0, ISO_SURFACE_NORMAL, iso).p99, 1e-4);
    /* A surface a thousandth of the range further is not taken for it. */
    const double range = s.pyramid.levels[0].max - s.pyramid.levels[0].min;
    assert_more_than(measure(&s, NULL, 0, ISO_SURFACE_POSITION, iso + 1e-3 * range).p99, 1e-3);
}

TEST(hits_on_bricks_of_random_levels_are_the_reference_s)
{
    ENDED_BY(destroy_brick_scene) brick_scene s;
    make_scene(&s, 1);
    const iso_brick_field baked = {&s.nodes, s.levels, ISO_FACES_BAKED};
    hits d = measure(&s, &baked, 0, ISO_SURFACE_POSITION, iso);
    assert_at_most(d.p99, 2e-4); /* as above; floats of the cache's coordinates besides */
    assert_at_most(d.worst, 1e-2);
    assert_more_than((double)d.hits, 1000);
    assert_at_most((double)d.apart, 3);
    d = measure(&s, &baked, 0, ISO_SURFACE_NORMAL, iso);
    assert_at_most(d.p99, 2e-4);
}

/* One plane of voxels, seen at an angle, thinner than a step of any marching: each ray has to meet it. */
TEST(a_sheet_of_one_voxel_has_no_holes)
{
    enum { n = 32 };
    FREED float *scalar = calloc(n * n * n, sizeof *scalar);
    FREED uint8_t *codes = calloc(n * n * n, 3);
    assert_non_null(scalar);
    for (size_t i = 0; i < n * n; ++i)
        scalar[n * n * (n / 2) + i] = 1;
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){n, n, n}, (double[]){1, 1, 1});
    const iso_level level = {.geometry = g, .stored_type = ISO_F32, .scalar = scalar, .codes = codes, .max = 1};
    static float white[8] = {1, 1, 1, 1, 1, 1, 1, 1};
    iso_view view = {.width = 48,
                     .height = 48,
                     .tf = {.count = 2, .hi = 1, .entries = white},
                     .shading = {.ambient = 1}};
    const iso_vec3 forward = iso_normalize(iso_v3(0.3, 0.4, -1));
    view.camera = orthographic(iso_madd(iso_geometry_box_center_mm(&g), forward, -60), forward, iso_v3(0, 1, 0), 8);
    const iso_surface surface = {.iso = 0.999};
    iso_gl_options opt = iso_gl_defaults();
    OWNED(iso_image) image;
    opt.surface = &surface;
    assert_ok(iso_gl_render(gl, &level, ISO_CODE_SNORM, &view, &opt, &image, &err));
    for (size_t i = 0; i < image.width * image.height; ++i)
        assert_within((double)image.rgba[4 * i + 3], 1, 0);
}

/* Two columns of rays, a two-thousandth of a voxel to both sides of a plane where bricks meet: the x axis is stretched,
 * so that pixels are narrow along it alone. Returns the part of the pairs whose places differ by more than `slack`
 * voxels, and the largest difference of normals among the others' in *turn. */
static double steps_across_faces(const brick_scene *s, iso_node_levels *nodes, iso_brick_faces faces, double slack,
                                 double *turn)
{
    const iso_brick_field f = {nodes, s->levels, faces};
    size_t apart = 0, pairs = 0;
    *turn = 0;
    for (size_t face = 1; face < nodes->count[0]; ++face) {
        iso_view view = s->view;
        const iso_geometry *g = &nodes->geometry;
        const iso_vec3 middle = {8.0 * (double)face + 0.5, 28, 60};
        view.width = 2, view.height = 112;
        view.camera = orthographic(iso_geometry_to_world(g, middle), iso_v3(0, 0, -1), iso_v3(0, 1, 0), 28);
        iso_image images[2];
        for (int k = 0; k < 2; ++k) {
            const iso_surface surface = {.iso = iso, .output = k ? ISO_SURFACE_NORMAL : ISO_SURFACE_POSITION};
            iso_gl_brick_options opt = iso_gl_brick_defaults();
            opt.surface = &surface;
            opt.cache_bits = 32;
            assert_ok(iso_gl_render_bricks(gl, &f, &view, &opt, &images[k], NULL, &err));
        }
        for (size_t row = 0; row < view.height; ++row) {
            const float *p = images[0].rgba + 8 * row, *n = images[1].rgba + 8 * row;
            if ((p[3] == 0 && p[7] == 0) || (p[2] > 32.99f && p[6] > 32.99f))
                continue; /* both pass, or are inside from the box's face on */
            ++pairs;
            if (!(p[3] == p[7] && fabs((double)p[2] - (double)p[6]) <= slack)) {
                ++apart;
                continue;
            }
            for (int c = 0; c < 3; ++c)
                *turn = fmax(*turn, fabs((double)n[c] - (double)n[4 + c]));
        }
        iso_image_destroy(&images[0]);
        iso_image_destroy(&images[1]);
    }
    assert_more_than((double)pairs, 50);
    return (double)apart / (double)pairs;
}

TEST(surfaces_do_not_step_where_bricks_meet)
{
    ENDED_BY(destroy_brick_scene) brick_scene s;
    OWNED(iso_node_levels) nodes;
    make_scene(&s, 1);
    iso_level level = s.pyramid.levels[0];
    level.geometry.index_to_world = (iso_mat3){{{1000, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    assert_ok(iso_node_levels_create(&nodes, &level, 8, 4, true, 0, &err));
    /* Half a thousandth of a voxel apart on a surface as steep as 20: 0.01. */
    double turn[2], baked = steps_across_faces(&s, &nodes, ISO_FACES_BAKED, 0.01, &turn[0]);
    double own = steps_across_faces(&s, &nodes, ISO_FACES_OWN, 0.01, &turn[1]);
    printf("pairs of rays whose hits are apart: baked %.4f, on their own %.4f; normals turn by %.2e and %.2e\n", baked,
           own, turn[0], turn[1]);
    assert_at_most(baked, 0.005); /* glancing rays */
    assert_more_than(own, 0.3);
    assert_more_than(turn[1], 10 * turn[0]);
}

TEST_MAIN(open_gl, close_gl)
