/* SPDX-License-Identifier: MIT */
/* drive.c - runs a target on its seeds, and on mutations of them that follow from a number.
 *
 *     isoshade-fuzz NAME [SEEDS [COUNT [SECONDS [SEED]]]]
 *     isoshade-fuzz NAME FILE                              that input alone
 *     isoshade-fuzz --seeds FOLDER NAME ...                the seeds of several, FOLDER/NAME, in a process each that this
 *                                                          one forks: for what starts slowly (tests/check_memcheck.sh)
 *
 * It ends after COUNT mutations or SECONDS of processor time, whichever is first, but not before the first 8, which are
 * the same on any machine; and prints how many it was, and how many seeds and mutations the reader took as good files.
 * An input at which it is stopped stays as crash-NAME in the current folder. Where the reader may end its program
 * (fuzz.h), the last one that did by an assertion stays there, too. */
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/file.h"
#include "tests/fuzz/readers.h"

typedef struct input {
    uint8_t *data;
    size_t size;
} input;

enum { MOST_SEEDS = 4096, MOST_SECONDS_OF_ONE = 10, MOST_BYTES_ASKED = 384 << 20, LEAST_MUTATIONS = 8, BROKEN = 99 };
static input seeds[MOST_SEEDS];
static size_t seed_count;
static uint8_t current[FUZZ_MOST_BYTES];
static size_t current_size;
static char crash_path[512];
static const fuzz_target *running;
static bool has_limit; /* of time, for one input */

/* ---- options of the sanitizers ---- */

const char *__asan_default_options(void);
const char *__asan_default_options(void)
{
    return "abort_on_error=1:handle_abort=0:allocator_may_return_null=1:detect_odr_violation=0";
}

const char *__ubsan_default_options(void);
const char *__ubsan_default_options(void)
{
    return "abort_on_error=1:print_stacktrace=1";
}

int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void *, size_t),
                                              void (*on_free)(const volatile void *)) __attribute__((weak));

static bool may_end(void)
{
    return &fuzz_reader_may_end && fuzz_reader_may_end;
}

static void keep_input(void)
{
    const int fd = open(crash_path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (fd >= 0 && write(fd, current, current_size) == (ssize_t)current_size && !may_end())
        fprintf(stderr, "fuzz: %s: the input is kept as %s\n", running->name, crash_path);
}

/* What lines were reached, where they are counted (make fuzz-coverage): a process that ends at once leaves them
 * unsaid. */
void __gcov_dump(void) __attribute__((weak));
static void keep_lines(void)
{
    if (__gcov_dump)
        __gcov_dump();
}

static void on_signal(int number)
{
    if (number == SIGVTALRM) {
        fuzz_has_failed = true;
        fprintf(stderr, "fuzz: a contract is broken: one input takes more than %d s\n", MOST_SECONDS_OF_ONE);
    }
    keep_input();
    keep_lines();
    if (fuzz_has_failed && may_end())
        _exit(BROKEN);
    signal(number, SIG_DFL);
    raise(number);
    _exit(1);
}

static void on_malloc(const volatile void *memory, size_t size)
{
    (void)memory;
    if (size > MOST_BYTES_ASKED && !may_end())
        fuzz_fail("%zu bytes are asked for an input of %zu", size, current_size);
}

static void on_free(const volatile void *memory)
{
    (void)memory;
}

static void watch(void)
{
    char *here = realpath(".", NULL);
    snprintf(crash_path, sizeof crash_path, "%s/crash-%s", here ? here : ".", running->name);
    free(here);
    signal(SIGABRT, on_signal);
    signal(SIGVTALRM, on_signal);
    if (__sanitizer_install_malloc_and_free_hooks)
        __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free);
}

static bool has_timer;

/* The limit of one input. */
static void wind_up(void)
{
    static timer_t timer;
    struct sigevent event = {.sigev_notify = SIGEV_SIGNAL, .sigev_signo = SIGVTALRM};
    const struct itimerspec limit = {.it_value.tv_sec = MOST_SECONDS_OF_ONE};
    if (!has_timer)
        has_timer = timer_create(CLOCK_PROCESS_CPUTIME_ID, &event, &timer) == 0;
    if (has_timer)
        timer_settime(timer, 0, &limit, NULL);
}

/* ---- seeds ---- */

