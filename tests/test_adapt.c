/* SPDX-License-Identifier: MIT */
#include "joint_pyramids.h"
#include "test.h"

#include "base/file.h"
#include "tf/adapt.h"

/* ---- Eq. 7 -------------------------------------------------------------------------- */

#define BINS 16

typedef struct entry {
    size_t s, z;
    uint64_t count;
} entry;

/* A histogram of BINS x BINS bins of step 2 from 10; entries ascend. */
static iso_joint make_joint(const entry *entries, size_t count)
{
    iso_joint j = {.z = {BINS, 10, 2}, .s = {BINS, 10, 2}, .second_count = 1, .entry_count = count};
    j.row_start = calloc(BINS + 1, sizeof *j.row_start);
    j.entry_z = malloc((count + 1) * sizeof *j.entry_z);
    j.entry_count_of = malloc((count + 1) * sizeof *j.entry_count_of);
    for (size_t i = 0; i < count; ++i) {
        j.entry_z[i] = (uint16_t)entries[i].z;
        j.entry_count_of[i] = entries[i].count;
        j.voxel_count += entries[i].count;
        ++j.row_start[entries[i].s + 1];
    }
    for (size_t s = 0; s < BINS; ++s)
        j.row_start[s + 1] += j.row_start[s];
    return j;
}

/* Color and extinction that differ at every bin; transparent below bin 4. */
static iso_tf_table make_tf(void)
{
    iso_tf_table t = {.count = BINS, .lo = 10, .hi = 10 + 2 * (BINS - 1)};
    t.entries = malloc(4 * BINS * sizeof *t.entries);
    for (size_t i = 0; i < BINS; ++i) {
        float e[4] = {0.1f + 0.05f * (float)i, 1 - 0.06f * (float)i, i % 2 ? 0.25f : 0.75f,
                      i < 4 ? 0 : 0.07f * (float)i};
        memcpy(t.entries + 4 * i, e, sizeof e);
    }
    return t;
}

static iso_geometry spacing_of(double mm)
{
    return iso_geometry_axis_aligned((size_t[]){8, 8, 8}, (double[]){mm, mm, mm});
}

static iso_tf_table adapt(const iso_joint *j, const iso_tf_table *tf, iso_adapt_options opt, double spacing_mm,
                          size_t level)
{
    iso_adapter *a;
    iso_tf_table out;
    iso_geometry g = spacing_of(spacing_mm);
    assert_ok(iso_adapter_create(j, &opt, &a, &err));
    assert_ok(iso_adapter_apply(a, tf, &g, level, &out, &err));
    iso_adapter_destroy(a);
    return out;
}

TEST(one_fine_value_a_row_leaves_the_tf_unchanged)
{
    entry diagonal[BINS];
    for (size_t i = 0; i < BINS; ++i)
        diagonal[i] = (entry){i, i, 5 + i};
    OWNED(iso_joint) j = make_joint(diagonal, BINS);
    OWNED(iso_tf_table) tf = make_tf();
    for (int average = 0; average < ISO_AVERAGE_COUNT; ++average)
        for (int weight = 0; weight < ISO_WEIGHT_COUNT; ++weight) {
            iso_adapt_options opt = {.average = (iso_adapt_average)average,
                                     .weight = (iso_adapt_weight)weight,
                                     .mix_s = 0.3,
                                     .mix_t = 0.3};
            OWNED(iso_tf_table) out = adapt(&j, &tf, opt, 1.5, 1);
            assert_int_equal(out.count, BINS);
            assert_within(out.hi, tf.hi, 1e-12);
            for (size_t i = 0; i < 4 * BINS; ++i)
                assert_within(out.entries[i], tf.entries[i], 2e-7); /* floats of weights and entries */
        }
}

/* Row 7 mixes bins 6 (3 voxels) and 10 (1 voxel): mean 7, deviation sqrt(3), so x = -1/sqrt(3) and sqrt(3). */
static const entry mixture[] = {{7, 6, 3}, {7, 10, 1}};

