/* SPDX-License-Identifier: MIT */
/* Two reports: the same report twice is no difference, and each planted change is exactly one row or one fact. */
#define _GNU_SOURCE

#include "report/difference.h"
#include "report/rows.h"
#include "report/sections.h"
#include "tests/test.h"

static const char text[] =
    "{'schema': 'isoshade.validate/1', 'verdict': 'agree', 'made': 'then', 'command': 'isoshade validate v.nrrd',"
    " 'volume': '/a/v.nrrd', 'scene': 'v.scene.json', 'versions': {'gl': 'llvmpipe 1'}, 'options': {'quick': true},"
    " 'machine': {'cores': 2}, 'seconds': {'total': 3}, 'asked': {'s': {'tier': 'tight', 'tf': 'smooth'}},"
    " 'agreement': ["
    "  {'scene': 's', 'level': 0, 'a': 'reference', 'renderer': 'gl', 'comparison': 'lock-step', 'variant': '', 'tier': 'lock-step',"
    "   'verdict': 'agree', 'rmse': 1e-5, 'max_abs': 1e-4, 'p99_abs': 0.1, 'ssim': 0.9, 'nonfinite_count': 0, 'seconds': 1.5,"
    "   'limits': {'rmse': 1e-4, 'max_abs': 1e-3}, 'gates': [], 'why': 'floats'},"
    "  {'scene': 's', 'level': 0, 'a': 'reference', 'renderer': 'cycles', 'comparison': 'limit', 'variant': '', 'tier': 'convergence',"
    "   'verdict': 'agree', 'rmse': 1e-3, 'max_abs': 1e-2, 'nonfinite_count': 0, 'limits': {'rmse': 2e-3},"
    "   'gates': [{'gate': 'error_bar', 'name': 'error bar', 'value': 1e-3, 'limit': 4e-3}],"
    "   'statistics': {'noise_bar': 1e-4, 'pixel_tolerance_largest': 0.01}, 'seconds': 9},"
    "  {'scene': 's', 'level': 0, 'a': 'reference', 'renderer': 'povray', 'comparison': 'limit', 'variant': '', 'tier': 'convergence',"
    "   'verdict': 'refused', 'rmse': null, 'limits': {}, 'gates': [], 'why': 'missing: no program povray'}],"
    " 'levels': [{'level': 1, 'verdict': 'agree', 'method': 'moments', 'tf': 'original', 'simple_held': true, 'stored': {'held': true},"
    "   'figures': [{'figure': 'rmse', 'name': 'RMSE', 'value': 0.1, 'asked': 0.2, 'held': true}]}],"
    " 'consistency': [{'method': 'moments', 'level': 1, 'tf': 'original', 'flip_mean': 0.1, 'gradient_angle_mean_deg': 20}],"
    " 'calibration': [{'renderer': 'gl', 'check': 'placement', 'value': 0.001, 'limit': 0.02, 'verdict': 'pass'}]}";

static json_t *report(void)
{
    FREED char *json = strdup(text);
    for (char *c = json; *c; ++c)
        *c = *c == '\'' ? '"' : *c;
    json_t *root = json_loads(json, 0, NULL);
    assert_non_null(root);
    return root;
}

static json_t *row_of(json_t *root, const char *list, size_t i)
{
    json_t *row = json_array_get(json_object_get(root, list), i);
    assert_non_null(row);
    return row;
}

/* Of the report and of what became of it; takes the reference. */
static json_t *difference_to(json_t *changed, bool results_only)
{
    json_t *first = report(), *d;
    assert_ok(iso_difference_of(first, changed, results_only, 1, &d, &err));
    iso_difference_conclude(d);
    json_decref(first);
    json_decref(changed);
    return d;
}

static size_t row_count(const json_t *d)
{
    return json_array_size(json_object_get(d, "rows"));
}

