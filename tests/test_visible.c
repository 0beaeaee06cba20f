/* SPDX-License-Identifier: MIT */
/* test_visible.c - shares of voxels, faces and pictures with known values, and their messages. */
#include "test.h"

#include "pyramid/value_table.h"
#include "scene/visible.h"

/* A volume of 20 x 10 x 10 voxels of 2 x 1 x 1 mm: its longest side is 40 mm, its mean side 20 mm. */
enum { NX = 20, NY = 10, NZ = 10, COUNT = NX * NY * NZ };
static const double longest_mm = 40, mean_mm = 20;

typedef struct subject {
    float scalar[COUNT], entries[8];
    iso_level level;
    iso_view view;
} subject;

/* All values 0; the TF is a line of extinction from 0 at 0 to `extinction` at 1. The camera looks along y and frames
 * the box with as much again around it, along its side of 40 mm: it is 1/8 of the picture. */
static void set_up(subject *s, double extinction)
{
    *s = (subject){.entries = {1, 1, 1, 0, 1, 1, 1, (float)extinction}};
    s->level.geometry = iso_geometry_axis_aligned((const size_t[]){NX, NY, NZ}, (const double[]){2, 1, 1});
    s->level.scalar = s->scalar;
    s->level.max = 1;
    s->view = (iso_view){.width = 64, .height = 64, .tf = {2, 0, 1, s->entries}};
    s->view.camera = (iso_camera){.orthographic = true,
                                  .position = {0, -100, 0},
                                  .forward = {0, 1, 0},
                                  .right = {1, 0, 0},
                                  .up = {0, 0, 1},
                                  .half_height = 40};
}

static size_t index_of(size_t x, size_t y, size_t z)
{
    return x + NX * (y + NY * z);
}

TEST(voxels_are_counted_from_the_threshold_on)
{
    subject s;
    set_up(&s, 1);
    const double threshold = -log1p(-1.0 / 255) / longest_mm; /* extinction and value are the same here */
    for (size_t i = 0; i < 7; ++i)
        s.scalar[index_of(3 + i, 4, 5)] = (float)(1.001 * threshold);
    for (size_t i = 0; i < 5; ++i)
        s.scalar[index_of(3 + i, 6, 5)] = (float)(0.999 * threshold);
    const iso_visible v = iso_visible_measure(&s.level, &s.view, NULL, 1);
    assert_within(v.voxels, 7.0 / COUNT, 1e-15);
    assert_within(v.shown_min, 1, 1e-6); /* of two entries the second is the first that is shown */
    assert_true(isinf(v.shown_max));
    const iso_visible many = iso_visible_measure(&s.level, &s.view, NULL, 2);
    assert_memory_equal(&v, &many, sizeof v);
}

/* Of 128^3 voxels every second row is sampled. A visible half is found so; what is at most 1 % is counted. */
TEST(large_volumes_are_sampled_where_that_decides)
{
    enum { SIDE = 128, ALL = SIDE * SIDE * SIDE };
    subject s;
    set_up(&s, 10);
    s.level.geometry = iso_geometry_axis_aligned((const size_t[]){SIDE, SIDE, SIDE}, (const double[]){1, 1, 1});
    FREED float *values = calloc(ALL, sizeof *values);
    assert_non_null(values);
    s.level.scalar = values;
    for (size_t i = 0; i < ALL / 2; ++i)
        values[i] = 1;
    assert_within(iso_visible_measure(&s.level, &s.view, NULL, 2).voxels, 0.5, 0.01);
    memset(values, 0, ALL * sizeof *values);
    for (size_t x = 0; x < SIDE; ++x)
        values[x] = 1; /* the first row, which the sample has, is .006 % of the voxels */
    assert_within(iso_visible_measure(&s.level, &s.view, NULL, 2).voxels, 1.0 / (SIDE * SIDE), 1e-15);
    memset(values, 0, ALL * sizeof *values);
    for (size_t i = 0; i < (size_t)8 * SIDE; ++i)
        values[SIDE * SIDE / 2 + i] = 1;
    assert_within(iso_visible_measure(&s.level, &s.view, NULL, 2).voxels, 8.0 / (SIDE * SIDE), 1e-15);
}

/* .1 % of 2000 voxels are two of them: one is complained of. */
TEST(less_than_a_thousandth_is_complained_of)
{
    subject s;
    char text[1024];
    set_up(&s, 10);
    s.view.camera.half_height = 20; /* near enough that two voxels are more than that of the picture */
    s.scalar[index_of(3, 4, 5)] = 1;
    iso_visible v = iso_visible_measure(&s.level, &s.view, NULL, 1);
    assert_true(iso_visible_complaint(&v, "the.nrrd", text, sizeof text));
    assert_non_null(strstr(text, "0.05 % of the voxels can be seen"));
    assert_non_null(strstr(text, "the volume's values are 0 to 1"));
    assert_non_null(strstr(text, "isoshade tf suggest the.nrrd -o new.tf.json"));
    s.scalar[index_of(4, 4, 5)] = 1;
    v = iso_visible_measure(&s.level, &s.view, NULL, 1);
    assert_within(v.voxels, 1e-3, 1e-15);
    assert_false(iso_visible_complaint(&v, "the.nrrd", text, sizeof text));
}

