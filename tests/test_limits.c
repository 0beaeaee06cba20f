/* SPDX-License-Identifier: MIT */
/* Limits of halved steps and closed forms: what is right agrees, what is planted does not, and the gates say which. */
#include "base/work.h"
#include "validate/closed_form.h"
#include "lab/faults.h"
#include "validate/validate.h"
#include "difference.h"
#include "sampled.h"
#include "volume/synthetic.h"

enum { pixels = 20 };

typedef struct subject {
    iso_pyramid pyramid;
    iso_view view;
} subject;

static iso_renderers renderers;

static int end_renderers(void **state)
{
    (void)state;
    iso_renderers_end(&renderers);
    return 0;
}

/* Unequal sizes and spacings; a TF of one color where `colors` is not asked for. */
static subject open_subject(iso_field_kind kind, bool colors, bool step)
{
    enum { entries = 17 };
    const size_t size[3] = {13, 11, 9};
    const double spacing[3] = {1, 1.25, 1.6};
    iso_field field = {.kind = kind, .geometry = iso_geometry_axis_aligned(size, spacing), .seed = 4};
    iso_pyramid_options build = iso_pyramid_defaults();
    subject s = {.view = {.width = pixels,
                          .height = pixels,
                          .light_count = 1,
                          .step_voxels = 0.5,
                          .shading = {.ambient = 0.2, .diffuse = 0.8, .specular = 0.3, .power = 5}}};
    build.level_count = 2;
    s.pyramid = sampled_pyramid(&field, ISO_F32, &build);
    iso_camera *c = &s.view.camera;
    c->forward = iso_normalize(iso_v3(1, 2, -0.7));
    c->right = iso_normalize(iso_cross(c->forward, iso_v3(0, 0, 1)));
    c->up = iso_cross(c->right, c->forward);
    c->half_height = 0.3;
    c->position = iso_scale(c->forward, -30);
    s.view.lights[0] = (iso_light){.direction = iso_normalize(iso_v3(-0.4, -1, 0.5)), .intensity = 1};
    s.view.background[1] = 0.2;
    s.view.tf = (iso_tf_table){.count = entries, .lo = 0, .hi = 1, .entries = calloc(entries, 4 * sizeof(float))};
    for (int i = 0; i < entries; ++i) {
        const float e[4] = {0.9f, colors ? 0.1f * (float)(i % 8) : 0.5f, 0.2f,
                            step ? (i > 8 ? 0.9f : 0.0f) : 0.02f + 0.01f * (float)i};
        memcpy(s.view.tf.entries + 4 * i, e, sizeof e);
    }
    return s;
}

static void close_subject(subject *s)
{
    iso_view_destroy(&s->view);
    iso_pyramid_destroy(&s->pyramid);
}

static iso_image reference(const subject *s)
{
    iso_image image;
    iso_render_options opt = iso_render_defaults(&iso_renderer_reference);
    assert_ok(
        iso_render_with(&(iso_render_request){&renderers, &s->pyramid, 0, &s->view, &opt, NULL}, &image, NULL, &err));
    return image;
}

/* The verdict that validation gives, and the gate that failed first ("" for the limit itself). */
static iso_verdict judge(const subject *s, const iso_image *truth, const iso_renderer_info *which, bool sharp,
                         char gate[64])
{
    OWNED(iso_extrapolated) limit;
    iso_limit_options opt = iso_limit_defaults();
    const iso_scene_agreement asked = {.tier = ISO_TIER_CONVERGENCE, .sharp = sharp};
    iso_report_agreement row = {.a = "a", .renderer = "b"};
    opt.step_voxels = 1.0 / 16;
    opt.factor = sharp ? ISO_EXTRAPOLATION_FACTOR_SHARP : ISO_EXTRAPOLATION_FACTOR_SMOOTH;
    assert_ok(iso_limit_find(&(iso_render_request){&renderers, &s->pyramid, 0, &s->view, NULL, NULL}, truth, which,
                             &opt, &limit, &err));
    assert_ok(iso_metrics_measure(truth, &limit.image, &row.metrics, &err));
    iso_validate_limit_row(&asked, &limit, &row);
    gate[0] = 0;
    for (size_t i = 0; i < row.gate_count && !gate[0]; ++i)
        if (!(row.gates[i].value <= row.gates[i].limit))
            snprintf(gate, 64, "%s", iso_gate_name(row.gates[i].gate));
    return iso_report_verdict(&row);
}

