/* SPDX-License-Identifier: MIT */
/* Joint histograms against direct sums, and their files. */
#include "test.h"

#include "base/file.h"
#include "joint_pyramids.h"
#include "tf/adapt.h"

/* Trilinear lookup in double precision, clamped to the edge. */
static double lookup(const iso_level *l, const double at[3])
{
    double sum = 0;
    size_t i[3][2];
    double w[3][2];
    for (int a = 0; a < 3; ++a) {
        double last = (double)l->geometry.size[a] - 1, x = fmin(fmax(at[a] - 0.5, 0), last);
        i[a][0] = (size_t)x;
        i[a][1] = i[a][0] + 1 < l->geometry.size[a] ? i[a][0] + 1 : i[a][0];
        w[a][1] = x - floor(x), w[a][0] = 1 - w[a][1];
    }
    for (int c = 0; c < 8; ++c) {
        int x = c & 1, y = c >> 1 & 1, z = c >> 2;
        sum += w[0][x] * w[1][y] * w[2][z] *
               (double)l->scalar[(i[2][z] * l->geometry.size[1] + i[1][y]) * l->geometry.size[0] + i[0][x]];
    }
    return sum;
}

/* Of the direct sum's counts, in all. */
static size_t misplaced(const iso_pyramid *p, size_t level, const iso_joint *j)
{
    const iso_level *fine = &p->levels[0];
    const size_t *n = fine->geometry.size;
    uint64_t *direct = calloc(j->s.count * j->z.count, sizeof *direct);
    size_t total = 0;
    double scale = 1.0 / (double)((size_t)1 << level);
    for (size_t i = 0; i < n[0] * n[1] * n[2]; ++i) {
        double at[3] = {((double)(i % n[0]) + 0.5) * scale, ((double)(i / n[0] % n[1]) + 0.5) * scale,
                        ((double)(i / n[0] / n[1]) + 0.5) * scale};
        size_t s = (size_t)((lookup(&p->levels[level], at) - j->s.lo) / j->s.step + 0.5);
        size_t z = (size_t)(((double)fine->scalar[i] - j->z.lo) / j->z.step + 0.5);
        ++direct[s * j->z.count + z];
    }
    for (size_t s = 0; s < j->s.count; ++s)
        for (size_t z = 0; z < j->z.count; ++z)
            total += (size_t)llabs((long long)(count_of(j, s, z) - direct[s * j->z.count + z]));
    free(direct);
    return total / 2;
}

static void assert_equals_direct_sum(const iso_pyramid *p, size_t level, const iso_joint *j)
{
    const size_t *n = p->levels[0].geometry.size;
    assert_int_equal(misplaced(p, level, j), 0);
    assert_int_equal(j->voxel_count, n[0] * n[1] * n[2]);
}

TEST(histograms_equal_a_direct_sum_of_trilinear_lookups)
{
    OWNED(iso_pyramid) p = random_pyramid(21, 14, 11, ISO_U8, 3);
    for (size_t level = 1; level < p.level_count; ++level) {
        OWNED(iso_joint) j;
        assert_ok(iso_joint_compute(&p, level, 8, ISO_SECOND_VALUE_NONE, 2, &j, &err));
        assert_equals_direct_sum(&p, level, &j);
    }
}

/* How many voxels were counted elsewhere than by a lookup in double precision, of one level of two-bit values. */
static size_t misplaced_count(size_t level)
{
    iso_geometry g = iso_geometry_axis_aligned((size_t[]){37, 22, 19}, (double[]){1, 1, 1});
    OWNED(iso_volume) v;
    OWNED(iso_pyramid) p;
    OWNED(iso_joint) j;
    iso_random random = {5};
    assert_ok(iso_volume_create(&v, &g, ISO_U8, "v", &err));
    for (size_t i = 0; i < 37 * 22 * 19; ++i)
        ((uint8_t *)v.data)[i] = (uint8_t)(iso_random_next(&random) & 0xc0);
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = level + 1;
    assert_ok(iso_pyramid_build(&v, "v", &opt, &p, NULL, &err));
    assert_ok(iso_joint_compute(&p, level, 8, ISO_SECOND_VALUE_NONE, 2, &j, &err));
    size_t sum = misplaced(&p, level, &j);
    return sum;
}

