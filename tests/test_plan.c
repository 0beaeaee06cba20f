/* SPDX-License-Identifier: MIT */
/* The plan: what is hidden is left out, what is coarse stays within the error, more error means less model. */
#include "difference.h"
#include "test.h"

#include "brick/pack.h"
#include "plan/plan.h"
#include "render/reference.h"
#include "volume/synthetic.h"

typedef struct scene {
    iso_volume volume;
    iso_node_levels nodes;
    iso_view view;
} scene;

static void make_scene(scene *s, iso_field_kind kind)
{
    const size_t size[3] = {41, 44, 33};
    iso_field f = {.kind = kind,
                   .geometry = iso_geometry_axis_aligned(size, (const double[3]){1, 0.9, 1.2}),
                   .seed = 1};
    OWNED(iso_scene) file;
    assert_ok(iso_field_sample(&f, ISO_F32, &s->volume, &err));
    iso_volume_stats stats = iso_volume_measure(&s->volume);
    iso_level level = {.geometry = f.geometry, .scalar = s->volume.data, .min = stats.min, .max = stats.max};
    assert_ok(iso_node_levels_create(&s->nodes, &level, 8, 3, true, 0, &err));
    assert_ok(iso_scene_load("refscenes/shells.scene.json", &file, &err));
    file.width = 48, file.height = 40;
    assert_ok(iso_scene_resolve(&file, &f.geometry, stats.min, stats.max, &s->view, &err));
    s->view.step_voxels = 1;
}

static void destroy_scene(scene *s)
{
    iso_view_destroy(&s->view);
    iso_node_levels_destroy(&s->nodes);
    iso_volume_destroy(&s->volume);
}

static size_t nodes_of(const iso_plan_errors *p, const iso_node_levels *n)
{
    size_t count = 0;
    for (size_t i = 0; i < p->brick_count; ++i) {
        size_t side = iso_brick_side(n, p->levels[i]);
        count += p->shown[i] && p->footprints[i] > 0 ? side * side * side : 0;
    }
    return count;
}

static iso_image render(const iso_brick_field *f, const iso_view *view)
{
    iso_reference_options opt = iso_reference_defaults();
    opt.quadrature = ISO_QUADRATURE_MIDPOINT;
    iso_image image;
    assert_ok(iso_reference_render_bricks(f, view, &opt, &image, NULL, &err));
    return image;
}

/* The prediction knows nothing of cancellation along rays nor of baked faces: the measured error is within a factor
 * of four of it here, which the command's verification makes good. */
TEST(prediction_bounds_the_model_and_is_near_the_measured_error)
{
    ENDED_BY(destroy_scene) scene s;
    OWNED(iso_plan_errors) p;
    make_scene(&s, ISO_FIELD_SHELLS);
    assert_ok(iso_plan_errors_create(&p, &s.nodes, &s.view, 1, 0, NULL, &err));
    const iso_brick_field f = {.nodes = &s.nodes, .levels = p.levels};
    OWNED(iso_image) full = render(&f, &s.view);
    size_t last = SIZE_MAX;
    static const double wanted[] = {0, 1e-3, 4e-3, 1.6e-2, 6.4e-2};
    for (size_t i = 0; i < 5; ++i) {
        double predicted = iso_plan_choose(&p, &s.nodes, wanted[i]);
        OWNED(iso_image) image = render(&f, &s.view);
        double measured = difference_of(&image, &full).rmse;
        assert_at_most(predicted, wanted[i]);
        assert_true(nodes_of(&p, &s.nodes) <= last);
        if (getenv("ISOSHADE_TEST_VERBOSE"))
            printf("wanted %g: predicted %g, measured %g, %zu nodes\n", wanted[i], predicted, measured,
                   nodes_of(&p, &s.nodes));
        assert_at_most(measured, 4 * wanted[i] + 1e-4);
        last = nodes_of(&p, &s.nodes);
    }
    memset(p.levels, 2, p.brick_count); /* all coarse: such a model must be rejected */
    OWNED(iso_image) coarse = render(&f, &s.view);
    assert_more_than(difference_of(&coarse, &full).rmse, 0.02);
}

/* Wherever it is: of no voxel the plan may think that coarse bricks, which lose it, have it. */
TEST(a_voxel_alone_is_not_overlooked)
{
    const size_t size[3] = {17, 17, 17}, middle = 8 + 17 * (8 + 17 * 8);
    static float scalar[17 * 17 * 17];
    OWNED(iso_scene) file;
    assert_ok(iso_scene_load("refscenes/shells.scene.json", &file, &err));
    file.width = file.height = 24;
    for (size_t at = middle; at < middle + 4; ++at) {
        iso_level level = {.geometry = iso_geometry_axis_aligned(size, (const double[3]){1, 1, 1}),
                           .scalar = scalar,
                           .max = 1};
        ENDED_BY(destroy_scene) scene s = {0};
        OWNED(iso_plan_errors) p;
        memset(scalar, 0, sizeof scalar);
        scalar[at] = 1;
        assert_ok(iso_node_levels_create(&s.nodes, &level, 16, 3, true, 0, &err));
        assert_ok(iso_scene_resolve(&file, &level.geometry, 0, 1, &s.view, &err));
        for (size_t e = 0; e < s.view.tf.count; ++e)
            s.view.tf.entries[4 * e + 3] = e > s.view.tf.count * 3 / 4 ? 1 : 0;
        assert_ok(iso_plan_errors_create(&p, &s.nodes, &s.view, 1, 0, NULL, &err));
        iso_plan_choose(&p, &s.nodes, 1e-9);
        assert_int_equal(p.levels[0], 0);
    }
}

