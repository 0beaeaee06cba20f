/* SPDX-License-Identifier: MIT */
/* The baseline: what counts as worse, and that nothing is accepted by itself. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "report/baseline.h"
#include "tests/test.h"

static json_t *report(double rmse, double flip, const char *extra_scene)
{
    json_t *r = json_pack(
        "{s:s, s:s, s:{s:s}, s:[{s:s, s:i, s:s, s:s, s:s, s:s, s:f, s:f, s:f, s:f}], s:[{s:s, s:i, s:f, s:f, s:n}]}",
        "schema", "isoshade.validate/1", "command", "isoshade validate v", "versions", "gl", "llvmpipe 1", "agreement",
        "scene", "smooth", "level", 1, "a", "reference", "b", "gl", "tier", "tight", "verdict", "agree", "rmse", rmse,
        "max_abs", 0.5, "p99_abs", 0.25, "flip_mean", 0.125, "consistency", "method", "naive", "level", 2,
        "ssim_dissimilarity_mean", 0.1, "flip_mean", flip, "gradient_angle_mean_deg");
    assert_non_null(r);
    if (extra_scene) {
        json_t *row = json_deep_copy(json_array_get(json_object_get(r, "agreement"), 0));
        json_object_set_new(row, "scene", json_string(extra_scene));
        json_array_append_new(json_object_get(r, "agreement"), row);
    }
    return r;
}

static json_t *figures_of(json_t *r)
{
    json_t *b;
    assert_ok(iso_baseline_from_report(r, &b, &err));
    json_decref(r);
    return b;
}

static iso_baseline_result run(json_t *now, json_t *accepted)
{
    iso_baseline_result result;
    assert_ok(iso_baseline_compare(now, accepted, 1.25, 1e-7, &result, &err));
    json_decref(now);
    json_decref(accepted);
    return result;
}

static void the_same_report_is_as_accepted(void **state)
{
    (void)state;
    iso_baseline_result r = run(figures_of(report(1e-3, 0.2, NULL)), figures_of(report(1e-3, 0.2, NULL)));
    assert_true(r.same == 7 && r.worse + r.missing + r.better + r.added == 0); /* an angle that is null is no figure */
    assert_int_equal(json_array_size(r.changes) + json_array_size(r.facts), 0);
    iso_baseline_result_destroy(&r);
}

static void a_figure_beyond_the_factor_is_worse_and_comes_first(void **state)
{
    (void)state;
    iso_baseline_result r = run(figures_of(report(1.3e-3, 0.1, NULL)), figures_of(report(1e-3, 0.2, NULL)));
    assert_true(r.worse == 1 && r.better == 1 && r.same == 5);
    json_t *first = json_array_get(r.changes, 0);
    assert_string_equal(json_string_value(json_object_get(first, "change")), "worse");
    assert_string_equal(json_string_value(json_object_get(first, "figure")),
                        "agreement/smooth/level 1/reference/gl/tight/rmse");
    iso_baseline_result_destroy(&r);
    r = run(figures_of(report(1.2e-3, 0.2, NULL)), figures_of(report(1e-3, 0.2, NULL)));
    assert_int_equal(r.worse, 0);
    iso_baseline_result_destroy(&r);
}

static void the_floor_forgives_rounding(void **state)
{
    (void)state;
    iso_baseline_result r = run(figures_of(report(9e-8, 0.2, NULL)), figures_of(report(0, 0.2, NULL)));
    assert_int_equal(r.worse, 0);
    iso_baseline_result_destroy(&r);
    r = run(figures_of(report(2e-7, 0.2, NULL)), figures_of(report(0, 0.2, NULL)));
    assert_int_equal(r.worse, 1);
    iso_baseline_result_destroy(&r);
}

static void a_lost_case_is_missing_and_a_new_one_is_no_failure(void **state)
{
    (void)state;
    iso_baseline_result r = run(figures_of(report(1e-3, 0.2, NULL)), figures_of(report(1e-3, 0.2, "sharp")));
    assert_int_equal(r.missing, 5); /* four figures and the verdict */
    iso_baseline_result_destroy(&r);
    r = run(figures_of(report(1e-3, 0.2, "sharp")), figures_of(report(1e-3, 0.2, NULL)));
    assert_true(r.added == 5 && r.worse + r.missing == 0);
    iso_baseline_result_destroy(&r);
}

