/* SPDX-License-Identifier: MIT */
/* npy.h - headers of arrays that numpy.save() wrote: a Python dictionary of type, order and shape [NEP 1]. */
#pragma once

#include "base/status.h"

enum { ISO_NPY_MOST_HEADER = 65536, ISO_NPY_MOST_AXES = 5 };

typedef struct iso_npy {
    char text[ISO_NPY_MOST_HEADER + 1];
    size_t samples_at; /* bytes before the samples */
} iso_npy;

/* Reads the header's text. ISO_E_IO; ISO_E_FORMAT: it is damaged. */
iso_status iso_npy_read_header(const char *path, iso_npy *n, iso_error *err);
/* Returns the text after 'key': in the dictionary; NULL: it is missing. */
const char *iso_npy_value(const iso_npy *n, const char *key);
/* Reads the type, such as '<f4': its byte order (<, >, | or =) and name. Returns false if it is none. */
bool iso_npy_type(const iso_npy *n, char *order, char name[3]);
/* Reads the shape in the order of the file's text. Returns false if it is damaged, or has more axes. */
bool iso_npy_shape(const iso_npy *n, size_t axes[ISO_NPY_MOST_AXES], size_t *count, bool *is_fortran);
/* Returns whether samples of this byte order have to be swapped. */
bool iso_npy_is_swapped(char order);