/* A step from 0 to 1 whose transfer function shows values near 1/4 alone: no voxel has one, and of level 1, whose value
 * half-way between its nodes is 1/2, none of level 0's places has one either. */
TEST(values_visible_only_between_voxels_are_not_overlooked)
{
    enum { SIDE = 17, STEP = 8 };
    static float scalar[SIDE * SIDE * SIDE];
    for (size_t i = 0; i < SIDE * SIDE * SIDE; ++i)
        scalar[i] = i % SIDE >= STEP;
    iso_level level = {.geometry = iso_geometry_axis_aligned((const size_t[3]){SIDE, SIDE, SIDE},
                                                             (const double[3]){1, 1, 1}),
                       .scalar = scalar,
                       .max = 1};
    OWNED(iso_scene) file;
    ENDED_BY(destroy_scene) scene s = {0};
    OWNED(iso_plan_errors) p;
    assert_ok(iso_scene_load("refscenes/shells.scene.json", &file, &err));
    file.width = file.height = 24;
    assert_ok(iso_node_levels_create(&s.nodes, &level, 16, 2, true, 0, &err));
    assert_ok(iso_scene_resolve(&file, &level.geometry, 0, 1, &s.view, &err));
    s.view.step_voxels = 1.0 / 16;
    for (size_t e = 0; e < s.view.tf.count; ++e) {
        const double value = (double)e / (double)(s.view.tf.count - 1);
        s.view.tf.entries[4 * e + 3] = fabs(value - 0.25) < 0.1 ? 1 : 0;
    }
    assert_ok(iso_plan_errors_create(&p, &s.nodes, &s.view, 1, 0, NULL, &err));
    const iso_brick_field f = {.nodes = &s.nodes, .levels = p.levels};
    OWNED(iso_image) full = render(&f, &s.view);
    p.levels[0] = 1;
    OWNED(iso_image) coarse = render(&f, &s.view);
    assert_more_than(difference_of(&coarse, &full).rmse, 0.01); /* a model that must be rejected */
    iso_plan_choose(&p, &s.nodes, 1e-3);
    assert_int_equal(p.levels[0], 0);
}

TEST(plan_does_not_depend_on_threads)
{
    ENDED_BY(destroy_scene) scene s;
    OWNED(iso_plan_errors) one, two;
    make_scene(&s, ISO_FIELD_NOISE);
    assert_ok(iso_plan_errors_create(&one, &s.nodes, &s.view, 1, 1, NULL, &err));
    assert_ok(iso_plan_errors_create(&two, &s.nodes, &s.view, 1, 2, NULL, &err));
    iso_plan_choose(&one, &s.nodes, 0.01);
    iso_plan_choose(&two, &s.nodes, 0.01);
    assert_memory_equal(one.levels, two.levels, one.brick_count);
    assert_memory_equal(one.squares, two.squares, one.brick_count * one.level_count * sizeof *one.squares);
    assert_memory_equal(one.footprints, two.footprints, one.brick_count * sizeof *one.footprints);
}

TEST(bricks_behind_the_opaque_and_outside_the_view_are_left_out)
{
    ENDED_BY(destroy_scene) scene s;
    OWNED(iso_plan_errors) p;
    make_scene(&s, ISO_FIELD_CONSTANT);
    for (size_t i = 0; i < s.view.tf.count; ++i)
        s.view.tf.entries[4 * i + 3] = 5; /* per mm: nothing is seen beyond 2 mm */
    s.view.camera.forward = iso_v3(1, 0, 0), s.view.camera.right = iso_v3(0, -1, 0), s.view.camera.up = iso_v3(0, 0, 1);
    s.view.camera.position = iso_v3(-100, 12, 0); /* looks at the half of larger y */
    s.view.camera.orthographic = true;
    s.view.camera.half_height = 8;
    assert_ok(iso_plan_errors_create(&p, &s.nodes, &s.view, 1, 0, NULL, &err));
    for (size_t i = 0; i < p.brick_count; ++i) {
        size_t x = i % s.nodes.count[0], y = i / s.nodes.count[0] % s.nodes.count[1];
        size_t z = i / (s.nodes.count[0] * s.nodes.count[1]);
        assert_int_equal(p.shown[i] != 0, p.footprints[i] > 0);
        if (x > 0 || y < 2)
            assert_within((double)p.footprints[i], 0, 0);
        else if (y == 4 && (z == 1 || z == 2))
            assert_more_than((double)p.footprints[i], 0);
    }
}

TEST_MAIN(NULL, NULL)