/* The figures under an adapted TF stand beside those under the original; reports of before have none, and no "tf". */
static void rows_under_either_tf_are_kept_apart(void **state)
{
    (void)state;
    json_t *now = report(1e-3, 0.2, NULL), *rows = json_object_get(now, "consistency");
    json_t *adapted = json_deep_copy(json_array_get(rows, 0));
    json_object_set_new(json_array_get(rows, 0), "tf", json_string("original"));
    json_object_set_new(adapted, "tf", json_string("adapted"));
    json_object_set_new(adapted, "flip_mean", json_real(0.1));
    json_array_append_new(rows, adapted);
    json_t *worse = json_deep_copy(now);
    json_object_set_new(json_array_get(json_object_get(worse, "consistency"), 1), "flip_mean", json_real(0.2));
    json_t *accepted = figures_of(now);
    const json_t *kept = json_object_get(json_object_get(accepted, "rows"), "consistency/naive+adapted/level 2");
    assert_within(json_number_value(json_object_get(kept, "flip_mean")), 0.1, 0);
    iso_baseline_result r = run(json_incref(accepted), figures_of(report(1e-3, 0.2, NULL)));
    assert_true(r.same == 7 && r.added == 2 && r.worse + r.missing == 0);
    iso_baseline_result_destroy(&r);
    r = run(figures_of(worse), accepted); /* planted: the original's figure under the adapted TF */
    assert_int_equal(r.worse, 1);
    assert_string_equal(json_string_value(json_object_get(json_array_get(r.changes, 0), "figure")),
                        "consistency/naive+adapted/level 2/flip_mean");
    iso_baseline_result_destroy(&r);
}

/* A case that is refused or not finite has null figures: it must not pass as "as accepted". */
static void a_figure_that_became_null_is_missing(void **state)
{
    (void)state;
    json_t *broken = report(1e-3, 0.2, NULL);
    json_object_set_new(json_array_get(json_object_get(broken, "agreement"), 0), "rmse", json_null());
    iso_baseline_result r = run(figures_of(broken), figures_of(report(1e-3, 0.2, NULL)));
    assert_int_equal(r.missing, 1);
    iso_baseline_result_destroy(&r);
}

static json_t *with_verdict(const char *verdict)
{
    json_t *r = report(1e-3, 0.2, NULL);
    json_object_set_new(json_array_get(json_object_get(r, "agreement"), 0), "verdict", json_string(verdict));
    return figures_of(r);
}

/* Fewer certainties than before are worse, though nothing differs: a row that agreed is only reported; its error bar, a gate's
 * limit or a limit of the metrics grew; its gate is nearly used up; SSIM fell. */
static json_t *certain_report(void)
{
    json_t *r = report(1e-3, 0.2, NULL), *row = json_array_get(json_object_get(r, "agreement"), 0);
    json_object_update_new(row,
                           json_pack("{s:f, s:f, s:{s:f}, s:[{s:s, s:f, s:f}]}", "ssim", 0.99, "error_bar", 2e-3,
                                     "limits", "rmse", 3e-3, "gates", "name", "bias", "value", -1.0, "limit", 4.0));
    json_object_set_new(r, "calibration",
                        json_pack("[{s:s, s:s, s:f, s:f, s:s}]", "renderer", "gl", "check", "slab", "value", 1e-4,
                                  "limit", 1e-3, "verdict", "pass"));
    return r;
}

static void what_is_less_certain_than_before_is_worse(void **state)
{
    (void)state;
    static const struct {
        const char *section, *set, *figure; /* what is planted, and the figure that has to be named */
    } planted[] = {
        {"agreement", "{\"verdict\": \"reported\"}", "agreement/smooth/level 1/reference/gl/tight/verdict"},
        {"agreement", "{\"error_bar\": 3e-3}", "agreement/smooth/level 1/reference/gl/tight/error_bar"},
        {"agreement", "{\"ssim\": 0.98}", "agreement/smooth/level 1/reference/gl/tight/ssim_dissimilarity"},
        {"agreement", "{\"limits\": {\"rmse\": 1}}", "agreement/smooth/level 1/reference/gl/tight/limit of rmse"},
        {"agreement", "{\"gates\": [{\"name\": \"bias\", \"value\": 3.9, \"limit\": 4}]}",
         "agreement/smooth/level 1/reference/gl/tight/bias, part of its limit"},
        {"agreement", "{\"gates\": [{\"name\": \"bias\", \"value\": 1, \"limit\": 40}]}",
         "agreement/smooth/level 1/reference/gl/tight/limit of bias"},
        {"calibration", "{\"verdict\": \"fail\"}", "calibration/gl/slab/verdict"},
        {"calibration", "{\"value\": 9e-4}", "calibration/gl/slab/value"},
    };
    for (size_t i = 0; i < sizeof planted / sizeof *planted; ++i) {
        json_t *now = certain_report();
        assert_int_equal(json_object_update_new(json_array_get(json_object_get(now, planted[i].section), 0),
                                                json_loads(planted[i].set, 0, NULL)),
                         0);
        iso_baseline_result r = run(figures_of(now), figures_of(certain_report()));
        assert_int_equal(r.worse + r.missing, 1);
        assert_string_equal(json_string_value(json_object_get(json_array_get(r.changes, 0), "figure")),
                            planted[i].figure);
        iso_baseline_result_destroy(&r);
    }
    json_t *without = certain_report(); /* a calibration or a gate that is not there any more is missing */
    json_object_del(without, "calibration");
    json_object_del(json_array_get(json_object_get(without, "agreement"), 0), "gates");
    iso_baseline_result r = run(figures_of(without), figures_of(certain_report()));
    assert_int_equal(r.missing, 5);
    iso_baseline_result_destroy(&r);
}

