/* SPDX-License-Identifier: MIT */
/* test_value_histogram.c - counts that are known, and bins that draw no comb. */
#include "test.h"

#include "volume/value_histogram.h"

static iso_volume volume_of(iso_type type, size_t count, const void *samples, size_t bytes)
{
    iso_volume v;
    const iso_geometry g = iso_geometry_axis_aligned((const size_t[]){count, 1, 1}, (const double[]){1, 1, 1});
    assert_ok(iso_volume_create(&v, &g, type, "test", &err));
    memcpy(v.data, samples, bytes);
    return v;
}

/* 0 to 999, each once, in at most 300 bins: 4 values a bin, in each but none of another width. */
TEST(whole_numbers_fill_bins_evenly)
{
    uint16_t samples[1000];
    for (size_t i = 0; i < 1000; ++i)
        samples[i] = (uint16_t)i;
    OWNED(iso_volume) v = volume_of(ISO_U16, 1000, samples, sizeof samples);
    OWNED(iso_value_histogram) h;
    assert_ok(iso_value_histogram_count(&v, 0, 999, 300, &h, &err));
    assert_within(h.width, 4, 0);
    assert_within(h.lo, -0.5, 0);
    assert_int_equal(h.count, 250);
    for (size_t b = 0; b < h.count; ++b)
        assert_int_equal(h.bins[b], 4);
    assert_int_equal(h.most, 4);
}

TEST(whole_numbers_in_floats_do_too)
{
    const float samples[5] = {-3, -3, 0, 2, 2};
    OWNED(iso_volume) v = volume_of(ISO_F32, 5, samples, sizeof samples);
    OWNED(iso_value_histogram) h;
    assert_ok(iso_value_histogram_count(&v, -3, 2, 64, &h, &err));
    assert_int_equal(h.count, 6);
    assert_int_equal(h.bins[0], 2);
    assert_int_equal(h.bins[3], 1);
    assert_int_equal(h.bins[5], 2);
}

/* Both ends are counted, what is beyond them is not. */
TEST(other_numbers_are_binned_over_the_range)
{
    const float samples[6] = {-0.1f, 0, 0.24f, 0.25f, 1, 1.1f};
    OWNED(iso_volume) v = volume_of(ISO_F32, 6, samples, sizeof samples);
    OWNED(iso_value_histogram) h;
    assert_ok(iso_value_histogram_count(&v, 0, 1, 4, &h, &err));
    assert_int_equal(h.count, 4);
    assert_int_equal(h.bins[0], 2);
    assert_int_equal(h.bins[1], 1);
    assert_int_equal(h.bins[2], 0);
    assert_int_equal(h.bins[3], 1);
}

TEST(one_value_is_one_bin)
{
    const float half[3] = {0.5f, 0.5f, 0.5f};
    const uint8_t whole[3] = {7, 7, 7};
    OWNED(iso_volume) v = volume_of(ISO_F32, 3, half, sizeof half), w = volume_of(ISO_U8, 3, whole, sizeof whole);
    iso_value_histogram h;
    assert_ok(iso_value_histogram_count(&v, 0.5, 0.5, 64, &h, &err));
    assert_int_equal(h.count, 1);
    assert_int_equal(h.bins[0], 3);
    assert_true(h.width > 0);
    iso_value_histogram_destroy(&h);
    assert_ok(iso_value_histogram_count(&w, 7, 7, 64, &h, &err));
    assert_int_equal(h.count, 1);
    assert_int_equal(h.bins[0], 3);
    iso_value_histogram_destroy(&h);
}

TEST_MAIN(NULL, NULL)
