/* SPDX-License-Identifier: MIT */
/* cmd_bench.c - finds and runs a benchmark. */
#include "bench/bench.h"
#include "cli/commands.h"

#include <stdio.h>
#include <string.h>

#define ISO_BENCH_EXTERN(name) extern const iso_command iso_bench_##name;
ISO_BENCH_LIST(ISO_BENCH_EXTERN)
#undef ISO_BENCH_EXTERN

#define ISO_BENCH_ENTRY(name) &iso_bench_##name,
const iso_command *const iso_benchmarks[] = {ISO_BENCH_LIST(ISO_BENCH_ENTRY) NULL};
#undef ISO_BENCH_ENTRY

static const char *short_name(const iso_command *benchmark)
{
    return benchmark->name + strlen("bench ");
}

const iso_command *iso_benchmark_find(const char *name)
{
    for (const iso_command *const *b = iso_benchmarks; *b; ++b)
        if (strcmp(short_name(*b), name) == 0)
            return *b;
    return NULL;
}

static void print_list(const iso_command *self)
{
    printf("isoshade %s - %s\n\nusage: isoshade %s %s\n\n%s\n\nbenchmarks:\n", self->name, self->summary, self->name,
           self->usage, self->details);
    for (const iso_command *const *b = iso_benchmarks; *b; ++b)
        printf("  %-12s %s\n", short_name(*b), (*b)->summary);
    printf("\nisoshade bench NAME --help shows its options.\n\nexamples:\n%s", self->examples);
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    if (argc < 2)
        return iso_fail(err, ISO_E_USAGE, "benchmark is missing; isoshade bench --help lists them");
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "--help=all") == 0 || strcmp(argv[1], "-h") == 0) {
        print_list(self);
        return ISO_OK;
    }
    iso_guess guess = {0};
    char text[80];
    for (const iso_command *const *b = iso_benchmarks; *b; ++b)
        iso_guess_try(&guess, argv[1], short_name(*b));
    const iso_command *benchmark = iso_benchmark_find(argv[1]);
    if (!benchmark)
        return iso_fail(err, ISO_E_USAGE, "unknown benchmark \"%s\"%s; isoshade bench --help lists them", argv[1],
                        iso_guess_text(&guess, "", text));
    return iso_command_run(benchmark, argc - 1, argv + 1, err);
}

const iso_command iso_command_bench = {
    .name = "bench",
    .summary = "measure speed against accuracy",
    .usage = "NAME [options]",
    .details = "Times are wall clock, the shortest of several runs; compare ratios within one run.",
    .examples = "  isoshade bench build --size 64 --runs 1\n",
    .run_words = run,
};
