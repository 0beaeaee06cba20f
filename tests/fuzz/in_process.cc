/* SPDX-License-Identifier: MIT */
/* in_process.cc - a reader that is a program of its own, called within this process: to start a program takes a hundred
 * times as long as most damaged files take to be refused. Linked with the objects of one such program but its main(), in
 * place of src/volume/child_start.c. What the reader writes goes to a file in memory, from which it is read as from the
 * program's output. */
#include <malloc.h>
#include <pthread.h>
#include <setjmp.h>
#include <sys/mman.h>
#include <time.h>

extern "C" {
#include "volume/child_start.h"
/* tests/fuzz/fuzz.h, which is no C++. */
extern const bool fuzz_reader_may_end;
const bool fuzz_reader_may_end = true;
extern unsigned fuzz_assertions;
}
#include "volume/child_writer.h"

namespace {

/* The sanitizer's own memory is more than any limit; with it all takes several times as long. */
#ifdef __SANITIZE_ADDRESS__
constexpr bool is_sanitized = true;
#else
constexpr bool is_sanitized = false;
#endif

/* As for the program itself, ISOSHADE_SANDBOX=off lifts the limits, for valgrind: it needs more memory and time. */
bool has_limits()
{
    const char *sandbox = getenv("ISOSHADE_SANDBOX");
    return !is_sanitized && !(sandbox && strcmp(sandbox, "off") == 0);
}

/* A header may promise any number of samples: so much is written, then nobody reads any more. */
enum { MOST_BYTES = 64 << 20 };

/* Where a reading is left at an assertion of a library or as it aborts, in the thread that reads. A process for each takes longer than all
 * else where every fifth file meets one. */
sigjmp_buf left;
volatile bool is_reading;
pthread_t reading_thread;

struct Output {
    int fd;
    size_t written;
};

ssize_t take(void *cookie, const char *data, size_t bytes)
{
    Output *output = static_cast<Output *>(cookie);
    if (output->written + bytes > MOST_BYTES)
        return 0;
    output->written += bytes;
    return write(output->fd, data, bytes);
}

/* Once: what the process holds at its start. */
rlim_t begin()
{
    size_t pages[6] = {};
    FILE *f = fopen("/proc/self/statm", "r");
    for (size_t i = 0; f && i < 6; ++i)
        if (fscanf(f, "%zu", &pages[i]) != 1)
            pages[i] = 0;
    if (f)
        fclose(f);
    mallopt(M_MMAP_THRESHOLD, 32 << 20); /* pages that are given back have to be cleared and mapped again */
    mallopt(M_TRIM_THRESHOLD, 64 << 20);
    pthread_attr_t threads; /* whose stacks are 8 MB each */
    pthread_attr_init(&threads);
    pthread_attr_setstacksize(&threads, 1 << 20);
    pthread_setattr_default_np(&threads);
    pthread_attr_destroy(&threads);
    return pages[5] * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
}

/* Processor time for what one input may keep a library busy with: OpenVDB counts to 2^32 where the file ended long before.
 * Its reader has seconds (limit_seconds), and answers at the same signal. 0: no limit any more. */
void limit_milliseconds(long ms)
{
    static timer_t timer;
    static const bool is_there = [] {
        sigevent event{};
        event.sigev_notify = SIGEV_SIGNAL;
        event.sigev_signo = SIGXCPU;
        return timer_create(CLOCK_PROCESS_CPUTIME_ID, &event, &timer) == 0;
    }();
    const itimerspec limit{{0, 0}, {0, ms * 1000000}};
    if (is_there)
        timer_settime(timer, 0, &limit, nullptr);
}

/* A reader has 192 MB and more beside 3100 bytes a byte of its file (memory_for). What is cleared for damaged lengths, up to
 * that, was nine tenths of the time; so here it has less, of which the small files of tests/fuzz/seeds need a part. */
void limit_further(const char *path)
{
    static const rlim_t start = begin();
    rlimit limit{};
    getrlimit(RLIMIT_DATA, &limit);
    const double room = 32e6 + 256 * bytes_of_input(path, 1e6);
    limit.rlim_cur = std::min(limit.rlim_cur, start + static_cast<rlim_t>(room));
    setrlimit(RLIMIT_DATA, &limit);
}

} // namespace

/* Both in place of the C library's: GDCM asserts, libpng aborts where ITK reads a header. What the frames between hold stays
 * lost: the driver ends a process after some. */
extern "C" void abort() noexcept
{
    if (is_reading && !is_sanitized && pthread_equal(pthread_self(), reading_thread)) {
        ++fuzz_assertions;
        siglongjmp(left, 1);
    }
    raise(SIGABRT);
    _exit(1);
}

extern "C" void __assert_fail(const char *what, const char *file, unsigned line, const char *function) noexcept
{
    fprintf(stderr, "%s:%u: %s: Assertion `%s' failed.\n", file, line, function, what);
    abort();
}

extern "C" iso_status iso_child_start(iso_child_process *process, const char *const words[], iso_error *err)
{
    Output output{memfd_create("output", MFD_CLOEXEC), 0};
    cookie_io_functions_t functions{};
    functions.write = take;
    FILE *out = output.fd >= 0 ? fopencookie(&output, "wb", functions) : nullptr;
    *process = iso_child_process{0, output.fd};
    if (!out)
        return iso_fail(err, ISO_E_MEMORY, "%s: no file in memory", words[1]);
    if (!strstr(words[0], FUZZ_PROGRAM))
        return iso_fail(err, ISO_E_MISSING, "%s is asked for, and this is " FUZZ_PROGRAM, words[0]);
    if (has_limits()) {
        limit_memory(memory_for(words[1]));
        limit_further(words[1]);
    }
    limit_milliseconds(has_limits() ? 100 : is_sanitized ? 900 : 60000);
    reading_thread = pthread_self();
    if (sigsetjmp(left, 0) == 0) {
        is_reading = true;
        write_volume(child_program, words[1],
                     {words[2], std::stoul(words[3]), std::stoul(words[4]), std::stoul(words[5])}, out);
    }
    is_reading = false;
    limit_milliseconds(0);
    fclose(out);
    lseek(output.fd, 0, SEEK_SET);
    return ISO_OK;
}
