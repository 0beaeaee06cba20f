/* SPDX-License-Identifier: MIT */
/* stream_input.h - planes of the input, read ahead by a thread; private to the streaming build.
 *
 * There are three sets of planes: one is being read, one is being built from, and one is being written as level 0. */
#pragma once

#include <pthread.h>

#include "volume/stream.h"

enum { STREAM_INPUT_SETS = 3 };

typedef struct stream_planes {
    char *data;
    size_t first, count;
} stream_planes;

typedef struct stream_input {
    iso_volume_source *source;          /* borrowed */
    size_t plane_bytes, capacity, read; /* read: planes that the source has given or skipped */
    stream_planes set[STREAM_INPUT_SETS];
    int newest;
    pthread_t thread;
    bool reading;
    iso_status status;
    iso_error error;
    double seconds_busy;
} stream_input;

/* Allocates sets of `capacity` planes. False if memory runs out. */
bool iso_stream_input_create(stream_input *in, iso_volume_source *source, size_t capacity);
void iso_stream_input_destroy(stream_input *in); /* accepts an empty one */

/* Starts to read the planes `from` to `to` (not included) into the next set; planes that the newest set holds are
 * copied. `from` and `to` never fall from call to call. Call iso_stream_input_wait() before the next request. */
void iso_stream_input_request(stream_input *in, size_t from, size_t to);
/* Waits for the planes of the last request. */
iso_status iso_stream_input_wait(stream_input *in, const stream_planes **planes, iso_error *err);
