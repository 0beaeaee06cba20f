/* SPDX-License-Identifier: MIT */
/* The line that says how far a command is: its words and its width. What a terminal gets is in check_progress.sh. */
#include "base/progress_line.h"
#include "test.h"

static const char *text_of(const char *name, double fraction, double seconds, size_t columns)
{
    static char text[256];
    iso_progress_text(text, sizeof text, "validate", name, fraction, seconds, columns);
    return text;
}

TEST(the_line_has_the_step_the_percent_and_the_time)
{
    assert_string_equal(text_of("level 1: cycles-limit", 0.439, 78.9, 0),
                        "validate: level 1: cycles-limit   43 %, 1 min 18 s");
    assert_string_equal(text_of("report", 0.999, 59.9, 0), "validate: report   99 %, 59 s");
    assert_string_equal(text_of("build", 0, 0, 0), "validate: build    0 %, 0 s");
    assert_string_equal(text_of("build", 0.5, 7512, 0), "validate: build   50 %, 2 h 05 min");
}

TEST(a_narrow_terminal_shortens_the_step_and_then_the_rest)
{
    assert_string_equal(text_of("level 1: cycles-limit", 0.43, 78, 42), "validate: level 1: cycl   43 %, 1 min 18 s");
    for (size_t columns = 1; columns < 80; ++columns)
        assert_true(strlen(text_of("level 1: cycles-limit", 0.43, 78, columns)) <= columns);
    /* Two bytes a letter: cut between letters. */
    assert_string_equal(text_of("\xc3\xa9\xc3\xa9\xc3\xa9", 0.43, 7, 27), "validate: \xc3\xa9\xc3\xa9   43 %, 7 s");
    assert_string_equal(text_of("\xc3\xa9\xc3\xa9\xc3\xa9", 0.43, 7, 25), "validate: \xc3\xa9   43 %, 7 s");
}

TEST(the_percent_is_of_all_steps_and_never_falls)
{
    iso_progress_line *line = iso_progress_line_create("test");
    const iso_progress p = iso_progress_of_line(line);
    static const struct {
        const char *name; /* NULL: the number is added */
        double number, fraction;
    } rows[] = {{"first", 0, 0},     {"first", 0.5, 0.125}, {"first", 0.2, 0.125}, {"a detail", 1, 0.125},
                {"second", 0, 0.25}, {NULL, 0.25, 0.375},   {NULL, 0.25, 0.5},     {"a detail", 0, 0.5},
                {"first", 0, 0.5},   {NULL, 7, 0.75},       {"fourth", 0.5, 0.95}, {"third", 0.5, 0.95},
                {"fourth", 1, 1}};
    static const char *const steps[] = {"first", "second", "third", "fourth"};
    static const double costs[] = {5, 10, 3, 2};
    assert_non_null(line);
    for (size_t i = 0; i < sizeof steps / sizeof *steps; ++i)
        iso_progress_line_expect(line, steps[i], costs[i]);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
        if (rows[i].name)
            iso_progress_report(&p, rows[i].name, rows[i].number);
        else
            iso_progress_line_add(line, rows[i].number);
        assert_within(iso_progress_line_fraction(line), rows[i].fraction, 1e-12);
    }
    iso_progress_line_destroy(line);
}

TEST(without_a_line_all_is_silent)
{
    const iso_progress silent = iso_progress_of_line(NULL);
    iso_progress_report(&silent, "part", 0.5);
    iso_progress_line_expect(NULL, "part", 1);
    iso_progress_line_add(NULL, 0.5);
    iso_progress_line_hide(NULL);
    iso_progress_line_destroy(NULL);
}

TEST_MAIN(NULL, NULL)
