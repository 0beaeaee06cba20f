/* SPDX-License-Identifier: MIT */
#include "test.h"

#include "base/random.h"
#include "volume/synthetic.h"

/* Unequal sizes and spacings, turned and off the origin: a swapped axis shows. */
static iso_field turned_field(iso_field_kind kind)
{
    iso_field f = {.kind = kind, .seed = 5};
    f.geometry = iso_geometry_axis_aligned((size_t[]){40, 56, 33}, (double[]){1, 0.8, 1.5});
    double c = cos(0.4), s = sin(0.4);
    f.geometry.index_to_world = (iso_mat3){{{c, -s * 0.8, 0}, {s, c * 0.8, 0}, {0, 0, 1.5}}};
    f.geometry.origin_mm = iso_v3(100, -50, 7);
    return f;
}

/* A kink between the two points of a difference makes it no gradient. */
static bool near_kink(const iso_field *f, iso_vec3 world)
{
    iso_vec3 p = iso_scale(iso_sub(world, iso_geometry_box_center_mm(&f->geometry)), 1 / 20.0);
    double r = iso_norm(p), flank = 1.5 / 20;
    if (f->kind == ISO_FIELD_SPHERE)
        return r < 1e-3 || fabs(r - 1) < 1e-3;
    if (f->kind == ISO_FIELD_SLAB)
        return fabs(fabs(fabs(p.z) - 0.5) - flank / 2) < 1e-3;
    return false;
}

TEST(gradients_equal_numerical_differences_of_the_values)
{
    iso_random random = {11};
    for (int kind = 0; kind < ISO_FIELD_COUNT; ++kind) {
        iso_field f = turned_field((iso_field_kind)kind);
        double steepest = 0;
        for (int i = 0; i < 2000; ++i) {
            iso_vec3 index = iso_v3(40 * iso_random_unit(&random), 56 * iso_random_unit(&random),
                                    33 * iso_random_unit(&random));
            iso_vec3 at = iso_geometry_to_world(&f.geometry, index), g;
            iso_field_value(&f, at, &g);
            if (near_kink(&f, at))
                continue;
            const double h = 1e-4; /* mm */
            double d[3];
            for (int a = 0; a < 3; ++a) {
                iso_vec3 e = iso_v3(a == 0 ? h : 0, a == 1 ? h : 0, a == 2 ? h : 0);
                d[a] = (iso_field_value(&f, iso_add(at, e), NULL) - iso_field_value(&f, iso_sub(at, e), NULL)) /
                       (2 * h);
            }
            /* third derivative h^2 / 6, at most (6 pi^2 / 20)^3 h^2 / 6 = 4e-8, and rounding 1e-16 / h */
            assert_within(g.x, d[0], 1e-7);
            assert_within(g.y, d[1], 1e-7);
            assert_within(g.z, d[2], 1e-7);
            steepest = fmax(steepest, iso_norm(g));
        }
        if (kind != ISO_FIELD_CONSTANT)
            assert_more_than(steepest, 1e-3); /* the comparison saw gradients */
    }
}

TEST(samples_are_the_field_at_voxel_centers)
{
    for (int kind = 0; kind < ISO_FIELD_COUNT; ++kind) {
        iso_field f = turned_field((iso_field_kind)kind);
        OWNED(iso_volume) v;
        assert_ok(iso_field_sample(&f, ISO_F64, &v, &err));
        const double *samples = v.data;
        for (size_t i = 0; i < 40 * 56 * 33; i += 97) {
            iso_vec3 center = iso_v3((double)(i % 40) + 0.5, (double)(i / 40 % 56) + 0.5, (double)(i / 2240) + 0.5);
            /* positions are stepped along a row: rounding of 1e-15, times slopes up to 1 / .03 */
            assert_within(samples[i], iso_field_value(&f, iso_geometry_to_world(&f.geometry, center), NULL), 1e-12);
        }
    }
}

TEST(integer_types_use_their_whole_range)
{
    static const double lo[] = {0, -128, 0, -32768, 0, -2147483648.0},
                        hi[] = {255, 127, 65535, 32767, 4294967295.0, 2147483647.0};
    iso_field f = {.kind = ISO_FIELD_SLAB};
    f.geometry = iso_geometry_axis_aligned((size_t[]){4, 4, 12}, (double[]){3, 3, 1});
    for (int type = ISO_U8; type <= ISO_I32; ++type) {
        OWNED(iso_volume) v;
        assert_ok(iso_field_sample(&f, (iso_type)type, &v, &err));
        iso_volume_stats s = iso_volume_measure(&v);
        assert_within(s.min, lo[type], 0);
        assert_within(s.max, hi[type], 0);
    }
}

