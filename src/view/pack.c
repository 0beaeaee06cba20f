/* SPDX-License-Identifier: MIT */
#include "view/pack.h"

#include <stdlib.h>
#include <zlib.h>

/* The fastest that is close to the best: level 9 takes three times as long for a hundredth of the bytes. */
enum { DEFLATE_LEVEL = 6, BLOCK = 1 << 16 };

typedef struct deflated {
    z_stream stream;
    unsigned char *out; /* NULL: only counted */
    size_t size, room;
    bool is_counted_only;
} deflated;

/* Feeds a block. False: no memory. */
static bool feed(deflated *d, unsigned char *block, size_t size, int flush)
{
    unsigned char scratch[BLOCK];
    d->stream.next_in = block;
    d->stream.avail_in = (uInt)size;
    do {
        if (!d->is_counted_only && d->room - d->size < BLOCK) {
            const size_t room = 2 * d->room + BLOCK;
            unsigned char *larger = realloc(d->out, room);
            if (!larger)
                return false;
            d->out = larger;
            d->room = room;
        }
        d->stream.next_out = d->is_counted_only ? scratch : d->out + d->size;
        d->stream.avail_out = BLOCK;
        deflate(&d->stream, flush);
        d->size += BLOCK - d->stream.avail_out;
    } while (d->stream.avail_out == 0);
    return true;
}

/* Byte `weight` of component c of the voxels [from, to). */
static bool feed_plane(deflated *d, const iso_pack_array *a, size_t c, size_t weight, const size_t span[2], bool delta)
{
    unsigned char block[BLOCK];
    uint32_t before = 0;
    for (size_t i = span[0]; i < span[1];) {
        size_t used = 0;
        for (; used < BLOCK && i < span[1]; ++i) {
            const uint32_t number = a->number(a->of, i, c);
            block[used++] = (unsigned char)((delta ? number - before : number) >> (8 * weight));
            before = number;
        }
        if (!feed(d, block, used, Z_NO_FLUSH))
            return false;
    }
    return true;
}

/* The voxels [from, to) as one stream; ISO_E_MEMORY. */
static iso_status deflate_span(const iso_pack_array *a, const size_t span[2], bool delta, deflated *d, iso_error *err)
{
    unsigned char nothing = 0;
    if (deflateInit(&d->stream, DEFLATE_LEVEL) != Z_OK)
        return iso_fail(err, ISO_E_MEMORY, "no memory to pack %zu voxels", a->count);
    bool good = true;
    for (size_t c = 0; c < a->components; ++c)
        for (size_t weight = 0; weight < a->width && good; ++weight)
            good = feed_plane(d, a, c, weight, span, delta);
    good = good && feed(d, &nothing, 0, Z_FINISH);
    deflateEnd(&d->stream);
    return good ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory to pack %zu voxels", a->count);
}

iso_status iso_pack(const iso_pack_array *a, iso_packed *packed, iso_error *err)
{
    /* Enough to tell which is smaller, and little beside the whole; from the middle, where the object is. */
    const size_t most = 1 << 18, tried = a->count < most ? a->count : most;
    const size_t part[2] = {(a->count - tried) / 2, (a->count - tried) / 2 + tried}, all[2] = {0, a->count};
    size_t sizes[2] = {0, 0};
    iso_status status = ISO_OK;
    *packed = (iso_packed){0};
    for (int delta = 0; delta < 2 && status == ISO_OK; ++delta) {
        deflated d = {.is_counted_only = true};
        status = deflate_span(a, part, delta, &d, err);
        sizes[delta] = d.size;
    }
    deflated d = {0};
    packed->delta = sizes[1] < sizes[0];
    if (status == ISO_OK)
        status = deflate_span(a, all, packed->delta, &d, err);
    packed->bytes = d.out;
    packed->size = d.size;
    if (status != ISO_OK) {
        free(packed->bytes);
        *packed = (iso_packed){0};
    }
    return status;
}
