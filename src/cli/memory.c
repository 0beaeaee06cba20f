/* SPDX-License-Identifier: MIT */
/* memory.c - what the program does where memory has ended.
 *
 * Small allocations that fail end the program with one line and ISO_E_MEMORY, and what is unfinished is removed: no
 * program can do much without a few bytes. So do all that libraries make: those below (popt, jansson, teem, OpenEXR, Mesa)
 * crash, wait for ever, or lose a part without a word. Large ones of our own code, of samples and pictures, fail as
 * everywhere and are told by what wanted them. It is the same with threads: Mesa waits for ever for one that could not be
 * started. So malloc() and its like are put before those of glibc here. The library isoshade is for programs of others,
 * which decide for themselves: it has none of this. */
#define _GNU_SOURCE
#include "cli/memory.h"

#include <dlfcn.h>
#include <errno.h>
#include <malloc.h>
#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/unfinished.h"
#include "isoshade.h"

static const char *program = "isoshade", *command = "";

void iso_memory_is_for(const char *program_name, const char *name)
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

/* The sanitizers have allocators of their own. */
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

enum { SMALL_BYTES = 1 << 20 };

void *__libc_malloc(size_t bytes);
void *__libc_calloc(size_t count, size_t bytes);
void *__libc_realloc(void *old, size_t bytes);
void *__libc_memalign(size_t alignment, size_t bytes);

/* The program's own code lies between the two. */
extern const char __executable_start, etext;

/* caller: where a call comes from */
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
    return bytes == 0 ? p : given(p, 1, bytes, CALLER); /* of no bytes it frees, and gives nothing */
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
        iso_memory_end("no more threads can be started");
    return failed;
}

#endif
