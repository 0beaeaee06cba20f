/* SPDX-License-Identifier: MIT */
/* Mixed resolution by the CPU ray caster against the reference on the same bricks; the same bits from each instruction
 * set, each number of threads, and with empty space left out. */
#include "brick_scene.h"

#include <string.h>

#include "render/cpu/mixed.h"

/* Causes: floats of the filter's sums, of a place in the table, of colors and normals, as in test_cpu_caster.c; 2e-8
 * and 2e-7 were seen. A brick on another level is off by 1e-3 and more. */
#define RMSE 1e-7
#define MAX_ABS 2e-6

static iso_image draw(const iso_brick_field *f, const iso_view *view, iso_cpu_brick_options opt)
{
    iso_image image;
    assert_ok(iso_cpu_render_bricks(f, view, &opt, &image, &err));
    return image;
}

static iso_cpu_brick_options exact(void)
{
    iso_cpu_brick_options opt = iso_cpu_brick_defaults();
    opt.node_bits = 32;
    return opt;
}

static void expect_same_bits(const iso_brick_field *f, const iso_view *view, iso_cpu_brick_options opt,
                             const iso_image *image, const char *what)
{
    OWNED(iso_image) other = draw(f, view, opt);
    if (memcmp(image->rgba, other.rgba, 4 * image->width * image->height * sizeof(float)) != 0)
        fail_msg("%s: %g apart", what, difference_of(image, &other).max_abs);
}

/* The picture in every way that it can be made. */
static iso_image draw_in_all_ways(const iso_brick_field *f, const iso_view *view, iso_cpu_brick_options opt)
{
    static const iso_cpu_width widths[] = {ISO_CPU_ONE, ISO_CPU_BASELINE, ISO_CPU_AVX2, ISO_CPU_AVX512};
    opt.threads = 1;
    opt.skip = ISO_CPU_SKIP_NEVER;
    iso_image image = draw(f, view, opt);
    for (size_t i = 0; i < sizeof widths / sizeof *widths; ++i)
        for (int skip = ISO_CPU_SKIP_NEVER; skip <= ISO_CPU_SKIP_ALWAYS; ++skip) {
            if (widths[i] > iso_cpu_widest())
                continue;
            opt.width = widths[i];
            opt.threads = 1 + (int)i;
            opt.skip = (iso_cpu_skip)skip;
            expect_same_bits(f, view, opt, &image, iso_cpu_width_name(widths[i]));
        }
    return image;
}

static void expect_the_reference(const iso_brick_field *f, const iso_view *view, const char *what)
{
    OWNED(iso_image) truth = brick_reference(f, view), image = draw_in_all_ways(f, view, exact());
    const difference d = difference_of(&truth, &image);
    print_message("%-24s rmse %.2g, most %.2g\n", what, d.rmse, d.max_abs);
    /* Bricks on their own jump at their faces, and a sample that rounding puts on the other side takes the other value:
     * there only the mean is bounded. */
    if (f->faces == ISO_FACES_BAKED)
        assert_at_most(d.max_abs, MAX_ABS);
    assert_at_most(d.rmse, f->faces == ISO_FACES_BAKED ? RMSE : 1e-3);
}

VALUES_TEST(random_levels_agree_with_the_reference)
{
    static const iso_field_kind kinds[] = {ISO_FIELD_MARSCHNER_LOBB, ISO_FIELD_SPHERE};
    for (size_t k = 0; k < 2; ++k) {
        ENDED_BY(destroy_brick_scene) brick_scene s;
        make_brick_scene(&s, kinds[k]);
        for (int faces = ISO_FACES_BAKED; faces <= ISO_FACES_OWN; ++faces) {
            const iso_brick_field f = {&s.nodes, s.levels, (iso_brick_faces)faces};
            expect_the_reference(&f, &s.view, faces == ISO_FACES_BAKED ? "baked faces" : "faces of their own");
        }
    }
}

