/* SPDX-License-Identifier: MIT */
/* Large buffers are whole, apart from each other, begin where a huge page does and are advised to have some; allocators
 * that do not keep this are noticed. */
#define _GNU_SOURCE
#include <errno.h>
#include <malloc.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/large.h"
#include "base/machine.h"
#include "tests/test.h"

enum { MIB = 1 << 20, HUGE_PAGE = 2 * MIB };

typedef void *allocator(size_t bytes);

/* Of the mapping that holds p: whether the kernel was asked for huge pages there; -1 when it does not tell. */
static int is_advised(const void *p)
{
    FILE *maps = fopen("/proc/self/smaps", "r");
    char line[4096];
    bool inside = false;
    int advised = -1;
    while (maps && advised < 0 && fgets(line, sizeof line, maps)) {
        uintmax_t from, to;
        if (sscanf(line, "%jx-%jx ", &from, &to) == 2)
            inside = from <= (uintptr_t)p && (uintptr_t)p < to;
        else if (inside && strncmp(line, "VmFlags:", 8) == 0)
            advised = strstr(line, " hg") != NULL;
    }
    if (maps)
        fclose(maps);
    return advised;
}

/* Kernels without huge pages refuse the advice, and then show none. */
static bool kernel_takes_advice(void)
{
    FREED void *p = aligned_alloc(HUGE_PAGE, 2 * HUGE_PAGE);
    const bool takes = p && madvise(p, 2 * HUGE_PAGE, MADV_HUGEPAGE) == 0 && is_advised(p) == 1;
    return takes;
}

/* From 4 MiB on. */
static bool begins_on_a_huge_page(allocator *alloc)
{
    static const size_t sizes[] = {4 * MIB, 4 * MIB + 1, 7 * MIB + 3};
    bool aligned = true;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        FREED void *p = alloc(sizes[i]);
        aligned = aligned && p && (uintptr_t)p % HUGE_PAGE == 0;
    }
    return aligned;
}

/* Its first and last whole huge page; of both, since advice may end early. */
static bool asks_for_huge_pages(allocator *alloc)
{
    const size_t bytes = 9 * MIB + 5;
    FREED char *p = alloc(bytes);
    const bool asks = p && is_advised(p) == 1 && is_advised(p + bytes / HUGE_PAGE * HUGE_PAGE - 1) == 1;
    return asks;
}

/* Every byte is there and is no other buffer's. */
static bool gives_whole_buffers(allocator *alloc)
{
    static const size_t sizes[] = {1, 4095, 2 * MIB, 4 * MIB - 1, 4 * MIB, 4 * MIB + 1, 7 * MIB + 3};
    enum { COUNT = sizeof sizes / sizeof *sizes };
    unsigned char *p[COUNT];
    bool whole = true;
    for (size_t i = 0; i < COUNT; ++i) {
        p[i] = alloc(sizes[i]);
        whole = whole && p[i] && malloc_usable_size(p[i]) >= sizes[i];
    }
    for (size_t i = 0; i < COUNT && whole; ++i)
        memset(p[i], (int)i + 1, sizes[i]);
    for (size_t i = 0; i < COUNT; ++i) {
        for (size_t k = 0; k < sizes[i] && whole; ++k)
            whole = p[i][k] == i + 1;
        free(p[i]);
    }
    return whole;
}

TEST(buffers_are_whole)
{
    assert_true(gives_whole_buffers(iso_large_alloc));
}

TEST(large_ones_begin_on_a_huge_page)
{
    assert_true(begins_on_a_huge_page(iso_large_alloc));
}

TEST(large_ones_are_advised_to_be_of_huge_pages)
{
    if (!kernel_takes_advice())
        skip();
    assert_true(asks_for_huge_pages(iso_large_alloc));
}

/* A sanitizer's allocator ends the program instead of returning NULL, unless an option forbids it. */
const char *__asan_default_options(void);
const char *__asan_default_options(void)
{
    return "allocator_may_return_null=1";
}

