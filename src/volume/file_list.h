/* SPDX-License-Identifier: MIT */
/* file_list.h - files that list others, a time step each: ParaView's .pvd and VTK's .series; private to src/volume. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

typedef struct iso_listed_file {
    double time;
    char *path; /* in the list's folder, if its name is relative */
} iso_listed_file;

typedef struct iso_file_list {
    iso_listed_file *file; /* by time; those of one time as they are listed */
    size_t count, room;
    double step; /* of time, if it is even within 1 %; 0 otherwise */
} iso_file_list;

/* True if the path's name is that of a list. */
bool iso_file_list_is_one(const char *path);
/* Reads a list, to be destroyed in every case. ISO_E_FORMAT: the list is damaged or empty, or has several parts of a
 * time step; ISO_E_IO; ISO_E_MEMORY. */
iso_status iso_file_list_read(const char *path, iso_file_list *list, iso_error *err);
void iso_file_list_destroy(iso_file_list *list);
