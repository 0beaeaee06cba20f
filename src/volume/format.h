/* SPDX-License-Identifier: MIT */
/* format.h - the table of volume formats: a row and a file each.
 *
 * A format's file, src/volume/NAME_open.c, defines iso_volume_format_NAME and is
 * listed below; doc/extending.md explains. iso_source_open() (stream.h) asks
 * the rows in order whether a file is theirs, by its first bytes. */
#pragma once

#include "base/names.h"
#include "volume/stream.h"

/* clang-format off */
#define ISO_VOLUME_FORMAT_LIST(X) \
    X(nrrd)                       \
    X(nifti)                      \
    X(metaimage)                  \
    X(vtk)                        \
    X(vti)                        \
    X(tiff)                       \
    X(mrc)                        \
    X(cube)                       \
    X(xsf)                        \
    X(gipl)                       \
    X(npy)                        \
    X(npz)                        \
    X(fits)                       \
    X(mif)                        \
    X(pvti)                       \
    X(hdf5)                       \
    X(netcdf)                     \
    X(zarr)                       \
    X(vdb)                        \
    X(itk)                        \
    X(afni)                       \
    X(dx)                         \
    X(vasp)                       \
    X(mgh)                        \
    X(raw)
/* clang-format on */

enum {
    ISO_VOLUME_HEAD_BYTES = 348
}; /* of a file, that probe() sees: the longest header that needs them is NIfTI-1's */

/* Bytes by which files of a format are known, and their place. */
typedef struct iso_mark {
    size_t at, size;
    const char *bytes;
} iso_mark;
#define ISO_MARK(at, bytes) \
    { \
        at, sizeof(bytes) - 1, bytes \
    }
/* True if the first bytes of a file have one of `count` marks. */
bool iso_marks_fit(const iso_mark *marks, size_t count, const unsigned char *head, size_t size);
enum { ISO_VOLUME_MARKS = 3 };

typedef struct iso_volume_format {
    const char *name;     /* "nrrd" */
    const char *title;    /* "NRRD" */
    const char *summary;  /* description of the readable part of the format */
    const char *suffixes; /* of its files' names, such as ".nrrd .nhdr": left out in a pyramid's name */
    const char
        *starts;     /* how its files start, for the message about a file that is of no format; NULL where probe is */
    bool takes_part;   /* of a file that holds several volumes, FILE:PART names one */
    bool unpacks;      /* gzip by itself, plane by plane; others get an unpacked copy of the file */
    bool takes_series; /* of a folder that holds several volumes, --series names one */
    iso_mark marks[ISO_VOLUME_MARKS]; /* a file with one of them, unpacked if compressed, is of this format */
    /* The same, if marks are not enough. Without both only options select the format, as for raw. */
    bool (*probe)(const unsigned char *head, size_t size);
    /* Whether a folder, or a file that no row's probe() takes, is of this format; NULL: none is. */
    bool (*probe_path)(const char *path);
    /* Reads the header into an empty source whose path is set, and leaves the samples ready to be read: a file or a
     * compressed file at the first sample, all samples in memory, or a reader of its own (stream_kernel.h). Checks
     * the geometry and that the number of samples is the header's. The caller closes the source on failure. */
    iso_status (*open)(iso_volume_source *source, iso_error *err);
    /* The same, if `open` is NULL, from the opened file, which the caller closes: headers of text, and short ones. */
    iso_status (*read)(FILE *file, iso_volume_source *source, iso_error *err);
} iso_volume_format;

extern const iso_names iso_volume_format_names;
/* Returns rows 0 .. iso_volume_format_names.count - 1, then those that were added; NULL after the last. */
const iso_volume_format *iso_volume_format_at(size_t row);

/* Adds a format, such as a module's; the row must live as long as the program. ISO_E_RANGE if the table is full.
 * Before threads open files. */
iso_status iso_volume_format_add(const iso_volume_format *format, iso_error *err);

/* Returns the bytes of the longest suffix of any format that `name` ends with. 0: there is none, or nothing precedes
 * it. */
size_t iso_volume_format_suffix_bytes(const char *name);
