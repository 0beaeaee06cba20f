/* SPDX-License-Identifier: MIT */
/* Direction codes: errors, zero, regions; the decoder in single precision. */
#include "encode/encode_kernel.h"
#include "tests/codes.h"
#include "tests/test.h"

typedef struct vec3f {
    float x, y, z;
} vec3f;
static inline vec3f make_vec3f(double x, double y, double z)
{
    return (vec3f){(float)x, (float)y, (float)z};
}
#define ISO_REAL float
#define ISO_VEC3 vec3f
#define ISO_MAKE_VEC3(x, y, z) make_vec3f(x, y, z)
#define ISO_SQRT(x) sqrtf(x)
#define ISO_ABS(x) fabsf(x)
#include "encode/code_decode.h"

static double max_error_deg(iso_code code, int count)
{
    double worst = 0;
    for (int i = 0; i < count; ++i) {
        iso_vec3 d = random_direction();
        worst = fmax(worst, angle_deg(round_trip(code, d), d));
    }
    return worst;
}

TEST(every_code_has_a_name_that_leads_back)
{
    for (int i = 0; i < ISO_CODE_COUNT; ++i) {
        iso_code found;
        assert_ok(iso_code_from_name(iso_code_describe(i)->name, &found, &err));
        assert_int_equal(found, i);
    }
    iso_code found;
    assert_status(iso_code_from_name("morse", &found, &err), ISO_E_USAGE);
}

TEST(region48_stays_within_the_papers_hole)
{
    /* The supremum of the nearest direction's angle is 0.17303 (Table 1); 1e-5 for single precision. */
    assert_at_most(max_error_deg(ISO_CODE_REGION48, 20000), 0.17304);
    /* and the bound is not idle: random directions come near it. */
    assert_more_than(max_error_deg(ISO_CODE_REGION48, 20000), 0.14);
}

TEST(snorm_rounding_stays_within_half_a_step)
{
    /* Half a step in each of three components: asin(sqrt(3) / 254) = 0.3907 degrees. */
    double worst = max_error_deg(ISO_CODE_SNORM, 100000);
    assert_at_most(worst, 0.3907);
    assert_more_than(worst, 0.3);
}

TEST(zero_is_kept_exactly)
{
    for (int i = 0; i < ISO_CODE_COUNT; ++i) {
        iso_vec3 d = round_trip(i, iso_v3(0, 0, 0));
        assert_true(d.x == 0 && d.y == 0 && d.z == 0);
        double n[3];
        iso_code_normal((double[3]){d.x, d.y, d.z}, n);
        assert_true(n[0] == 0 && n[1] == 0 && n[2] == 0);
    }
    uint8_t bytes[3];
    iso_code_encode(ISO_CODE_REGION48, (float[3]){0, 0, 0}, bytes, 1);
    assert_int_equal(bytes[0], 128);
    assert_int_equal(bytes[1], 128);
    assert_int_equal(bytes[2], 128);
}

/* "Undefined" has a code of its own: what every code makes of zero stays apart from what it makes of directions, the
 * poles of the octahedral map and the middle of the lattices included. */
TEST(no_direction_is_stored_as_undefined)
{
    for (int code = 0; code < ISO_CODE_COUNT; ++code) {
        const size_t size = iso_code_describe(code)->bytes;
        uint8_t undefined[8], bytes[8];
        iso_code_encode(code, (float[3]){0, 0, 0}, undefined, 1);
        for (int i = 0; i < 27 + 5000; ++i) {
            iso_vec3 d = i < 27 ? iso_v3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1) : random_direction();
            if (i == 13) /* zero */
                continue;
            if (i % 2) /* near the axis or the plane */
                d = iso_v3(d.x + 1e-6, d.y * 1e-3, d.z);
            d = iso_normalize(d);
            iso_code_encode(code, (float[3]){(float)d.x, (float)d.y, (float)d.z}, bytes, 1);
            assert_true(memcmp(bytes, undefined, size) != 0);
            assert_more_than(iso_norm(round_trip(code, d)), 0.9);
        }
    }
}

TEST(defined_directions_have_full_length_in_region48)
{
    for (int i = 0; i < 5000; ++i) /* 1e-6: single precision */
        assert_within(iso_norm(round_trip(ISO_CODE_REGION48, random_direction())), 1, 1e-6);
}

