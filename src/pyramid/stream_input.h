/* SPDX-License-Identifier: MIT */
/* stream_input.h - planes of the input in memory, read ahead by a thread of their own; private to the streaming build.
 *
 * A set of planes is read while another one is built from, and a third, whose samples are level 0's, is written. */
#ifndef ISO_PYRAMID_STREAM_INPUT_H
#define ISO_PYRAMID_STREAM_INPUT_H

#include <pthread.h>

#include "volume/stream.h"

enum { STREAM_INPUT_SETS = 3 };

typedef struct stream_planes {
    char *data;
    size_t first, count;
} stream_planes;

typedef struct stream_input {
    iso_volume_source *source; /* borrowed */
    size_t plane_bytes, capacity, read; /* read: planes that the source has given or skipped */
    stream_planes set[STREAM_INPUT_SETS];
    int newest;
    pthread_t thread;
    bool reading;
    iso_status status;
    iso_error error;
    double seconds_busy;
} stream_input;

/* Memory for sets of `capacity` planes. False when there is none. */
bool iso_stream_input_create(stream_input *in, iso_volume_source *source, size_t capacity);
void iso_stream_input_destroy(stream_input *in); /* accepts an empty one */

/* Starts to read the planes `from` to `to` (not included) into the set after the newest one; those that the newest one
 * holds are copied. Both only grow from call to call. What was asked for before must have been waited for. */
void iso_stream_input_request(stream_input *in, size_t from, size_t to);
/* Waits for what was asked for. */
iso_status iso_stream_input_wait(stream_input *in, const stream_planes **planes, iso_error *err);

#endif