static json_t *with_a_level(const char *verdict, double flip)
{
    json_t *r = report(1e-3, 0.2, NULL);
    json_object_set_new(r, "levels", json_pack("[{s:i, s:s, s:[{s:s, s:f, s:f}]}]", "level", 1, "verdict", verdict,
                                               "figures", "figure", "flip", "value", flip, "asked", 0.25));
    return r;
}

static void a_level_that_held_and_does_not_is_worse(void **state)
{
    (void)state;
    iso_baseline_result r = run(figures_of(with_a_level("differ", 0.1)), figures_of(with_a_level("agree", 0.1)));
    assert_true(r.worse == 1 && r.missing == 0);
    assert_string_equal(json_string_value(json_object_get(json_array_get(r.changes, 0), "figure")),
                        "levels/level 1/verdict");
    iso_baseline_result_destroy(&r);
    r = run(figures_of(with_a_level("agree", 0.2)), figures_of(with_a_level("agree", 0.1)));
    assert_true(r.worse == 1 && r.missing == 0); /* its figure */
    iso_baseline_result_destroy(&r);
    r = run(figures_of(report(1e-3, 0.2, NULL)), figures_of(with_a_level("agree", 0.1)));
    assert_true(r.worse == 0 && r.missing == 3);
    iso_baseline_result_destroy(&r);
}

/* A word that is not known must not pass for anything; nor a list with verdicts that no table has. */
static void what_is_not_known_of_a_report_is_refused(void **state)
{
    (void)state;
    const char *const words[] = {"fine", "", "pass"}; /* the last is one of calibrations */
    json_t *b;
    iso_error why;
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i) {
        json_t *r = with_a_level(words[i], 0.1);
        assert_int_equal(iso_baseline_from_report(r, &b, &why), ISO_E_FORMAT);
        assert_non_null(strstr(why.text, "levels, row 1: verdict"));
        json_decref(r);
    }
    json_t *r = with_a_level("agree", 0.1);
    json_object_set_new(r, "made_up", json_pack("[{s:s}]", "verdict", "agree"));
    assert_int_equal(iso_baseline_from_report(r, &b, &why), ISO_E_FORMAT);
    assert_non_null(strstr(why.text, "\"made_up\" has verdicts and is no section that is known"));
    json_decref(r);
    r = with_a_level("agree", 0.1);
    json_object_set_new(r, "verdict", json_string("good"));
    assert_status(iso_baseline_from_report(r, &b, &err), ISO_E_FORMAT);
    json_decref(r);
    iso_baseline_result result;
    json_t *now = figures_of(with_a_level("agree", 0.1)), *accepted = figures_of(with_a_level("agree", 0.1));
    json_object_set_new(json_object_get(json_object_get(accepted, "rows"), "levels/level 1"), "verdict",
                        json_string("god"));
    assert_status(iso_baseline_compare(now, accepted, 1.25, 1e-7, &result, &err), ISO_E_FORMAT);
    json_decref(now);
    json_decref(accepted);
}