TEST(planes_do_not_depend_on_slabs_or_threads)
{
    for (int kind = 0; kind < ISO_FIELD_COUNT; ++kind) {
        iso_field f = turned_field((iso_field_kind)kind);
        f.grain = 0.1;
        const size_t plane = 40 * 56;
        FREED float *whole = malloc(33 * plane * sizeof *whole), *slab = malloc(33 * plane * sizeof *slab);
        assert_ok(iso_field_sample_planes(&f, ISO_F32, 0, 33, 1, whole, &err));
        for (size_t z = 0; z < 33; z += 5) {
            size_t end = z + 5 < 33 ? z + 5 : 33;
            assert_ok(iso_field_sample_planes(&f, ISO_F32, z, end, 3, slab, &err));
            assert_memory_equal(slab, whole + z * plane, (end - z) * plane * sizeof *slab);
        }
    }
}

TEST(known_values_are_where_they_should_be)
{
    iso_field f = {.kind = ISO_FIELD_SPHERE};
    f.geometry = iso_geometry_axis_aligned((size_t[]){20, 30, 40}, (double[]){1, 1, 1});
    iso_vec3 g;
    assert_within(iso_field_value(&f, iso_v3(0, 5, 0), &g), 0.5, 1e-15); /* half of the half edge of 10 mm */
    assert_within(g.y, -0.1, 1e-15);
    f.kind = ISO_FIELD_SHELLS;
    assert_within(iso_field_value(&f, iso_v3(0, 0, 4.5), NULL), 1, 1e-12);
    assert_within(iso_field_value(&f, iso_v3(8, 0, 0), NULL), 1, 1e-12);
    f.kind =
        ISO_FIELD_MARSCHNER_LOBB; /* at the center: (1 - 0 + alpha (1 + cos 12 pi)) / (2 (1 + alpha)) = 1.5 / 2.5 */
    assert_within(iso_field_value(&f, iso_v3(0, 0, 0), NULL), 0.6, 1e-12);
    f.kind = ISO_FIELD_SLAB;
    assert_within(iso_field_value(&f, iso_v3(0, 0, 4.4), NULL), 1, 0);
    assert_within(iso_field_value(&f, iso_v3(0, 0, 5), NULL), 0.5, 1e-15);
    assert_within(iso_field_value(&f, iso_v3(0, 0, 5.6), NULL), 0, 0);
}

TEST(another_seed_is_another_noise)
{
    iso_field a = turned_field(ISO_FIELD_NOISE), b = a;
    b.seed = 6;
    double difference = 0;
    for (int i = 0; i < 20; ++i) {
        iso_vec3 at = iso_v3(90 + i, -40 + 2 * i, 20);
        difference = fmax(difference, fabs(iso_field_value(&a, at, NULL) - iso_field_value(&b, at, NULL)));
    }
    assert_more_than(difference, 0.02);
}

/* Grain of a tenth: its mean, deviation and what neighbors share, of 20^3 voxels; each within four standard errors. */
TEST(grain_is_white_and_as_strong_as_was_asked)
{
    iso_field f = {.kind = ISO_FIELD_CONSTANT, .seed = 3, .grain = 0.1};
    f.geometry = iso_geometry_axis_aligned((size_t[]){20, 20, 20}, (double[]){1, 1, 1});
    iso_volume v;
    assert_ok(iso_field_sample(&f, ISO_F64, &v, &err));
    const double *value = v.data;
    enum { n = 20 * 20 * 20 };
    double mean = 0, square = 0, along[3] = {0, 0, 0};
    const size_t step[3] = {1, 20, 400};
    for (size_t i = 0; i < n; ++i)
        mean += (value[i] - 0.5) / n, square += (value[i] - 0.5) * (value[i] - 0.5) / n;
    for (int a = 0; a < 3; ++a)
        for (size_t i = 0; i < n - 400; ++i)
            along[a] += (value[i] - 0.5) * (value[i + step[a]] - 0.5) / (n - 400) / square;
    assert_within(mean, 0, 4 * 0.1 / sqrt(n));
    assert_within(sqrt(square), 0.1, 4 * 0.1 / sqrt(2.0 * n));
    for (int a = 0; a < 3; ++a)
        assert_within(along[a], 0, 4 / sqrt(n));
    const double first = value[0];
    iso_volume_destroy(&v);
    f.seed = 4;
    assert_ok(iso_field_sample(&f, ISO_F64, &v, &err));
    assert_more_than(fabs(((const double *)v.data)[0] - first), 1e-6);
    iso_volume_destroy(&v);
}

TEST(unknown_names_are_refused_with_the_list)
{
    iso_field_kind kind;
    iso_error message = {""};
    assert_int_equal(iso_field_from_name("spheer", &kind, &message), ISO_E_USAGE);
    assert_non_null(strstr(message.text, "marschner-lobb"));
    for (int k = 0; k < ISO_FIELD_COUNT; ++k) {
        assert_ok(iso_field_from_name(iso_field_name((iso_field_kind)k), &kind, &err));
        assert_int_equal(kind, k);
    }
}

TEST_MAIN(NULL, NULL)
