/* SPDX-License-Identifier: MIT */
/* random.h - seeded random numbers that are the same on every machine.
 *
 * SplitMix64 [steele-2014]: one word of state, any seed is good. */
#pragma once

#include <stddef.h>
#include <stdint.h>

typedef struct iso_random {
    uint64_t state;
} iso_random;

static inline uint64_t iso_random_next(iso_random *r)
{
    uint64_t z = (r->state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}
/* Returns a number in [0, 1). */
static inline double iso_random_unit(iso_random *r)
{
    return (double)(iso_random_next(r) >> 11) * 0x1p-53;
}
/* Returns a number in [0, n), n > 0. */
static inline size_t iso_random_below(iso_random *r, size_t n)
{
    return (size_t)(iso_random_unit(r) * (double)n);
}

/* Returns a number in [0, 1), by Xorshift64 [marsaglia-2003], with which the recorded figures of the direction codes
 * were made. *state is the seed, not 0. */
static inline double iso_xorshift_unit(uint64_t *state)
{
    *state ^= *state << 13, *state ^= *state >> 7, *state ^= *state << 17;
    return (double)(*state >> 11) * 0x1p-53;
}
