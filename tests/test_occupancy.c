/* SPDX-License-Identifier: MIT */
#include "test.h"

#include "base/random.h"
#include "brick/occupancy.h"

static const size_t size[3] = {21, 9, 14};

static float *random_scalar(void)
{
    size_t count = size[0] * size[1] * size[2];
    float *scalar = malloc(count * sizeof *scalar);
    assert_non_null(scalar);
    iso_random random = {7};
    for (size_t i = 0; i < count; ++i)
        scalar[i] = (float)iso_random_below(&random, 1000);
    return scalar;
}

TEST(ranges_hold_every_voxel_and_its_neighbors)
{
    FREED float *scalar = random_scalar();
    iso_geometry g = iso_geometry_axis_aligned(size, (const double[3]){1, 1, 1});
    OWNED(iso_brick_ranges) r;
    assert_ok(iso_brick_ranges_create(&r, scalar, &g, 4, &err));
    assert_int_equal(r.count[0], 6);
    assert_int_equal(r.count[1], 3);
    assert_int_equal(r.count[2], 4);
    for (size_t i = 0; i < iso_brick_ranges_count(&r); ++i) {
        long b[3] = {(long)(i % 6), (long)(i / 6 % 3), (long)(i / 18)};
        float min = INFINITY, max = -INFINITY;
        for (long z = 4 * b[2] - 1; z <= 4 * b[2] + 4; ++z)
            for (long y = 4 * b[1] - 1; y <= 4 * b[1] + 4; ++y)
                for (long x = 4 * b[0] - 1; x <= 4 * b[0] + 4; ++x)
                    if (x >= 0 && y >= 0 && z >= 0 && x < 21 && y < 9 && z < 14) {
                        float v = scalar[x + 21 * (y + 9 * z)];
                        min = fminf(min, v), max = fmaxf(max, v);
                    }
        assert_true(r.min_max[2 * i] == min && r.min_max[2 * i + 1] == max);
    }
}

TEST(tf_shows_what_any_value_of_the_range_shows)
{
    float entries[4 * 5] = {0};
    entries[4 * 3 + 3] = 1; /* a tent over 20..40 with its top at 30 */
    const iso_tf_table tf = {.count = 5, .lo = 0, .hi = 40, .entries = entries};
    assert_false(iso_tf_shows(&tf, 0, 10));
    assert_false(iso_tf_shows(&tf, -50, 5));
    assert_true(iso_tf_shows(&tf, 0, 20.5));
    assert_true(iso_tf_shows(&tf, 25, 25));
    assert_true(iso_tf_shows(&tf, 35, 90));
    assert_true(iso_tf_shows(&tf, 0, 100));
    assert_false(iso_tf_shows(&tf, 100, 200));
    entries[4 * 4 + 3] = 1; /* the last entry holds beyond the range */
    assert_true(iso_tf_shows(&tf, 100, 200));
}

TEST(distance_is_to_the_nearest_occupied_brick)
{
    float min_max[2 * 5 * 4 * 3] = {0}, entries[8] = {0};
    entries[7] = 1;
    iso_brick_ranges r = {.brick_voxels = 8, .count = {5, 4, 3}, .min_max = min_max};
    const iso_tf_table tf = {.count = 2, .lo = 0.5, .hi = 1, .entries = entries};
    static const size_t occupied[2][3] = {{0, 0, 0}, {4, 2, 2}};
    uint8_t distance[60];
    assert_within(iso_occupancy_compute(&r, &tf, distance), 0, 0);
    for (size_t i = 0; i < 60; ++i)
        assert_int_equal(distance[i], 255);
    for (size_t o = 0; o < 2; ++o)
        min_max[2 * (occupied[o][0] + 5 * (occupied[o][1] + 4 * occupied[o][2])) + 1] = 1;
    assert_within(iso_occupancy_compute(&r, &tf, distance), 2.0 / 60, 1e-15);
    for (size_t i = 0; i < 60; ++i) {
        const long b[3] = {(long)(i % 5), (long)(i / 5 % 4), (long)(i / 20)};
        long least = 255;
        for (size_t o = 0; o < 2; ++o) {
            long d = 0;
            for (int a = 0; a < 3; ++a)
                d = labs(b[a] - (long)occupied[o][a]) > d ? labs(b[a] - (long)occupied[o][a]) : d;
            least = d < least ? d : least;
        }
        assert_int_equal(distance[i], least);
    }
}