/* A gate that fails need not show in any figure. */
static void a_row_that_agreed_and_does_not_is_worse(void **state)
{
    (void)state;
    const char *const bad[] = {"differ", "refused"};
    for (int i = 0; i < 2; ++i) {
        iso_baseline_result r = run(with_verdict(bad[i]), with_verdict("agree"));
        assert_true(r.worse == 1 && r.same == 6);
        assert_string_equal(json_string_value(json_object_get(json_array_get(r.changes, 0), "figure")),
                            "agreement/smooth/level 1/reference/gl/tight/verdict");
        iso_baseline_result_destroy(&r);
        r = run(with_verdict("agree"), with_verdict(bad[i]));
        assert_true(r.better == 1 && r.worse == 0);
        iso_baseline_result_destroy(&r);
    }
}

static void other_versions_are_told_and_are_no_failure(void **state)
{
    (void)state;
    json_t *other = report(1e-3, 0.2, NULL);
    json_object_set_new(json_object_get(other, "versions"), "gl", json_string("llvmpipe 2"));
    json_object_set_new(other, "options", json_pack("{s:b}", "quick", 1));
    iso_baseline_result r = run(figures_of(other), figures_of(report(1e-3, 0.2, NULL)));
    assert_true(r.worse + r.missing == 0 && json_array_size(r.facts) == 2);
    const json_t *first = json_array_get(r.facts, 0);
    assert_string_equal(json_string_value(json_object_get(first, "fact")), "versions/gl");
    assert_string_equal(json_string_value(json_object_get(first, "accepted")), "llvmpipe 1");
    assert_string_equal(json_string_value(json_object_get(first, "now")), "llvmpipe 2");
    iso_baseline_result_destroy(&r);
}

/* Reports list their rows by severity, which a last digit changes: a baseline must not. */
static void the_same_rows_give_the_same_text_in_any_order(void **state)
{
    (void)state;
    json_t *a = report(1.23456789e-3, 0.2, "another"), *b = json_deep_copy(a), *rows = json_object_get(b, "agreement");
    json_array_append(rows, json_array_get(rows, 0));
    json_array_remove(rows, 0);
    a = figures_of(a), b = figures_of(b);
    char *text_a = json_dumps(a, JSON_REAL_PRECISION(9)), *text_b = json_dumps(b, JSON_REAL_PRECISION(9));
    assert_string_equal(text_a, text_b);
    assert_non_null(strstr(text_a, "\"rmse\": 0.001235,")); /* and no digit that does not repeat */
    free(text_a);
    free(text_b);
    json_decref(a);
    json_decref(b);
}

static void bad_files_and_limits_are_refused(void **state)
{
    (void)state;
    json_t *other = json_pack("{s:s}", "schema", "other"), *none = json_pack("{s:s}", "schema", "isoshade.validate/1"),
           *b;
    json_t *twice = report(1, 1, "smooth"), *good = figures_of(report(1, 1, NULL));
    iso_baseline_result r;
    assert_status(iso_baseline_from_report(other, &b, &err), ISO_E_FORMAT);
    assert_status(iso_baseline_from_report(none, &b, &err), ISO_E_RANGE);
    assert_status(iso_baseline_from_report(twice, &b, &err), ISO_E_RANGE);
    assert_status(iso_baseline_compare(good, other, 1.25, 0, &r, &err), ISO_E_FORMAT);
    assert_status(iso_baseline_compare(good, good, 0.9, 0, &r, &err), ISO_E_RANGE);
    assert_status(iso_baseline_compare(good, good, NAN, 0, &r, &err), ISO_E_RANGE);
    assert_status(iso_baseline_compare(good, good, 2, -1, &r, &err), ISO_E_RANGE);
    json_decref(other);
    json_decref(none);
    json_decref(twice);
    json_decref(good);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_same_report_is_as_accepted),
        cmocka_unit_test(a_figure_beyond_the_factor_is_worse_and_comes_first),
        cmocka_unit_test(the_floor_forgives_rounding),
        cmocka_unit_test(a_lost_case_is_missing_and_a_new_one_is_no_failure),
        cmocka_unit_test(rows_under_either_tf_are_kept_apart),
        cmocka_unit_test(a_figure_that_became_null_is_missing),
        cmocka_unit_test(what_is_less_certain_than_before_is_worse),
        cmocka_unit_test(a_level_that_held_and_does_not_is_worse),
        cmocka_unit_test(what_is_not_known_of_a_report_is_refused),
        cmocka_unit_test(a_row_that_agreed_and_does_not_is_worse),
        cmocka_unit_test(other_versions_are_told_and_are_no_failure),
        cmocka_unit_test(the_same_rows_give_the_same_text_in_any_order),
        cmocka_unit_test(bad_files_and_limits_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
