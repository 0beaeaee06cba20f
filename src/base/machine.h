/* SPDX-License-Identifier: MIT */
/* machine.h - description of the machine, for reports whose figures depend on it. */
#ifndef ISO_MACHINE_H
#define ISO_MACHINE_H

#include <jansson.h>

/* Returns {"processor", "cores", "memory_bytes", "system"}; "unknown" if the system does not report one. */
json_t *iso_machine_describe(void);

#endif
