/* SPDX-License-Identifier: MIT */
/* large.h - memory for buffers of megabytes that are written from end to end.
 *
 * The kernel hands out memory by pages of 4 KiB when they are first touched, which for the buffers of a build costs as
 * much as a tenth of its time; where it has pages of 2 MiB on request (Linux, transparent huge pages), it is asked for
 * them. */
#ifndef ISO_BASE_LARGE_H
#define ISO_BASE_LARGE_H

#include <stddef.h>

/* As malloc(); freed by free(). From 4 MiB on it begins on a multiple of 2 MiB, and its whole huge pages are asked for.
 * NULL: there is no such memory. */
void *iso_large_alloc(size_t bytes);

#endif
