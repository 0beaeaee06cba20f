/* SPDX-License-Identifier: MIT */
/* format.h - the table of transfer-function formats: one row and one file each.
 *
 * A format's file, src/tf/format_NAME.c, defines iso_tf_format_NAME and is
 * listed below; doc/extending.md explains. To read, a file's format follows from
 * its name and, if several formats share an ending, from its content. To write,
 * it follows from the name alone. Every command that takes a transfer function
 * reads these files, and `isoshade tf convert` reads and writes them. */
#pragma once

#include "base/names.h"
#include "tf/curves.h"

/* clang-format off */
#define ISO_TF_FORMAT_LIST(X) \
    X(csv)                    \
    X(json)                   \
    X(slicer)                 \
    X(slicer_mrml)            \
    X(slicer_vp)              \
    X(paraview)               \
    X(paraview_xml)           \
    X(niivue)                 \
    X(inviwo)                 \
    X(voreen)                 \
    X(imagej)                 \
    X(png)
/* clang-format on */

/* Input file: its bytes, followed by a 0, and the user's request. */
typedef struct iso_tf_file {
    const char *path, *text;
    size_t size;
    const iso_tf_request *request;
} iso_tf_file;

/* Output: a TF's points, or the table for renderers, with opacities for unit_mm. */
typedef struct iso_tf_output {
    const iso_tf *tf;
    const iso_tf_table *table;
    double unit_mm;
} iso_tf_output;

enum { ISO_TF_MARKS = 3 };
typedef struct iso_tf_format {
    const char *name;    /* "json" */
    const char *summary; /* content of a file */
    const char *suffix;  /* ".tf.json" */
    const char *also;    /* second ending of input files, which other formats may share: ".json"; or NULL */
    const char *marks[ISO_TF_MARKS]; /* texts of which a file of this format has one; none: the name decides */
    bool has_all_marks;              /* True if it has all of them */
    /* Loads a TF; ISO_E_FORMAT names the file. NULL: such files are only written. */
    iso_status (*load)(const iso_tf_file *file, iso_tf *tf, iso_error *err);
    /* Writes the file; it appears once it is complete. NULL: such files are only read. */
    iso_status (*save)(const iso_tf_output *output, const char *path, iso_error *err);
    bool is_per_voxel; /* True if written opacities are per voxel */
    bool has_no_unit;  /* True if the format cannot store the length of opacities */
    bool needs_range;  /* True if points are written at the volume's values, not at fractions of its range */
} iso_tf_format;

extern const iso_names iso_tf_format_names;
const iso_tf_format *iso_tf_format_at(size_t row); /* NULL after the last row */
/* Returns the format with the longest suffix that the path ends with; NULL: none. */
const iso_tf_format *iso_tf_format_of(const char *path);
/* Writes the suffixes of all output formats, ".csv or .tf.json", into text and returns it. */
char *iso_tf_format_written(char *text, size_t size);

/* ---- shared by loaders ------------------------------------------------------------------------------------------- */

/* Sets *chosen to the requested name; a single name is chosen without a request. ISO_E_USAGE lists the names;
 * ISO_E_FORMAT: there is none. what: "color map", for messages. */
iso_status iso_tf_choose(const iso_tf_file *file, const char *what, const char *const *names, size_t count,
                         size_t *chosen, iso_error *err);

/* Resamples the curves to a TF according to the file's request, and completes them by it. */
iso_status iso_tf_take_curves(const iso_tf_file *file, iso_tf_curves *curves, iso_tf *tf, iso_error *err);
