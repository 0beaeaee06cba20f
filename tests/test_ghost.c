/* SPDX-License-Identifier: MIT */
/* What a level shows where level 0 shows nothing: where that is, how much of it is seen, and that adapting leaves it
 * out. */
#include "test.h"

#include "tf/adapt.h"
#include "tf/ghost.h"

enum { N = 64, LEVEL = 2 };

static iso_pyramid pyramid_of(size_t n, double (*value)(const double at[3]), size_t levels)
{
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){n, n, n}, (double[]){1, 1, 1});
    OWNED(iso_volume) v;
    iso_pyramid p;
    assert_ok(iso_volume_create(&v, &g, ISO_F32, "v", &err));
    float *data = v.data;
    for (size_t z = 0; z < n; ++z)
        for (size_t y = 0; y < n; ++y)
            for (size_t x = 0; x < n; ++x)
                *data++ = (float)value((double[]){(double)x + 0.5, (double)y + 0.5, (double)z + 0.5});
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = levels;
    assert_ok(iso_pyramid_build(&v, "v", &opt, &p, NULL, &err));
    return p;
}

static double radius(const double at[3])
{
    const double d[3] = {at[0] - N / 2.0, at[1] - N / 2.0, at[2] - N / 2.0};
    return sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

/* Bone in tissue in air, and beside the head thin rests, half of whose coarse voxels are air: their mean is what the
 * skin's coarse voxels have. */
static double head(const double at[3])
{
    const double r = radius(at);
    const bool rest = (at[0] > 1 && at[0] < 3) || (at[0] > N - 3 && at[0] < N - 1);
    return rest ? 0.7 : r < 12 ? 1 : r < 25 ? 0.4 : 0;
}

/* The same without the rests. */
static double bare_head(const double at[3])
{
    return at[0] < 4 || at[0] > N - 4 ? 0 : head(at);
}

static double step(const double at[3])
{
    return at[0] < 8 ? 1 : 0;
}

/* White; extinction 0 below `first` and above `last`, 1 between. */
static iso_tf_table band(double first, double last)
{
    iso_tf_table t = {.count = 101, .lo = 0, .hi = 1, .entries = calloc(4 * 101, sizeof(float))};
    for (size_t i = 0; i < t.count; ++i) {
        const double value = (double)i / 100;
        for (size_t c = 0; c < 3; ++c)
            t.entries[4 * i + c] = 1;
        t.entries[4 * i + 3] = value > first && value < last ? 1 : 0;
    }
    return t;
}

/* Trilinear, at a place in voxels of level 0. */
static double level_at(const iso_level *l, size_t level, const double at[3])
{
    const size_t *n = l->geometry.size;
    double sum = 0;
    for (size_t corner = 0; corner < 8; ++corner) {
        double weight = 1;
        size_t i[3];
        for (size_t a = 0; a < 3; ++a) {
            const double x = fmin(fmax(ldexp(at[a], -(int)level) - 0.5, 0), (double)(n[a] - 1)), f = x - floor(x);
            i[a] = (size_t)x + (corner >> a & 1);
            i[a] = i[a] < n[a] ? i[a] : n[a] - 1;
            weight *= corner >> a & 1 ? f : 1 - f;
        }
        sum += weight * (double)l->scalar[i[0] + n[0] * (i[1] + n[1] * i[2])];
    }
    return sum;
}

/* Mean opacity along z beside bone and rests by two voxels of the level and more, where level 0 shows nothing at
 * all. */
static double opacity_beside(const iso_pyramid *p, size_t level, const iso_tf_table *tf)
{
    double sum = 0, rgbs[4];
    size_t count = 0;
    for (size_t y = 0; y < N; y += 2)
        for (size_t x = 12; x < N - 12; x += 2) {
            double depth = 0;
            if (hypot((double)x + 0.5 - N / 2.0, (double)y + 0.5 - N / 2.0) < 12 + 8)
                continue;
            for (size_t z = 0; z < N; ++z) {
                iso_tf_lookup(tf,
                              level_at(&p->levels[level], level,
                                       (double[]){(double)x + 0.5, (double)y + 0.5, (double)z + 0.5}),
                              rgbs);
                depth += rgbs[3];
            }
            sum += 1 - exp(-depth);
            ++count;
        }
    return sum / (double)count;
}

TEST(adapting_leaves_the_ghost_of_the_skin_out)
{
    OWNED(iso_pyramid) p = pyramid_of(N, head, LEVEL + 1);
    OWNED(iso_tf_table) tf = band(0.6, 2), plain, kept;
    iso_adapt_options opt = iso_adapt_defaults();
    iso_adapt_judgment v;
    double ghost_plain, ghost_original, ghost_kept;
    opt.fall_back = false; /* the planted fault: adapted as Eq. 7 has it, whatever is seen of it */
    assert_ok(iso_adapt_level(&p, LEVEL, &tf, &opt, &plain, NULL, &err));
    opt.fall_back = true;
    assert_ok(iso_adapt_level(&p, LEVEL, &tf, &opt, &kept, &v, &err));
    assert_ok(iso_ghost_measure(&p, LEVEL, &tf, &tf, NULL, 1, &ghost_original, &err));
    assert_ok(iso_ghost_measure(&p, LEVEL, &tf, &plain, NULL, 1, &ghost_plain, &err));
    assert_ok(iso_ghost_measure(&p, LEVEL, &tf, &kept, NULL, 1, &ghost_kept, &err));
    assert_within(opacity_beside(&p, 0, &tf), 0, 1e-12);
    assert_within(opacity_beside(&p, LEVEL, &tf), 0, 1e-12);
    assert_more_than(opacity_beside(&p, LEVEL, &plain), 0.05);
    assert_at_most(opacity_beside(&p, LEVEL, &kept), 0.01);
    assert_within(ghost_original, 0, 1e-12);
    assert_more_than(ghost_plain, 5 * ISO_GHOST_LIMIT);
    assert_at_most(ghost_kept, ISO_GHOST_LIMIT);
    assert_within(v.ghost, ghost_plain, 1e-12);
    assert_true(v.seen && v.given_back > 0);
}

TEST(a_head_without_rests_has_no_ghost_to_leave_out)
{
    OWNED(iso_pyramid) p = pyramid_of(N, bare_head, LEVEL + 1);
    OWNED(iso_tf_table) tf = band(0.6, 2), plain, kept;
    iso_adapt_options opt = iso_adapt_defaults();
    iso_adapt_judgment v;
    opt.fall_back = false;
    assert_ok(iso_adapt_level(&p, LEVEL, &tf, &opt, &plain, NULL, &err));
    opt.fall_back = true;
    assert_ok(iso_adapt_level(&p, LEVEL, &tf, &opt, &kept, &v, &err));
    assert_within(opacity_beside(&p, LEVEL, &plain), 0, 1e-3);
    assert_true(v.seen && v.given_back == 0 && v.ghost < ISO_GHOST_LIMIT);
    if (!v.use_original)
        assert_memory_equal(kept.entries, plain.entries, 4 * plain.count * sizeof(float));
}

/* The rows of the bits that are set are empty, along x. */
static void assert_empty_along_x(const iso_pyramid *p, size_t level, const iso_tf_table *tf, unsigned wanted)
{
    FREED uint8_t *empty;
    const size_t *n = p->levels[level].geometry.size;
    assert_ok(iso_ghost_mask(&p->levels[0], &p->levels[level], level, tf, 2, &empty, &err));
    for (size_t i = 0; i < n[0] * n[1] * n[2]; ++i)
        assert_int_equal(empty[i] != 0, wanted >> (i % n[0]) & 1);
}

TEST(what_is_empty_is_known)
{
    OWNED(iso_pyramid) p = pyramid_of(16, step, 3);
    OWNED(iso_tf_table) high = band(0.9, 2), middle = band(0.4, 0.6);
    /* Voxel i of level 1 is fine voxels 2 i and 2 i + 1, with one more on each side; of level 2 four, with two. */
    assert_empty_along_x(&p, 1, &high, 0xe0);
    assert_empty_along_x(&p, 2, &high, 0x8);
    /* No fine voxel is in the band, but what lies between those at the step is. */
    assert_empty_along_x(&p, 1, &middle, 0xe7);
    assert_empty_along_x(&p, 2, &middle, 0x9);
}

/* Whether one of the fine voxels that judge a coarse one, its own and half its size around it, is 1. */
static bool has_one(const iso_level *fine, size_t level, const size_t at[3])
{
    const long half = (1L << level) / 2;
    bool found = false;
    for (size_t i = 0; i < iso_geometry_voxel_count(&fine->geometry); ++i) {
        const size_t *n = fine->geometry.size, where[3] = {i % n[0], i / n[0] % n[1], i / n[0] / n[1]};
        bool near = fine->scalar[i] == 1;
        for (int a = 0; a < 3; ++a)
            near = near && (long)where[a] >= ((long)at[a] << level) - half &&
                   (long)where[a] < ((long)(at[a] + 1) << level) + half;
        found |= near;
    }
    return found;
}

TEST(what_is_empty_is_so_along_all_axes_and_at_odd_ends)
{
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){13, 10, 7}, (double[]){1, 1, 1});
    OWNED(iso_volume) v;
    OWNED(iso_pyramid) p;
    uint32_t seed = 7;
    assert_ok(iso_volume_create(&v, &g, ISO_F32, "v", &err));
    for (size_t i = 0; i < 13 * 10 * 7; ++i)
        ((float *)v.data)[i] = (float)((seed = 1664525 * seed + 1013904223) >> 24 < 5);
    ((float *)v.data)[13 * 10 * 7 - 1] = 1;
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = 3;
    assert_ok(iso_pyramid_build(&v, "v", &opt, &p, NULL, &err));
    OWNED(iso_tf_table) high = band(0.9, 2);
    for (size_t level = 1; level < 3; ++level) {
        FREED uint8_t *empty;
        const size_t *n = p.levels[level].geometry.size;
        assert_ok(iso_ghost_mask(&p.levels[0], &p.levels[level], level, &high, 3, &empty, &err));
        for (size_t i = 0; i < n[0] * n[1] * n[2]; ++i)
            assert_int_equal(empty[i] != 0,
                             !has_one(&p.levels[0], level, (size_t[]){i % n[0], i / n[0] % n[1], i / n[0] / n[1]}));
    }
}

