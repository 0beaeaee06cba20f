/* SPDX-License-Identifier: MIT */
/* large.h - memory for buffers of megabytes that are written from end to end.
 *
 * The kernel hands out memory by pages of 4 KiB on first touch. For the buffers of a build that costs up to a tenth
 * of its time. If the kernel has pages of 2 MiB on request (Linux, transparent huge pages), they are requested. */
#ifndef ISO_BASE_LARGE_H
#define ISO_BASE_LARGE_H

#include <stddef.h>

/* Allocates as malloc() does; freed by free(). From 4 MiB on it begins on a multiple of 2 MiB, and its whole huge
 * pages are requested. NULL: out of memory. */
void *iso_large_alloc(size_t bytes);

#endif