TEST(snorm_keeps_the_length)
{
    for (int i = 0; i < 5000; ++i) {
        double length = uniform();
        iso_vec3 d = round_trip(ISO_CODE_SNORM, iso_scale(random_direction(), length));
        assert_within(iso_norm(d), length, sqrt(3) / 254 + 1e-6); /* half a step in each component */
    }
}

/* The largest errors of each code (isoshade-lab encode finds them), a little rounded up. */
static const double limits_deg[ISO_CODE_COUNT] = {
    [ISO_CODE_SNORM] = 0.3907,   [ISO_CODE_FIT] = 0.33,     [ISO_CODE_SHELL] = 0.34,
    [ISO_CODE_FREE] = 0.3198,    [ISO_CODE_CUBE] = 0.3178,  [ISO_CODE_REGION48] = 0.17304,
    [ISO_CODE_OCT24] = 0.0397,   [ISO_CODE_HALF] = 0.0243,
};

TEST(every_code_stays_within_its_largest_error)
{
    for (int code = 0; code < ISO_CODE_COUNT; ++code) {
        double worst = max_error_deg(code, 100000);
        assert_at_most(worst, limits_deg[code]);
        assert_more_than(worst, 0.75 * limits_deg[code]); /* or the limit says nothing */
    }
}

/* One direction and its 48 images under permutations and signs. */
TEST(all_48_regions_are_alike)
{
    static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (int code = 0; code < ISO_CODE_OCT24; ++code) /* the octahedral map's lattice has fewer symmetries */
        for (int i = 0; i < 20; ++i) {
            iso_vec3 d = random_direction();
            iso_vec3 decoded = round_trip(code, d);
            double in[3] = {d.x, d.y, d.z}, out[3] = {decoded.x, decoded.y, decoded.z};
            for (int region = 0; region < 48; ++region) {
                double image_in[3], image_out[3];
                for (int a = 0; a < 3; ++a) {
                    double sign = region >> a & 1 ? -1 : 1;
                    image_in[a] = sign * in[orders[region / 8][a]];
                    image_out[a] = sign * out[orders[region / 8][a]];
                }
                iso_vec3 got = round_trip(code, iso_v3(image_in[0], image_in[1], image_in[2]));
                iso_vec3 image = iso_v3(image_in[0], image_in[1], image_in[2]);
                if (region < 8) { /* signs alone: the same bytes, negated */
                    assert_true(got.x == image_out[0] && got.y == image_out[1] && got.z == image_out[2]);
                } else { /* sums run in another order and may choose otherwise among candidates that are equal to 1e-5 */
                    assert_within(angle_deg(got, image), angle_deg(decoded, d), 1e-4);
                }
            }
        }
}

TEST(axes_and_diagonals_are_encoded)
{
    for (int code = 0; code < ISO_CODE_COUNT; ++code)
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z) {
                    iso_vec3 d = iso_normalize(iso_v3(x, y, z));
                    if (x || y || z)
                        assert_at_most(angle_deg(round_trip(code, d), d), limits_deg[code]);
                }
}

/* The text that shaders get, compiled in single precision, against the double one. */
TEST(the_decoder_in_float_agrees_with_double)
{
    for (int code = 0; code < ISO_CODE_COUNT; ++code)
        for (int i = 0; i < 20000; ++i) {
            vec3f e = make_vec3f(2 * uniform() - 1, 2 * uniform() - 1, 2 * uniform() - 1);
            vec3f f = iso_decode(iso_code_describe(code)->decoder, e);
            double d[3];
            iso_code_decode(code, (double[3]){e.x, e.y, e.z}, d);
            assert_within(f.x, d[0], 1e-6); /* a dozen roundings of 6e-8 */
            assert_within(f.y, d[1], 1e-6);
            assert_within(f.z, d[2], 1e-6);
            vec3f n = iso_shading_normal(f);
            assert_at_most(n.x * n.x + n.y * n.y + n.z * n.z, 1);
        }
}

static void fill_random(float *directions, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        iso_vec3 d = random_direction();
        directions[3 * i] = (float)d.x;
        directions[3 * i + 1] = (float)d.y;
        directions[3 * i + 2] = (float)d.z;
    }
}

