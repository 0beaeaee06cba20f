/* SPDX-License-Identifier: MIT */
/* Clip planes: a slab's closed form, the ray caster against the reference, bricks that are left out. */
#include "brick_scene.h"
#include "gl.h"

#include "render/gl/bricks_gl.h"

static void cut(iso_scene *file)
{
    file->width = 72, file->height = 60;
    file->clip_count = 2;
    file->clips[0].normal = iso_normalize(iso_v3(0.2, 1, 0.3));
    file->clips[0].at = 0.45;
    file->clips[1].normal = iso_v3(-1, 0, 0);
    file->clips[1].at = 0.5;
}

static void make_scene(brick_scene *s)
{
    make_changed_brick_scene(s, ISO_FIELD_MARSCHNER_LOBB, 1, cut);
}

/* As in test_raycaster.c: floats; the cut is where the segments are clipped. */
#define MAX_ABS 2e-5

TEST(cut_images_agree_with_the_reference_and_with_no_other_plane)
{
    ENDED_BY(destroy_brick_scene) brick_scene s;
    make_scene(&s);
    const iso_level *level = &s.pyramid.levels[0];
    iso_reference_options exact = iso_reference_defaults();
    iso_image a, b, whole;
    exact.quadrature = ISO_QUADRATURE_MIDPOINT;
    assert_ok(iso_reference_render(level, ISO_CODE_SNORM, &s.view, &exact, &b, NULL, &err));
    for (int skip = ISO_GL_SKIP_NEVER; skip <= ISO_GL_SKIP_ALWAYS; ++skip) {
        iso_gl_options opt = iso_gl_defaults();
        opt.skip = (iso_gl_skip)skip;
        assert_ok(iso_gl_render(gl, level, ISO_CODE_SNORM, &s.view, &opt, &a, &err));
        assert_at_most(difference_of(&a, &b).max_abs, MAX_ABS);
        iso_image_destroy(&a);
    }
    /* A plane that is a hundredth of a voxel off is seen. */
    iso_view moved = s.view;
    moved.clips[0].offset_mm += 0.01;
    iso_gl_options opt = iso_gl_defaults();
    assert_ok(iso_gl_render(gl, level, ISO_CODE_SNORM, &moved, &opt, &a, &err));
    assert_more_than(difference_of(&a, &b).max_abs, 5 * MAX_ABS);
    moved.clip_count = 0;
    assert_ok(iso_gl_render(gl, level, ISO_CODE_SNORM, &moved, &opt, &whole, &err));
    assert_more_than(difference_of(&whole, &b).max_abs, 0.1);
    iso_image_destroy(&whole);
    iso_image_destroy(&a);
    iso_image_destroy(&b);
}

TEST(bricks_behind_the_planes_are_left_out_and_change_nothing)
{
    ENDED_BY(destroy_brick_scene) brick_scene s;
    make_scene(&s);
    const iso_brick_field f = {&s.nodes, s.levels, ISO_FACES_BAKED};
    iso_reference_options exact = iso_reference_defaults();
    iso_gl_brick_options opt = iso_gl_brick_defaults();
    iso_gl_brick_stats cut, whole;
    iso_image a, b;
    exact.quadrature = ISO_QUADRATURE_MIDPOINT;
    opt.cache_bits = 32;
    assert_ok(iso_gl_render_bricks(gl, &f, &s.view, &opt, &a, &cut, &err));
    assert_ok(iso_reference_render_bricks(&f, &s.view, &exact, &b, NULL, &err));
    assert_at_most(difference_of(&a, &b).max_abs, MAX_ABS);
    iso_image_destroy(&a);
    iso_image_destroy(&b);
    const iso_surface surface = {.iso = 0.6 * s.nodes.max + 0.4 * s.nodes.min};
    exact.quadrature = ISO_QUADRATURE_FIRST_HIT;
    exact.iso = surface.iso;
    opt.surface = &surface;
    assert_ok(iso_gl_render_bricks(gl, &f, &s.view, &opt, &a, NULL, &err));
    assert_ok(iso_reference_render_bricks(&f, &s.view, &exact, &b, NULL, &err));
    assert_at_most(difference_of(&a, &b).max_abs, 2e-3); /* glancing hits: tests/test_first_hit.c */
    iso_image_destroy(&a);
    iso_image_destroy(&b);
    opt.surface = NULL;
    s.view.clip_count = 0;
    assert_ok(iso_gl_render_bricks(gl, &f, &s.view, &opt, &a, &whole, &err));
    printf("bricks shown: %zu cut, %zu whole\n", cut.shown_count, whole.shown_count);
    assert_true(cut.shown_count < whole.shown_count * 6 / 10);
    iso_image_destroy(&a);
}

TEST(a_slab_cut_at_an_angle_has_its_closed_form)
{
    enum { n = 8 };
    float scalar[n * n * n], entries[8] = {1, 1, 1, 0.3f, 1, 1, 1, 0.3f};
    uint8_t codes[3 * n * n * n] = {0};
    for (int i = 0; i < n * n * n; ++i)
        scalar[i] = 0.5f;
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){n, n, n}, (double[]){1, 1, 1});
    const iso_level level = {.geometry = g, .stored_type = ISO_F32, .scalar = scalar, .codes = codes, .max = 1};
    iso_view view = {.width = 16,
                     .height = 16,
                     .tf = {.count = 2, .hi = 1, .entries = entries},
                     .shading = {.ambient = 1},
                     .step_voxels = 0.7,
                     .clip_count = 1};
    view.camera = (iso_camera){.orthographic = true,
                               .position = {0, 0, 20},
                               .forward = {0, 0, -1},
                               .right = {1, 0, 0},
                               .up = {0, 1, 0},
                               .half_height = 3};
    view.clips[0] = (iso_clip_plane){iso_normalize(iso_v3(1, 0, -2)), 0}; /* z <= x / 2 stays, of -4 <= z <= 4 */
    iso_reference_options exact = iso_reference_defaults();
    iso_gl_options opt = iso_gl_defaults();
    iso_image images[2];
    assert_ok(iso_reference_render(&level, ISO_CODE_SNORM, &view, &exact, &images[0], NULL, &err));
    assert_ok(iso_gl_render(gl, &level, ISO_CODE_SNORM, &view, &opt, &images[1], &err));
    for (size_t i = 0; i < 256; ++i) {
        const double x = 3 * (2 * ((double)(i % 16) + 0.5) / 16 - 1), alpha = 1 - exp(-(double)0.3f * (4 + x / 2));
        assert_within((double)images[0].rgba[4 * i + 3], alpha, 1e-7); /* the image is of floats */
        assert_within((double)images[1].rgba[4 * i + 3], alpha, 2e-6);
    }
    iso_image_destroy(&images[0]);
    iso_image_destroy(&images[1]);
}

TEST(planes_that_leave_nothing_of_a_box_are_told)
{
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){4, 4, 4}, (double[]){2, 1, 1}); /* x from -4 to 4 mm */
    const iso_view view = {.clip_count = 1, .clips = {{.normal = {1, 0, 0}, .offset_mm = 1}}};
    const double lo[3] = {0, 0, 0}, below[3] = {2.4, 4, 4}, above[3] = {2.6, 4, 4};
    assert_false(iso_view_keeps(&view, &g, lo, below));
    assert_true(iso_view_keeps(&view, &g, lo, above));
}

TEST_MAIN(open_gl, close_gl)