/* Level 0 is not sampled in clear voxels; faint ones are empty, but not clear. */
TEST(clear_voxels_change_no_view)
{
    enum { FEW = 100 };
    OWNED(iso_pyramid) p = pyramid_of(N, head, 2);
    OWNED(iso_tf_table) tf = band(0.6, 2);
    FREED uint8_t *empty;
    for (size_t i = 0; i <= 10; ++i)
        tf.entries[4 * i + 3] = 1e-5F; /* the air is faint */
    assert_ok(iso_ghost_mask(&p.levels[0], &p.levels[1], 1, &tf, 2, &empty, &err));
    iso_small_views_input in = {
        .fine = &p.levels[0], .coarse = &p.levels[1], .level = 1, .original = &tf, .tfs = {&tf}, .tf_count = 1};
    iso_small_views_error without[ISO_SMALL_VIEWS_MAX_TFS], with[ISO_SMALL_VIEWS_MAX_TFS];
    assert_ok(iso_small_views_compare(&in, without, &err));
    size_t count[3] = {0};
    const size_t all = iso_geometry_voxel_count(&p.levels[1].geometry);
    for (size_t i = 0; i < all; ++i)
        ++count[empty[i]];
    assert_true(count[0] > FEW && count[ISO_GHOST_EMPTY] > FEW && count[ISO_GHOST_CLEAR] > FEW);
    in.empty = empty;
    assert_ok(iso_small_views_compare(&in, with, &err));
    assert_memory_equal(with[0].of_view, without[0].of_view, sizeof with[0].of_view);
    assert_true(with[0].rmse == without[0].rmse);
    memset(empty, ISO_GHOST_CLEAR, all); /* a wrong mask is seen */
    assert_ok(iso_small_views_compare(&in, with, &err));
    assert_true(memcmp(with[0].of_view, without[0].of_view, sizeof with[0].of_view) != 0 &&
                with[0].rmse != without[0].rmse);
}

TEST(threads_change_no_entry)
{
    OWNED(iso_pyramid) p = pyramid_of(N, head, LEVEL + 1);
    OWNED(iso_tf_table) tf = band(0.6, 2), one, three;
    iso_adapt_options opt = iso_adapt_defaults();
    opt.threads = 1;
    assert_ok(iso_adapt_level(&p, LEVEL, &tf, &opt, &one, NULL, &err));
    opt.threads = 3;
    assert_ok(iso_adapt_level(&p, LEVEL, &tf, &opt, &three, NULL, &err));
    assert_int_equal(one.count, three.count);
    assert_memory_equal(one.entries, three.entries, 4 * one.count * sizeof(float));
}

TEST_MAIN(NULL, NULL)