/* So many rows, of which the first has `change` and `what`; no fact that counts but of them. */
static void expect_rows(json_t *changed, size_t count, const char *name, const char *what)
{
    json_t *d = difference_to(changed, false), *row = json_array_get(json_object_get(d, "rows"), 0),
           *one = json_array_get(json_object_get(row, "what"), 0);
    assert_int_equal(row_count(d), count);
    assert_int_equal(json_array_size(json_object_get(d, "facts")), 0);
    assert_string_equal(iso_row_text(d, "verdict"), count ? "differ" : "agree");
    if (count) {
        assert_string_equal(iso_row_text(row, "name"), name);
        assert_string_equal(iso_row_text(one, "what"), what);
        assert_int_equal(json_array_size(json_object_get(row, "what")), 1);
    }
    json_decref(d);
}

static void set_number(json_t *row, const char *key, double value)
{
    assert_int_equal(json_object_set_new(row, key, json_real(value)), 0);
}

TEST(the_same_report_twice_is_no_difference)
{
    json_auto_t *d = difference_to(report(), false);
    assert_int_equal(row_count(d), 0);
    assert_int_equal(json_integer_value(json_object_get(d, "row_count")), 6);
    assert_string_equal(iso_row_text(d, "verdict"), "agree");
    assert_non_null(strstr(iso_row_text(d, "sentence"), "No difference in 6 rows"));
}

TEST(times_dates_commands_and_folders_are_no_difference)
{
    json_t *now = report();
    set_number(row_of(now, "agreement", 0), "seconds", 99);
    json_object_set_new(row_of(now, "agreement", 0), "command", json_string("isoshade render"));
    set_number(json_object_get(now, "seconds"), "total", 99);
    json_object_set_new(now, "made", json_string("now"));
    json_object_set_new(now, "command", json_string("isoshade validate /b/v.nrrd"));
    json_object_set_new(now, "volume", json_string("/b/v.nrrd"));
    expect_rows(now, 0, NULL, NULL);
}

TEST(a_metric_moves_by_a_hundredth_of_its_limit)
{
    const char *name = "s, level 0: gl against reference";
    json_t *less = report(), *more = report(), *down = report(), *gone = report();
    set_number(row_of(less, "agreement", 0), "rmse", 1.09e-5); /* of a limit of 1e-4 */
    expect_rows(less, 0, NULL, NULL);
    set_number(row_of(more, "agreement", 0), "rmse", 1.11e-5);
    expect_rows(more, 1, name, "rmse");
    set_number(row_of(down, "agreement", 0), "rmse", 0.89e-5);
    expect_rows(down, 1, name, "rmse");
    json_object_set_new(row_of(gone, "agreement", 0), "max_abs", json_null());
    expect_rows(gone, 1, name, "max_abs");
}

TEST(a_figure_without_a_limit_is_not_judged)
{
    json_t *now = report();
    set_number(row_of(now, "agreement", 0), "p99_abs", 0.9);
    expect_rows(now, 0, NULL, NULL);
}

TEST(noise_is_allowed_its_own_size)
{
    const double both = 1.5 * sqrt(2) * 1e-4;
    json_t *less = report(), *more = report(), *quiet = report();
    set_number(row_of(less, "agreement", 1), "rmse", 1e-3 + 0.99 * both);
    expect_rows(less, 0, NULL, NULL);
    set_number(row_of(more, "agreement", 1), "rmse", 1e-3 + 1.01 * both);
    expect_rows(more, 1, "s, level 0: cycles, limit against reference", "rmse");
    /* Without noise in B that of A alone. */
    json_object_del(row_of(quiet, "agreement", 1), "statistics");
    set_number(row_of(quiet, "agreement", 1), "rmse", 1e-3 + 1.55e-4);
    expect_rows(quiet, 1, "s, level 0: cycles, limit against reference", "rmse");
}

