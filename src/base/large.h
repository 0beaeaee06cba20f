/* SPDX-License-Identifier: MIT */
/* large.h - memory for buffers of megabytes that are written from end to end.
 *
 * The kernel hands out memory by pages of 4 KiB on first touch. For the buffers of a build that costs up to a tenth
 * of its time. If the kernel has pages of 2 MiB on request (Linux, transparent huge pages), they are requested. */
#pragma once

#include <stddef.h>

/* Allocates as malloc() does; freed by free(). From 4 MiB on it begins on a multiple of 2 MiB, and its whole huge
 * pages are requested. NULL: out of memory. */
void *iso_large_alloc(size_t bytes);

/* Allocates zeroed memory for samples; freed by iso_large_free(). From 64 MiB on, more than half of the free memory
 * becomes a file without a name in $TMPDIR or /var/tmp: its pages can leave the memory. NULL: neither memory nor disk
 * suffices. */
void *iso_large_samples(size_t bytes);
/* Does so in any case. */
void *iso_large_on_disk(size_t bytes);
/* Frees either; accepts NULL and what malloc() returned. */
void iso_large_free(void *samples);
