/* SPDX-License-Identifier: MIT */
/* The line that says how far a job is: its words, its width, and how seldom a log has one. The drawing itself is in
 * check_progress.sh. */
#include <math.h>
#include <string.h>

#include "base/progress_line.h"
#include "test.h"

static const char *text_of(const char *part, double fraction, double left, size_t columns)
{
    static char text[256];
    const iso_job_state state = {.part = part, .fraction = fraction, .left_seconds = left};
    iso_progress_text(text, sizeof text, "validate", &state, columns);
    return text;
}

static void the_line_has_the_part_the_percent_and_the_time_left(void **state)
{
    (void)state;
    assert_string_equal(text_of("level 1: cycles-limit", 0.439, 78, 0),
                        "validate: level 1: cycles-limit    43 %, about 1 min 20 s left");
    assert_string_equal(text_of("report", 0.999, 0.1, 0), "validate: report    99 %, about a few seconds left");
    assert_string_equal(text_of("", 0.5, 43, 0), "validate:   50 %, about 45 s left");
    assert_string_equal(text_of("build", 0, NAN, 0), "validate: build     0 %");
}

static void times_are_as_round_as_an_estimate_knows_them(void **state)
{
    (void)state;
    assert_non_null(strstr(text_of("", 0, 58, 0), "about 60 s left"));
    assert_non_null(strstr(text_of("", 0, 119, 0), "about 2 min left"));
    assert_non_null(strstr(text_of("", 0, 598, 0), "about 10 min left"));
    assert_non_null(strstr(text_of("", 0, 1234, 0), "about 21 min left"));
    assert_non_null(strstr(text_of("", 0, 7500, 0), "about 2 h 5 min left"));
}

static void a_narrow_terminal_shortens_the_part_and_then_the_rest(void **state)
{
    (void)state;
    assert_string_equal(text_of("level 1: cycles-limit", 0.43, 78, 52),
                        "validate: level 1: cy    43 %, about 1 min 20 s left");
    for (size_t columns = 1; columns < 80; ++columns)
        assert_true(strlen(text_of("level 1: cycles-limit", 0.43, 78, columns)) <= columns);
    /* Two bytes a letter: cut between letters, and as many of them as there are columns. */
    assert_string_equal(text_of("\xc3\xa9\xc3\xa9\xc3\xa9\xc3\xa9", 0.43, NAN, 20),
                        "validate: \xc3\xa9\xc3\xa9    43 %");
}

/* Lines of a job of so many seconds that is looked at each second. */
static int lines_of(double all_seconds)
{
    iso_progress_log log = {0};
    int lines = 0;
    double last = 0;
    for (double passed = 0; passed < all_seconds; passed += 1) {
        const iso_job_state state = {.fraction = passed / all_seconds, .passed_seconds = passed};
        if (!iso_progress_log_is_due(&log, &state))
            continue;
        assert_true(passed - last >= 5);
        last = passed;
        ++lines;
    }
    return lines;
}

static void a_log_has_few_lines(void **state)
{
    (void)state;
    assert_int_equal(lines_of(4), 0);
    assert_int_equal(lines_of(9), 1);
    assert_int_equal(lines_of(100), 9);                          /* each tenth */
    assert_true(lines_of(3600) >= 115 && lines_of(3600) <= 125); /* each half minute */
}

static void without_a_line_all_is_silent(void **state)
{
    (void)state;
    iso_progress_lane lane = {.line = NULL};
    const iso_progress silent = iso_progress_of_lane(&lane), first = iso_progress_of_line(NULL);
    iso_progress_report(&silent, "part", 0.5);
    iso_progress_report(&first, "part", 0.5);
    iso_progress_lane_end(&lane);
    iso_progress_line_begin_phase(NULL, "phase");
    iso_progress_line_hide(NULL);
    assert_null(iso_progress_line_lock(NULL));
    iso_progress_line_unlock(NULL);
    iso_progress_line_destroy(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_line_has_the_part_the_percent_and_the_time_left),
        cmocka_unit_test(times_are_as_round_as_an_estimate_knows_them),
        cmocka_unit_test(a_narrow_terminal_shortens_the_part_and_then_the_rest),
        cmocka_unit_test(a_log_has_few_lines),
        cmocka_unit_test(without_a_line_all_is_silent),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