static void add_seed(const char *path)
{
    char *data;
    size_t size;
    if (seed_count == MOST_SEEDS || iso_file_read(path, &data, &size, NULL) != ISO_OK)
        return;
    if (size <= FUZZ_MOST_BYTES)
        seeds[seed_count++] = (input){(uint8_t *)data, size};
    else
        free(data);
}

static int by_name(const struct dirent **a, const struct dirent **b)
{
    return strcmp((*a)->d_name, (*b)->d_name);
}

static void read_seeds(const char *path)
{
    struct dirent **entries = NULL;
    const int count = scandir(path, &entries, NULL, by_name);
    if (count < 0) {
        add_seed(path);
        return;
    }
    for (int i = 0; i < count; ++i) {
        char *file = iso_path_join(path, entries[i]->d_name);
        if (entries[i]->d_name[0] != '.')
            add_seed(file);
        free(file);
        free(entries[i]);
    }
    free(entries);
}

/* ---- the run ---- */

/* Whether the reader took it. */
static bool run(const uint8_t *data, size_t size)
{
    static size_t runs;
    if (data != current)
        memcpy(current, data, size);
    current_size = size;
    if (has_limit && runs++ % 16 == 0)
        wind_up();
    fuzz_run(running, current, size);
    return fuzz_was_read;
}

/* One to a few changes of a seed; sometimes the end of another one behind it. */
static void make_input(fuzz_random *random)
{
    const input *from = &seeds[fuzz_below(random, seed_count)], *other = &seeds[fuzz_below(random, seed_count)];
    memcpy(current, from->data, from->size);
    size_t size = from->size;
    if (fuzz_below(random, 16) == 0 && size > 0 && other->size > 0) {
        const size_t keep = fuzz_below(random, size), rest = fuzz_below(random, other->size);
        if (keep + other->size - rest <= FUZZ_MOST_BYTES) {
            memcpy(current + keep, other->data + rest, other->size - rest);
            size = keep + other->size - rest;
        }
    }
    const size_t changes = (size_t)1 << fuzz_below(random, 4);
    for (size_t i = 0; i < changes; ++i)
        size = fuzz_mutate(running, random, current, size, FUZZ_MOST_BYTES);
    current_size = size;
}

/* With those of programs that were started. */
static double seconds_used(void)
{
    struct rusage children;
    getrusage(RUSAGE_CHILDREN, &children);
    return (double)clock() / CLOCKS_PER_SEC + (double)(children.ru_utime.tv_sec + children.ru_stime.tv_sec) +
           1e-6 * (double)(children.ru_utime.tv_usec + children.ru_stime.tv_usec);
}

/* What was run, of which so many were read. */
typedef struct tally {
    fuzz_random random;
    uint64_t seeds, mutations, seeds_read, mutations_read, ended;
} tally;

static void run_next_seed(tally *t)
{
    const input *seed = &seeds[t->seeds++];
    t->seeds_read += run(seed->data, seed->size);
}

static void run_next_mutation(tally *t)
{
    make_input(&t->random);
    ++t->mutations;
    t->mutations_read += run(current, current_size);
}

/* The clock is looked at after each mutation where they take a millisecond and more, as those do that start a
 * program. */
static void run_here(tally *t, uint64_t count, double seconds)
{
    while (t->seeds < seed_count)
        run_next_seed(t);
    const double start = seconds_used();
    uint64_t next_look = LEAST_MUTATIONS;
    while (seed_count > 0 && t->mutations < count) {
        run_next_mutation(t);
        if (t->mutations < next_look)
            continue;
        const double used = seconds_used() - start;
        if (used >= seconds)
            break;
        next_look = t->mutations + (used > 1e-3 * (double)t->mutations ? 1 : 16);
    }
}

/* ---- readers that may end their program ---- */

enum { INPUTS_OF_ONE_PROCESS = 1 << 14, ASSERTIONS_OF_ONE_PROCESS = 32 };

/* Inputs until the run's end, or so many that what libraries lose does not add up. What an assertion left is
 * counted. */
static void run_some(tally *t, uint64_t count, double seconds)
{
    const struct rlimit none = {0, 0};
    setrlimit(RLIMIT_CORE, &none);
    has_timer = false;
    unsigned assertions = 0;
    for (int i = 0; i < INPUTS_OF_ONE_PROCESS && (double)clock() < seconds * CLOCKS_PER_SEC; ++i) {
        if (t->seeds < seed_count)
            run_next_seed(t);
        else if (t->mutations < count)
            run_next_mutation(t);
        if (fuzz_assertions == assertions)
            continue;
        t->ended += fuzz_assertions - assertions;
        assertions = fuzz_assertions;
        keep_input();
        if (assertions >= ASSERTIONS_OF_ONE_PROCESS)
            return;
    }
}