static double off_the_formula(const subject *s, const subject *rendered)
{
    OWNED(iso_image) formula, image = reference(rendered);
    assert_ok(iso_closed_form_render(&s->pyramid.levels[0], s->pyramid.options.code, &s->view, &formula, &err));
    double off = difference_of(&formula, &image).max_abs;
    return off;
}

TEST(the_reference_meets_the_closed_form)
{
    const iso_field_kind kinds[] = {ISO_FIELD_CONSTANT, ISO_FIELD_RAMP};
    for (int k = 0; k < 2; ++k) {
        ENDED_BY(close_subject) subject s = open_subject(kinds[k], false, false);
        assert_at_most(off_the_formula(&s, &s), 1e-6); /* the reference's tolerance */
    }
}

/* The formula knows place, unit, range, gradient and light. */
TEST(planted_faults_miss_the_closed_form)
{
    const iso_fault faults[] = {ISO_FAULT_HALF_VOXEL, ISO_FAULT_MIRRORED,  ISO_FAULT_STALE, ISO_FAULT_UNIT,
                                ISO_FAULT_RANGE,      ISO_FAULT_AXIS_SWAP, ISO_FAULT_LIGHT, ISO_FAULT_ONE_SIDED};
    ENDED_BY(close_subject) subject s = open_subject(ISO_FIELD_RAMP, false, false);
    for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i) {
        ENDED_BY(close_subject) subject wrong = open_subject(ISO_FIELD_RAMP, false, false);
        iso_fault_plant(faults[i], &wrong.pyramid, 0, &wrong.view);
        double off = off_the_formula(&s, &wrong);
        if (!(off > 1e-3))
            fail_msg("%s: only %g off", iso_fault_name(faults[i]), off);
    }
}

TEST(a_closed_form_is_refused_where_there_is_none)
{
    iso_image image;
    iso_error why = {""};
    ENDED_BY(close_subject)
    subject bent = open_subject(ISO_FIELD_SPHERE, false, false), colorful = open_subject(ISO_FIELD_RAMP, true, false);
    assert_int_equal(iso_closed_form_render(&bent.pyramid.levels[0], bent.pyramid.options.code, &bent.view, &image,
                                            &why),
                     ISO_E_RANGE);
    assert_non_null(strstr(why.text, "linear"));
    assert_int_equal(iso_closed_form_render(&colorful.pyramid.levels[0], colorful.pyramid.options.code, &colorful.view,
                                            &image, &why),
                     ISO_E_RANGE);
    assert_non_null(strstr(why.text, "colors"));
}

TEST(the_ray_caster_has_the_reference_for_its_limit)
{
    char gate[64];
    for (int sharp = 0; sharp < 2; ++sharp) {
        ENDED_BY(close_subject) subject s = open_subject(ISO_FIELD_NOISE, true, sharp);
        OWNED(iso_image) truth = reference(&s);
        assert_int_equal(judge(&s, &truth, &iso_renderer_gl, sharp, gate), ISO_VERDICT_AGREE);
    }
}

/* A wrong image converges as nicely as a right one, but elsewhere: the error does not fall. */
TEST(planted_faults_move_the_limit_out_of_its_bars)
{
    const iso_fault faults[] = {ISO_FAULT_HALF_VOXEL, ISO_FAULT_UNIT,      ISO_FAULT_SRGB,
                                ISO_FAULT_RANGE,      ISO_FAULT_AXIS_SWAP, ISO_FAULT_LIGHT,
                                ISO_FAULT_ONE_SIDED,  ISO_FAULT_STALE,     ISO_FAULT_MIRRORED};
    ENDED_BY(close_subject) subject s = open_subject(ISO_FIELD_NOISE, true, false);
    OWNED(iso_image) truth = reference(&s);
    for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i) {
        ENDED_BY(close_subject) subject wrong = open_subject(ISO_FIELD_NOISE, true, false);
        char gate[64];
        iso_fault_plant(faults[i], &wrong.pyramid, 0, &wrong.view);
        if (judge(&wrong, &truth, &iso_renderer_gl, false, gate) != ISO_VERDICT_DIFFER)
            fail_msg("not caught: %s", iso_fault_name(faults[i]));
        assert_string_equal(gate, "left of the error by halving the step");
    }
}

