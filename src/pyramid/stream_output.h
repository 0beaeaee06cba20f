/* SPDX-License-Identifier: MIT */
/* stream_output.h - the files of all levels, written by threads of their own; private to the streaming build.
 *
 * Each level has two sets of buffers: one is written while the other is filled. Several ranks (base/ranks.h) write the
 * same files in turns. The rank whose turn it is has the *tails* of all files: the checksum so far, and the bytes that
 * do not fill a block of the disk yet. */
#pragma once

#include <pthread.h>
#include <stdatomic.h>

#include "base/bigfile.h"
#include "pyramid/cascade.h"
#include "pyramid/pyramid_layout.h"

enum { STREAM_MAX_LEVELS = 32, STREAM_WRITERS = 2 };

/* Buffers hold `capacity` planes from `first` on. */
typedef struct stream_level {
    iso_geometry geometry;
    iso_type type;
    bool converts; /* scalars come from set[].scalar, else from the input */
    size_t capacity;
    iso_cascade_out set[2];
    size_t first;   /* plane of the buffers' first plane */
    size_t written; /* planes that the last slab completed */
    level_file files[FILE_COUNT];
    iso_bigfile *file[FILE_COUNT]; /* NULL: not stored */
    XXH3_state_t *hash[FILE_COUNT];
} stream_level;

/* A piece of a file. */
typedef struct stream_item {
    stream_level *level;
    int file;
    const void *data;
    size_t bytes;
} stream_item;

typedef struct stream_output {
    size_t level_count;
    stream_level levels[STREAM_MAX_LEVELS];
    bool direct;   /* files past the page cache */
    bool in_turns; /* with other ranks */
    int active;    /* the set that is filled */
    stream_item items[STREAM_MAX_LEVELS * FILE_COUNT];
    size_t item_count;
    atomic_size_t next_item;
    pthread_t writers[STREAM_WRITERS];
    int writer_count;      /* that are at work */
    pthread_mutex_t mutex; /* of status and error */
    iso_status status;
    iso_error error;
    double seconds_busy;
} stream_output;

/* Describes the levels by the options and the size; allocates no memory yet. */
void iso_stream_output_describe(stream_output *o, const iso_geometry *g, iso_type input,
                                const iso_pyramid_options *opt);
/* Leaves out the files of the levels below `first`. */
void iso_stream_output_begin_at(stream_output *o, size_t first);
/* Returns the bytes of one plane of a level in each set; the bytes of one plane of a file. */
size_t iso_stream_level_plane_bytes(const stream_level *l, const iso_pyramid_options *opt);

/* Allocates buffers for slabs of this many planes. False if memory runs out. */
bool iso_stream_output_create(stream_output *o, const iso_cascade *c, size_t slab, const iso_pyramid_options *opt);
void iso_stream_output_destroy(stream_output *o); /* waits; leaves the files as they are */

/* Opens the files in the folder, each at its level's plane `first`: new with their headers, or what an earlier build
 * left. */
iso_status iso_stream_output_open(stream_output *o, const char *dir, iso_error *err);
/* Opens the files that another rank has created. */
iso_status iso_stream_output_join(stream_output *o, const char *dir, iso_error *err);

/* Copies planes that the last slab began and did not complete to the active set. */
void iso_stream_output_copy_begun(stream_output *o);
/* Gets the buffers for the planes of the slab. */
void iso_stream_output_targets(const stream_output *o, iso_cascade_out out[STREAM_MAX_LEVELS]);
/* Lists the planes that the slab completed: level k up to plane complete[k]; level 0's scalars may stand in the input's
 * planes. */
void iso_stream_output_list(stream_output *o, const size_t complete[STREAM_MAX_LEVELS], const char *input,
                            size_t input_first);
/* Starts to write the listed planes; the other set becomes active. */
void iso_stream_output_start(stream_output *o);
iso_status iso_stream_output_wait(stream_output *o, iso_error *err);
/* Waits until all written data is on the disk. */
iso_status iso_stream_output_sync(stream_output *o, iso_error *err);
/* Cuts and closes; levels[].files have their sizes and checksums. */
iso_status iso_stream_output_close(stream_output *o, iso_error *err);

/* Returns the bytes of the tails, for turns: aligned to 64, they can be sent to any rank. */
size_t iso_stream_tails_bytes(const stream_output *o);
/* Gets the tails of the files that iso_stream_output_open() has opened. */
void iso_stream_tails_get(const stream_output *o, void *tails);
/* Continues writing after these tails. To be called while nothing is being written. */
void iso_stream_tails_set(stream_output *o, const void *tails);
/* Hashes the listed items and moves the tails past them. iso_stream_tails_set() has been called with these tails. */
void iso_stream_tails_advance(stream_output *o, void *tails);
