/* SPDX-License-Identifier: MIT */
/* The summary of a report as Markdown: what it has to say, and names that are no markup. */
#define _GNU_SOURCE

#include "report/markdown.h"
#include "tests/folder.h"
#include "tests/test.h"

/* One row that differs, of a scene of that name, a calibration that failed, and two rows refused for one reason. */
static json_t *report(const char *scene)
{
    json_error_t error;
    json_t *root = json_pack_ex(
        &error, 0,
        "{s:s, s:s, s:s, s:s, s:s, s:[{s:s, s:i, s:s, s:s, s:s, s:f, s:f, s:{s:f, s:f}, s:[{s:s, s:s, s:f, s:f}]},"
        " {s:s, s:s, s:s, s:s}, {s:s, s:s, s:s, s:s}], s:[{s:s, s:s, s:s, s:n, s:f}, {s:s, s:s, s:s, s:s}], s:{s:s}}",
        "schema", "isoshade.validate/1", "title", scene, "verdict", "differ", "sentence", "They do not agree.",
        "levels_sentence", "The levels hold.", "agreement", "scene", scene, "level", 2, "renderer", "gl", "comparison",
        "lock-step", "verdict", "differ", "rmse", 0.25, "max_abs", 0.75, "limits", "rmse", 0.5, "max_abs", 0.25,
        "gates", "gate", "bias", "name", "bias beyond chance", "value", 0.5, "limit",
        1.0, /* of them max_abs is worst */
        "scene", "a", "renderer", "povray", "verdict", "refused", "why", "missing: no povray", /**/
        "scene", "b", "renderer", "povray", "verdict", "refused", "why", "missing: no povray", /**/
        "calibration", "renderer", "gl", "check", "placement", "verdict", "fail", "value", "limit", 0.02, "renderer",
        "outside", "check", "slab", "verdict", "not compared", "detail", "no picture", /**/
        "versions", "Blender Cycles", "Blender 3.4.1");
    if (!root)
        fail_msg("%s", error.text);
    return root;
}

static char *summary_of(json_t *root, const char *link)
{
    char *path = iso_path_join(folder, "summary.md"), *text;
    size_t size;
    assert_ok(iso_markdown_of_report(path, root, link, &err));
    assert_ok(iso_file_read(path, &text, &size, &err));
    json_decref(root);
    free(path);
    return text;
}

static void has(const char *text, const char *line)
{
    if (!strstr(text, line))
        fail_msg("\"%s\" is missing in:\n%s", line, text);
}

TEST(a_summary_says_what_failed_and_why)
{
    FREED char *text = summary_of(report("shells"), "out/index.html");
    has(text, "### ❌ isoshade validate: shells\n");
    has(text, "\nThey do not agree.\n");
    has(text, "\nThe levels hold.\n");
    has(text, "\n| shells | 2 | gl | max&#95;abs | 0.75 | 0.25 |\n");
    has(text, "\n| calibration | | gl | placement | no number | 0.02 |\n");
    has(text, "\n- povray: missing: no povray (2 rows)\n");
    has(text, "\n- outside, slab: no picture\n");
    has(text, "\n| Blender Cycles | Blender 3.4.1 |\n");
    has(text, "\n[out/index.html](out/index.html)\n");
}

TEST(a_name_is_no_markup)
{
    FREED char *text = summary_of(report("<b>|x `y` [z](w) *v* @u &amp; #1\n| a |"), "a b|(c).html");
    has(text,
        "| &#60;b&#62;&#124;x &#96;y&#96; &#91;z&#93;(w) &#42;v&#42; &#64;u &#38;amp; &#35;1 &#124; a &#124; | 2 |");
    has(text, "(a%20b%7C%28c%29.html)\n");
    assert_null(strstr(text, "<b>"));
}

TEST(a_report_that_agrees_has_no_table_of_failures)
{
    json_t *root = report("shells");
    json_object_set_new(root, "verdict", json_string("agree"));
    json_array_clear(json_object_get(root, "agreement"));
    json_array_clear(json_object_get(root, "calibration"));
    FREED char *text = summary_of(root, NULL);
    has(text, "### ✅ isoshade validate: shells\n");
    assert_null(strstr(text, "at most"));
    assert_null(strstr(text, "Refused"));
    assert_null(strstr(text, "]("));
}

TEST(long_tables_end_and_say_so)
{
    json_t *root = report("shells"), *rows = json_object_get(root, "agreement");
    for (int i = 0; i < 50; ++i)
        json_array_append(rows, json_array_get(rows, 0));
    FREED char *text = summary_of(root, NULL);
    has(text, "\nand 12 more in the report.\n"); /* 51 rows and a calibration, of which 40 are shown */
}

TEST_MAIN(make_folder, remove_folder)
