/* SPDX-License-Identifier: MIT */
/* files.h - the time of a streaming build, compared with the time that the disk needs for the same bytes. */
#pragma once

#include "pyramid/pyramid_stream.h"

/* Times of the fastest build and of the fastest copy. */
typedef struct bench_files_times {
    iso_stream_report stream;
    /* Seconds to read the volume's file and write files as long as the pyramid's, in parallel, nothing computed: until
     * they are on the disk (as the pyramid is), and until the system has accepted them. */
    double floor, floor_unflushed;
    size_t bytes; /* read and written */
} bench_files_times;

/* Builds `runs` times in a new folder within `folder`, each build next to one copy of the same bytes. memory_bytes:
 * limit of the buffers; 0: the build's default. */
iso_status iso_bench_files(const iso_volume *v, const iso_pyramid_options *opt, const char *folder, size_t memory_bytes,
                           size_t runs, bench_files_times *times, iso_error *err);
/* Does the same for a volume in a file. */
iso_status iso_bench_files_of(const char *volume, const iso_pyramid_options *opt, const char *folder,
                              size_t memory_bytes, size_t runs, bench_files_times *times, iso_error *err);
