/* SPDX-License-Identifier: MIT */
/* What codes are measured by: their holes, the best codes there are, the table of the paper. */
#include "tests/codes.h"
#include "tests/test.h"

#include "encode/encode_kernel.h"
#include "lab/codes/code_error.h"
#include "lab/codes/code_hole.h"
#include "lab/codes/encode_exact.h"

static double mean_error_deg(void (*encode)(const float *, uint8_t *, size_t), iso_code code, const float *in,
                             size_t count)
{
    FREED uint8_t *bytes = malloc(6 * count);
    FREED float *out = malloc(3 * count * sizeof *out);
    double sum = 0;
    encode(in, bytes, count);
    iso_code_decode_all(code, bytes, out, count);
    for (size_t i = 0; i < count; ++i)
        sum += angle_deg(iso_v3(out[3 * i], out[3 * i + 1], out[3 * i + 2]),
                         iso_v3(in[3 * i], in[3 * i + 1], in[3 * i + 2]));
    return sum / (double)count;
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

TEST(fast_searches_are_as_good_as_the_exact_ones)
{
    enum { COUNT = 5000 };
    static float in[3 * COUNT];
    fill_random(in, COUNT);
    double fit = mean_error_deg(iso_encode_fit, ISO_CODE_FIT, in, COUNT);
    double fit_exact = mean_error_deg(iso_encode_fit_exact, ISO_CODE_FIT, in, COUNT);
    assert_at_most(fit, 1.02 * fit_exact); /* the window leaves out the longest 1 % */
    assert_at_most(fit_exact, 1.02 * fit);
    double region48 = mean_error_deg(iso_encode_region48, ISO_CODE_REGION48, in, COUNT);
    double region48_exact = mean_error_deg(iso_encode_region48_exact, ISO_CODE_REGION48, in, COUNT);
    assert_within(region48, region48_exact, 1e-4 * region48_exact); /* expanded to second order */
    /* The planted fault: plain rounding is not within 2 % of the best fit. */
    assert_more_than(mean_error_deg(iso_encode_snorm, ISO_CODE_SNORM, in, COUNT), 1.5 * fit_exact);
}

TEST(holes_are_those_that_are_published)
{
    static const struct {
        iso_code code;
        double hole_deg, tolerance_deg;
    } known[] = {
        {ISO_CODE_REGION48, 0.17303, 1.5e-5}, /* [diaz-garcia-2017] Table 1: 0.1730 */
        {ISO_CODE_CUBE, 0.31776, 1.5e-5},     /* sqrt(2) / 255 rad, as a plane angle; Table 1: 0.3177 */
        {ISO_CODE_OCT24, 0.0396, 1e-4},
    };
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        iso_hole hole;
        const char *how;
        assert_ok(iso_code_hole(known[i].code, 1e-5, &hole, &how, &err));
        assert_within(hole.radius_deg, known[i].hole_deg, known[i].tolerance_deg);
        /* The encoder, which does not know of holes, attains it there. */
        double off = angle_deg(round_trip(known[i].code, hole.where), hole.where);
        if (strcmp(how, "exact") == 0)
            assert_within(off, hole.radius_deg, 1e-4); /* floats round the direction and the decoder */
    }
    iso_hole none, best;
    assert_ok(iso_region48_hole(0, 1e-5, &none, &err));
    assert_ok(iso_region48_hole(0.61, 1e-5, &best, &err));
    assert_within(none.radius_deg, 0.31776, 1.5e-5);
    assert_within(best.radius_deg, 0.17303, 1.5e-5);
    iso_vec3 outside = {1, 2, 0};
    assert_status(iso_hole_measure(&outside, 1, 1e-3, &best, &err), ISO_E_RANGE);
    assert_status(iso_hole_measure(&outside, 0, 1e-3, &best, &err), ISO_E_RANGE);
}

TEST(a_hole_of_few_directions_has_its_closed_form)
{
    /* The six axes: farthest from all is the diagonal. */
    iso_vec3 axis = {1, 0, 0};
    iso_hole hole;
    assert_ok(iso_hole_measure(&axis, 1, 1e-5, &hole, &err));
    assert_within(hole.radius_deg, acos(1 / sqrt(3)) / degree, 1.1e-5);
}

TEST(the_default_code_keeps_its_promises_between_voxels)
{
    iso_code_error_options opt = iso_code_error_defaults();
    iso_code_error fit, snorm, at_voxels;
    const iso_scheme fit_scheme = {"fit", ISO_CODE_FIT, NULL, NULL},
                     snorm_scheme = {"snorm", ISO_CODE_SNORM, NULL, NULL};
    opt.count = 20000;
    assert_ok(iso_code_error_measure(&fit_scheme, &opt, &at_voxels, &err));
    opt.apart_deg = 15;
    assert_ok(iso_code_error_measure(&fit_scheme, &opt, &fit, &err));
    assert_ok(iso_code_error_measure(&snorm_scheme, &opt, &snorm, &err));
    assert_at_most(at_voxels.max_deg, 0.33);
    assert_at_most(fit.mean_deg, 0.09);
    assert_at_most(fit.max_deg, 0.5);
    assert_more_than(snorm.mean_deg, 0.13); /* plain rounding must not pass */
    opt.count = 3;
    assert_status(iso_code_error_measure(&fit_scheme, &opt, &fit, &err), ISO_E_RANGE);
}

TEST(the_papers_table_finds_what_the_exact_search_finds)
{
    enum { COUNT = 2000 };
    static float in[3 * COUNT];
    fill_random(in, COUNT);
    in[0] = in[1] = in[2] = 0;
    in[3] = in[4] = in[5] = -0.5f;
    iso_paper_table table;
    assert_ok(iso_paper_table_create(128, &table, &err));
    static uint8_t bytes[3 * COUNT];
    static float out[3 * COUNT];
    iso_paper_encode(&table, in, bytes, COUNT);
    iso_code_decode_all(ISO_CODE_REGION48, bytes, out, COUNT);
    assert_true(out[0] == 0 && out[1] == 0 && out[2] == 0);
    for (size_t i = 1; i < COUNT; ++i) /* Table 4: 0.165 in a sample; 128^3 adds less than 1e-3 to 0.1730 */
        assert_at_most(angle_deg(iso_v3(in[3 * i], in[3 * i + 1], in[3 * i + 2]),
                                 iso_v3(out[3 * i], out[3 * i + 1], out[3 * i + 2])),
                       0.174);
    iso_paper_table_destroy(&table);
    assert_status(iso_paper_table_create(1, &table, &err), ISO_E_RANGE);
}

TEST_MAIN(NULL, NULL)
