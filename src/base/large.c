/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/large.h"

#include <fcntl.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include "base/machine.h"

enum { HUGE_PAGE = 1 << 21, LEAST_ON_DISK = 1 << 26 };

void *iso_large_alloc(size_t bytes)
{
    if (bytes < 2 * (size_t)HUGE_PAGE || bytes > SIZE_MAX - HUGE_PAGE)
        return malloc(bytes);
    /* A multiple of the alignment, as aligned_alloc() requires; untouched pages take no memory. */
    void *p = aligned_alloc(HUGE_PAGE, (bytes + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE);
    /* Only advice: the end may be part of a huge page, and is left to pages of 4 KiB. */
    if (p)
        (void)madvise(p, bytes / HUGE_PAGE * HUGE_PAGE, MADV_HUGEPAGE);
    return p;
}

/* ---- samples on disk --------------------------------------------------------------------------------------------- */

typedef struct mapping {
    void *begin;
    size_t bytes;
    struct mapping *next;
} mapping;

static mapping *mappings;
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;

/* Maps a new file without a name. Its blocks are reserved: a full disk ends here, not in the middle of a write. */
static void *map_file(size_t bytes)
{
    const char *dir = getenv("TMPDIR");
    char *name = NULL;
    const int file = asprintf(&name, "%s/isoshade-XXXXXX", dir && *dir ? dir : "/var/tmp") < 0
                         ? -1
                         : mkostemp(name, O_CLOEXEC);
    if (file >= 0)
        unlink(name);
    free(name);
    if (file < 0)
        return MAP_FAILED;
    void *p = posix_fallocate(file, 0, (off_t)bytes) == 0
                  ? mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0)
                  : MAP_FAILED;
    close(file);
    return p;
}

void *iso_large_on_disk(size_t bytes)
{
    mapping *m = malloc(sizeof *m);
    void *p = m && bytes <= SIZE_MAX / 4 ? map_file(bytes + !bytes) : MAP_FAILED;
    if (p == MAP_FAILED) {
        free(m);
        return NULL;
    }
    pthread_mutex_lock(&mutex);
    *m = (mapping){p, bytes + !bytes, mappings};
    mappings = m;
    pthread_mutex_unlock(&mutex);
    return p;
}

void *iso_large_samples(size_t bytes)
{
    const bool is_too_much = bytes >= LEAST_ON_DISK && (double)bytes > iso_machine_free_bytes("") / 2;
    void *p = is_too_much ? iso_large_on_disk(bytes) : NULL;
    return p ? p : calloc(bytes ? bytes : 1, 1);
}

/* Takes the mapping that begins at p off the list; NULL if there is none. */
static mapping *take_mapping(const void *p)
{
    pthread_mutex_lock(&mutex);
    mapping **at = &mappings;
    while (*at && (*at)->begin != p)
        at = &(*at)->next;
    mapping *found = *at;
    if (found)
        *at = found->next;
    pthread_mutex_unlock(&mutex);
    return found;
}

void iso_large_free(void *samples)
{
    mapping *m = samples ? take_mapping(samples) : NULL;
    if (!m) {
        free(samples);
        return;
    }
    munmap(m->begin, m->bytes);
    free(m);
}