TEST(too_much_is_refused)
{
    static const size_t sizes[] = {SIZE_MAX, SIZE_MAX - HUGE_PAGE, SIZE_MAX - HUGE_PAGE + 1, SIZE_MAX / 2 + 1};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i)
        assert_null(iso_large_alloc(sizes[i]));
}

/* ---- samples ---- */

/* Of the mapping that holds p: the name of its file in /proc/self/maps, or "". */
static const char *file_of(const void *p)
{
    static char line[4096];
    FILE *maps = fopen("/proc/self/maps", "r");
    assert_non_null(maps);
    const char *name = "";
    while (!name[0] && fgets(line, sizeof line, maps)) {
        uintmax_t from, to;
        if (sscanf(line, "%jx-%jx ", &from, &to) == 2 && from <= (uintptr_t)p && (uintptr_t)p < to)
            name = strchr(line, '/') ? strchr(line, '/') : "";
    }
    fclose(maps);
    return name;
}

TEST(samples_on_disk_are_zeroed_and_have_no_name)
{
    enum { BYTES = 3 * MIB + 5 };
    unsigned char *p[2] = {iso_large_on_disk(BYTES), iso_large_on_disk(BYTES)};
    assert_true(p[0] && p[1]);
    assert_non_null(strstr(file_of(p[0]), "(deleted)"));
    for (size_t i = 0; i < BYTES; ++i)
        assert_true(p[0][i] == 0 && p[1][i] == 0);
    memset(p[0], 1, BYTES);
    memset(p[1], 2, BYTES);
    assert_true(p[0][0] == 1 && p[0][BYTES - 1] == 1 && p[1][0] == 2 && p[1][BYTES - 1] == 2);
    iso_large_free(p[0]);
    assert_string_equal(file_of(p[0]), ""); /* unmapped */
    assert_true(p[1][BYTES / 2] == 2);
    iso_large_free(p[1]);
    assert_null(iso_large_on_disk(SIZE_MAX / 4));
    iso_large_free(NULL);
}

TEST(few_samples_are_in_memory)
{
    unsigned char *p = iso_large_samples(MIB);
    assert_non_null(p);
    assert_null(strstr(file_of(p), "(deleted)"));
    assert_true(p[0] == 0 && p[MIB - 1] == 0);
    iso_large_free(p);
}

static double data_bytes(void)
{
    FILE *file = fopen("/proc/self/status", "r");
    char line[256];
    double kilobytes = 0;
    while (file && fgets(line, sizeof line, file) && sscanf(line, "VmData: %lf", &kilobytes) != 1)
        ;
    if (file)
        fclose(file);
    return 1024 * kilobytes;
}

/* `ulimit -d`: samples of more than half of what it leaves are on disk; the planted allocator has no room for them. */
TEST(many_samples_keep_to_the_limit_of_the_process)
{
    const size_t bytes = 80 * (size_t)MIB;
    struct rlimit whole, small;
#ifdef __SANITIZE_ADDRESS__
    skip(); /* its allocator ends the program */
#endif
    assert_true(getrlimit(RLIMIT_DATA, &whole) == 0);
    small = whole;
    small.rlim_cur = (rlim_t)(data_bytes() + (double)bytes / 2);
    if (setrlimit(RLIMIT_DATA, &small) != 0)
        skip();
    unsigned char *p = iso_large_samples(bytes);
    const bool planted = !calloc(bytes, 1);
    assert_true(setrlimit(RLIMIT_DATA, &whole) == 0);
    assert_non_null(p);
    assert_non_null(strstr(file_of(p), "(deleted)"));
    assert_true(planted);
    iso_large_free(p);
}

static void write_text(const char *root, const char *path, const char *text)
{
    char whole[4096];
    snprintf(whole, sizeof whole, "%s/%s", root, path);
    for (char *slash = whole + strlen(root) + 1; (slash = strchr(slash, '/')); ++slash) {
        *slash = 0;
        assert_true(mkdir(whole, 0700) == 0 || errno == EEXIST);
        *slash = '/';
    }
    FILE *file = fopen(whole, "w");
    assert_true(file && fputs(text, file) >= 0 && fclose(file) == 0);
}