/* The verdict at a coarse start, and where the halving ended. */
static iso_verdict judge_from_afar(const subject *s, const iso_image *truth, bool sharp, bool to_the_end, double *step)
{
    OWNED(iso_extrapolated) limit;
    const iso_scene_agreement asked = {.tier = ISO_TIER_CONVERGENCE, .sharp = sharp};
    iso_limit_options opt = iso_validate_limit_options(&asked, &iso_renderer_gl, 2, 0);
    iso_report_agreement row = {.a = "a", .renderer = "b"};
    opt.step_voxels = 0.25;
    if (to_the_end)
        opt.hopeless = INFINITY;
    assert_ok(iso_limit_find(&(iso_render_request){&renderers, &s->pyramid, 0, &s->view, NULL, NULL}, truth,
                             &iso_renderer_gl, &opt, &limit, &err));
    assert_ok(iso_metrics_measure(truth, &limit.image, &row.metrics, &err));
    iso_validate_limit_row(&asked, &limit, &row);
    *step = limit.step_voxels;
    return iso_report_verdict(&row);
}

/* From a thousandth of a percent to a factor: what is given up is what would be rejected at the last step, too. */
TEST(what_is_hopeless_would_be_rejected_in_the_end)
{
    size_t sooner = 0, agreed = 0;
    double samples = 0, samples_to_the_end = 0; /* of what differs */
    for (int sharp = 0; sharp < 2; ++sharp) {
        ENDED_BY(close_subject) subject s = open_subject(ISO_FIELD_NOISE, true, sharp);
        OWNED(iso_image) truth = reference(&s);
        for (double amount = 1e-3; amount < 200; amount *= 4) {
            const iso_planted planted = {.deviation = ISO_DEVIATION_UNIT, .amount = amount};
            ENDED_BY(close_subject) subject wrong = open_subject(ISO_FIELD_NOISE, true, sharp);
            double step, last;
            iso_plant(&planted, &wrong.pyramid, 0, &wrong.view);
            const double before = iso_work_sum().samples;
            const iso_verdict verdict = judge_from_afar(&wrong, &truth, sharp, false, &step);
            const double between = iso_work_sum().samples;
            assert_int_equal(verdict, judge_from_afar(&wrong, &truth, sharp, true, &last));
            samples += verdict == ISO_VERDICT_DIFFER ? between - before : 0;
            samples_to_the_end += verdict == ISO_VERDICT_DIFFER ? iso_work_sum().samples - between : 0;
            sooner += step > last;
            agreed += verdict == ISO_VERDICT_AGREE;
        }
    }
    assert_true(sooner >= 4 && agreed >= 4);
    printf("what differs is told after %.2g of the samples\n", samples / samples_to_the_end);
    assert_more_than(samples_to_the_end, 1.5 * samples);
}

/* Where the TF's step is not resolved, the bars of a smooth TF are not reached, and the row says so. */
TEST(a_sharp_tf_that_is_called_smooth_is_told)
{
    ENDED_BY(close_subject) subject s = open_subject(ISO_FIELD_NOISE, true, true);
    for (size_t i = 3; i < 4 * s.view.tf.count; i += 4)
        s.view.tf.entries[i] *= 60; /* the first sample inside decides */
    OWNED(iso_image) truth = reference(&s);
    OWNED(iso_extrapolated) limit;
    iso_limit_options opt = iso_limit_defaults();
    opt.step_voxels = opt.finest_voxels = 0.5;
    assert_ok(iso_limit_find(&(iso_render_request){&renderers, &s.pyramid, 0, &s.view, NULL, NULL}, &truth,
                             &iso_renderer_gl, &opt, &limit, &err));
    iso_report_agreement row = {.a = "a", .renderer = "b"};
    assert_ok(iso_metrics_measure(&truth, &limit.image, &row.metrics, &err));
    iso_validate_limit_row(&(iso_scene_agreement){.tier = ISO_TIER_CONVERGENCE}, &limit, &row);
    assert_int_equal(iso_report_verdict(&row), ISO_VERDICT_DIFFER);
    assert_more_than(limit.bar, opt.wanted_bar);
}

