/* SPDX-License-Identifier: MIT */
/* Mixed resolution on the GPU against the reference on the same bricks, and its seams. */
#include "test.h"
#include "gl.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/random.h"
#include "brick/pack.h"
#include "render/gl/bricks_gl.h"
#include "render/reference.h"
#include "volume/synthetic.h"

/* As in test_raycaster.c: floats. */
#define MAX_ABS 2e-5
#define RMSE 1e-6

typedef struct scene {
    iso_level level;
    iso_node_levels nodes;
    iso_view view;
    uint8_t levels[5 * 7 * 4];
} scene;

static void make_scene(scene *s, iso_field_kind kind)
{
    const double c = cos(0.4), d = sin(0.4);
    iso_geometry g = {.size = {40, 56, 33},
                      .origin_mm = {-17, 5, 40},
                      .box_index = {40, 56, 33},
                      .index_to_world = {{{c, -0.8 * d, 0}, {d, 0.8 * c, 0}, {0, 0, 1.7}}}};
    iso_field f = {.kind = kind, .geometry = g, .seed = 3};
    iso_volume v;
    iso_scene file;
    assert_ok(iso_field_sample(&f, ISO_F32, &v, &err));
    iso_volume_stats stats = iso_volume_measure(&v);
    *s = (scene){
        .level = {.geometry = g, .stored_type = ISO_F32, .scalar = v.data, .min = stats.min, .max = stats.max}};
    assert_ok(iso_node_levels_create(&s->nodes, &s->level, 8, 4, true, 0, &err));
    assert_ok(iso_scene_load("refscenes/marschner-lobb.scene.json", &file, &err));
    file.width = 64, file.height = 56;
    assert_ok(iso_scene_resolve(&file, &g, stats.min, stats.max, &s->view, &err));
    iso_scene_destroy(&file);
    iso_random random = {3};
    assert_int_equal(iso_brick_count(&s->nodes), sizeof s->levels);
    for (size_t i = 0; i < sizeof s->levels; ++i)
        s->levels[i] = (uint8_t)iso_random_below(&random, 4);
}

static void destroy_scene(scene *s)
{
    iso_view_destroy(&s->view);
    iso_node_levels_destroy(&s->nodes);
    free(s->level.scalar);
}

static double max_difference(const iso_image *a, const iso_image *b, double *rmse)
{
    double max = 0, sum = 0;
    size_t count = 4 * a->width * a->height;
    for (size_t i = 0; i < count; ++i) {
        double e = fabs((double)a->rgba[i] - (double)b->rgba[i]);
        if (!(e <= max))
            max = e;
        sum += e * e;
    }
    *rmse = sqrt(sum / (double)count);
    return max;
}

static iso_image reference(const iso_brick_field *f, const iso_view *view)
{
    iso_reference_options opt = iso_reference_defaults();
    opt.quadrature = ISO_QUADRATURE_MIDPOINT;
    iso_image image;
    assert_ok(iso_reference_render_bricks(f, view, &opt, &image, NULL, &err));
    return image;
}

static void random_layouts_agree_with_the_reference_in_every_loop(void **state)
{
    (void)state;
    static const iso_field_kind kinds[] = {ISO_FIELD_MARSCHNER_LOBB, ISO_FIELD_SPHERE};
    for (size_t k = 0; k < 2; ++k) {
        scene s;
        make_scene(&s, kinds[k]);
        for (int faces = ISO_FACES_BAKED; faces <= ISO_FACES_OWN; ++faces) {
            iso_brick_field f = {&s.nodes, s.levels, (iso_brick_faces)faces};
            iso_image b = reference(&f, &s.view);
            for (int skip = ISO_GL_SKIP_NEVER; skip <= ISO_GL_SKIP_ALWAYS; ++skip) {
                iso_gl_brick_options opt = iso_gl_brick_defaults();
                opt.cache_bits = 32;
                opt.skip = (iso_gl_skip)skip;
                iso_image a;
                double rmse;
                assert_ok(iso_gl_render_bricks(gl, &f, &s.view, &opt, &a, NULL, &err));
                double max = max_difference(&a, &b, &rmse);
                if (getenv("ISOSHADE_TEST_VERBOSE"))
                    printf("faces %d skip %d: max_abs %.2e rmse %.2e\n", faces, skip, max, rmse);
                /* Bricks on their own jump at their faces, and a sample that rounding puts on the other side takes
                 * the other value: there only the mean is bounded. */
                if (faces == ISO_FACES_BAKED)
                    assert_at_most(max, MAX_ABS);
                assert_at_most(rmse, faces == ISO_FACES_BAKED ? RMSE : 1e-3);
                iso_image_destroy(&a);
            }
            iso_image_destroy(&b);
        }
        destroy_scene(&s);
    }
}

