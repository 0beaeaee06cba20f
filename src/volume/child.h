/* SPDX-License-Identifier: MIT */
/* child.h - a volume that a program of its own reads (child_stream.h); private to src/volume. */
#pragma once

#include "volume/stream_kernel.h"

typedef struct iso_child_program {
    const char *name;    /* "isoshade-itk" */
    const char *library; /* its library, for messages */
    const char *package; /* Debian's, that it is built with */
} iso_child_program;

/* Starts the program for the source's path, reads its header, and leaves it ready to give planes. `part`: the part
 * of the path's content to read; NULL: the only one. ISO_E_MISSING if it was not built. */
iso_status iso_child_open(iso_volume_source *source, const iso_child_program *program, const char *part,
                          iso_error *err);
