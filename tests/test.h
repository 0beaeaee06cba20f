/* SPDX-License-Identifier: MIT */
/* test.h - cmocka, and comparisons that NaN fails. */
#ifndef ISO_TEST_H
#define ISO_TEST_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "base/status.h"

/* A case that checks values, by code that other cases reach, too. The sanitizers leave it out: they find faults of code
 * and are slow. cmocka passes over a case without a name. */
#if defined __SANITIZE_ADDRESS__
#define cmocka_values_test(function) {NULL, function, NULL, NULL, NULL}
#else
#define cmocka_values_test(function) cmocka_unit_test(function)
#endif

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

#endif