TEST(wide_bars_are_halved_until_they_are_narrow)
{
    ENDED_BY(close_subject) subject s = open_subject(ISO_FIELD_NOISE, true, false);
    OWNED(iso_image) truth = reference(&s);
    OWNED(iso_extrapolated) coarse, fine;
    iso_limit_options opt = iso_limit_defaults();
    opt.step_voxels = 1, opt.wanted_bar = opt.wanted_left = opt.factor = INFINITY; /* anything goes */
    assert_ok(iso_limit_find(&(iso_render_request){&renderers, &s.pyramid, 0, &s.view, NULL, NULL}, &truth,
                             &iso_renderer_gl, &opt, &coarse, &err));
    assert_within(coarse.step_voxels, 1, 0);
    opt = iso_limit_defaults();
    opt.step_voxels = 1, opt.wanted_bar = coarse.step_bar / 10;
    assert_ok(iso_limit_find(&(iso_render_request){&renderers, &s.pyramid, 0, &s.view, NULL, NULL}, &truth,
                             &iso_renderer_gl, &opt, &fine, &err));
    assert_at_most(fine.step_voxels, 0.5);
    assert_at_most(fine.bar, opt.wanted_bar);
    opt.seeds = 1;
    iso_extrapolated none;
    assert_status(iso_limit_find(&(iso_render_request){&renderers, &s.pyramid, 0, &s.view, NULL, NULL}, &truth,
                                 &iso_renderer_gl, &opt, &none, &err),
                  ISO_E_RANGE);
}

/* RMSE may hold while structure does not: where both are asked for, halving goes on. Without that (the planted fault,
 * and what a shell of a coarse level once showed) the row of a lit scene differs, though a finer step would do. */
TEST(halving_goes_on_until_a_person_would_not_see_it)
{
    ENDED_BY(close_subject) subject s = open_subject(ISO_FIELD_NOISE, true, true);
    OWNED(iso_image) truth = reference(&s);
    OWNED(iso_extrapolated) blind, seeing;
    iso_limit_options opt = iso_limit_defaults();
    opt.step_voxels = 1, opt.wanted_bar = opt.wanted_left = opt.factor = INFINITY;
    assert_ok(iso_limit_find(&(iso_render_request){&renderers, &s.pyramid, 0, &s.view, NULL, NULL}, &truth,
                             &iso_renderer_gl, &opt, &blind, &err));
    opt.wanted_ssim_dissimilarity = blind.ssim_dissimilarity / 20;
    opt.wanted_flip = blind.flip_mean / 4;
    assert_ok(iso_limit_find(&(iso_render_request){&renderers, &s.pyramid, 0, &s.view, NULL, NULL}, &truth,
                             &iso_renderer_gl, &opt, &seeing, &err));
    assert_within(blind.step_voxels, 1, 0);
    assert_at_most(seeing.step_voxels, 0.5);
    assert_at_most(seeing.ssim_dissimilarity, opt.wanted_ssim_dissimilarity);
    assert_at_most(seeing.flip_mean, opt.wanted_flip);
}

/* Where nothing rounds by more than 7.6e-6 of the peak, 1.8e-5 in every pixel is a fault, though it would be none in
 * one. A white background doubles what is rounded; what POV-Ray draws before it is right. */
TEST(an_offset_of_the_whole_image_fails_povrays_lock_step)
{
    for (int white = 0; white < 2; ++white) {
        ENDED_BY(close_subject) subject s = open_subject(ISO_FIELD_NOISE, true, false);
        iso_render_options opt = iso_render_defaults(&iso_renderer_povray), same;
        OWNED(iso_image) image, truth;
        s.view.background[0] = s.view.background[1] = s.view.background[2] = white;
        same = iso_render_defaults(&iso_renderer_reference);
        same.quadrature = ISO_QUADRATURE_POVRAY;
        same.source = ISO_FROM_DECODED;
        same.intervals = opt.intervals = 64;
        assert_ok(
            iso_render_with(&(iso_render_request){&renderers, &s.pyramid, 0, &s.view, &opt, NULL}, &image, NULL, &err));
        assert_ok(iso_render_with(&(iso_render_request){&renderers, &s.pyramid, 0, &s.view, &same, NULL}, &truth, NULL,
                                  &err));
        iso_report_agreement row = {.a = "a", .renderer = "b", .error_bar = NAN};
        row.tolerances = iso_validate_lock_step(&iso_renderer_povray, &s.view, false);
        assert_ok(iso_metrics_measure(&truth, &image, &row.metrics, &err));
        assert_int_equal(iso_report_verdict(&row), ISO_VERDICT_AGREE);
        for (size_t i = 0; i < 4 * pixels * pixels; ++i)
            image.rgba[i] = truth.rgba[i] + (white ? 3.6e-5f : 1.8e-5f);
        assert_ok(iso_metrics_measure(&truth, &image, &row.metrics, &err));
        row.tolerances.max_abs = fmax(row.tolerances.max_abs, 4e-5); /* the RMSE alone has to see it */
        assert_int_equal(iso_report_verdict(&row), ISO_VERDICT_DIFFER);
    }
}

