/* Direction codes: errors, zero, regions; the decoder in single precision. */
#include "test.h"

#include <math.h>
#include <string.h>

#include "base/linalg.h"
#include "encode/code.h"

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

static const double degree = 0.017453292519943295;

static uint64_t state = 20170613; /* the seed of every random test here */
static double uniform(void)
{
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return (double)(state >> 11) * 0x1p-53;
}

static iso_vec3 random_direction(void)
{
    double z = 2 * uniform() - 1, phi = 6.283185307179586 * uniform(), r = sqrt(1 - z * z);
    return iso_v3(r * cos(phi), r * sin(phi), z);
}

/* What a nearest fetch decodes to. */
static iso_vec3 round_trip(iso_code code, iso_vec3 d)
{
    float in[3] = {(float)d.x, (float)d.y, (float)d.z}, out[3];
    uint8_t bytes[3];
    iso_code_encode(code, in, bytes, 1);
    iso_code_decode_all(code, bytes, out, 1);
    return iso_v3(out[0], out[1], out[2]);
}

static double angle_deg(iso_vec3 a, iso_vec3 b)
{
    return atan2(iso_norm(iso_cross(a, b)), iso_dot(a, b)) / degree;
}

static double max_error_deg(iso_code code, int count)
{
    double worst = 0;
    for (int i = 0; i < count; ++i) {
        iso_vec3 d = random_direction();
        worst = fmax(worst, angle_deg(round_trip(code, d), d));
    }
    return worst;
}

static void every_code_has_a_name_that_leads_back(void **unused)
{
    (void)unused;
    for (int i = 0; i < ISO_CODE_COUNT; ++i) {
        iso_code found;
        assert_ok(iso_code_from_name(iso_code_describe(i)->name, &found, &err));
        assert_int_equal(found, i);
    }
    iso_code found;
    assert_status(iso_code_from_name("morse", &found, &err), ISO_E_USAGE);
}

static void region48_stays_within_the_papers_hole(void **unused)
{
    (void)unused;
    /* The supremum of the nearest direction's angle is 0.17303 (Table 1); 1e-5 for single precision. */
    assert_at_most(max_error_deg(ISO_CODE_REGION48, 20000), 0.17304);
    /* and the bound is not idle: random directions come near it. */
    assert_more_than(max_error_deg(ISO_CODE_REGION48, 20000), 0.14);
}

static void snorm_rounding_stays_within_half_a_step(void **unused)
{
    (void)unused;
    /* Half a step in each of three components: asin(sqrt(3) / 254) = 0.3907 degrees. */
    double worst = max_error_deg(ISO_CODE_SNORM, 100000);
    assert_at_most(worst, 0.3907);
    assert_more_than(worst, 0.3);
}

static void zero_is_kept_exactly(void **unused)
{
    (void)unused;
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

static void defined_directions_have_full_length_in_region48(void **unused)
{
    (void)unused;
    for (int i = 0; i < 5000; ++i) /* 1e-6: single precision */
        assert_within(iso_norm(round_trip(ISO_CODE_REGION48, random_direction())), 1, 1e-6);
}

static void snorm_keeps_the_length(void **unused)
{
    (void)unused;
    for (int i = 0; i < 5000; ++i) {
        double length = uniform();
        iso_vec3 d = round_trip(ISO_CODE_SNORM, iso_scale(random_direction(), length));
        assert_within(iso_norm(d), length, sqrt(3) / 254 + 1e-6); /* half a step in each component */
    }
}

/* One direction and its 48 images under permutations and signs. */
static void all_48_regions_are_alike(void **unused)
{
    (void)unused;
    static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (int code = 0; code < ISO_CODE_COUNT; ++code)
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
                assert_true(got.x == image_out[0] && got.y == image_out[1] && got.z == image_out[2]);
            }
        }
}

static void axes_and_diagonals_are_encoded(void **unused)
{
    (void)unused;
    for (int code = 0; code < ISO_CODE_COUNT; ++code)
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z) {
                    iso_vec3 d = iso_normalize(iso_v3(x, y, z));
                    if (x || y || z)
                        assert_at_most(angle_deg(round_trip(code, d), d), code == ISO_CODE_SNORM ? 0.3907 : 0.17304);
                }
}

/* The text that shaders get, compiled in single precision, against the double one. */
static void the_decoder_in_float_agrees_with_double(void **unused)
{
    (void)unused;
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

static void the_normal_fades_below_one_code_step_only(void **unused)
{
    (void)unused;
    double n[3];
    iso_code_normal((double[3]){0, 1, 0}, n);
    assert_within(n[1], 1, 4e-5); /* eps^2 / 2 = 3.1e-5 */
    iso_code_normal((double[3]){0, 0, -0.1}, n);
    assert_within(n[2], -1, 4e-3); /* eps^2 / 2 / 0.01 = 3.1e-3 */
    iso_code_normal((double[3]){ISO_DIRECTION_EPS, 0, 0}, n);
    assert_within(n[0], sqrt(0.5), 1e-12);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_code_has_a_name_that_leads_back),
        cmocka_unit_test(region48_stays_within_the_papers_hole),
        cmocka_unit_test(snorm_rounding_stays_within_half_a_step),
        cmocka_unit_test(zero_is_kept_exactly),
        cmocka_unit_test(defined_directions_have_full_length_in_region48),
        cmocka_unit_test(snorm_keeps_the_length),
        cmocka_unit_test(all_48_regions_are_alike),
        cmocka_unit_test(axes_and_diagonals_are_encoded),
        cmocka_unit_test(the_decoder_in_float_agrees_with_double),
        cmocka_unit_test(the_normal_fades_below_one_code_step_only),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
