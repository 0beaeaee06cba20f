/* SPDX-License-Identifier: MIT */
/* pyramid_stream.h - builds a pyramid slab by slab, from a volume's file to the pyramid's files, in bounded memory.
 *
 * The files are the same, byte for byte, as those of iso_pyramid_build() and
 * iso_pyramid_save(). During the build the folder is called .NAME.partial; it is renamed
 * when it is complete, so that a killed build never looks finished. A killed build can be
 * resumed: progress.json says how far its files are valid.
 *
 * The next slab is read and the last one written while one is built. Ranks of an
 * MPI job (base/ranks.h) take the slabs in turns and write the same files. The state
 * that a slab needs from the one before, such as the checksums so far, is sent from
 * rank to rank, so that each byte is read, hashed and written once. */
#pragma once

#include "base/ranks.h"
#include "pyramid/pyramid.h"
#include "volume/stream.h"

/* Opens the volume at its first plane. Volumes of floats are opened and read twice, the first time for their range;
 * with ISO_DIRECTION_AUTO all are read once more, for the choice. */
typedef struct iso_stream_input {
    iso_status (*open)(void *user, iso_volume_source **source, iso_error *err);
    void *user;
    const char *path; /* becomes the pyramid's source */
} iso_stream_input;

/* Longest time whose work a killed build loses. Each note waits until all written data is on the disk, .25 s on
 * some. */
#define ISO_STREAM_SAVE_SECONDS 10.0

typedef struct iso_stream_options {
    size_t memory_bytes; /* of buffers; 0: as little as is fast */
    size_t max_slab;     /* planes; 0: as memory allows; at least as many as the levels need */
    size_t first_level;  /* finest level whose files are written; from 1 on only iso_pyramid_load_from() reads them */
    bool resume;         /* resume a killed build of the same volume and options */
    bool direct;         /* write past the page cache, as large files are in any case */
    double save_seconds; /* between two notes of how far the build is; 0: one after each slab */
    size_t stop_after;   /* planes; 0: all. For tests: ends as if killed */
    const struct iso_key *key; /* inputs of the build besides the opened files (base/key.h); or NULL */
    iso_ranks *ranks;    /* NULL: no MPI. Each rank makes the same call and takes memory_bytes */
} iso_stream_options;

typedef struct iso_stream_report {
    size_t level_count;
    struct {
        iso_geometry geometry;
        iso_type type;
        double min, max;
    } levels[32];
    iso_direction_choice choice; /* with ISO_DIRECTION_AUTO */
    size_t slab_planes, buffer_bytes, resumed_at_plane;
    char not_resumed[256]; /* why an earlier build was not taken up, such as "v.raw changed since"; or empty */
    double seconds_read, seconds_build, seconds_write,
        seconds_total;                       /* read, write: waiting for the threads that do it */
    double seconds_reading, seconds_writing; /* of these threads, summed, with hashing */
} iso_stream_report;

/* Builds in slabs. ISO_E_MEMORY if memory_bytes is too little; the message has the minimum. All ranks get the same
 * status and message; the report is rank 0's. */
iso_status iso_pyramid_stream(const iso_stream_input *in, const iso_pyramid_options *opt,
                              const iso_stream_options *stream, const char *dir, iso_stream_report *report,
                              const iso_progress *progress, iso_error *err);
