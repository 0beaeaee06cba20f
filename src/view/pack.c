/* SPDX-License-Identifier: MIT */
#include "view/pack.h"

#include <stdlib.h>

#include <libdeflate.h>

/* Compresses like zlib's level 6 in a third of the time; level 9 takes three times as long to save 1 %. */
enum { DEFLATE_LEVEL = 6 };

/* Writes the bytes of voxels [from, to): for each component all lowest bytes first, then the next ones. */
static void lay_out(const iso_pack_array *a, const size_t span[2], bool delta, unsigned char *bytes)
{
    for (size_t c = 0; c < a->components; ++c)
        for (size_t weight = 0; weight < a->width; ++weight) {
            uint32_t before = 0;
            for (size_t i = span[0]; i < span[1]; ++i) {
                const uint32_t number = a->number(a->of, i, c);
                *bytes++ = (unsigned char)((delta ? number - before : number) >> (8 * weight));
                before = number;
            }
        }
}

/* An array with the buffers to pack it. */
typedef struct packer {
    const iso_pack_array *array;
    struct libdeflate_compressor *state;
    unsigned char *bytes;  /* for the whole array */
    unsigned char *packed; /* for the largest compressed size */
    size_t room;
} packer;

/* Packs voxels [from, to) into p->packed and returns the number of bytes. */
static size_t deflate_span(const packer *p, const size_t span[2], bool delta)
{
    const iso_pack_array *a = p->array;
    lay_out(a, span, delta, p->bytes);
    return libdeflate_zlib_compress(p->state, p->bytes, (span[1] - span[0]) * a->components * a->width, p->packed,
                                    p->room);
}

/* Shrinks a buffer; returns the old one if that fails. */
static unsigned char *fit(unsigned char *bytes, size_t size)
{
    unsigned char *fitted = realloc(bytes, size);
    if (fitted)
        return fitted;
    return bytes;
}

iso_status iso_pack(const iso_pack_array *a, iso_packed *packed, iso_error *err)
{
    /* Large enough to compare, but little of the whole; from the middle, where the object is. */
    const size_t most = 1 << 18, tried = a->count < most ? a->count : most;
    const size_t part[2] = {(a->count - tried) / 2, (a->count - tried) / 2 + tried}, all[2] = {0, a->count};
    const size_t bytes = a->count * a->components * a->width;
    packer p = {.array = a, .state = libdeflate_alloc_compressor(DEFLATE_LEVEL)};
    *packed = (iso_packed){0};
    if (p.state) {
        p.room = libdeflate_zlib_compress_bound(p.state, bytes);
        p.bytes = malloc(bytes + 1);
        p.packed = malloc(p.room);
    }
    const bool has_room = p.bytes && p.packed;
    if (has_room) {
        packed->delta = deflate_span(&p, part, true) < deflate_span(&p, part, false);
        packed->size = deflate_span(&p, all, packed->delta);
        packed->bytes = fit(p.packed, packed->size);
    } else {
        free(p.packed);
    }
    free(p.bytes);
    libdeflate_free_compressor(p.state);
    return has_room ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory to pack %zu voxels", a->count);
}
