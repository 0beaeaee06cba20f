/* SPDX-License-Identifier: MIT */
/* test.h - cmocka, common headers of the C library, and comparisons that NaN fails. */
#pragma once

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/status.h"

/* Cases of a program, in their order in the file. */
enum { ISO_MOST_CASES = 64 };
static struct CMUnitTest iso_cases[ISO_MOST_CASES];
static int iso_case_lines[ISO_MOST_CASES];
static size_t iso_case_count;

static inline void iso_add_case(int line, struct CMUnitTest added)
{
    size_t at = iso_case_count++;
    if (at == ISO_MOST_CASES)
        abort();
    for (; at > 0 && iso_case_lines[at - 1] > line; --at) {
        iso_cases[at] = iso_cases[at - 1];
        iso_case_lines[at] = iso_case_lines[at - 1];
    }
    iso_cases[at] = added;
    iso_case_lines[at] = line;
}

/* Runs all cases between setup and teardown of the program; each may be NULL. */
static inline int run_cases(CMFixtureFunction setup, CMFixtureFunction teardown)
{
    return _cmocka_run_group_tests("tests", iso_cases, iso_case_count, setup, teardown);
}

/* clang-format off */
#define ISO_CASE(function, name, setup, teardown)                                                        \
    static void function(void **state);                                                                  \
    __attribute__((constructor)) static void function##_is_a_case(void)                                  \
    {                                                                                                    \
        iso_add_case(__LINE__, (struct CMUnitTest){name, function, setup, teardown, NULL});              \
    }                                                                                                    \
    static void function(__attribute__((unused)) void **state)

/* TEST(a_sentence) { ... } is a case; one of TEST_BETWEEN has its own setup and teardown. A case of VALUES_TEST checks
 * values, by code that other cases reach, too. The sanitizers leave it out: they find faults of code and are slow.
 * cmocka passes over a case without a name. */
#define TEST(function) ISO_CASE(function, #function, NULL, NULL)
#define TEST_BETWEEN(function, setup, teardown) ISO_CASE(function, #function, setup, teardown)
#if defined __SANITIZE_ADDRESS__
enum { ISO_SANITIZED = 1 };
#define VALUES_TEST(function) ISO_CASE(function, NULL, NULL, NULL)
#else
enum { ISO_SANITIZED = 0 };
#define VALUES_TEST(function) TEST(function)
#endif

/* The main() of a program that does nothing else. */
#define TEST_MAIN(setup, teardown)                                                                       \
    int main(void)                                                                                       \
    {                                                                                                    \
        return run_cases(setup, teardown);                                                               \
    }
/* clang-format on */

/* The tolerance states its cause in a comment where it is used. */
/* clang-format off */
#define assert_within(value, expected, tolerance)                                                       \
    do {                                                                                                \
        double value_ = (value), expected_ = (expected), tolerance_ = (tolerance);                      \
        if (!(value_ - expected_ <= tolerance_ && expected_ - value_ <= tolerance_))                    \
            fail_msg("%s = %.17g, expected %.17g within %g", #value, value_, expected_, tolerance_);    \
    } while (0)

#define assert_at_most(value, limit)                                                       \
    do {                                                                                   \
        double value_ = (value), limit_ = (limit);                                         \
        if (!(value_ <= limit_))                                                           \
            fail_msg("%s = %.17g, at most %g", #value, value_, limit_);                    \
    } while (0)

#define assert_more_than(value, limit)                                                     \
    do {                                                                                   \
        double value_ = (value), limit_ = (limit);                                         \
        if (!(value_ > limit_))                                                            \
            fail_msg("%s = %.17g, must exceed %g", #value, value_, limit_);                \
    } while (0)
/* clang-format on */

/* Runs a call that takes an iso_error last, named err. */
/* clang-format off */
#define assert_ok(call)                                                                    \
    do {                                                                                   \
        iso_error err = {""};                                                              \
        iso_status status_ = (call);                                                       \
        if (status_ != ISO_OK)                                                             \
            fail_msg("%s: status %d: %s", #call, (int)status_, err.text);                  \
    } while (0)

#define assert_status(call, wanted)                                                        \
    do {                                                                                   \
        iso_error err = {""};                                                              \
        iso_status status_ = (call);                                                       \
        if (status_ != (wanted))                                                           \
            fail_msg("%s: status %d, wanted %d: %s", #call, (int)status_, (int)(wanted), err.text); \
        if (status_ != ISO_OK && !err.text[0])                                             \
            fail_msg("%s: no message", #call);                                             \
    } while (0)
/* clang-format on */
