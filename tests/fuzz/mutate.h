/* SPDX-License-Identifier: MIT */
/* mutate.h - what the files of mutations have in common. */
#pragma once

#include "tests/fuzz/fuzz.h"

/* Puts `with` in place of `count` bytes at `at`; what does not fit is left out. `with` lies outside of data. */
size_t fuzz_replace(uint8_t *data, size_t size, size_t most, size_t at, size_t count, const void *with, size_t length);
/* One of the dictionary; NULL: it has none. */
const uint8_t *fuzz_some_word(fuzz_random *random, size_t *size);
/* A number at which something changes: a power of two, or one less. */
uint64_t fuzz_some_edge(fuzz_random *random);
/* One or a few values of the JSON text that the input is, or the first of its files; 0: it has none. */
size_t fuzz_mutate_json(fuzz_random *random, uint8_t *data, size_t size, size_t most);
