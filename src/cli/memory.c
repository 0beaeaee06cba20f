/* SPDX-License-Identifier: MIT */
/* memory.c - ends the program if small allocations fail.
 *
 * Small allocations that fail, and all of other libraries, end the program with one line and ISO_E_MEMORY after
 * removing unfinished files. Libraries (popt, jansson, teem, OpenEXR, Mesa) would otherwise crash, hang, or silently
 * lose data. Large allocations of our own code, such as samples and pictures, fail normally, with a message of the
 * caller. Threads that cannot be started end the program, too: Mesa would wait for them forever. For this, malloc() and
 * related functions here replace glibc's. The library isoshade does not: programs that use it decide for themselves. */
#define _GNU_SOURCE
#include "cli/memory.h"

#include <dlfcn.h>
#include <errno.h>
#include <malloc.h>
#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/unfinished.h"
#include "isoshade.h"

static const char *program = "isoshade", *command = "";

void iso_memory_set_command(const char *program_name, const char *name)
{
    program = program_name;
    command = name;
}

void iso_memory_end(const char *why)
{
    const char *const parts[] = {program, command[0] ? " " : "", command, ": ", why, "\n"};
    iso_unfinished_remove(true);
    for (size_t i = 0; why && i < sizeof parts / sizeof *parts; ++i)
        if (write(STDERR_FILENO, parts[i], strlen(parts[i])) < 0)
            break;
    _exit(ISO_E_MEMORY);
}

/* The sanitizers replace the allocator themselves. */
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

enum { SMALL_BYTES = 1 << 20 };

void *__libc_malloc(size_t bytes);
void *__libc_calloc(size_t count, size_t bytes);
void *__libc_realloc(void *old, size_t bytes);
void *__libc_memalign(size_t alignment, size_t bytes);

/* Bounds of the program's own code. */
extern const char __executable_start, etext;

/* True if a call comes from the program's own code. caller: return address. */
static bool is_ours(const void *caller)
{
    return (const char *)caller >= &__executable_start && (const char *)caller < &etext;
}

static void *given(void *p, size_t count, size_t bytes, const void *caller)
{
    size_t all;
    if (!p && (!is_ours(caller) || (!__builtin_mul_overflow(count, bytes, &all) && all < SMALL_BYTES)))
        iso_memory_end("out of memory");
    return p;
}
#define CALLER __builtin_return_address(0)

void *malloc(size_t bytes)
{
    return given(__libc_malloc(bytes), 1, bytes, CALLER);
}

void *calloc(size_t count, size_t bytes)
{
    return given(__libc_calloc(count, bytes), count, bytes, CALLER);
}

void *realloc(void *old, size_t bytes)
{
    void *p = __libc_realloc(old, bytes);
    return bytes == 0 ? p : given(p, 1, bytes, CALLER); /* 0 bytes: frees p and returns NULL */
}

void *memalign(size_t alignment, size_t bytes)
{
    return given(__libc_memalign(alignment, bytes), 1, bytes, CALLER);
}

void *aligned_alloc(size_t alignment, size_t bytes)
{
    return given(__libc_memalign(alignment, bytes), 1, bytes, CALLER);
}

int posix_memalign(void **p, size_t alignment, size_t bytes)
{
    if (alignment % sizeof(void *) != 0 || alignment == 0 || (alignment & (alignment - 1)) != 0)
        return EINVAL;
    void *got = given(__libc_memalign(alignment, bytes), 1, bytes, CALLER);
    if (!got)
        return ENOMEM;
    *p = got;
    return 0;
}

int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*routine)(void *), void *argument)
{
    typedef int create(pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);
    static create *next;
    if (!next)
        *(void **)&next = dlsym(RTLD_NEXT, "pthread_create");
    const int failed = next(thread, attributes, routine, argument);
    if (failed && !is_ours(CALLER))
        iso_memory_end("cannot start more threads");
    return failed;
}

#endif