TEST(a_brick_of_another_level_is_seen)
{
    ENDED_BY(destroy_brick_scene) brick_scene s;
    make_brick_scene(&s, ISO_FIELD_MARSCHNER_LOBB);
    const iso_brick_field f = {&s.nodes, s.levels, ISO_FACES_BAKED};
    OWNED(iso_image) truth = brick_reference(&f, &s.view);
    const size_t middle = 2 + 5 * (3 + 7 * 2);
    s.levels[middle] = s.levels[middle] ? 0 : 2;
    OWNED(iso_image) image = draw(&f, &s.view, exact());
    const difference d = difference_of(&truth, &image);
    assert_more_than(d.max_abs, 1e-3);
    assert_more_than(d.rmse, 1e3 * RMSE);
}

TEST(views_may_be_cut_orthographic_unlit_or_from_inside)
{
    ENDED_BY(destroy_brick_scene) brick_scene s;
    make_brick_scene(&s, ISO_FIELD_SPHERE);
    const iso_brick_field f = {&s.nodes, s.levels, ISO_FACES_BAKED};
    const iso_camera camera = s.view.camera;
    s.view.clip_count = 1;
    const iso_vec3 normal = iso_normalize(iso_v3(1, 0.3, -0.2)),
                   middle = iso_geometry_to_world(&s.level.geometry, iso_v3(20, 28, 16));
    s.view.clips[0] = (iso_clip_plane){normal, iso_dot(normal, middle)};
    expect_the_reference(&f, &s.view, "clipped");
    s.view.clip_count = 0;
    s.view.camera.orthographic = true;
    s.view.camera.half_height = 0.6 * iso_geometry_box_radius_mm(&s.level.geometry);
    expect_the_reference(&f, &s.view, "orthographic");
    s.view.camera = camera;
    s.view.camera.position = middle;
    expect_the_reference(&f, &s.view, "from inside");
    s.view.camera = camera;
    s.view.light_count = 0;
    expect_the_reference(&f, &s.view, "not lit");
}

/* Planes along the grid that keep .7 voxels of the bricks on a face's other side, which are not left out for that. */
TEST(bricks_of_which_a_sliver_is_kept_are_drawn)
{
    static const iso_vec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const iso_vec3 face = {2 * 8 + 0.5, 3 * 8 + 0.5, 2 * 8 + 0.5};
    ENDED_BY(destroy_brick_scene) brick_scene s;
    make_brick_scene(&s, ISO_FIELD_SPHERE);
    const iso_brick_field f = {&s.nodes, s.levels, ISO_FACES_BAKED};
    s.view.clip_count = 1;
    for (int a = 0; a < 3; ++a)
        for (int side = -1; side <= 1; side += 2) {
            const iso_vec3 at = iso_geometry_to_world(&s.level.geometry, iso_madd(face, axes[a], -0.7 * side));
            const iso_vec3 normal = iso_normalize(iso_mul(s.level.geometry.index_to_world, iso_scale(axes[a], side)));
            s.view.clips[0] = (iso_clip_plane){normal, iso_dot(normal, at)};
            expect_the_reference(&f, &s.view, "a sliver");
        }
}

/* 16 bits: half a step of 1/65535 a value through a transfer function whose slope is 30 and more. */
TEST(nodes_of_16_bits_are_close)
{
    ENDED_BY(destroy_brick_scene) brick_scene s;
    make_brick_scene(&s, ISO_FIELD_MARSCHNER_LOBB);
    const iso_brick_field f = {&s.nodes, s.levels, ISO_FACES_BAKED};
    assert_ok(iso_node_levels_round(&s.nodes, 1, &err));
    OWNED(iso_image) truth = brick_reference(&f, &s.view);
    for (int shaded = 1; shaded >= 0; --shaded) {
        iso_cpu_brick_options opt = iso_cpu_brick_defaults();
        opt.shaded = shaded;
        s.view.light_count = shaded ? s.view.light_count : 0;
        OWNED(iso_image) unlit = shaded ? (iso_image){0} : brick_reference(&f, &s.view);
        OWNED(iso_image) image = draw_in_all_ways(&f, &s.view, opt);
        const difference d = difference_of(shaded ? &truth : &unlit, &image);
        assert_at_most(d.max_abs, 2e-3);
        assert_at_most(d.rmse, 1e-4);
    }
}

