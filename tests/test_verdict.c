/* SPDX-License-Identifier: MIT */
/* What a report says of a row, and what a row is of: words, identity, and when nothing may be called agreement. */
#define _GNU_SOURCE
#include <math.h>
#include <string.h>

#include "report/report.h"
#include "tests/folder.h"
#include "tests/test.h"

static char *inside(const char *name)
{
    char *path = iso_path_join(folder, name);
    assert_non_null(path);
    return path;
}

static iso_report *open_report(const char *name)
{
    const iso_report_about about = {.title = "t"};
    char *dir = inside(name);
    iso_report *r;
    assert_ok(iso_report_create(&r, dir, &about, &err));
    free(dir);
    return r;
}

static const json_t *row_of(const iso_report *r, size_t at)
{
    return json_array_get(json_object_get(iso_report_json(r), "agreement"), at);
}

static void every_word_of_a_verdict_is_read_again(void **state)
{
    (void)state;
    for (int i = 0; i < ISO_VERDICT_UNKNOWN; ++i) {
        json_t *word = json_string(iso_verdict_word((iso_verdict)i));
        assert_int_equal(iso_verdict_from(word), i);
        json_decref(word);
    }
    json_t *odd = json_string("agreed");
    assert_int_equal(iso_verdict_from(odd), ISO_VERDICT_UNKNOWN);
    assert_int_equal(iso_verdict_from(NULL), ISO_VERDICT_UNKNOWN);
    json_decref(odd);
    /* Less certain is worse, and nothing is less certain than no word. */
    assert_true(iso_verdict_doubt(ISO_VERDICT_NOT_COMPARED) > iso_verdict_doubt(ISO_VERDICT_AGREE));
    assert_true(iso_verdict_doubt(ISO_VERDICT_REFUSED) > iso_verdict_doubt(ISO_VERDICT_NOT_COMPARED));
    assert_true(iso_verdict_doubt(ISO_VERDICT_DIFFER) > iso_verdict_doubt(ISO_VERDICT_REFUSED));
    assert_true(iso_verdict_doubt(ISO_VERDICT_UNKNOWN) > iso_verdict_doubt(ISO_VERDICT_DIFFER));
}

/* A comma in a variant's or a renderer's name is no part of the row's form. */
static void a_row_holds_what_it_is_of_in_fields(void **state)
{
    (void)state;
    iso_report *r = open_report("fields");
    iso_report_agreement row = {.scene = "s",
                                .a = "reference",
                                .renderer = "gl, of Mesa",
                                .comparison = ISO_COMPARISON_LIMIT,
                                .variant = "naive, adapted TF",
                                .error_bar = NAN,
                                .tolerances = {.rmse = 1}};
    assert_ok(iso_report_add_agreement(r, &row, &err));
    const json_t *kept = row_of(r, 0);
    assert_string_equal(iso_row_text(kept, "renderer"), "gl, of Mesa");
    assert_string_equal(iso_row_text(kept, "comparison"), "limit");
    assert_string_equal(iso_row_text(kept, "variant"), "naive, adapted TF");
    assert_string_equal(iso_row_text(kept, "b"), "gl, of Mesa, limit, naive, adapted TF");
    json_object_set_new((json_t *)kept, "b", json_string("a name for people alone"));
    iso_row_identity id = iso_row_identify(kept);
    assert_string_equal(id.renderer, "gl, of Mesa");
    assert_int_equal(id.comparison, ISO_COMPARISON_LIMIT);
    assert_string_equal(id.variant, "naive, adapted TF");
    iso_report_destroy(r);
}

static void rows_of_older_reports_are_read_by_their_name(void **state)
{
    (void)state;
    static const struct {
        const char *b, *tier, *renderer;
        iso_comparison comparison;
        const char *variant;
    } rows[] = {
        {"gl", "lock-step", "gl", ISO_COMPARISON_LOCK_STEP, ""},
        {"gl, limit", "convergence", "gl", ISO_COMPARISON_LIMIT, ""},
        {"gl, exact lookups", "lock-step", "gl", ISO_COMPARISON_EXACT, ""},
        {"povray, naive", "lock-step", "povray", ISO_COMPARISON_LOCK_STEP, "naive"},
        {"cycles, limit, eq1, adapted TF", "lit", "cycles", ISO_COMPARISON_LIMIT, "eq1, adapted TF"},
        {"gl, exact lookups, moments, 2D TF (gradient)", "lock-step", "gl", ISO_COMPARISON_EXACT,
         "moments, 2D TF (gradient)"},
        {"reference", "closed form", "reference", ISO_COMPARISON_CLOSED_FORM, ""},
        {"gl, limit", "closed form", "gl", ISO_COMPARISON_LIMIT, ""},
        {"povray", "first hit", "povray", ISO_COMPARISON_FIRST_HIT, ""},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
        json_t *row = json_pack("{s:s, s:s}", "b", rows[i].b, "tier", rows[i].tier);
        char name[ISO_ROW_NAME_BYTES];
        const iso_row_identity id = iso_row_identify(row);
        assert_string_equal(id.renderer, rows[i].renderer);
        assert_int_equal(id.comparison, rows[i].comparison);
        assert_string_equal(id.variant, rows[i].variant);
        iso_row_name_of(row, name);
        assert_string_equal(name, rows[i].b);
        json_decref(row);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_word_of_a_verdict_is_read_again),
        cmocka_unit_test(a_row_holds_what_it_is_of_in_fields),
        cmocka_unit_test(rows_of_older_reports_are_read_by_their_name),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