TEST(two_values_average_as_eq_7_says)
{
    OWNED(iso_joint) j = make_joint(mixture, 2);
    OWNED(iso_tf_table) tf = make_tf();
    const double length = 1.5, x[2] = {-1 / sqrt(3), sqrt(3)}, share[2] = {0.75, 0.25};
    const float *e[2] = {tf.entries + 4 * 6, tf.entries + 4 * 10};
    for (int weight = 0; weight < ISO_WEIGHT_COUNT; ++weight) {
        double w[2];
        for (int i = 0; i < 2; ++i) {
            double gauss = exp(-x[i] * x[i] / 2), triangle = 0.4 * (1 - 0.4 * fabs(x[i]));
            double unit_gauss = gauss / (sqrt(2 * 3.14159265358979323846) * erf(2.5 / sqrt(2)));
            w[i] = share[i] * (weight == ISO_WEIGHT_GAUSS      ? gauss
                               : weight == ISO_WEIGHT_FLAT     ? 1
                               : weight == ISO_WEIGHT_TRIANGLE ? triangle
                                                               : 0.5 * 0.2 + 0.25 * triangle + 0.25 * unit_gauss);
        }
        double k = w[0] + w[1], u[2] = {w[0] / k, w[1] / k};
        for (int average = 0; average < ISO_AVERAGE_COUNT; ++average) {
            iso_adapt_options opt = {.average = (iso_adapt_average)average,
                                     .weight = (iso_adapt_weight)weight,
                                     .mix_s = 0.5,
                                     .mix_t = 0.25};
            OWNED(iso_tf_table) out = adapt(&j, &tf, opt, length, 2);
            double span = average == ISO_AVERAGE_TRANSMITTANCE ? length * 2 : length; /* h_0 sqrt(4) */
            double a[2], extinction, color[2] = {u[0], u[1]};
            for (int i = 0; i < 2; ++i)
                a[i] = average == ISO_AVERAGE_EXTINCTION ? (double)e[i][3] : 1 - exp(-(double)e[i][3] * span);
            double mean = u[0] * a[0] + u[1] * a[1];
            extinction = average == ISO_AVERAGE_EXTINCTION ? mean : -log(1 - mean) / span;
            if (average != ISO_AVERAGE_RGBA)
                color[0] = u[0] * a[0] / mean, color[1] = u[1] * a[1] / mean;
            for (int c = 0; c < 3; ++c)
                assert_within(out.entries[4 * 7 + c], color[0] * (double)e[0][c] + color[1] * (double)e[1][c],
                              3e-7); /* floats */
            assert_within(out.entries[4 * 7 + 3], extinction, 3e-7);
        }
    }
}

TEST(transparent_entries_do_not_darken_the_color)
{
    static const entry half[] = {{5, 1, 1}, {5, 9, 1}}; /* bin 1 is transparent */
    OWNED(iso_joint) j = make_joint(half, 2);
    OWNED(iso_tf_table) tf = make_tf();
    memset(tf.entries + 4 * 1, 0, 3 * sizeof *tf.entries); /* and black */
    OWNED(iso_tf_table) weighted = adapt(&j, &tf, iso_adapt_defaults(), 1, 1);
    for (int c = 0; c < 3; ++c)
        assert_within(weighted.entries[4 * 5 + c], (double)tf.entries[4 * 9 + c], 2e-7);
    OWNED(iso_tf_table)
    plain = adapt(&j, &tf, (iso_adapt_options){.average = ISO_AVERAGE_RGBA, .weight = ISO_WEIGHT_GAUSS}, 1, 1);
    for (int c = 0; c < 3; ++c) /* the fault that the paper's average has: half as bright */
        assert_within(plain.entries[4 * 5 + c], 0.5 * (double)tf.entries[4 * 9 + c], 2e-7);
}

TEST(rows_of_no_opacity_keep_the_mean_color)
{
    static const entry clear[] = {{2, 1, 1}, {2, 3, 1}};
    OWNED(iso_joint) j = make_joint(clear, 2);
    OWNED(iso_tf_table) tf = make_tf();
    OWNED(iso_tf_table) out = adapt(&j, &tf, iso_adapt_defaults(), 1, 1);
    for (int c = 0; c < 3; ++c)
        assert_within(out.entries[4 * 2 + c], 0.5 * ((double)tf.entries[4 * 1 + c] + (double)tf.entries[4 * 3 + c]),
                      2e-7);
    assert_within(out.entries[4 * 2 + 3], 0, 0);
}