TEST(gates_move_by_a_part_of_their_limit)
{
    json_t *less = report(), *more = report(), *wider = report();
    set_number(json_array_get(json_object_get(row_of(less, "agreement", 1), "gates"), 0), "value", 2.9e-3);
    expect_rows(less, 0, NULL, NULL);
    set_number(json_array_get(json_object_get(row_of(more, "agreement", 1), "gates"), 0), "value", 3.1e-3);
    expect_rows(more, 1, "s, level 0: cycles, limit against reference", "error bar");
    set_number(json_array_get(json_object_get(row_of(wider, "agreement", 1), "gates"), 0), "limit", 5e-3);
    expect_rows(wider, 1, "s, level 0: cycles, limit against reference", "limit of error bar");
}

TEST(a_stated_limit_may_not_move_and_an_error_bar_may)
{
    json_t *stated = report(), *bar = report(), *lifted = report();
    set_number(json_object_get(row_of(stated, "agreement", 0), "limits"), "max_abs", 1.001e-3);
    expect_rows(stated, 1, "s, level 0: gl against reference", "limit of max_abs");
    set_number(json_object_get(row_of(bar, "agreement", 1), "limits"), "rmse", 2.2e-3);
    expect_rows(bar, 0, NULL, NULL);
    json_object_del(json_object_get(row_of(lifted, "agreement", 0), "limits"), "max_abs");
    expect_rows(lifted, 1, "s, level 0: gl against reference", "limit of max_abs");
}

TEST(verdicts_and_their_reasons_count)
{
    json_t *verdict = report(), *level = report(), *held = report(), *refused = report(), *path = report(),
           *unfit = report();
    json_object_set_new(row_of(verdict, "agreement", 0), "verdict", json_string("differ"));
    expect_rows(verdict, 1, "s, level 0: gl against reference", "verdict");
    json_object_set_new(row_of(level, "levels", 0), "verdict", json_string("differ"));
    expect_rows(level, 1, "level 1", "verdict");
    json_object_set_new(json_object_get(row_of(held, "levels", 0), "stored"), "held", json_false());
    expect_rows(held, 1, "level 1", "stored");
    json_object_set_new(row_of(refused, "agreement", 2), "why", json_string("failed its calibration: placement"));
    expect_rows(refused, 1, "s, level 0: povray, limit against reference", "refused");
    json_object_set_new(row_of(path, "agreement", 2), "why", json_string("missing: /tmp/x/povray"));
    expect_rows(path, 0, NULL, NULL);
    json_object_set_new(row_of(unfit, "calibration", 0), "verdict", json_string("fail"));
    expect_rows(unfit, 1, "calibration of gl: placement", "verdict");
}

TEST(other_figures_have_their_own_tolerances)
{
    json_t *reports[6];
    for (int i = 0; i < 6; ++i)
        reports[i] = report();
    set_number(row_of(reports[0], "calibration", 0), "value", 0.0029); /* of 0.02 */
    expect_rows(reports[0], 0, NULL, NULL);
    set_number(row_of(reports[1], "calibration", 0), "value", 0.0031);
    expect_rows(reports[1], 1, "calibration of gl: placement", "value");
    set_number(row_of(reports[2], "consistency", 0), "flip_mean", 0.1009);
    expect_rows(reports[2], 0, NULL, NULL);
    set_number(row_of(reports[3], "consistency", 0), "flip_mean", 0.1011);
    expect_rows(reports[3], 1, "level 1 against level 0, moments", "FLIP");
    set_number(row_of(reports[4], "consistency", 0), "gradient_angle_mean_deg", 20.2);
    expect_rows(reports[4], 1, "level 1 against level 0, moments", "direction, mean degrees");
    set_number(json_array_get(json_object_get(row_of(reports[5], "levels", 0), "figures"), 0), "value", 0.102);
    expect_rows(reports[5], 1, "level 1", "RMSE");
}

