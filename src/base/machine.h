/* SPDX-License-Identifier: MIT */
/* machine.h - description of the machine, for reports whose figures depend on it; and its free memory. */
#pragma once

#include <jansson.h>

/* Returns {"processor", "cores", "memory_bytes", "system"}; "unknown" if the system does not report one. */
json_t *iso_machine_describe(void);

/* Returns the bytes of memory that are free, by /proc/meminfo, or those left to a control group (version 1 or 2) of this
 * process or by its `ulimit -d` if that is less. Infinite if none of the files tells. root: put before the paths of all
 * files, for tests. */
double iso_machine_free_bytes(const char *root);