TEST(encoders_with_and_without_avx2_give_the_same_bytes)
{
    enum { COUNT = 4099 }; /* not a multiple of a block */
    static float in[3 * COUNT];
    static uint8_t fast[6 * COUNT], baseline[6 * COUNT];
    fill_random(in, COUNT);
    for (size_t i = 0; i < COUNT; i += 5) /* zeros, short ones and long ones too */
        for (int a = 0; a < 3; ++a)
            in[3 * i + (size_t)a] *= (float)(i % 7) * 0.2f;
/* clang-format off */
#define SAME_BYTES(name)                                                                              \
    name(in, fast, COUNT);                                                                            \
    name##_baseline(in, baseline, COUNT);                                                             \
    size_t name##_differ = 0;                                                                         \
    for (size_t i = 0; i < 3 * COUNT; ++i)                                                            \
        name##_differ += fast[i] != baseline[i];                                                      \
    /* Only region48 fuses products: candidates that are equally near to 1e-5 may change places. */   \
    assert_true(name##_differ <= ((void (*)(const float *, uint8_t *, size_t))name == iso_encode_region48 ? 30 : 0));
    /* clang-format on */
    ISO_ENCODER_LIST(SAME_BYTES)
#undef SAME_BYTES
}

TEST(short_counts_touch_nothing_behind_them)
{
    float in[3 * 20];
    fill_random(in, 20);
    for (int code = 0; code < ISO_CODE_COUNT; ++code)
        for (size_t count = 0; count < 20; ++count) {
            uint8_t bytes[6 * 20];
            memset(bytes, 77, sizeof bytes);
            iso_code_encode(code, in, bytes, count);
            for (size_t i = iso_code_describe(code)->bytes * count; i < sizeof bytes; ++i)
                assert_int_equal(bytes[i], 77);
        }
}

TEST(lengths_are_kept_by_the_codes_that_say_so)
{
    for (int code = 0; code < ISO_CODE_COUNT; ++code)
        for (int i = 0; i < 2000; ++i) {
            double length = uniform(), got = iso_norm(round_trip(code, iso_scale(random_direction(), length)));
            /* A best fit trades up to 5 of 127 steps of length for direction. */
            if (iso_code_describe(code)->keeps_length)
                assert_within(got, length, code == ISO_CODE_FIT ? 5 / 127.0 : 0.0069);
            else
                assert_within(got, 1, 0.051); /* shell: 0.95 to 1 */
        }
}

static iso_vec3 decode_ranked(iso_code code, double y, double z)
{
    double d[3];
    iso_code_decode(code, (double[3]){1, y, z}, d);
    return iso_v3(d[0], d[1], d[2]);
}

/* Monotone in the paper's sense: small triangles of cube-dots keep their
 * orientation; and the edges of the 48 regions stay where they are. */
TEST(the_warping_decoder_does_not_fold)
{
    enum { STEPS = 600 };
    const double h = 1.0 / STEPS;
    const iso_code code = ISO_CODE_REGION48;
    for (int i = 1; i < STEPS; ++i)
        for (int j = 0; j < i; ++j) {
            iso_vec3 a = decode_ranked(code, i * h, j * h), b = decode_ranked(code, (i + 1) * h, j * h);
            iso_vec3 d = decode_ranked(code, i * h, (j + 1) * h);
            assert_more_than(iso_dot(iso_cross(a, b), d) / (h * h), 1e-4);
        }
    for (int i = 0; i <= STEPS; ++i) {
        assert_within(decode_ranked(code, i * h, 0).z, 0, 1e-15);
        iso_vec3 diagonal = decode_ranked(code, i * h, i * h), edge = decode_ranked(code, 1, i * h);
        assert_within(diagonal.y, diagonal.z, 1e-15);
        assert_within(edge.x, edge.y, 1e-15);
    }
}

TEST(the_normal_fades_below_one_code_step_only)
{
    double n[3];
    iso_code_normal((double[3]){0, 1, 0}, n);
    assert_within(n[1], 1, 4e-5); /* eps^2 / 2 = 3.1e-5 */
    iso_code_normal((double[3]){0, 0, -0.1}, n);
    assert_within(n[2], -1, 4e-3); /* eps^2 / 2 / 0.01 = 3.1e-3 */
    iso_code_normal((double[3]){ISO_DIRECTION_EPS, 0, 0}, n);
    assert_within(n[0], sqrt(0.5), 1e-12);
}

TEST_MAIN(NULL, NULL)
