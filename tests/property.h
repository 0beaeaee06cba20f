/* SPDX-License-Identifier: MIT */
/* property.h - what holds for any case: cases drawn by chance, and of one that fails the smallest that fails too.
 *
 * A case is a list of numbers, each drawn from 0 to its limit; a property turns them into volumes, points and sizes,
 * and returns NULL, or what is wrong. Shrinking makes numbers smaller, one after the other, for as long as the property
 * fails: so 0 has to be the simplest of each. ISO_PROPERTY_SEED=n and ISO_PROPERTY_CASES=n repeat a run and go on for
 * longer. */
#pragma once

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/random.h"
#include "test.h"

enum { ISO_PROPERTY_MOST = 64 };

typedef struct iso_property {
    const char *name;
    size_t count;                      /* numbers of a case, at most ISO_PROPERTY_MOST */
    unsigned limit[ISO_PROPERTY_MOST]; /* of each; where it is 0 that of the one before counts */
    size_t cases;                      /* that are drawn */
    const char *(*fails)(const unsigned *numbers);
} iso_property;

static inline unsigned iso_property_limit(const iso_property *p, size_t i)
{
    while (i > 0 && p->limit[i] == 0)
        --i;
    return p->limit[i];
}

static inline size_t iso_property_setting(const char *variable, size_t otherwise)
{
    const char *text = getenv(variable);
    return text && *text ? (size_t)strtoull(text, NULL, 10) : otherwise;
}

/* Each number to 0, to its half, and one less, until none of it fails any more. */
static inline const char *iso_property_shrink(const iso_property *p, unsigned *numbers, const char *why)
{
    for (int again = 1, rounds = 0; again && rounds < 100; ++rounds) {
        again = 0;
        for (size_t i = 0; i < p->count; ++i) {
            const unsigned was = numbers[i], tries[] = {0, was / 2, was - (was > 0)};
            for (size_t k = 0; k < 3 && numbers[i] == was && was > 0; ++k) {
                numbers[i] = tries[k];
                const char *still = p->fails(numbers);
                if (still)
                    why = still, again = 1;
                else
                    numbers[i] = was;
            }
        }
    }
    return why;
}

/* NULL where it holds; else the message, which names the seed and the smallest case. */
static inline const char *iso_property_try(const iso_property *p)
{
    static char message[1200];
    const size_t seed = iso_property_setting("ISO_PROPERTY_SEED", 1),
                 cases = iso_property_setting("ISO_PROPERTY_CASES", p->cases);
    iso_random random = {.state = seed};
    for (size_t c = 0; c < cases; ++c) {
        unsigned numbers[ISO_PROPERTY_MOST];
        for (size_t i = 0; i < p->count; ++i)
            numbers[i] = (unsigned)(iso_random_next(&random) % ((uint64_t)iso_property_limit(p, i) + 1));
        const char *why = p->fails(numbers);
        if (!why)
            continue;
        why = iso_property_shrink(p, numbers, why);
        int n = snprintf(message, sizeof message, "%s: case %zu of ISO_PROPERTY_SEED=%zu, shrunk to", p->name, c, seed);
        for (size_t i = 0; i < p->count && n < 900; ++i)
            n += snprintf(message + n, sizeof message - (size_t)n, " %u", numbers[i]);
        snprintf(message + n, sizeof message - (size_t)n, ": %s", why);
        return message;
    }
    return NULL;
}

#define assert_property(property) \
    do { \
        const char *failed_ = iso_property_try(property); \
        if (failed_) \
            fail_msg("%s", failed_); \
    } while (0)
