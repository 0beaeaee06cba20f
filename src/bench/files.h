/* SPDX-License-Identifier: MIT */
/* files.h - the time of a streaming build, compared with the time that the disk needs for the same bytes. */
#ifndef ISO_BENCH_FILES_H
#define ISO_BENCH_FILES_H

#include "pyramid/pyramid_stream.h"

/* Of the fastest run of each. */
typedef struct bench_files_times {
    iso_stream_report stream;
    /* Reading the volume's file and writing files as long as the pyramid's, at once, nothing computed: until the disk
     * has them, as it has the pyramid's, and until they are handed to it. */
    double floor, floor_unflushed;
    size_t bytes; /* read and written */
} bench_files_times;

/* Builds `runs` times in a folder of its own within `folder`, each build beside one copy of the same bytes.
 * memory_bytes: of buffers; 0: as build does. */
iso_status iso_bench_files(const iso_volume *v, const iso_pyramid_options *opt, const char *folder, size_t memory_bytes,
                           size_t runs, bench_files_times *times, iso_error *err);
/* The same for a volume that is in a file already. */
iso_status iso_bench_files_of(const char *volume, const iso_pyramid_options *opt, const char *folder,
                              size_t memory_bytes, size_t runs, bench_files_times *times, iso_error *err);

#endif
