/* SPDX-License-Identifier: MIT */
/* format.h - the table of transfer-function formats: a row and a file each.
 *
 * A format's file, src/tf/format_NAME.c, defines iso_tf_format_NAME and is
 * listed below; doc/extending.md explains. What is read is told by a file's
 * name and, where several formats share an ending, by its content; what is
 * written is told by the name alone. Every command that takes a transfer
 * function reads these files, and `isoshade tf convert` reads and writes them. */
#ifndef ISO_TF_FORMAT_H
#define ISO_TF_FORMAT_H

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

/* A file that is read: its bytes, behind which a 0 stands, and what the user says of it. */
typedef struct iso_tf_file {
    const char *path, *text;
    size_t size;
    const iso_tf_request *request;
} iso_tf_file;

/* What is written: a TF's points, or the table that renderers would look up, with opacities for unit_mm. */
typedef struct iso_tf_output {
    const iso_tf *tf;
    const iso_tf_table *table;
    double unit_mm;
} iso_tf_output;

typedef struct iso_tf_format {
    const char *name;    /* "json" */
    const char *summary; /* what a file holds */
    const char *suffix;  /* ".tf.json" */
    const char *also;    /* another ending of files that are read, which other formats may have: ".json"; or NULL */
    /* Does the content look like one? NULL: it cannot be told, the name decides. */
    bool (*probe)(const iso_tf_file *file);
    /* The TF, or ISO_E_FORMAT with the file's name. NULL: such files are written only. */
    iso_status (*load)(const iso_tf_file *file, iso_tf *tf, iso_error *err);
    /* The file appears when it is whole. NULL: such files are read only. */
    iso_status (*save)(const iso_tf_output *output, const char *path, iso_error *err);
    bool is_per_voxel; /* opacities that are written are for a voxel */
    bool says_no_unit; /* nor the length that opacities are for */
    bool needs_range;  /* what is written stands at the volume's own values, not at fractions of its range */
} iso_tf_format;

extern const iso_names iso_tf_format_names;
const iso_tf_format *iso_tf_format_at(size_t row); /* NULL behind the last */
/* The format of the longest suffix that the path ends with; NULL: none. */
const iso_tf_format *iso_tf_format_of(const char *path);
/* ".csv or .tf.json" of the formats that are written, in text, which it returns. */
char *iso_tf_format_written(char *text, size_t size);

/* ---- what loaders share ------------------------------------------------------------------------------------------ */

/* Does the file hold the text? */
bool iso_tf_file_has(const iso_tf_file *file, const char *text);

/* Which of the names the user asks for. One needs no asking. ISO_E_USAGE lists them. what: "color map". */
iso_status iso_tf_choose(const iso_tf_file *file, const char *what, const char *const *names, size_t count,
                         size_t *chosen, iso_error *err);

/* The curves and what the user says, resampled; takes what curves own, whatever it returns. */
iso_status iso_tf_take_curves(const iso_tf_file *file, iso_tf_curves *curves, iso_tf *tf, iso_error *err);

#endif