TEST(free_memory_is_that_of_the_machine_or_of_its_control_group)
{
    const double real = iso_machine_free_bytes("");
    assert_true(real > 0 && real <= (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE));
    FREED char *root = iso_make_temp_dir();
    assert_non_null(root);
    assert_true(isinf(iso_machine_free_bytes(root)));
    write_text(root, "proc/meminfo", "MemTotal: 9000 kB\nMemAvailable:    5000 kB\n");
    assert_true(iso_machine_free_bytes(root) == 5000 * 1024);
    /* Version 2: the group around it has the limit. */
    write_text(root, "proc/self/cgroup", "0::/a/b\n");
    write_text(root, "sys/fs/cgroup/a/b/memory.max", "max\n");
    write_text(root, "sys/fs/cgroup/a/memory.max", "4000000\n");
    write_text(root, "sys/fs/cgroup/a/memory.current", "3500000\n");
    assert_true(iso_machine_free_bytes(root) == 500000);
    write_text(root, "sys/fs/cgroup/a/memory.stat", "file 7\ninactive_file 1000000\n");
    assert_true(iso_machine_free_bytes(root) == 1500000);
    /* Version 1; the group of a container may be seen as the root. */
    write_text(root, "proc/self/cgroup", "5:devices:/c\n4:memory:/c\n0::/\n");
    write_text(root, "sys/fs/cgroup/memory/memory.limit_in_bytes", "2000000\n");
    write_text(root, "sys/fs/cgroup/memory/memory.usage_in_bytes", "2500000\n");
    assert_true(iso_machine_free_bytes(root) == 0);
    write_text(root, "sys/fs/cgroup/memory/memory.stat", "inactive_file 1\ntotal_inactive_file 800000\n");
    assert_true(iso_machine_free_bytes(root) == 300000);
    /* The limit of the process. */
    write_text(root, "proc/self/status", "VmPeak:\t  9000 kB\nVmData:\t     200 kB\n");
    write_text(root, "proc/self/limits", "Max data size             unlimited            unlimited            bytes\n");
    assert_true(iso_machine_free_bytes(root) == 300000);
    write_text(root, "proc/self/limits", "Max data size             409600               unlimited            bytes\n");
    assert_true(iso_machine_free_bytes(root) == 409600 - 200 * 1024);
    write_text(root, "proc/self/limits", "Max data size             204799               unlimited            bytes\n");
    assert_true(iso_machine_free_bytes(root) == 0);
    iso_remove_tree(root);
}

/* ---- planted faults ---- */

/* Whole huge pages alone: the end is missing. */
static void *rounded_down(size_t bytes)
{
    return bytes < 2 * HUGE_PAGE ? malloc(bytes) : aligned_alloc(HUGE_PAGE, bytes / HUGE_PAGE * HUGE_PAGE);
}

/* Half of what was asked for. */
static void *too_short(size_t bytes)
{
    return malloc(bytes / 2);
}

static void *never_there(size_t bytes)
{
    (void)bytes;
    return NULL;
}

/* For its first huge page only. */
static void *half_advised(size_t bytes)
{
    void *p = aligned_alloc(HUGE_PAGE, (bytes + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE);
    if (p)
        (void)madvise(p, HUGE_PAGE, MADV_HUGEPAGE);
    return p;
}

TEST(faults_are_noticed)
{
    assert_false(gives_whole_buffers(rounded_down));
    assert_false(gives_whole_buffers(too_short));
    assert_false(gives_whole_buffers(never_there));
    assert_false(begins_on_a_huge_page(malloc)); /* glibc keeps a header before it */
    assert_false(begins_on_a_huge_page(never_there));
    assert_false(asks_for_huge_pages(half_advised));
    assert_false(asks_for_huge_pages(rounded_down));
}

TEST_MAIN(NULL, NULL)