/* Faces across x show 2 x 100 mm2, those across y and z 2 x 400 each: 1800 mm2 in all, a voxel 1 or 2 of them. */
TEST(faces_count_by_their_area)
{
    subject s;
    char text[1024];
    const double opaque = 10 * log(10) / mean_mm;
    set_up(&s, 1.001 * opaque);
    for (size_t i = 0; i < COUNT; ++i)
        s.scalar[i] = 1;
    iso_visible v = iso_visible_measure(&s.level, &s.view, NULL, 1);
    assert_within(v.faces, 1, 1e-12);
    assert_true(iso_visible_complaint(&v, "the.nrrd", text, sizeof text));
    assert_non_null(strstr(text, "the picture is of a box: 100 % of its faces"));
    for (size_t y = 2; y < 5; ++y)
        for (size_t x = 2; x < 8; ++x)
            s.scalar[index_of(x, y, 0)] = 0; /* 18 voxels of 2 mm2 on the face z = 0: 2 % of 1800 mm2 */
    v = iso_visible_measure(&s.level, &s.view, NULL, 1);
    assert_within(v.faces, 0.98, 1e-12);
    assert_false(iso_visible_complaint(&v, "the.nrrd", text, sizeof text));
    s.scalar[index_of(2, 2, 0)] = 1;
    v = iso_visible_measure(&s.level, &s.view, NULL, 1);
    assert_true(iso_visible_complaint(&v, "the.nrrd", text, sizeof text));
    s.view.clip_count = 1; /* a clip plane shows the inside */
    s.view.clips[0] = (iso_clip_plane){{0, 1, 0}, 0};
    v = iso_visible_measure(&s.level, &s.view, NULL, 1);
    assert_false(iso_visible_complaint(&v, "the.nrrd", text, sizeof text));
}

TEST(fog_that_can_be_seen_through_is_no_box)
{
    subject s;
    char text[1024];
    set_up(&s, 0.999 * 10 * log(10) / mean_mm);
    for (size_t i = 0; i < COUNT; ++i)
        s.scalar[i] = 1;
    const iso_visible v = iso_visible_measure(&s.level, &s.view, NULL, 1);
    assert_within(v.faces, 0, 0);
    assert_false(iso_visible_complaint(&v, "the.nrrd", text, sizeof text));
}

/* The box is 32 x 8 of 64 x 64 pixels; of it the half of large x is shown. */
TEST(rays_see_what_the_camera_sees)
{
    subject s;
    char text[1024];
    set_up(&s, 1);
    for (size_t z = 0; z < NZ; ++z)
        for (size_t y = 0; y < NY; ++y)
            for (size_t x = NX / 2; x < NX; ++x)
                s.scalar[index_of(x, y, z)] = 1;
    iso_visible v = iso_visible_measure(&s.level, &s.view, NULL, 1);
    assert_within(v.box, 1.0 / 16, 1e-15);
    assert_within(v.picture, 1.0 / 32, 1e-15);
    v = iso_visible_measure(&s.level, &s.view, &(double){0.5}, 1);
    assert_within(v.picture, 1.0 / 32, 1e-15);
    s.view.camera.forward = (iso_vec3){0, -1, 0};
    s.view.camera.right = (iso_vec3){-1, 0, 0};
    v = iso_visible_measure(&s.level, &s.view, NULL, 1);
    assert_within(v.box, 0, 0);
    assert_true(iso_visible_complaint(&v, "the.nrrd", text, sizeof text));
    assert_non_null(strstr(text, "the camera looks past the volume"));
}

/* 10 mm of it along each ray: a depth at which alpha is 1/255 shows something, a little less does not. */
TEST(rays_add_up_what_they_meet)
{
    subject s;
    for (int more = 0; more < 2; ++more) {
        set_up(&s, (more ? 1.001 : 0.999) * -log1p(-1.0 / 255) / 10);
        for (size_t i = 0; i < COUNT; ++i)
            s.scalar[i] = 1;
        const iso_visible v = iso_visible_measure(&s.level, &s.view, NULL, 1);
        assert_within(v.picture, more ? v.box : 0, 1e-15);
    }
}

