/* SPDX-License-Identifier: MIT */
/* stream_kernel.h - what the readers of formats share; private to src/volume. */
#ifndef ISO_VOLUME_STREAM_KERNEL_H
#define ISO_VOLUME_STREAM_KERNEL_H

#include <stdio.h>
#include <zlib.h>

#include "volume/stream.h"

struct iso_volume_source {
    char *path;       /* for error messages */
    iso_volume header;
    FILE *file;       /* plain samples, or */
    gzFile gz;        /* compressed ones, or */
    char *preloaded;  /* all of them, of encodings that are read at once */
    bool swap_bytes;
    iso_type stored;  /* the type in the file; header.type is another one where the scale is applied */
    bool scaled;
    double slope, intercept;
    size_t planes_done;
};

/* Headers are read into an empty source with its path set; on failure the
 * caller closes it. */
iso_status iso_nrrd_open(iso_volume_source *source, iso_error *err);
iso_status iso_nifti_open(iso_volume_source *source, iso_error *err);

/* True when the first bytes are those of a NIfTI-1 or NIfTI-2 header of either byte order. */
bool iso_nifti_starts_like(const unsigned char *head, size_t size);

/* Checks header.geometry, and that `available` is the number of bytes of its samples. */
iso_status iso_source_check_bytes(const iso_volume_source *source, double available, iso_error *err);
size_t iso_source_bytes(const iso_volume_source *source);

#endif
