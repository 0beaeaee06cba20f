/* SPDX-License-Identifier: MIT */
/* Palettes in the renderers: GL against the reference, and both against the directions that the palette stands for. */
#include "sampled.h"

#include "pyramid/palette_level.h"
#include "render/gl/raycaster.h"
#include "render/reference.h"
#include "volume/synthetic.h"

static iso_gl *gl;

typedef struct subject {
    iso_pyramid pyramid;
    iso_palette palette;
    iso_view view;
    float entries[8];
} subject;

/* A sphere's directions are all different; unequal sizes and spacings. */
static void subject_create(subject *s, size_t directions, bool orthographic)
{
    const size_t size[3] = {24, 33, 20};
    const double spacing[3] = {1, 0.8, 1.5};
    iso_field field = {.kind = ISO_FIELD_MARSCHNER_LOBB, .geometry = iso_geometry_axis_aligned(size, spacing)};
    iso_pyramid_options opt = iso_pyramid_defaults();
    iso_palette_options fit = iso_palette_defaults();
    OWNED(iso_direction_set) set;
    memset(s, 0, sizeof *s);
    opt.level_count = 1;
    opt.keep_float = true;
    s->pyramid = sampled_pyramid(&field, ISO_F32, &opt);
    iso_level *level = &s->pyramid.levels[0];
    assert_ok(
        iso_direction_set_create(&set, level->directions, NULL, iso_geometry_voxel_count(&level->geometry), &err));
    fit.swap_trials = 0;
    fit.directions = directions;
    assert_ok(iso_palette_fit(&set, &fit, &s->palette, NULL, &err));
    assert_ok(iso_level_attach_palette(level, opt.code, &s->palette, &err));

    double radius = iso_geometry_box_radius_mm(&level->geometry);
    iso_camera *c = &s->view.camera;
    c->forward = iso_normalize(iso_v3(1, 2, -0.7));
    c->right = iso_normalize(iso_cross(c->forward, iso_v3(0.1, 0, 1)));
    c->up = iso_cross(c->right, c->forward);
    c->orthographic = orthographic;
    c->half_height = orthographic ? 0.9 * radius : 0.3;
    c->position = iso_madd(iso_geometry_box_center_mm(&level->geometry), c->forward, -4 * radius);
    s->view.width = 40;
    s->view.height = 36;
    s->view.step_voxels = 0.6;
    s->view.light_count = 1;
    s->view.lights[0] = (iso_light){.direction = iso_normalize(iso_v3(-1, 0.5, 2)), .intensity = 1};
    s->view.shading = (iso_shading){.ambient = 0.3, .diffuse = 0.6, .specular = 0.3, .power = 20};
    const float ramp[8] = {1, 0.5f, 0.2f, 0, 0.4f, 0.9f, 1, 0.3f};
    memcpy(s->entries, ramp, sizeof ramp);
    s->view.tf = (iso_tf_table){.count = 2, .lo = level->min, .hi = level->max, .entries = s->entries};
}

static void subject_destroy(subject *s)
{
    iso_level_detach_palette(&s->pyramid.levels[0]);
    iso_palette_destroy(&s->palette);
    iso_pyramid_destroy(&s->pyramid);
}

static iso_image by_gl(const subject *s, iso_direction_source source, bool shade_table)
{
    iso_gl_options opt = iso_gl_defaults();
    iso_image image;
    opt.source = source;
    opt.shade_table = shade_table;
    assert_ok(iso_gl_render(gl, &s->pyramid.levels[0], s->pyramid.options.code, &s->view, &opt, &image, &err));
    return image;
}

static iso_image by_reference(const subject *s, iso_direction_source source)
{
    iso_reference_options opt = iso_reference_defaults();
    iso_image image;
    opt.quadrature = ISO_QUADRATURE_MIDPOINT;
    opt.source = source;
    assert_ok(iso_reference_render(&s->pyramid.levels[0], s->pyramid.options.code, &s->view, &opt, &image, NULL, &err));
    return image;
}

typedef struct difference {
    double max_abs, rmse, part_above; /* part of the values that differ by more than 2e-5 */
} difference;

/* Destroys both. */
static difference compare(iso_image a, iso_image b)
{
    difference d = {0, 0, 0};
    double count = 4 * (double)(a.width * a.height);
    for (size_t i = 0; i < 4 * a.width * a.height; ++i) {
        double e = fabs((double)a.rgba[i] - (double)b.rgba[i]);
        if (!(e <= d.max_abs))
            d.max_abs = e;
        d.rmse += e * e / count;
        d.part_above += !(e <= 2e-5) / count;
    }
    d.rmse = sqrt(d.rmse);
    iso_image_destroy(&a);
    iso_image_destroy(&b);
    return d;
}