TEST(bricks_that_are_not_wanted_are_left_out)
{
    ENDED_BY(destroy_brick_scene) brick_scene s;
    uint8_t wanted[sizeof s.levels] = {0};
    make_brick_scene(&s, ISO_FIELD_SPHERE);
    const iso_brick_field f = {&s.nodes, s.levels, ISO_FACES_BAKED};
    iso_cpu_brick_options opt = exact();
    opt.wanted = wanted;
    iso_image image = draw_in_all_ways(&f, &s.view, opt);
    for (size_t i = 0; i < image.width * image.height; ++i)
        assert_true(image.rgba[4 * i + 3] == 0);
    iso_image_destroy(&image);
    double alpha[2] = {0, 0};
    for (size_t half = 0; half < 2; ++half) {
        for (size_t i = 0; i < sizeof wanted; ++i)
            wanted[i] = i < sizeof wanted / 2 || half;
        image = draw_in_all_ways(&f, &s.view, opt);
        for (size_t i = 0; i < image.width * image.height; ++i)
            alpha[half] += (double)image.rgba[4 * i + 3];
        iso_image_destroy(&image);
    }
    assert_more_than(alpha[0], 0.2 * alpha[1]);
    assert_more_than(alpha[1], 1.2 * alpha[0]);
}

/* Bricks of each size, of volumes that are a node thin, and as fine as the volume. */
TEST(sizes_may_be_odd)
{
    static const struct {
        size_t size[3], brick_voxels, level_count;
    } of[] = {{{9, 1, 13}, 2, 2}, {{1, 2, 5}, 4, 3}, {{33, 18, 3}, 16, 5}, {{20, 7, 11}, 64, 7}, {{17, 17, 17}, 4, 1}};
    ENDED_BY(destroy_brick_scene) brick_scene s;
    make_brick_scene(&s, ISO_FIELD_SPHERE);
    for (size_t k = 0; k < sizeof of / sizeof *of; ++k) {
        iso_geometry g = iso_geometry_axis_aligned(of[k].size, (const double[3]){1, 0.8, 1.7});
        const iso_field field = {.kind = ISO_FIELD_NOISE, .geometry = g, .seed = 5};
        OWNED(iso_volume) v;
        OWNED(iso_node_levels) n;
        OWNED(iso_scene) file;
        OWNED(iso_view) view;
        char what[64];
        assert_ok(iso_field_sample(&field, ISO_F32, &v, &err));
        const iso_volume_stats stats = iso_volume_measure(&v);
        const iso_level level = {
            .geometry = g, .stored_type = ISO_F32, .scalar = v.data, .min = stats.min, .max = stats.max};
        assert_ok(iso_node_levels_create(&n, &level, of[k].brick_voxels, of[k].level_count, true, 0, &err));
        assert_ok(iso_scene_load("refscenes/marschner-lobb.scene.json", &file, &err));
        file.width = 33, file.height = 21;
        assert_ok(iso_scene_resolve(&file, &g, stats.min, stats.max, &view, &err));
        FREED uint8_t *levels = malloc(iso_brick_count(&n));
        assert_non_null(levels);
        for (size_t i = 0; i < iso_brick_count(&n); ++i)
            levels[i] = (uint8_t)(i * 7 % of[k].level_count);
        snprintf(what, sizeof what, "%zu x %zu x %zu in %zu", of[k].size[0], of[k].size[1], of[k].size[2],
                 of[k].brick_voxels);
        expect_the_reference(&(iso_brick_field){&n, levels, ISO_FACES_BAKED}, &view, what);
    }
}

TEST(what_it_lacks_is_refused)
{
    ENDED_BY(destroy_brick_scene) brick_scene s;
    iso_image image;
    make_brick_scene(&s, ISO_FIELD_SPHERE);
    const iso_brick_field f = {&s.nodes, s.levels, ISO_FACES_BAKED};
    iso_cpu_brick_options opt = exact();
    opt.node_bits = 8;
    assert_status(iso_cpu_render_bricks(&f, &s.view, &opt, &image, &err), ISO_E_RANGE);
    opt = exact();
    opt.step_voxels = INFINITY;
    assert_status(iso_cpu_render_bricks(&f, &s.view, &opt, &image, &err), ISO_E_RANGE);
}

TEST_MAIN(NULL, NULL)