/* 16 bits: half a step of 1/65535 a value through a TF of slope 30 and more. */
static void cache_of_16_bits_is_close(void **state)
{
    (void)state;
    scene s;
    make_scene(&s, ISO_FIELD_MARSCHNER_LOBB);
    iso_brick_field f = {&s.nodes, s.levels, ISO_FACES_BAKED};
    iso_image a, b = reference(&f, &s.view);
    iso_gl_brick_options opt = iso_gl_brick_defaults();
    double rmse;
    iso_node_levels_round(&s.nodes);
    assert_ok(iso_gl_render_bricks(gl, &f, &s.view, &opt, &a, NULL, &err));
    assert_at_most(max_difference(&a, &b, &rmse), 2e-3);
    assert_at_most(rmse, 1e-4);
    iso_image_destroy(&a);
    iso_image_destroy(&b);
    destroy_scene(&s);
}

static void bricks_all_at_the_finest_level_are_the_volume(void **state)
{
    (void)state;
    scene s;
    make_scene(&s, ISO_FIELD_SPHERE);
    memset(s.levels, 0, sizeof s.levels);
    s.view.light_count = 0; /* directions come from other filters */
    iso_brick_field f = {&s.nodes, s.levels, ISO_FACES_BAKED};
    iso_gl_brick_options opt = iso_gl_brick_defaults();
    iso_gl_options whole = iso_gl_defaults();
    iso_image a, b;
    double rmse;
    opt.cache_bits = 32;
    opt.shaded = false;
    whole.source = ISO_FROM_ON_THE_FLY;
    assert_ok(iso_gl_render_bricks(gl, &f, &s.view, &opt, &a, NULL, &err));
    assert_ok(iso_gl_render(gl, &s.level, ISO_CODE_SNORM, &s.view, &whole, &b, &err));
    assert_at_most(max_difference(&a, &b, &rmse), MAX_ABS);
    iso_image_destroy(&a);
    iso_image_destroy(&b);
    destroy_scene(&s);
}

static void a_cache_that_is_too_small_is_refused_and_coarser_bricks_fit_it(void **state)
{
    (void)state;
    scene s;
    make_scene(&s, ISO_FIELD_MARSCHNER_LOBB);
    memset(s.levels, 0, sizeof s.levels);
    iso_brick_field f = {&s.nodes, s.levels, ISO_FACES_BAKED};
    iso_gl_brick_options opt = iso_gl_brick_defaults();
    iso_gl_brick_stats stats;
    iso_image image;
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
    iso_image_destroy(&image);
    destroy_scene(&s);
}

/* Pages as if a texture had no more than a few slots a side: the same samples from other textures. z + page keeps fewer
 * bits of z: a hundred-thousandth of a texel here. */
static void pages_show_what_one_texture_shows(void **state)
{
    (void)state;
    scene s;
    make_scene(&s, ISO_FIELD_MARSCHNER_LOBB);
    iso_brick_field f = {&s.nodes, s.levels, ISO_FACES_BAKED};
    iso_gl_brick_options opt = iso_gl_brick_defaults();
    iso_gl_brick_stats stats;
    iso_image one, paged;
    double rmse;
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
            assert_at_most(max_difference(&one, &paged, &rmse), MAX_ABS);
            iso_image_destroy(&paged);
        }
    }
    assert_true(stats.page_count > 1);
    opt.page_side = stats.slot_side;
    assert_status(iso_gl_render_bricks(gl, &f, &s.view, &opt, &paged, &stats, &err), ISO_E_RANGE);
    iso_image_destroy(&one);
    destroy_scene(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_layouts_agree_with_the_reference_in_every_loop),
        cmocka_unit_test(cache_of_16_bits_is_close),
        cmocka_unit_test(bricks_all_at_the_finest_level_are_the_volume),
        cmocka_unit_test(pages_show_what_one_texture_shows),
        cmocka_unit_test(a_cache_that_is_too_small_is_refused_and_coarser_bricks_fit_it),
    };
    return cmocka_run_group_tests(tests, open_gl, close_gl);
}
