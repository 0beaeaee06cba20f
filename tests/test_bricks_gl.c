/* SPDX-License-Identifier: MIT */
/* Mixed resolution on the GPU against the reference on the same bricks, and its seams. */
#include "brick_scene.h"
#include "gl.h"

#include <string.h>

#include "brick/pack.h"
#include "render/gl/bricks_gl.h"

/* As in test_raycaster.c: floats. */
#define MAX_ABS 2e-5
#define RMSE 1e-6

TEST(random_layouts_agree_with_the_reference_in_every_loop)
{
    static const iso_field_kind kinds[] = {ISO_FIELD_MARSCHNER_LOBB, ISO_FIELD_SPHERE};
    for (size_t k = 0; k < 2; ++k) {
        ENDED_BY(destroy_brick_scene) brick_scene s;
        make_brick_scene(&s, kinds[k]);
        for (int faces = ISO_FACES_BAKED; faces <= ISO_FACES_OWN; ++faces) {
            iso_brick_field f = {&s.nodes, s.levels, (iso_brick_faces)faces};
            OWNED(iso_image) b = brick_reference(&f, &s.view);
            for (int skip = ISO_GL_SKIP_NEVER; skip <= ISO_GL_SKIP_ALWAYS; ++skip) {
                iso_gl_brick_options opt = iso_gl_brick_defaults();
                opt.cache_bits = 32;
                opt.skip = (iso_gl_skip)skip;
                OWNED(iso_image) a;
                assert_ok(iso_gl_render_bricks(gl, &f, &s.view, &opt, &a, NULL, &err));
                const difference d = difference_of(&a, &b);
                if (getenv("ISOSHADE_TEST_VERBOSE"))
                    printf("faces %d skip %d: max_abs %.2e rmse %.2e\n", faces, skip, d.max_abs, d.rmse);
                /* Bricks on their own jump at their faces, and a sample that rounding puts on the other side takes
                 * the other value: there only the mean is bounded. */
                if (faces == ISO_FACES_BAKED)
                    assert_at_most(d.max_abs, MAX_ABS);
                assert_at_most(d.rmse, faces == ISO_FACES_BAKED ? RMSE : 1e-3);
            }
        }
    }
}

/* 16 bits: half a step of 1/65535 a value through a TF of slope 30 and more. */
TEST(cache_of_16_bits_is_close)
{
    ENDED_BY(destroy_brick_scene) brick_scene s;
    make_brick_scene(&s, ISO_FIELD_MARSCHNER_LOBB);
    iso_brick_field f = {&s.nodes, s.levels, ISO_FACES_BAKED};
    OWNED(iso_image) a, b = brick_reference(&f, &s.view);
    iso_gl_brick_options opt = iso_gl_brick_defaults();
    assert_ok(iso_node_levels_round(&s.nodes, 1, &err));
    assert_ok(iso_gl_render_bricks(gl, &f, &s.view, &opt, &a, NULL, &err));
    const difference d = difference_of(&a, &b);
    assert_at_most(d.max_abs, 2e-3);
    assert_at_most(d.rmse, 1e-4);
}

TEST(bricks_all_at_the_finest_level_are_the_volume)
{
    ENDED_BY(destroy_brick_scene) brick_scene s;
    make_brick_scene(&s, ISO_FIELD_SPHERE);
    memset(s.levels, 0, sizeof s.levels);
    s.view.light_count = 0; /* directions come from other filters */
    iso_brick_field f = {&s.nodes, s.levels, ISO_FACES_BAKED};
    iso_gl_brick_options opt = iso_gl_brick_defaults();
    iso_gl_options whole = iso_gl_defaults();
    OWNED(iso_image) a, b;
    opt.cache_bits = 32;
    opt.shaded = false;
    whole.source = ISO_FROM_ON_THE_FLY;
    assert_ok(iso_gl_render_bricks(gl, &f, &s.view, &opt, &a, NULL, &err));
    assert_ok(iso_gl_render(gl, &s.level, ISO_CODE_SNORM, &s.view, &whole, &b, &err));
    assert_at_most(difference_of(&a, &b).max_abs, MAX_ABS);
}

TEST(a_cache_that_is_too_small_is_refused_and_coarser_bricks_fit_it)
{
    ENDED_BY(destroy_brick_scene) brick_scene s;
    make_brick_scene(&s, ISO_FIELD_MARSCHNER_LOBB);
    memset(s.levels, 0, sizeof s.levels);
    iso_brick_field f = {&s.nodes, s.levels, ISO_FACES_BAKED};
    iso_gl_brick_options opt = iso_gl_brick_defaults();
    iso_gl_brick_stats stats;
    OWNED(iso_image) image;
    opt.max_slots = 30;
    opt.keep_hidden = true;
    assert_status(iso_gl_render_bricks(gl, &f, &s.view, &opt, &image, &stats, &err), ISO_E_RANGE);
    for (size_t i = 0; i < sizeof s.levels; i += 2)
        s.levels[i] = 1;
    for (size_t i = 1; i < sizeof s.levels; i += 2)
        s.levels[i] = i % 16 == 1 ? 0 : 2;
    assert_ok(iso_gl_render_bricks(gl, &f, &s.view, &opt, &image, &stats, &err));
    assert_true(stats.slot_count <= 30);
    assert_int_equal(stats.shown_count, sizeof s.levels);
}

/* Pages as if a texture had no more than a few slots a side: the same samples from other textures. z + page keeps fewer
 * bits of z: a hundred-thousandth of a texel here. */
TEST(pages_show_what_one_texture_shows)
{
    ENDED_BY(destroy_brick_scene) brick_scene s;
    make_brick_scene(&s, ISO_FIELD_MARSCHNER_LOBB);
    iso_brick_field f = {&s.nodes, s.levels, ISO_FACES_BAKED};
    iso_gl_brick_options opt = iso_gl_brick_defaults();
    iso_gl_brick_stats stats;
    iso_image one, paged;
    opt.cache_bits = 32;
    opt.keep_hidden = true;
    assert_ok(iso_gl_render_bricks(gl, &f, &s.view, &opt, &one, &stats, &err));
    assert_int_equal(stats.page_count, 1);
    for (size_t side = 4; side >= 3; --side) {
        opt.page_side = side * stats.slot_side;
        for (int skip = ISO_GL_SKIP_NEVER; skip <= ISO_GL_SKIP_ALWAYS; ++skip) {
            opt.skip = (iso_gl_skip)skip;
            assert_ok(iso_gl_render_bricks(gl, &f, &s.view, &opt, &paged, &stats, &err));
            assert_true(stats.page_count == (stats.slot_count - 1) / (side * side * side) + 1);
            assert_at_most(difference_of(&one, &paged).max_abs, MAX_ABS);
            iso_image_destroy(&paged);
        }
    }
    assert_true(stats.page_count > 1);
    opt.page_side = stats.slot_side;
    assert_status(iso_gl_render_bricks(gl, &f, &s.view, &opt, &paged, &stats, &err), ISO_E_RANGE);
    iso_image_destroy(&one);
}

TEST_MAIN(open_gl, close_gl)
