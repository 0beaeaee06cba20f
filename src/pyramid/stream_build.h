/* SPDX-License-Identifier: MIT */
/* stream_build.h - the parts of a streaming build (pyramid_stream.h), private to them.
 *
 *   pyramid_stream.c   the whole build: opens, sets up and closes
 *   stream_choose.c    reads the volume once more before, if direction filters are to be chosen
 *   stream_slabs.c     size of a slab, its buffers; slabs in sequence on a single rank
 *   stream_turns.c     slabs in turns with other ranks of an MPI job
 *   stream_progress.c  notes of a build's progress, and resuming from them
 *   stream_input.c, stream_output.c   the threads that read and write */
#pragma once

#include "base/bigfile.h"
#include "base/file.h"
#include "base/json.h"
#include "base/key.h"
#include "pyramid/cascade.h"
#include "pyramid/pyramid_stream.h"
#include "pyramid/stream_input.h"
#include "pyramid/stream_output.h"

#define STREAM_PROGRESS_NAME "progress.json"
#define STREAM_CARRY_NAME "carry.raw"

/* The message from one rank to the next: this struct, the files' tails (stream_output.h), and the last planes of the
 * cascade's carry (cascade.h). */
typedef struct stream_turn {
    iso_status status;
    iso_error error;
    double lo[STREAM_MAX_LEVELS], hi[STREAM_MAX_LEVELS];
    size_t carry_first, carry_count;
} __attribute__((aligned(64))) stream_turn;

/* Decisions of rank 0 for all ranks. */
typedef struct stream_plan {
    char folder[4096];
    size_t start, slab; /* first plane; planes of a slab */
} stream_plan;

typedef struct pyramid_build {
    const iso_stream_input *in;
    const iso_pyramid_options *opt;
    iso_pyramid_options own; /* copy that opt points to, with the choices made */
    const iso_stream_options *how;
    iso_stream_report *report;
    iso_output output; /* rank 0's */
    bool resumed;      /* the folder was there, left by an earlier run */
    iso_key *key;      /* rank 0's */
    iso_volume_source *source;
    iso_volume header;
    iso_cascade *cascade;
    stream_input input;
    stream_output out;
    stream_plan plan;
    size_t overlap; /* planes that a slab may have to be fed from before its own */
    double progress_at;  /* iso_clock_seconds() of the latest note, or of the build's begin */
    iso_bigfile *carry;  /* rank 0's */
    size_t carry_planes; /* written */
    stream_turn *turn;   /* only with other ranks */
} pyramid_build;

typedef struct stream_slab {
    size_t from, z0, z1; /* planes z0 to z1 (not included), fed from plane `from` on */
    size_t read_from, read_to;
} stream_slab;

static inline bool stream_is_alone(const pyramid_build *s)
{
    return iso_ranks_count(s->how->ranks) == 1;
}

static inline bool stream_is_first(const pyramid_build *s)
{
    return iso_ranks_index(s->how->ranks) == 0;
}

static inline size_t stream_plane_bytes(const pyramid_build *s)
{
    return s->header.geometry.size[0] * s->header.geometry.size[1] * iso_type_bytes(s->header.type);
}

/* ---- slabs ---- */

/* Gets the range of the input: that of the type for integers of 8 and 16 bits, otherwise by reading all samples, each
 * rank its share. */
iso_status iso_stream_input_range(pyramid_build *s, double *range, iso_error *err);
/* Chooses direction filters if s->opt leaves them to the build: reads all samples, each rank its share. */
iso_status iso_stream_choose(pyramid_build *s, double scale, const iso_progress *progress, iso_error *err);
/* Returns the most planes that are fed twice when a rank does not have the slab before. */
size_t iso_stream_longest_warm_up(const pyramid_build *s);
/* Sets plan.slab to as many planes as are fast and as memory allows. */
iso_status iso_stream_choose_slab(pyramid_build *s, iso_error *err);
/* Returns bytes of all buffers for slabs of this many planes; planes of the input that are in memory at once. */
size_t iso_stream_buffer_bytes(const pyramid_build *s, size_t slab);
size_t iso_stream_planes_capacity(const pyramid_build *s, size_t slab);

size_t iso_stream_slab_count(const pyramid_build *s);
stream_slab iso_stream_slab_at(const pyramid_build *s, size_t i);
/* Starts to read the slab's planes; does nothing after the last slab. */
void iso_stream_request_slab(pyramid_build *s, size_t i);
iso_status iso_stream_wait_for_planes(pyramid_build *s, const stream_planes **planes, iso_error *err);
iso_status iso_stream_feed_slab(pyramid_build *s, const stream_slab *b, const stream_planes *planes, iso_error *err);
void iso_stream_list_slab(pyramid_build *s, const stream_slab *b, const stream_planes *planes);
/* Builds all slabs, without other ranks. done: planes that are in the files already. */
iso_status iso_stream_run_alone(pyramid_build *s, json_t *job, size_t done, const iso_progress *progress,
                                iso_error *err);

/* ---- turns ---- */

/* Allocates the message between ranks. False if memory runs out. */
bool iso_stream_turn_create(pyramid_build *s);
/* Builds all slabs, in turns with the other ranks. */
iso_status iso_stream_run_in_turns(pyramid_build *s, json_t *job, const iso_progress *progress, iso_error *err);
/* Closes the files on the rank of the last slab and sends their sizes and checksums to rank 0. */
iso_status iso_stream_close_in_turns(pyramid_build *s, iso_error *err);

/* ---- progress.json ---- */

/* Makes s->key. The inputs are open. */
iso_status iso_stream_make_key(pyramid_build *s, double scale, iso_error *err);
/* Creates a new progress.json of this key; NULL: no memory. */
json_t *iso_stream_describe_job(const pyramid_build *s);
/* Tests whether an earlier build in the folder had the same key, and how many planes it finished. ISO_E_IO: its notes
 * cannot be read. */
iso_status iso_stream_read_progress(pyramid_build *s, bool *is_same, size_t *planes, iso_error *err);
/* Reads the cascade's carry up to plane z from the folder's file. */
iso_status iso_stream_take_up_carry(pyramid_build *s, const char *folder, size_t z, iso_error *err);
/* True if progress.json is to be written now. Not after every slab, because each time the last blocks of the files are
 * written too, and the disk is waited for. */
bool iso_stream_progress_is_due(pyramid_build *s);
/* Notes in progress.json that a build can be resumed at plane z. */
iso_status iso_stream_note_progress(pyramid_build *s, json_t *job, size_t z, iso_error *err);
/* Removes progress.json and the carry from the folder of a complete build. */
void iso_stream_remove_progress(const pyramid_build *s);