/* The same in processes that are forked one after the other, each of which goes on where the one before ended. */
static void run_in_processes(tally *result, uint64_t count, double seconds)
{
    tally *t = mmap(NULL, sizeof *t, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (t == MAP_FAILED)
        fuzz_fail("no memory to share");
    *t = *result;
    for (double left = seconds;
         t->seeds < seed_count || (t->mutations < count && (t->mutations < LEAST_MUTATIONS || left > 0));
         left = seconds - seconds_used()) {
        int how = 0;
        fflush(NULL);
        const pid_t child = fork();
        if (child == 0) {
            run_some(t, count, fmin(fmax(left, 0.1), 1));
            keep_lines();
            _exit(0);
        }
        if (child < 0 || waitpid(child, &how, 0) != child)
            fuzz_fail("no process can be started: %s", strerror(errno));
        if (WIFEXITED(how) && WEXITSTATUS(how) == BROKEN)
            exit(1);
        t->ended += !(WIFEXITED(how) && WEXITSTATUS(how) == 0);
    }
    *result = *t;
    munmap(t, sizeof *t);
}

/* All seeds of a target, as they are. */
static int run_seeds(const fuzz_target *target, const char *seeds_folder)
{
    char *path = iso_path_join(seeds_folder, target->name);
    running = target;
    read_seeds(path);
    free(path);
    fuzz_begin(running);
    for (size_t i = 0; i < seed_count; ++i)
        run(seeds[i].data, seeds[i].size);
    printf("%-16s %4zu seeds\n", running->name, seed_count);
    return seed_count > 0 ? 0 : 1;
}

static int run_seeds_of_each(const char *seeds_folder, char **names)
{
    int failed = 0;
    for (; *names; ++names) {
        const fuzz_target *target = fuzz_find(*names);
        int status = 1;
        fflush(stdout);
        const pid_t child = target ? fork() : -1;
        if (child == 0)
            exit(run_seeds(target, seeds_folder));
        if (child < 0 || waitpid(child, &status, 0) != child || status != 0) {
            fprintf(stderr, "fuzz: %s: failed\n", *names);
            failed = 1;
        }
    }
    return failed;
}

int main(int argc, char **argv)
{
    if (argc > 3 && strcmp(argv[1], "--seeds") == 0)
        return run_seeds_of_each(argv[2], argv + 3);
    running = argc > 1 ? fuzz_find(argv[1]) : NULL;
    if (argc == 2 && strcmp(argv[1], "--list") == 0) {
        for (const fuzz_target *t = fuzz_targets; t->name; ++t)
            printf("%s %s\n", t->name, t->sources);
        return 0;
    }
    if (!running) {
        fprintf(stderr, "isoshade-fuzz NAME [SEEDS [COUNT [SECONDS [SEED]]]], or --list for the names\n");
        return 2;
    }
    const uint64_t count = argc > 3 ? strtoull(argv[3], NULL, 10) : 0;
    const double seconds = argc > 4 ? strtod(argv[4], NULL) : 1e9;
    tally t = {.random = {argc > 5 ? strtoull(argv[5], NULL, 10) : 1}};
    char words[400] = "";
    for (const char *c = argv[1]; argc > 2 && *c; ++c) /* of the format and of its family: words/tf_json, words/tf */
        if (c[1] == 0 || c[1] == '_') {
            snprintf(words, sizeof words, "%s/../../words/%.*s", argv[2], (int)(c - argv[1]) + 1, argv[1]);
            fuzz_read_words(words);
        }
    if (argc > 2)
        read_seeds(argv[2]);
    watch();
    has_limit = true;
    fuzz_begin(running);
    if (may_end())
        run_in_processes(&t, count, seconds);
    else
        run_here(&t, count, seconds);
    if (may_end())
        printf("%-16s %4llu inputs ended the reader\n", running->name, (unsigned long long)t.ended);
    printf("%-16s %4zu seeds, %4llu read %9llu mutations, %9llu read %7.1f s\n", running->name, seed_count,
           (unsigned long long)t.seeds_read, (unsigned long long)t.mutations, (unsigned long long)t.mutations_read,
           seconds_used());
    return 0;
}