TEST(empty_rows_are_filled_on_premultiplied_entries)
{
    static const entry two[] = {{4, 2, 1}, {8, 12, 1}}; /* row 4 transparent, row 8 not */
    iso_joint j = make_joint(two, 2);
    OWNED(iso_tf_table) tf = make_tf();
    iso_tf_table out = adapt(&j, &tf, iso_adapt_defaults(), 1, 1);
    const double opacity = 1 - exp(-(double)tf.entries[4 * 12 + 3]);
    for (size_t row = 5; row < 8; ++row) {
        assert_within(1 - exp(-(double)out.entries[4 * row + 3]), opacity * (double)(row - 4) / 4, 3e-7);
        for (int c = 0; c < 3; ++c) /* the transparent end gives no color */
            assert_within(out.entries[4 * row + (size_t)c], (double)tf.entries[4 * 12 + c], 3e-7);
    }
    assert_memory_equal(out.entries, out.entries + 4 * 4, 4 * sizeof(float)); /* below the first row: its copy */
    assert_memory_equal(out.entries + 4 * 15, out.entries + 4 * 8, 4 * sizeof(float));
    iso_tf_table_destroy(&out);
    iso_joint_destroy(&j);
    j = make_joint(NULL, 0);
    out = adapt(&j, &tf, iso_adapt_defaults(), 1, 1);
    for (size_t i = 0; i < 4 * BINS; ++i)
        assert_within(out.entries[i], (double)tf.entries[i], 2e-7);
    iso_tf_table_destroy(&out);
    iso_joint_destroy(&j);
}

TEST(what_lies_beyond_the_window_is_left_out)
{
    static const entry outlier[] = {{5, 5, 999}, {5, 15, 1}}; /* the outlier is 32 deviations off */
    OWNED(iso_joint) j = make_joint(outlier, 2);
    OWNED(iso_tf_table) tf = make_tf();
    OWNED(iso_tf_table) inside = adapt(&j, &tf, iso_adapt_defaults(), 1, 1);
    assert_within(inside.entries[4 * 5 + 3], (double)tf.entries[4 * 5 + 3], 2e-7);
    iso_adapt_options wide = iso_adapt_defaults();
    wide.window = 100;
    OWNED(iso_tf_table) all = adapt(&j, &tf, wide, 1, 1);
    assert_more_than(all.entries[4 * 5 + 3], (double)tf.entries[4 * 5 + 3] + 1e-4);
}

TEST(opaque_rows_stay_finite)
{
    static const entry opaque[] = {{9, 9, 1}, {9, 10, 1}, {11, 11, 1}};
    OWNED(iso_joint) j = make_joint(opaque, 3);
    OWNED(iso_tf_table) tf = make_tf();
    for (size_t i = 9; i < 12; ++i)
        tf.entries[4 * i + 3] = 1e4f;
    for (int average = 0; average < ISO_AVERAGE_COUNT; ++average) {
        OWNED(iso_tf_table) out = adapt(&j, &tf, (iso_adapt_options){.average = (iso_adapt_average)average}, 3, 3);
        for (size_t row = 0; row < BINS; ++row)
            assert_true(isfinite(out.entries[4 * row + 3]) && out.entries[4 * row + 3] <= 1e4f);
        assert_within(out.entries[4 * 9 + 3], 1e4, 1e-3);
    }
}

TEST(options_outside_their_limits_are_refused)
{
    OWNED(iso_joint) j = make_joint(mixture, 2);
    iso_adapter *a;
    iso_adapt_options opt = iso_adapt_defaults();
    opt.window = 0.5;
    assert_status(iso_adapter_create(&j, &opt, &a, &err), ISO_E_RANGE);
    opt = (iso_adapt_options){.weight = ISO_WEIGHT_MIXED, .mix_s = 0.7, .mix_t = 0.4};
    assert_status(iso_adapter_create(&j, &opt, &a, &err), ISO_E_RANGE);
}

TEST(a_table_as_a_tf_file_gives_the_same_entries_back)
{
    OWNED(iso_tf_table) tf = make_tf(), back;
    tf.entries[4 * 6 + 3] = 50; /* 1 mm of it would be opaque beyond the cap */
    OWNED(iso_tf) file;
    iso_geometry g = spacing_of(3);
    assert_ok(iso_tf_from_table(&tf, &file, &err));
    assert_ok(iso_tf_tabulate(&file, 0, 1, &g, &back, &err));
    assert_int_equal(back.count, tf.count);
    assert_within(back.lo, tf.lo, 0);
    assert_within(back.hi, tf.hi, 0);
    for (size_t i = 0; i < 4 * tf.count; ++i)
        assert_within(back.entries[i], (double)tf.entries[i], 1e-5); /* a logarithm near opacity .98 */
}