TEST(rows_appear_and_disappear)
{
    json_t *more = report(), *less = report(), *twin = report(), *d;
    json_t *row = json_deep_copy(row_of(more, "agreement", 0));
    json_object_set_new(row, "level", json_integer(1));
    json_array_append_new(json_object_get(more, "agreement"), row);
    d = difference_to(more, false);
    assert_true(row_count(d) == 1 && json_integer_value(json_object_get(d, "appeared_count")) == 1);
    assert_string_equal(iso_row_text(json_array_get(json_object_get(d, "rows"), 0), "name"),
                        "s, level 1: gl against reference");
    json_decref(d);
    json_array_remove(json_object_get(less, "agreement"), 0);
    d = difference_to(less, false);
    assert_true(row_count(d) == 1 && json_integer_value(json_object_get(d, "disappeared_count")) == 1);
    json_decref(d);
    /* A second row of one name hides nothing. */
    json_array_append_new(json_object_get(twin, "agreement"), json_deep_copy(row_of(twin, "agreement", 0)));
    d = difference_to(twin, false);
    assert_true(row_count(d) == 1 && json_integer_value(json_object_get(d, "appeared_count")) == 1);
    json_decref(d);
}

TEST(versions_and_options_count_unless_results_alone_are_asked_for)
{
    for (int i = 0; i < 8; ++i) {
        json_t *now = report();
        if (i / 2 == 0)
            json_object_set_new(json_object_get(now, "versions"), "gl", json_string("llvmpipe 2"));
        else if (i / 2 == 1)
            json_object_set_new(json_object_get(now, "options"), "quick", json_false());
        else if (i / 2 == 2)
            json_object_set_new(json_object_get(json_object_get(now, "asked"), "s"), "tf", json_string("sharp"));
        else
            json_object_set_new(json_object_get(now, "machine"), "cores", json_integer(3)); /* told, never counted */
        json_auto_t *d = difference_to(now, i % 2);
        assert_int_equal(json_array_size(json_object_get(d, "facts")), 1);
        assert_int_equal(row_count(d), 0);
        assert_string_equal(iso_row_text(d, "verdict"), i % 2 == 0 && i / 2 < 3 ? "differ" : "agree");
    }
}

TEST(the_worst_change_comes_first)
{
    json_t *now = report();
    set_number(row_of(now, "agreement", 0), "rmse", 1);
    json_object_set_new(row_of(now, "calibration", 0), "verdict", json_string("fail"));
    json_auto_t *d = difference_to(now, false);
    assert_int_equal(row_count(d), 2);
    assert_string_equal(iso_row_text(json_array_get(json_object_get(d, "rows"), 0), "kind"), "calibration");
}

/* What of a report makes it worse than the accepted one: planted by JSON that a row takes. */
static const struct {
    const char *list;
    size_t row;
    const char *set;
    size_t worse; /* this way, and the other way round: */
    size_t better;
} planted[] = {
    {"agreement", 0, "{'verdict': 'differ'}", 1, 0},
    {"agreement", 0, "{'verdict': 'refused'}", 1, 0},
    {"agreement", 0, "{'verdict': 'not compared'}", 1, 0},
    {"agreement", 0, "{'rmse': 3e-5}", 1, 0},
    {"agreement", 0, "{'rmse': null}", 1, 0},
    {"agreement", 0, "{'limits': {'rmse': 1, 'max_abs': 1e-3}}", 1, 0},
    {"agreement", 1, "{'gates': [{'gate': 'error_bar', 'name': 'error bar', 'value': -3.9e-3, 'limit': 4e-3}]}", 1, 0},
    {"agreement", 1, "{'gates': [{'gate': 'error_bar', 'name': 'error bar', 'value': 1e-3, 'limit': 4e-2}]}", 1, 0},
    {"agreement", 1, "{'gates': []}", 2, 0}, /* a gate and its limit are gone, or are new */
    {"levels", 0, "{'verdict': 'differ'}", 1, 0},
    {"levels", 0, "{'stored': {'held': false}}", 1, 0},
    {"levels", 0, "{'figures': [{'figure': 'rmse', 'name': 'RMSE', 'value': 0.19, 'asked': 0.2}]}", 1, 0},
    {"levels", 0, "{'method': 'naive'}", 0, 0},
    {"consistency", 0, "{'flip_mean': 0.2}", 1, 0},
    {"calibration", 0, "{'verdict': 'fail'}", 1, 0},
    {"calibration", 0, "{'value': 0.015}", 1, 0},
};