TEST(coarser_levels_are_looked_up_the_same)
{
    assert_int_equal(misplaced_count(3), 0); /* 2 + 9 + 12 bits: exact */
    assert_true(misplaced_count(4) <= 8); /* 2 + 12 + 15 bits: float rounds, so some of 15466 ties fall the other way */
}

TEST(histograms_of_twelve_and_sixteen_bits_count_the_same)
{
    OWNED(iso_pyramid) p = random_pyramid(13, 10, 7, ISO_U16, 2);
    for (int bits = 12; bits <= 16; bits += 4) { /* 12: tables; 16: hash maps */
        OWNED(iso_joint) j;
        assert_ok(iso_joint_compute(&p, 1, bits, ISO_SECOND_VALUE_NONE, 2, &j, &err));
        assert_within(j.z.step, 1, 0); /* 3000 values fit */
        assert_true(j.z.count == (size_t)1 << bits && j.s.count == 4096);
        uint64_t sum = 0;
        for (size_t s = 0; s < j.s.count; ++s)
            for (size_t i = j.row_start[s]; i < j.row_start[s + 1]; ++i) {
                assert_true(i == j.row_start[s] || j.entry_z[i] > j.entry_z[i - 1]);
                sum += j.entry_count_of[i];
            }
        assert_int_equal(sum, 13 * 10 * 7);
        if (bits == 12)
            assert_equals_direct_sum(&p, 1, &j);
    }
}

static void assert_same_joint(const iso_joint *a, const iso_joint *b)
{
    assert_int_equal(a->entry_count, b->entry_count);
    assert_int_equal(a->voxel_count, b->voxel_count);
    assert_memory_equal(a->row_start, b->row_start, (a->s.count + 1) * sizeof *a->row_start);
    assert_memory_equal(a->entry_z, b->entry_z, a->entry_count * sizeof *a->entry_z);
    assert_memory_equal(a->entry_count_of, b->entry_count_of, a->entry_count * sizeof *a->entry_count_of);
}

TEST(counts_do_not_depend_on_threads)
{
    OWNED(iso_pyramid) p = random_pyramid(17, 9, 13, ISO_U8, 3);
    OWNED(iso_joint) whole = {0}, other = {0};
    assert_ok(iso_joint_compute(&p, 2, 8, ISO_SECOND_VALUE_NONE, 1, &whole, &err));
    assert_ok(iso_joint_compute(&p, 2, 8, ISO_SECOND_VALUE_NONE, 5, &other, &err));
    assert_same_joint(&whole, &other);
}

TEST(stored_histograms_come_back_and_foreign_ones_are_refused)
{
    FREED char *dir = iso_make_temp_dir();
    OWNED(iso_pyramid) p = random_pyramid(17, 9, 13, ISO_U8, 3);
    for (int bits = 8; bits <= 12; bits += 4) { /* dense, then sparse */
        OWNED(iso_joint) j, back;
        assert_ok(iso_joint_compute(&p, 1, bits, ISO_SECOND_VALUE_NONE, 1, &j, &err));
        assert_ok(iso_joint_save(&j, dir, 1, bits, &err));
        assert_ok(iso_joint_load(dir, &(iso_joint_key){1, bits, ISO_SECOND_VALUE_NONE}, &j.z, &j.s, j.voxel_count,
                                 &back, &err));
        assert_same_joint(&j, &back);
        iso_joint_destroy(&back);
        assert_status(iso_joint_load(dir, &(iso_joint_key){1, bits, ISO_SECOND_VALUE_NONE}, &j.z, &j.s,
                                     j.voxel_count + 1, &back, &err),
                      ISO_E_FORMAT);
        iso_bins other = j.z;
        other.step *= 1.01;
        assert_status(iso_joint_load(dir, &(iso_joint_key){1, bits, ISO_SECOND_VALUE_NONE}, &other, &j.s, j.voxel_count,
                                     &back, &err),
                      ISO_E_FORMAT);
        assert_status(iso_joint_load(dir, &(iso_joint_key){2, bits, ISO_SECOND_VALUE_NONE}, &j.z, &j.s, j.voxel_count,
                                     &back, &err),
                      ISO_E_IO);
    }
    iso_remove_tree(dir);
}

TEST_MAIN(NULL, NULL)
