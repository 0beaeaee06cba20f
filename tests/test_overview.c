/* SPDX-License-Identifier: MIT */
/* A volume that is read slab by slab has the same range, percentiles and histograms as one that is kept, and a changed
 * voxel changes them. */
#include "tests/folder.h"
#include "tests/test.h"
#include "volume/overview.h"

enum { NX = 7, NY = 5, NZ = 11, COUNT = NX * NY * NZ };

static double value_of(size_t i)
{
    return (double)((i * 7919) % 251);
}

static void put(iso_volume *v, size_t i, double value)
{
    switch (v->type) {
    case ISO_U8: ((uint8_t *)v->data)[i] = (uint8_t)value; break;
    case ISO_I16: ((int16_t *)v->data)[i] = (int16_t)(value - 120); break;
    case ISO_F32: ((float *)v->data)[i] = (float)(value / 7); break;
    default: ((double *)v->data)[i] = value / 7;
    }
}

/* changed: a voxel that gets 255 more than any has, or COUNT for none. */
static void write_volume(const char *path, iso_type type, size_t changed)
{
    OWNED(iso_volume) v;
    iso_volume_sink *sink = NULL;
    const iso_geometry g = iso_geometry_axis_aligned((const size_t[]){NX, NY, NZ}, (const double[]){1, 1, 1});
    assert_ok(iso_volume_create(&v, &g, type, "overview", &err));
    for (size_t i = 0; i < COUNT; ++i)
        put(&v, i, i == changed ? 255 : value_of(i));
    assert_ok(iso_sink_open(path, &v, false, &sink, &err));
    assert_ok(iso_sink_write(sink, NZ, v.data, &err));
    assert_ok(iso_sink_commit(sink, &err));
}

static iso_overview look(const char *path, size_t kept_bytes, size_t slab_bytes, int threads)
{
    iso_volume_input input = {0};
    iso_overview s;
    const iso_overview_options opt = {.kept_bytes = kept_bytes,
                                      .slab_bytes = slab_bytes,
                                      .drawn_bins = 512,
                                      .threads = threads};
    assert_ok(iso_overview_run(path, &input, &opt, &s, NULL, &err));
    return s;
}

static bool are_same_bins(const iso_value_histogram *a, const iso_value_histogram *b)
{
    return a->count == b->count && a->most == b->most && a->lo == b->lo && a->width == b->width &&
           memcmp(a->bins, b->bins, a->count * sizeof *a->bins) == 0;
}

static bool are_same(const iso_overview *a, const iso_overview *b)
{
    return a->stats.min == b->stats.min && a->stats.max == b->stats.max &&
           fabs(a->stats.mean - b->stats.mean) <= 1e-13 * fabs(a->stats.max) && /* sums in another order */
           a->rounded == b->rounded && a->most_rounded == b->most_rounded &&
           memcmp(a->percentile, b->percentile, sizeof a->percentile) == 0 &&
           memcmp(a->bins, b->bins, sizeof a->bins) == 0 && are_same_bins(&a->shown, &b->shown) &&
           are_same_bins(&a->drawn, &b->drawn) && a->header.notes.label_count == b->header.notes.label_count;
}

static const iso_type types[] = {ISO_U8, ISO_I16, ISO_F32, ISO_F64};

TEST(slabs_of_any_size_say_what_the_whole_volume_says)
{
    for (size_t t = 0; t < sizeof types / sizeof *types; ++t) {
        FREED char *path = iso_path_join(folder, "volume.nrrd");
        write_volume(path, types[t], COUNT);
        OWNED(iso_overview) whole = look(path, 0, 0, 1);
        const size_t plane = NX * NY * iso_type_bytes(types[t]);
        for (size_t planes = 1; planes <= NZ; planes += 3)
            for (int threads = 1; threads <= 3; threads += 2) {
                OWNED(iso_overview) s = look(path, 1, planes * plane, threads);
                assert_true(are_same(&whole, &s));
            }
        assert_int_equal(whole.rounded > 0, types[t] == ISO_F64);
        assert_null(whole.header.data);
    }
}

/* The planted fault, in the last slab, which has one plane. */
TEST(a_changed_voxel_changes_the_overview)
{
    for (size_t t = 0; t < sizeof types / sizeof *types; ++t) {
        FREED char *path = iso_path_join(folder, "volume.nrrd"), *other = iso_path_join(folder, "other.nrrd");
        write_volume(path, types[t], COUNT);
        write_volume(other, types[t], COUNT - 1);
        OWNED(iso_overview)
        a = look(path, 1, 2 * NX * NY * iso_type_bytes(types[t]), 2),
        b = look(other, 1, 2 * NX * NY * iso_type_bytes(types[t]), 2);
        assert_false(are_same(&a, &b));
    }
}

TEST(what_is_no_number_is_refused_with_its_place)
{
    FREED char *path = iso_path_join(folder, "nan.nrrd");
    OWNED(iso_volume) v;
    iso_volume_sink *sink = NULL;
    iso_volume_input input = {0};
    iso_overview s;
    const iso_geometry g = iso_geometry_axis_aligned((const size_t[]){NX, NY, NZ}, (const double[]){1, 1, 1});
    assert_ok(iso_volume_create(&v, &g, ISO_F32, "overview", &err));
    ((float *)v.data)[NX * NY * 9 + 3] = -INFINITY;
    assert_ok(iso_sink_open(path, &v, false, &sink, &err));
    assert_ok(iso_sink_write(sink, NZ, v.data, &err));
    assert_ok(iso_sink_commit(sink, &err));
    const iso_overview_options slabs = {.kept_bytes = 1, .slab_bytes = 2 * NX * NY * sizeof(float)};
    iso_error why = {""};
    assert_int_equal(iso_overview_run(path, &input, &slabs, &s, NULL, &why), ISO_E_RANGE);
    assert_non_null(strstr(why.text, "voxel (3, 0, 9) is NaN"));
    const iso_overview_options kept = {.drawn_bins = 0};
    assert_int_equal(iso_overview_run(path, &input, &kept, &s, NULL, &why), ISO_E_RANGE);
    assert_non_null(strstr(why.text, "the first is (3, 0, 9)"));
}

TEST_MAIN(make_folder, remove_folder)