/* Floats against doubles: as for the other sources, 2e-5. */
TEST(gl_agrees_with_the_reference)
{
    const size_t directions[] = {254, 1022}; /* 8 and 16 bits an index */
    for (int i = 0; i < 2; ++i) {
        OWNED(subject) s;
        subject_create(&s, directions[i], i);
        difference d = compare(by_gl(&s, ISO_FROM_PALETTE, false), by_reference(&s, ISO_FROM_PALETTE));
        assert_at_most(d.max_abs, 2e-5);
        /* A sample on a voxel's face, within a float's rounding, may take either voxel: some 1e5 samples, each within
         * 1e-5 voxels of a face with a chance of 6e-5. */
        d = compare(by_gl(&s, ISO_FROM_PALETTE_NEAREST, false), by_reference(&s, ISO_FROM_PALETTE_NEAREST));
        assert_at_most(d.part_above, 0.005);
        /* Power: the two sources are not the same, nor is another palette. */
        d = compare(by_gl(&s, ISO_FROM_PALETTE, false), by_reference(&s, ISO_FROM_PALETTE_NEAREST));
        assert_more_than(d.part_above, 0.05);
        float x = s.palette.xyz[3 * 7];
        s.palette.xyz[3 * 7] = -s.palette.xyz[3 * 8];
        s.palette.xyz[3 * 8] = x;
        iso_image turned = by_gl(&s, ISO_FROM_PALETTE, false);
        s.palette.xyz[3 * 8] = -s.palette.xyz[3 * 7];
        s.palette.xyz[3 * 7] = x;
        d = compare(turned, by_reference(&s, ISO_FROM_PALETTE));
        assert_more_than(d.max_abs, 2e-5);
    }
}

/* With an entry for every direction a palette is the floats. */
TEST(a_palette_of_all_directions_is_the_float_field)
{
    OWNED(subject) s;
    subject_create(&s, 32000, false);
    difference d = compare(by_reference(&s, ISO_FROM_PALETTE), by_reference(&s, ISO_FROM_FLOAT));
    /* Directions normalized again in floats (1e-7), up to 1 / eps = 100 times larger where eight of them cancel. */
    assert_at_most(d.max_abs, 1e-5);
    d = compare(by_gl(&s, ISO_FROM_PALETTE, false), by_gl(&s, ISO_FROM_FLOAT, false));
    assert_at_most(d.max_abs, 2e-5);
}

VALUES_TEST(more_entries_come_closer_to_the_floats)
{
    const size_t directions[] = {20, 254, 1022};
    double before = 1;
    for (int i = 0; i < 3; ++i) {
        OWNED(subject) s;
        subject_create(&s, directions[i], false);
        difference d = compare(by_reference(&s, ISO_FROM_PALETTE), by_reference(&s, ISO_FROM_FLOAT));
        assert_more_than(0.6 * before, d.rmse);
        before = d.rmse;
    }
}

/* Seen along one direction, the table of shades is the shading itself; in perspective it is not. */
TEST(shade_table_is_the_shading_for_a_viewer_far_away)
{
    for (int orthographic = 0; orthographic < 2; ++orthographic) {
        OWNED(subject) s;
        subject_create(&s, 254, orthographic);
        difference d = compare(by_gl(&s, ISO_FROM_PALETTE_NEAREST, true), by_gl(&s, ISO_FROM_PALETTE_NEAREST, false));
        /* Shades of an entry by doubles against floats, with n = d / sqrt(1 + eps^2) in the shader: eps is about one
         * step of an 8-bit code, 1/127^2 / 2 = 3e-5 of the shade. */
        if (orthographic)
            assert_at_most(d.max_abs, 1e-4);
        else
            assert_more_than(d.max_abs, 1e-4);
    }
}

TEST(a_level_without_palette_is_refused)
{
    OWNED(subject) s;
    subject_create(&s, 20, false);
    iso_level_detach_palette(&s.pyramid.levels[0]);
    iso_gl_options opt = iso_gl_defaults();
    iso_reference_options reference = iso_reference_defaults();
    iso_image image;
    opt.source = reference.source = ISO_FROM_PALETTE;
    assert_status(iso_gl_render(gl, &s.pyramid.levels[0], s.pyramid.options.code, &s.view, &opt, &image, &err),
                  ISO_E_RANGE);
    assert_status(iso_reference_render(&s.pyramid.levels[0], s.pyramid.options.code, &s.view, &reference, &image, NULL,
                                       &err),
                  ISO_E_RANGE);
}

static int setup(void **state)
{
    (void)state;
    iso_error err = {""};
    iso_status status = iso_gl_create(&gl, NULL, &err);
    if (status != ISO_OK)
        printf("%s\n", err.text);
    return status;
}

static int teardown(void **state)
{
    (void)state;
    iso_gl_destroy(gl);
    return 0;
}

TEST_MAIN(setup, teardown)
