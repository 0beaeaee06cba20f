/* SPDX-License-Identifier: MIT */
/* stream_build.h - one streaming build and its parts; private to it.
 *
 *   pyramid_stream.c   from beginning to end: opens, sets up, and closes
 *   stream_slabs.c     how many planes a slab has, its buffers; slabs one after the other, alone
 *   stream_turns.c     slabs in turns with other ranks of an MPI job
 *   stream_progress.c  what a killed build leaves, and how it is taken up
 *   stream_input.c, stream_output.c   the threads that read and write */
#ifndef ISO_PYRAMID_STREAM_BUILD_H
#define ISO_PYRAMID_STREAM_BUILD_H

#include "base/bigfile.h"
#include "base/file.h"
#include "base/json.h"
#include "pyramid/cascade.h"
#include "pyramid/pyramid_stream.h"
#include "pyramid/stream_input.h"
#include "pyramid/stream_output.h"

#define STREAM_CARRY_NAME "carry.raw"

/* What goes from rank to rank with the turn: this, the files' tails, and the last planes of the cascade's carry. */
typedef struct stream_turn {
    iso_status status;
    iso_error error;
    double lo[STREAM_MAX_LEVELS], hi[STREAM_MAX_LEVELS];
    size_t carry_first, carry_count;
} __attribute__((aligned(64))) stream_turn;

/* What rank 0 decides. */
typedef struct stream_plan {
    char folder[4096];
    size_t start, slab; /* first plane; planes of a slab */
} stream_plan;

typedef struct pyramid_build {
    const iso_stream_input *in;
    const iso_pyramid_options *opt;
    const iso_stream_options *how;
    iso_stream_report *report;
    iso_output output; /* rank 0's */
    iso_volume_source *source;
    iso_volume header;
    iso_cascade *cascade;
    stream_input input;
    stream_output out;
    stream_plan plan;
    size_t overlap; /* planes that a slab may have to be fed from before its own */
    size_t progress_at;
    iso_bigfile *carry;  /* rank 0's */
    size_t carry_planes; /* written */
    stream_turn *turn;   /* only with other ranks */
} pyramid_build;

typedef struct stream_slab {
    size_t from, z0, z1; /* fed from; its planes */
    size_t read_from, read_to;
} stream_slab;

static inline bool stream_is_alone(const pyramid_build *s) { return iso_ranks_count(s->how->ranks) == 1; }

static inline bool stream_is_first(const pyramid_build *s) { return iso_ranks_index(s->how->ranks) == 0; }

static inline size_t stream_plane_bytes(const pyramid_build *s)
{
    return s->header.geometry.size[0] * s->header.geometry.size[1] * iso_type_bytes(s->header.type);
}

/* ---- slabs ---- */

/* Of the type for narrow integers; of others by reading them all, each rank its share. */
iso_status iso_stream_input_range(pyramid_build *s, double *range, iso_error *err);
/* What is fed twice when slabs do not follow each other. */
size_t iso_stream_longest_warm_up(const pyramid_build *s);
/* As many planes as are fast and as memory allows, into plan.slab. */
iso_status iso_stream_choose_slab(pyramid_build *s, iso_error *err);
/* Of all buffers for slabs of this many planes; and the planes of the input that are held at once. */
size_t iso_stream_buffer_bytes(const pyramid_build *s, size_t slab);
size_t iso_stream_planes_capacity(const pyramid_build *s, size_t slab);

size_t iso_stream_slab_count(const pyramid_build *s);
stream_slab iso_stream_slab_at(const pyramid_build *s, size_t i);
/* Its planes begin to be read; nothing behind the last slab. */
void iso_stream_request_slab(pyramid_build *s, size_t i);
iso_status iso_stream_wait_for_planes(pyramid_build *s, const stream_planes **planes, iso_error *err);
iso_status iso_stream_feed_slab(pyramid_build *s, const stream_slab *b, const stream_planes *planes, iso_error *err);
void iso_stream_list_slab(pyramid_build *s, const stream_slab *b, const stream_planes *planes);
iso_status iso_stream_wait_for_writers(pyramid_build *s, iso_error *err);
/* All slabs, without other ranks. done: planes that are in the files already. */
iso_status iso_stream_run_alone(pyramid_build *s, json_t *job, size_t done, const iso_progress *progress,
                                iso_error *err);

/* ---- turns ---- */

/* Memory for what goes from rank to rank. False when there is none. */
bool iso_stream_turn_create(pyramid_build *s);
/* All slabs, in turns with the other ranks. */
iso_status iso_stream_run_in_turns(pyramid_build *s, json_t *job, const iso_progress *progress, iso_error *err);
/* The rank of the last slab closes the files; what it knows of them comes to rank 0. */
iso_status iso_stream_close_in_turns(pyramid_build *s, iso_error *err);

/* ---- progress.json ---- */

/* What makes this very job: input, geometry, options. */
json_t *iso_stream_describe_job(const pyramid_build *s, double scale);
/* Whether an earlier build's progress is of this very job, and how far it came. */
bool iso_stream_read_progress(pyramid_build *s, const json_t *job, size_t *planes);
/* The cascade's carry up to plane z, from the folder's file. */
iso_status iso_stream_take_up_carry(pyramid_build *s, const char *folder, size_t z, iso_error *err);
/* Not after every small slab: the last blocks of the files are written each time. */
bool iso_stream_progress_is_due(pyramid_build *s, size_t z);
/* What is on the disk up to plane z may be taken up. */
iso_status iso_stream_note_progress(pyramid_build *s, json_t *job, size_t z, iso_error *err);
/* From the folder of a build that is complete. */
void iso_stream_remove_progress(const pyramid_build *s);

#endif