TEST(judgment_is_the_error_at_the_voxels)
{
    OWNED(iso_joint) j = make_joint(mixture, 2);
    OWNED(iso_tf_table) tf = make_tf(), out = adapt(&j, &tf, iso_adapt_defaults(), 1, 1);
    iso_geometry g = spacing_of(1);
    iso_adapt_judgment v;
    assert_ok(iso_adapt_judge(&j, &tf, &out, &g, &v, &err));
    double sums[2] = {0};
    for (int i = 0; i < 2; ++i)
        for (int which = 0; which < 2; ++which) {
            const float *fine = tf.entries + 4 * mixture[i].z, *coarse = (which ? out.entries : tf.entries) + 4 * 7;
            double af = 1 - exp(-(double)fine[3]), ac = 1 - exp(-(double)coarse[3]), square = (af - ac) * (af - ac);
            for (int c = 0; c < 3; ++c)
                square += pow(af * (double)fine[c] - ac * (double)coarse[c], 2);
            sums[which] += (double)mixture[i].count / 4 * square;
        }
    assert_within(v.rms_original, sqrt(sums[0]), 1e-9);
    assert_within(v.rms_adapted, sqrt(sums[1]), 1e-9);
    assert_more_than(v.rms_original, v.rms_adapted);
    assert_false(v.use_original);
}

/* 12 x 8 x 8 voxels: a homogeneous block of value 50 in the planes x < 4, and a plate of 100 in x = 7 and 8, y < 4. The
 * plate fills half of its coarse voxels, so at level 1 it has the value 50 too. */
static iso_pyramid shared_value_pyramid(bool with_block)
{
    iso_geometry g = iso_geometry_axis_aligned((size_t[]){12, 8, 8}, (double[]){1, 1, 1});
    OWNED(iso_volume) v;
    iso_pyramid p;
    assert_ok(iso_volume_create(&v, &g, ISO_U8, "v", &err));
    for (size_t z = 0; z < 8; ++z)
        for (size_t y = 0; y < 8; ++y) {
            uint8_t *row = (uint8_t *)v.data + (z * 8 + y) * 12;
            for (size_t x = 0; with_block && x < 4; ++x)
                row[x] = 50;
            if (y < 4)
                row[7] = row[8] = 100;
        }
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = 2;
    assert_ok(iso_pyramid_build(&v, "v", &opt, &p, NULL, &err));
    return p;
}

TEST(a_tissue_that_shares_a_value_with_a_plate_stays_dark)
{
    /* 100 is opaque, 50 is not */
    iso_tf_table tf = {.count = 256, .lo = 0, .hi = 255, .entries = calloc(4 * 256, sizeof(float))}, out;
    for (size_t i = 80; i < 256; ++i)
        tf.entries[4 * i] = 1, tf.entries[4 * i + 3] = 2;
    for (int with_block = 0; with_block < 2; ++with_block) {
        OWNED(iso_pyramid) p = shared_value_pyramid(with_block);
        iso_adapt_options opt = iso_adapt_defaults();
        /* without the block the row of 50 holds the plate's voxels alone, and shows them; with it they are its tail */
        opt.fall_back = false;
        assert_ok(iso_adapt_level(&p, 1, &tf, &opt, &out, NULL, &err));
        assert_true((out.entries[4 * 50 + 3] > 0.01f) == !with_block);
        iso_tf_table_destroy(&out);
        /* The planted fault: a wide window shows the block. Its error at the voxels is the smaller one all the same,
         * small views refuse it. */
        iso_adapt_judgment v;
        opt.window = 3;
        assert_ok(iso_adapt_level(&p, 1, &tf, &opt, &out, NULL, &err));
        assert_more_than(out.entries[4 * 50 + 3], 0.01);
        iso_tf_table_destroy(&out);
        opt.fall_back = true;
        assert_ok(iso_adapt_level(&p, 1, &tf, &opt, &out, &v, &err));
        assert_true(v.seen && v.rms_adapted < v.rms_original && (v.use_original || !with_block));
        iso_tf_table_destroy(&out);
    }
    iso_tf_table_destroy(&tf);
}

