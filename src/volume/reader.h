/* SPDX-License-Identifier: MIT */
/* reader.h - functions that readers of short headers share; private to src/volume. */
#pragma once

#include "volume/stream_kernel.h"

/* Reads the first bytes of a file, at most `bytes`, and ends them with a 0: `head` is a byte longer. ISO_E_IO. */
iso_status iso_reader_head(const char *path, char *head, size_t bytes, size_t *got, iso_error *err);

/* True if a word is among a file's first 4096 bytes, or if the file cannot be read, which the reader reports. */
bool iso_reader_may_hold(const char *path, const char *word);

/* True if the name ends so, in small letters or in capitals. */
bool iso_reader_is_named(const char *path, const char *ending);

/* Sets the grid: step[a] leads from the center of a sample to the next along axis a, `first` is the center of the first
 * one, both in `unit`, which --unit overrides. Checks it by iso_source_check_geometry(). */
iso_status iso_reader_place(iso_volume_source *source, const size_t size[3], double step[3][3], const double first[3],
                            const char *unit, iso_error *err);

/* Returns a big-endian number of 1 to 8 bytes; a big-endian float. */
uint64_t iso_reader_number(const unsigned char *at, size_t bytes);
double iso_reader_float(const unsigned char *at);

/* Returns the text after the line's key and sign, such as "dim:", without spaces; NULL: no line starts with it. */
const char *iso_reader_value(const char *text, const char *key);

/* Finds the text of an attribute of the XML tag that starts at `tag`, which may be NULL; false, and "": it has none. */
bool iso_reader_attribute(const char *tag, const char *name, char *out, size_t size);

/* Sets the source's type by a format's word for it: of VTK, MetaImage or MRtrix, in any case. False: it is none. */
bool iso_reader_take_type(iso_volume_source *source, const char *word, size_t length);
/* Does the same for a whole word. ISO_E_FORMAT: it is none. */
iso_status iso_reader_need_type(iso_volume_source *source, const char *word, iso_error *err);

/* Reads numbers between spaces or commas; returns their count, at most `most`. */
size_t iso_reader_numbers(const char *text, double *out, size_t most);