TEST(clip_planes_that_leave_nothing_are_named)
{
    subject s;
    char text[1024];
    set_up(&s, 1);
    for (size_t i = 0; i < COUNT; ++i)
        s.scalar[i] = 1;
    s.view.clip_count = 1;
    s.view.clips[0] = (iso_clip_plane){{1, 0, 0}, 100};
    const iso_visible v = iso_visible_measure(&s.level, &s.view, NULL, 1);
    assert_true(iso_visible_complaint(&v, "the.nrrd", text, sizeof text));
    assert_non_null(strstr(text, "clip_planes"));
}

TEST(an_isosurface_outside_the_values_is_named)
{
    subject s;
    char text[1024];
    set_up(&s, 1);
    s.scalar[index_of(5, 5, 5)] = 1;
    iso_visible v = iso_visible_measure(&s.level, &s.view, &(double){1.01}, 1);
    assert_true(iso_visible_complaint(&v, "the.nrrd", text, sizeof text));
    assert_non_null(strstr(text, "the isosurface of 1.01 is nowhere: the volume's values are 0 to 1"));
    v = iso_visible_measure(&s.level, &s.view, &(double){0}, 1);
    assert_true(iso_visible_complaint(&v, "the.nrrd", text, sizeof text));
    assert_non_null(strstr(text, "is the whole box"));
}

/* A picture of 100 x 20 pixels, of which two are .1 %. */
TEST(pictures_are_judged_by_alpha_and_color)
{
    const double background[3] = {0.2, 0.2, 0.2};
    OWNED(iso_image) image;
    char text[1024];
    iso_visible v = {.voxels = 1, .box = 1, .value_max = 1, .size = {100, 20}};
    assert_ok(iso_image_create(&image, 100, 20, &err));
    for (size_t i = 0; i < 4 * 2000; ++i)
        image.rgba[i] = i % 4 == 3 ? 0.0039f : 0.2f;
    image.rgba[7] = 0.004f, image.rgba[4] = 0.9f;
    iso_visible_take_image(&v, &image, background);
    assert_within(v.picture, 5e-4, 1e-15);
    assert_true(iso_visible_complaint(&v, "the.nrrd", text, sizeof text));
    assert_non_null(strstr(text, "something is on 0.05 % of the picture of 100 x 20 pixels"));
    image.rgba[11] = 1;
    iso_visible_take_image(&v, &image, background);
    assert_within(v.picture, 1e-3, 1e-15);
    assert_within(v.same_color, 5e-4, 1e-15);
    assert_false(iso_visible_complaint(&v, "the.nrrd", text, sizeof text));
    image.rgba[4] = 0.2f;
    iso_visible_take_image(&v, &image, background);
    assert_true(iso_visible_complaint(&v, "the.nrrd", text, sizeof text));
    assert_non_null(strstr(text, "has the background's color"));
    for (int c = 0; c < 3; ++c) { /* one channel is enough to be told from it */
        image.rgba[4 + c] = 0.9f;
        iso_visible_take_image(&v, &image, background);
        assert_false(iso_visible_complaint(&v, "the.nrrd", text, sizeof text));
        image.rgba[4 + c] = 0.2f;
    }
}

/* ---- a function of values, computed once per value ---- */

static uint32_t calls;

static uint32_t square_of(const void *user, double value)
{
    ++calls;
    assert_ptr_equal(user, &calls);
    return (uint32_t)(value * value);
}

/* Values that a table of integers has, and others, which a rescaled level could have. */
TEST(a_table_has_the_results_of_the_function)
{
    subject s;
    set_up(&s, 1);
    uint64_t expected = 0;
    for (size_t i = 0; i < COUNT; ++i) {
        s.scalar[i] = (float)((int)(i % 301) - 100) + (i % 50 == 0 ? 0.5f : 0);
        expected += (uint64_t)((double)s.scalar[i] * (double)s.scalar[i]);
    }
    s.level.stored_type = ISO_I16;
    s.level.min = -100, s.level.max = 200.5;
    for (int small = 1; small >= 0; --small) {
        s.level.stored_type = small ? ISO_I16 : ISO_F32;
        OWNED(iso_value_table) t = iso_value_table_create(&s.level, square_of, &calls);
        calls = 0;
        assert_int_equal(iso_value_table_sum(&t, 0, COUNT), expected);
        assert_int_equal(calls, small ? COUNT / 50 : COUNT);
    }
    uint8_t bytes[COUNT];
    const iso_volume v = {.geometry = s.level.geometry, .type = ISO_U8, .data = bytes};
    expected = 0;
    for (size_t i = 0; i < COUNT; ++i) {
        bytes[i] = (uint8_t)i;
        expected += i < 7 ? 0 : (uint64_t)bytes[i] * bytes[i];
    }
    s.level.scalar = NULL;
    s.level.samples = &v;
    s.level.stored_type = ISO_U8;
    OWNED(iso_value_table) t = iso_value_table_create(&s.level, square_of, &calls);
    assert_int_equal(iso_value_table_sum(&t, 7, COUNT - 7), expected);
}

TEST_MAIN(NULL, NULL)