TEST(a_larger_error_at_the_voxels_keeps_the_original_tf)
{
    /* The window cuts off the entry at 14, three deviations away: TF_0(6) is left, and TF_0(7) at the row is closer to
     * all. */
    static const entry tail[] = {{7, 6, 90}, {7, 14, 10}};
    OWNED(iso_joint) j = make_joint(tail, 2);
    OWNED(iso_tf_table) tf = make_tf();
    for (size_t i = 0; i < BINS; ++i)
        memcpy(tf.entries + 4 * i, (const float[]){1, 1, 1, (float)(0.02 * (double)i)}, 4 * sizeof(float));
    iso_adapt_options wide = iso_adapt_defaults();
    wide.window = 4;
    OWNED(iso_tf_table) narrow_tf = adapt(&j, &tf, iso_adapt_defaults(), 1, 1), wide_tf = adapt(&j, &tf, wide, 1, 1);
    iso_geometry g = spacing_of(1);
    iso_adapt_judgment v;
    assert_ok(iso_adapt_judge(&j, &tf, &narrow_tf, &g, &v, &err));
    assert_true(v.use_original && v.rms_adapted > v.rms_original);
    assert_ok(iso_adapt_judge(&j, &tf, &wide_tf, &g, &v, &err)); /* the mean of all has the least error there is */
    assert_true(!v.use_original && v.rms_adapted < v.rms_original);
}

TEST(deviation_parts_homogeneous_voxels_from_mixed_ones)
{
    OWNED(iso_pyramid) p = shared_value_pyramid(true);
    OWNED(iso_joint) one, second;
    assert_ok(iso_joint_compute(&p, 1, 8, ISO_SECOND_VALUE_NONE, 1, &one, &err));
    assert_ok(iso_joint_compute(&p, 1, 8, ISO_SECOND_VALUE_DEVIATION, 2, &second, &err));
    assert_int_equal(second.voxel_count, one.voxel_count);
    for (size_t s = 0; s < one.s.count; ++s) { /* the bins of the second value sum to the row */
        uint64_t whole = 0, parts = 0;
        for (size_t i = one.row_start[s]; i < one.row_start[s + 1]; ++i)
            whole += one.entry_count_of[i];
        for (size_t c = 0; c < ISO_TF_2D_ROWS; ++c)
            for (size_t i = second.row_start[c * one.s.count + s]; i < second.row_start[c * one.s.count + s + 1]; ++i)
                parts += second.entry_count_of[i];
        assert_int_equal(whole, parts);
    }
    /* value 50: row 0 holds the block alone, and the plate has the row of deviation 50, the largest there is */
    assert_more_than((double)count_of(&second, 50, 50), 100);
    assert_int_equal(count_of(&second, 50, 100), 0);
    assert_more_than((double)count_of(&second, 7 * 256 + 50, 100), 10);
    assert_int_equal(count_of(&second, 7 * 256 + 50, 50), 0);
}

TEST(levels_of_a_pyramid_get_tables_and_level_0_keeps_its_own)
{
    OWNED(iso_pyramid) p = random_pyramid(17, 9, 13, ISO_U8, 3);
    iso_tf_table tf = make_tf(), out;
    iso_adapt_options opt = iso_adapt_defaults();
    iso_adapt_judgment v;
    opt.fall_back = false;
    assert_ok(iso_adapt_level(&p, 0, &tf, &opt, &out, &v, &err));
    assert_true(v.use_original && out.count == tf.count);
    assert_memory_equal(out.entries, tf.entries, 4 * BINS * sizeof(float));
    iso_tf_table_destroy(&out);
    assert_ok(iso_adapt_level(&p, 1, &tf, &opt, &out, &v, &err));
    assert_true(!v.use_original && out.count == 256);
    iso_tf_table_destroy(&out);
    assert_status(iso_adapt_level(&p, 3, &tf, &opt, &out, &v, &err), ISO_E_RANGE);
    opt.bits = 7;
    assert_status(iso_adapt_level(&p, 1, &tf, &opt, &out, &v, &err), ISO_E_RANGE);
    iso_tf_table_destroy(&tf);
}

TEST_MAIN(NULL, NULL)