static json_t *planted_report(size_t i)
{
    json_t *root = report();
    FREED char *json = strdup(planted[i].set);
    for (char *c = json; *c; ++c)
        *c = *c == '\'' ? '"' : *c;
    assert_int_equal(
        json_object_update_new(row_of(root, planted[i].list, planted[i].row), json_loads(json, 0, NULL)), 0);
    return root;
}

static size_t count_worse(json_t *then, json_t *now, double factor)
{
    json_auto_t *d;
    assert_ok(iso_difference_of(then, now, true, factor, &d, &err));
    const size_t count = iso_difference_count_worse(d);
    json_decref(then);
    json_decref(now);
    return count;
}

TEST(what_is_less_certain_is_worse_and_more_is_not)
{
    assert_int_equal(count_worse(report(), report(), 1), 0);
    for (size_t i = 0; i < sizeof planted / sizeof *planted; ++i) {
        const size_t worse = count_worse(report(), planted_report(i), 1),
                     better = count_worse(planted_report(i), report(), 1);
        if (worse != planted[i].worse || better != planted[i].better)
            fail_msg("%s of %s: %zu worse, and the other way round %zu", planted[i].set, planted[i].list, worse, better);
    }
    assert_int_equal(count_worse(report(), planted_report(3), 30), 0); /* tolerances are as wide as is asked */
    json_t *less = report();
    json_array_remove(json_object_get(less, "agreement"), 1);
    assert_int_equal(count_worse(report(), json_incref(less), 1), 1); /* a row is gone */
    assert_int_equal(count_worse(less, report(), 1), 0);              /* or new */
}

TEST(a_report_without_rows_is_not_accepted)
{
    json_t *root = report(), *kept;
    assert_ok(iso_difference_accept(root, &kept, &err));
    assert_null(json_object_get(kept, "made"));
    assert_null(json_object_get(row_of(kept, "agreement", 0), "seconds"));
    assert_int_equal(count_worse(kept, report(), 1), 0);
    static const char *const lists[] = {"agreement", "levels", "consistency", "calibration"};
    for (size_t i = 0; i < sizeof lists / sizeof *lists; ++i)
        json_object_set_new(root, lists[i], json_array());
    assert_status(iso_difference_accept(root, &kept, &err), ISO_E_FORMAT);
    json_decref(root);
}

/* A word that is not known must not pass for anything; nor a list with verdicts that no table has. */
TEST(what_is_not_known_of_a_report_is_refused)
{
    static const char *const words[] = {"fine", "", "pass"}; /* the last is one of calibrations */
    iso_error why;
    json_t *root = report();
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i) {
        json_object_set_new(row_of(root, "levels", 0), "verdict", json_string(words[i]));
        assert_int_equal(iso_report_check(root, "r", &why), ISO_E_FORMAT);
        assert_non_null(strstr(why.text, "levels, row 1: unknown verdict"));
    }
    json_decref(root);
    root = report();
    json_object_set_new(root, "made_up", json_pack("[{s:s}]", "verdict", "agree"));
    assert_int_equal(iso_report_check(root, "r", &why), ISO_E_FORMAT);
    assert_non_null(strstr(why.text, "unknown section \"made_up\" with verdicts"));
    json_decref(root);
    root = report();
    json_object_set_new(root, "verdict", json_string("good"));
    assert_status(iso_report_check(root, "r", &err), ISO_E_FORMAT);
    json_decref(root);
}

TEST(other_files_are_refused)
{
    json_t *one = report(), *other = json_pack("{s:s}", "schema", "isoshade.accepted/2"), *d;
    assert_status(iso_difference_of(one, other, false, 1, &d, &err), ISO_E_FORMAT);
    assert_null(d);
    json_decref(one);
    json_decref(other);
}

TEST_MAIN(NULL, NULL)
