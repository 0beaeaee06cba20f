/* SPDX-License-Identifier: MIT */
/* stream_kernel.h - what the readers of formats share; private to src/volume. */
#ifndef ISO_VOLUME_STREAM_KERNEL_H
#define ISO_VOLUME_STREAM_KERNEL_H

#include <stdio.h>
#include <zlib.h>

#include "volume/format.h"

struct iso_volume_source {
    char *path; /* for error messages */
    iso_volume header;
    FILE *file; /* plain samples, or */
    gzFile gz;  /* compressed ones, or */
    bool gz_end_is_missing;
    char *preloaded; /* all of them, of encodings that are read at once */
    bool swap_bytes;
    iso_type stored; /* the type in the file; header.type is another one where the scale is applied */
    bool scaled;
    double slope, intercept;
    size_t planes_done;
    /* Samples that are none of these: read_planes gives the next ones in the machine's byte order, and close_reader, which
     * may be NULL, ends it. */
    void *reader;
    iso_status (*read_planes)(iso_volume_source *source, size_t plane_count, void *out, iso_error *err);
    void (*close_reader)(iso_volume_source *source);
};

/* Checks header.geometry, and that `available` is the number of bytes of its samples. */
iso_status iso_source_check_bytes(const iso_volume_source *source, double available, iso_error *err);
/* The same of what the plain file holds from where it stands. */
iso_status iso_source_check_rest(const iso_volume_source *source, iso_error *err);
size_t iso_source_bytes(const iso_volume_source *source);

#endif
