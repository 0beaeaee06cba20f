/* SPDX-License-Identifier: MIT */
/* Where a picture can show anything: every point of a block that shows is in the tile of its pixel, within the tile's
 * distances; what lies far from all blocks is in none. */
#include "test.h"

#include "base/random.h"
#include "render/screen_reach.h"

enum { BLOCKS = 5 * 4 * 6 };

typedef struct scene_case {
    iso_geometry geometry;
    iso_view view;
    uint8_t distance[BLOCKS];
    iso_screen_blocks blocks;
} scene_case;

/* A sheared, turned volume of 20 x 16 x 24 voxels in blocks of 4, a part of which shows; all of it
 * where the camera stands in the middle, among blocks that others surround. */
static void make_case(scene_case *c, iso_random *random, bool orthographic, double away)
{
    const size_t size[3] = {20, 16, 24};
    *c = (scene_case){.geometry = iso_geometry_axis_aligned(size, (const double[3]){1, 0.7, 1.9})};
    c->geometry.index_to_world.m[0][1] = 0.4;
    c->geometry.index_to_world.m[2][0] = -0.3;
    for (size_t i = 0; i < BLOCKS; ++i)
        c->distance[i] = away < 10 || iso_random_below(random, 4) == 0 ? 0 : 1;
    c->blocks = (iso_screen_blocks){c->distance, {5, 4, 6}, 4, 0};
    const iso_vec3 middle = iso_geometry_box_center_mm(&c->geometry);
    const iso_vec3 toward = iso_normalize(iso_v3(iso_random_unit(random) - 0.5, iso_random_unit(random) - 0.5,
                                                 iso_random_unit(random) - 0.5));
    iso_camera *camera = &c->view.camera;
    camera->orthographic = orthographic;
    camera->forward = toward;
    camera->right = iso_normalize(iso_cross(toward, iso_v3(0.1, 0.3, 1)));
    camera->up = iso_cross(camera->right, toward);
    camera->position = iso_madd(middle, toward, -away);
    camera->half_height = orthographic ? 20 : 0.4;
    c->view.width = 93;
    c->view.height = 61;
}

/* The pixel of a point and its distance along that pixel's ray; false: it is not in the picture. */
static bool find_pixel(const scene_case *c, iso_vec3 point, size_t *column, size_t *row, double *mm)
{
    const iso_camera *camera = &c->view.camera;
    const iso_vec3 v = iso_sub(point, camera->position);
    const double depth = iso_dot(v, camera->forward), by = camera->orthographic ? 1 : depth;
    const double width = (double)c->view.width, height = (double)c->view.height;
    if (depth <= 0)
        return false;
    const double x = 0.5 * width * (iso_dot(v, camera->right) / (by * camera->half_height * width / height) + 1);
    const double y = 0.5 * height * (1 - iso_dot(v, camera->up) / (by * camera->half_height));
    *mm = camera->orthographic ? depth : iso_norm(v);
    if (!(x >= 0 && x < width && y >= 0 && y < height))
        return false;
    *column = (size_t)x;
    *row = (size_t)y;
    return true;
}

/* How many random points of blocks that show lie outside what their tile says. */
static size_t count_missed(const scene_case *c, const iso_screen_reach *r, iso_random *random, size_t *seen)
{
    size_t missed = 0;
    for (int i = 0; i < 4000; ++i) {
        const size_t b = iso_random_below(random, BLOCKS);
        size_t column, row;
        double mm;
        if (c->distance[b] > 0)
            continue;
        const iso_vec3 index = iso_v3(4 * ((double)(b % 5) + iso_random_unit(random)),
                                      4 * ((double)(b / 5 % 4) + iso_random_unit(random)),
                                      4 * ((double)(b / 20) + iso_random_unit(random)));
        if (!find_pixel(c, iso_geometry_to_world(&c->geometry, index), &column, &row, &mm))
            continue;
        const float *reach = r->mm + 2 * (row / ISO_SCREEN_TILE * r->columns + column / ISO_SCREEN_TILE);
        ++*seen;
        missed += !(reach[0] <= mm && mm <= reach[1]);
    }
    return missed;
}

TEST(visible_points_are_within_the_distances_of_their_tile)
{
    iso_random random = {11};
    size_t seen = 0;
    for (int i = 0; i < 24; ++i) {
        scene_case c;
        OWNED(iso_screen_reach) r;
        make_case(&c, &random, i % 2, i % 3 == 0 ? 4 : 60); /* a camera inside the volume, too */
        assert_ok(iso_screen_reach_create(&r, &c.geometry, &c.view, &c.blocks, &err));
        assert_int_equal(count_missed(&c, &r, &random, &seen), 0);
    }
    assert_true(seen > 5000);
}

/* Planted: each block is taken to begin one block further, so points are missed. */
TEST(blocks_that_stand_elsewhere_are_noticed)
{
    iso_random random = {11};
    size_t missed = 0, seen = 0;
    for (int i = 0; i < 24; ++i) {
        scene_case c;
        OWNED(iso_screen_reach) r;
        make_case(&c, &random, i % 2, 60);
        c.blocks.first = 4;
        assert_ok(iso_screen_reach_create(&r, &c.geometry, &c.view, &c.blocks, &err));
        missed += count_missed(&c, &r, &random, &seen);
    }
    assert_true(missed > 0);
}

TEST(invisible_blocks_are_in_no_tile)
{
    iso_random random = {5};
    scene_case c;
    OWNED(iso_screen_reach) r;
    size_t covered = 0;
    make_case(&c, &random, true, 60);
    memset(c.distance, 1, sizeof c.distance);
    c.distance[0] = 0;
    assert_ok(iso_screen_reach_create(&r, &c.geometry, &c.view, &c.blocks, &err));
    for (size_t i = 0; i < r.columns * r.rows; ++i)
        covered += r.mm[2 * i] <= r.mm[2 * i + 1];
    /* A block of 4 voxels of at most 1.9 mm is at most 14 mm wide; 61 pixels are 40 mm. */
    assert_true(covered >= 1 && covered <= 25);
}

TEST(blocks_inside_others_are_passed_over_and_nothing_changes)
{
    iso_random random = {9};
    scene_case c;
    OWNED(iso_screen_reach) full, hollow;
    make_case(&c, &random, false, 60);
    memset(c.distance, 0, sizeof c.distance);
    assert_ok(iso_screen_reach_create(&full, &c.geometry, &c.view, &c.blocks, &err));
    for (size_t z = 1; z < 5; ++z)
        for (size_t y = 1; y < 3; ++y)
            for (size_t x = 1; x < 4; ++x)
                c.distance[x + 5 * (y + 4 * z)] = 1;
    assert_ok(iso_screen_reach_create(&hollow, &c.geometry, &c.view, &c.blocks, &err));
    assert_memory_equal(full.mm, hollow.mm, 2 * full.columns * full.rows * sizeof *full.mm);
}

TEST_MAIN(NULL, NULL)
