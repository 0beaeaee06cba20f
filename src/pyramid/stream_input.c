/* SPDX-License-Identifier: MIT */
#include "pyramid/stream_input.h"

#include <stdlib.h>
#include <string.h>

#include "base/large.h"
#include "base/parallel.h"

bool iso_stream_input_create(stream_input *in, iso_volume_source *source, size_t capacity)
{
    const iso_volume *v = iso_source_volume(source);
    *in = (stream_input){.source = source, .capacity = capacity};
    in->plane_bytes = v->geometry.size[0] * v->geometry.size[1] * iso_type_bytes(v->type);
    bool good = true;
    for (int i = 0; i < STREAM_INPUT_SETS; ++i) {
        in->set[i].data = iso_large_alloc(capacity * in->plane_bytes);
        good = good && in->set[i].data;
    }
    return good;
}

void iso_stream_input_destroy(stream_input *in)
{
    if (in->reading)
        pthread_join(in->thread, NULL);
    for (int i = 0; i < STREAM_INPUT_SETS; ++i)
        free(in->set[i].data);
    *in = (stream_input){0};
}

static void *read_set(void *user)
{
    stream_input *in = user;
    const stream_planes *old = &in->set[(in->newest + STREAM_INPUT_SETS - 1) % STREAM_INPUT_SETS];
    stream_planes *p = &in->set[in->newest];
    const double start = iso_clock_seconds();
    const size_t end = old->first + old->count, keep = end > p->first ? end - p->first : 0;
    in->status = ISO_OK;
    if (keep > 0)
        memcpy(p->data, old->data + (old->count - keep) * in->plane_bytes, keep * in->plane_bytes);
    if (p->first + keep > in->read)
        in->status = iso_source_skip(in->source, p->first + keep - in->read, &in->error);
    TRY(in->status, iso_source_read(in->source, p->count - keep, p->data + keep * in->plane_bytes, &in->error));
    in->read = p->first + p->count;
    in->seconds_busy += iso_clock_seconds() - start;
    return NULL;
}

void iso_stream_input_request(stream_input *in, size_t from, size_t to)
{
    in->newest = (in->newest + 1) % STREAM_INPUT_SETS;
    in->set[in->newest].first = from;
    in->set[in->newest].count = to - from;
    in->reading = pthread_create(&in->thread, NULL, read_set, in) == 0;
    if (!in->reading)
        read_set(in);
}

iso_status iso_stream_input_wait(stream_input *in, const stream_planes **planes, iso_error *err)
{
    if (in->reading)
        pthread_join(in->thread, NULL);
    in->reading = false;
    *planes = &in->set[in->newest];
    if (in->status != ISO_OK && err)
        *err = in->error;
    return in->status;
}
