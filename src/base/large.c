/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/large.h"

#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>

enum { HUGE_PAGE = 1 << 21 };

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
