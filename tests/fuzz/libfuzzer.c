/* SPDX-License-Identifier: MIT */
/* libfuzzer.c - the targets as clang's libFuzzer runs them. The target is that of the environment variable ISO_FUZZ. */
#include <stdio.h>
#include <stdlib.h>

#include "tests/fuzz/readers.h"

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t most);
const char *__asan_default_options(void);

const char *__asan_default_options(void)
{
    return "detect_leaks=0:allocator_may_return_null=1:detect_odr_violation=0:detect_container_overflow=0";
}

static const fuzz_target *target;

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc, (void)argv;
    const char *name = getenv("ISO_FUZZ"), *words = getenv("ISO_FUZZ_WORDS");
    target = name ? fuzz_find(name) : NULL;
    if (!target) {
        fprintf(stderr, "fuzz: ISO_FUZZ names no target\n");
        exit(2);
    }
    if (words)
        fuzz_read_words(words);
    fuzz_begin(target);
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_run(target, data, size);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed)
{
    fuzz_random random = {seed};
    size_t changed = fuzz_below(&random, 2) ? fuzz_mutate_shape(target, &random, data, size, most) : 0;
    if (changed == 0)
        changed = LLVMFuzzerMutate(data, size, most);
    if (target->repair && fuzz_below(&random, 16))
        target->repair(data, changed);
    return changed;
}