/* POV-Ray's pair: the planes stay, the intervals halve, and the finer step is what was asked for or less. */
TEST(povrays_pair_halves_the_intervals_between_the_same_planes)
{
    ENDED_BY(close_subject) subject s = open_subject(ISO_FIELD_CONSTANT, false, false);
    const iso_geometry *g = &s.pyramid.levels[0].geometry;
    const double chord = 2 * iso_geometry_box_radius_mm(g) / iso_geometry_min_spacing_mm(g);
    for (double step = 1; step > 0.005; step /= 2) {
        iso_render_options frames[2] = {iso_render_defaults(&iso_renderer_povray),
                                        iso_render_defaults(&iso_renderer_povray)};
        iso_render_ask_steps(&iso_renderer_povray, &s.pyramid.levels[0], step, 2, fmin(fmax(64 * step, 1), 4), frames);
        const iso_render_options coarse = frames[0], fine = frames[1];
        assert_int_equal(fine.intervals, 2 * coarse.intervals);
        assert_int_equal(fine.planes, coarse.planes);
        assert_at_most((double)fine.intervals, 255);
        double most = chord / (double)(fine.intervals * (fine.planes + 1));
        assert_at_most(most, step * (1 + 1e-9));
        assert_more_than(most, 0.6 * step); /* and not much finer */
    }
}

/* What a report says of a limit is enough to make it again, whatever steps it was halved from. */
TEST(a_limit_is_made_again_from_what_is_said_of_it)
{
    static const iso_renderer_info *const which[] = {&iso_renderer_gl, &iso_renderer_povray};
    ENDED_BY(close_subject) subject s = open_subject(ISO_FIELD_NOISE, true, false);
    OWNED(iso_image) truth = reference(&s);
    for (int i = 0; i < 2; ++i) {
        OWNED(iso_extrapolated) found;
        OWNED(iso_image) again, other;
        iso_limit_options opt = iso_limit_defaults();
        opt.step_voxels = 1, opt.finest_voxels = 0.5, opt.wanted_bar = 0; /* halved once */
        assert_ok(iso_limit_find(&(iso_render_request){&renderers, &s.pyramid, 0, &s.view, NULL, NULL}, &truth,
                                 which[i], &opt, &found, &err));
        assert_within(found.step_voxels, 0.5, 0);
        opt = iso_limit_defaults();
        opt.step_voxels = found.step_voxels, opt.planes = found.planes, opt.intervals = found.intervals;
        assert_ok(iso_limit_render(&(iso_render_request){&renderers, &s.pyramid, 0, &s.view, NULL, NULL}, which[i],
                                   &opt, &again, &err));
        assert_within(difference_of(&found.image, &again).max_abs, 0, 0);
        opt.step_voxels /= 2, opt.intervals = 2 * ((opt.intervals + 2) / 3);
        assert_ok(iso_limit_render(&(iso_render_request){&renderers, &s.pyramid, 0, &s.view, NULL, NULL}, which[i],
                                   &opt, &other, &err));
        assert_more_than(difference_of(&found.image, &other).max_abs, 1e-4); /* another step is another limit */
    }
}

/* What people see when the images alternate, though their RMSE is allowed: FLIP and 1 - SSIM are asked for too. */
TEST(lit_images_that_look_different_differ)
{
    const struct {
        double flip, ssim_dissimilarity;
        iso_verdict verdict;
    } cases[] = {{5e-3, 5e-4, ISO_VERDICT_AGREE}, {2e-2, 5e-4, ISO_VERDICT_DIFFER}, {5e-3, 2e-3, ISO_VERDICT_DIFFER}};
    const iso_scene_agreement lit = {.tier = ISO_TIER_LIT}, unlit = {.tier = ISO_TIER_CONVERGENCE};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const iso_extrapolated limit = {.allowed = 0.1, .bar = 1e-5, .coarse_rmse = 4e-6, .fine_rmse = 1e-6};
        iso_report_agreement row = {.a = "a", .renderer = "b"}, plain = row;
        row.metrics = (iso_metrics){.flip_mean = cases[i].flip, .ssim = 1 - cases[i].ssim_dissimilarity};
        plain.metrics = row.metrics;
        iso_validate_limit_row(&lit, &limit, &row);
        iso_validate_limit_row(&unlit, &limit, &plain);
        assert_int_equal(iso_report_verdict(&row), cases[i].verdict);
        assert_int_equal(iso_report_verdict(&plain), ISO_VERDICT_AGREE);
    }
}

TEST_MAIN(NULL, end_renderers)
