/* SPDX-License-Identifier: MIT */
/* format.h - the table of transfer-function formats: a row and a file each.
 *
 * A format's file, src/tf/format_NAME.c, defines iso_tf_format_NAME and is
 * listed below; doc/extending.md shows one. A file is of the format whose suffix
 * its name ends with: then every command that takes a transfer function reads
 * it, and `isoshade tf convert` reads and writes it. */
#ifndef ISO_TF_FORMAT_H
#define ISO_TF_FORMAT_H

#include "base/names.h"
#include "tf/tf.h"

/* clang-format off */
#define ISO_TF_FORMAT_LIST(X) \
    X(csv)                    \
    X(json)
/* clang-format on */

typedef struct iso_tf_format {
    const char *name;    /* "json" */
    const char *summary; /* what a file holds */
    const char *suffix;  /* ".tf.json" */
    /* As iso_tf_load(). NULL: such files are written only. */
    iso_status (*load)(const char *path, iso_tf *tf, iso_error *err);
    /* The table, opacities for unit_mm; the file appears when it is whole. NULL: such files are read only. */
    iso_status (*save)(const iso_tf_table *table, double unit_mm, const char *path, iso_error *err);
} iso_tf_format;

extern const iso_names iso_tf_format_names;
const iso_tf_format *iso_tf_format_at(size_t row); /* NULL behind the last */
/* The format of the longest suffix that the path ends with; NULL: none. */
const iso_tf_format *iso_tf_format_of(const char *path);
/* ".csv or .tf.json" of the formats that are written, in text, which it returns. */
char *iso_tf_format_written(char *text, size_t size);

#endif
