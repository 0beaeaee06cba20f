/* SPDX-License-Identifier: MIT */
/* machine.h - what a program ran on, for reports whose figures depend on it. */
#ifndef ISO_MACHINE_H
#define ISO_MACHINE_H

#include <jansson.h>

/* {"processor", "cores", "memory_bytes", "system"}; "unknown" where the system does not say. */
json_t *iso_machine_describe(void);

#endif
