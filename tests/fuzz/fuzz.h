/* SPDX-License-Identifier: MIT */
/* fuzz.h - readers are given damaged files, and what they answer is held to their contract.
 *
 * A target is one reader: a row of the table in targets.c. One program holds all of them, and runs the one that its own
 * name or its first argument says; drive.c is the main() of `make check`, with mutations from a fixed seed, and
 * libfuzzer.c lends the same targets and mutations to clang's libFuzzer (`make fuzz`).
 *
 * Beside crashes and what the sanitizers find, a target stops the program (fuzz_fail) where a contract is broken: a
 * failure without a message, a memory request far beyond the input, values that are no numbers, a file that is not read
 * back as it was written.
 *
 * An input is one file, or several: a line "==== NAME" begins each further one, which then lies beside the first. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

typedef enum fuzz_shape {
    FUZZ_BYTES, /* binary */
    FUZZ_LINES, /* text, or text and then samples: numbers and lines are changed too */
    FUZZ_JSON,  /* values of the tree are changed too */
} fuzz_shape;

typedef struct fuzz_target {
    const char *name;
    const char *file; /* what the input is called when it is read; with "/" at its end: a folder of several files */
    fuzz_shape shape;
    void (*run)(const struct fuzz_target *target, const char *path, const uint8_t *data, size_t size);
    /* Makes checksums right again after a mutation, in place; or NULL. */
    void (*repair)(uint8_t *data, size_t size);
    const char *sources; /* whose lines are counted for it, as patterns of the shell */
} fuzz_target;

extern const fuzz_target fuzz_targets[]; /* ends with a NULL name */

/* ---- what targets use ---- */

_Noreturn void fuzz_fail(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* A status other than ISO_OK comes with a message of one line. */
void fuzz_check_status(iso_status status, const iso_error *err);
/* The reader took the input, as it does each good file: where it never does, only its refusals are looked at. */
void fuzz_note_read(void);
/* Both: ISO_OK says that it took it. */
void fuzz_check_read(iso_status status, const iso_error *err);
/* A file beside the input, in a folder that goes with the program. */
const char *fuzz_beside(const char *name);

/* ---- what drivers use ---- */

/* Whether a contract was found broken: what ends the program is then no library's doing. */
extern bool fuzz_has_failed;
/* Whether the reader took the input of the last fuzz_run(). */
extern bool fuzz_was_read;
/* Where it is defined, the reader's libraries may end their program, as they end a program of their own when isoshade
 * runs (in_process.cc): that is counted, and the run goes on. */
extern const bool fuzz_reader_may_end __attribute__((weak));
/* How many of these ends were assertions and the like that this process went on from; what such a reader held is
 * lost. */
extern unsigned fuzz_assertions;

const fuzz_target *fuzz_find(const char *name);
/* The folder, and the limit of memory. */
void fuzz_begin(const fuzz_target *target);
void fuzz_run(const fuzz_target *target, const uint8_t *data, size_t size);

typedef struct fuzz_random {
    uint64_t state;
} fuzz_random;
uint64_t fuzz_next(fuzz_random *random);
size_t fuzz_below(fuzz_random *random, size_t count); /* 0 where count is 0 */

enum { FUZZ_MOST_BYTES = 1 << 16 };
/* Words of a dictionary, one a line as libFuzzer has them: name="text". */
void fuzz_read_words(const char *path);
/* One mutation of data[0 .. size), which has room for `most`; the new size. */
size_t fuzz_mutate(const fuzz_target *target, fuzz_random *random, uint8_t *data, size_t size, size_t most);
/* One that knows the shape alone; 0 where it does not fit. */
size_t fuzz_mutate_shape(const fuzz_target *target, fuzz_random *random, uint8_t *data, size_t size, size_t most);