TEST(bricks_of_no_voxel_are_refused)
{
    iso_geometry g = iso_geometry_axis_aligned(size, (const double[3]){1, 1, 1});
    iso_brick_ranges r;
    float scalar = 0;
    assert_status(iso_brick_ranges_create(&r, &scalar, &g, 0, &err), ISO_E_RANGE);
}

/* True if a block is occupied. Outside the volume all are empty. */
static bool is_occupied(const uint8_t *occupied, const long b[3], int octant, const long off[3])
{
    long at[3];
    for (int a = 0; a < 3; ++a) {
        at[a] = b[a] + (octant >> a & 1 ? -off[a] : off[a]);
        if (at[a] < 0 || at[a] >= (long)size[a])
            return false;
    }
    return occupied[at[0] + 21 * (at[1] + 9 * at[2])] == 0;
}

/* The largest empty cube, shell by shell, that begins at b and goes the octant's way. */
static int side_of_cube(const uint8_t *occupied, const long b[3], int octant)
{
    for (long side = 0; side < 21; ++side) /* the volume is no larger */
        for (long z = 0; z <= side; ++z)
            for (long y = 0; y <= side; ++y)
                for (long x = z == side || y == side ? 0 : side; x <= side; ++x)
                    if (is_occupied(occupied, b, octant, (long[]){x, y, z}))
                        return (int)side;
    return ISO_OCTANT_MOST;
}

static size_t count_wrong_sides(const uint8_t *occupied, const uint8_t *octants)
{
    const size_t count = size[0] * size[1] * size[2];
    size_t wrong = 0;
    for (int octant = 0; octant < ISO_OCTANTS; ++octant)
        for (size_t i = 0; i < count; ++i) {
            const long b[3] = {(long)(i % 21), (long)(i / 21 % 9), (long)(i / (21 * 9))};
            wrong += octants[(size_t)octant * count + i] != side_of_cube(occupied, b, octant);
        }
    return wrong;
}

/* Planted: the map of another octant. */
TEST(octants_hold_the_largest_empty_cubes_ahead)
{
    const size_t count = size[0] * size[1] * size[2];
    FREED uint8_t *occupied = malloc(count), *octants = malloc(ISO_OCTANTS * count);
    iso_random random = {11};
    assert_non_null(occupied);
    assert_non_null(octants);
    for (size_t i = 0; i < count; ++i)
        occupied[i] = iso_random_below(&random, 100) > 1;
    iso_occupancy_octants(size, occupied, 3, octants);
    assert_int_equal(count_wrong_sides(occupied, octants), 0);
    memcpy(octants + 2 * count, octants + 5 * count, count);
    assert_true(count_wrong_sides(occupied, octants) > 0);
}

/* The list gives the answers of the table. Planted: a list without the last visible entry. */
TEST(a_list_of_the_next_visible_entries_agrees)
{
    float entries[4 * 40] = {0};
    uint32_t next[40];
    entries[4 * 7 + 3] = entries[4 * 8 + 3] = entries[4 * 31 + 3] = 1;
    const iso_tf_table tf = {.count = 40, .lo = -3, .hi = 36, .entries = entries};
    size_t wrong[2] = {0, 0};
    for (int planted = 0; planted < 2; ++planted) {
        const iso_tf_shown shown = iso_tf_shown_of(&tf, next);
        for (int i = 0; i < 40 && planted; ++i)
            next[i] = next[i] == 31 ? 40 : next[i];
        for (double min = -6; min < 40; min += 0.5)
            for (double max = min; max < 42; max += 0.5)
                wrong[planted] += iso_tf_shows(&tf, min, max) != iso_tf_shown_in(&shown, min, max);
    }
    assert_int_equal(wrong[0], 0);
    assert_true(wrong[1] > 0);
}

TEST_MAIN(NULL, NULL)
