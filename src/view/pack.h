/* SPDX-License-Identifier: MIT */
/* pack.h - arrays of voxels for a page: bytes of one weight together, differences where they pack better, deflated.
 *
 * An array has `count` voxels of `components` numbers of `width` bytes each. It is written component by component, and of
 * each the lowest bytes of all voxels first, then the next ones: high bytes are alike and pack well. With `delta` each
 * number is the difference from that of the voxel before, modulo 2^(8 width). zlib's format, which the page's
 * DecompressionStream("deflate") reads. */
#ifndef ISO_VIEW_PACK_H
#define ISO_VIEW_PACK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

typedef struct iso_pack_array {
    size_t count, components, width;
    /* Number c of voxel i, of which the low `width` bytes count. */
    uint32_t (*number)(const void *of, size_t i, size_t c);
    const void *of;
} iso_pack_array;

typedef struct iso_packed {
    unsigned char *bytes; /* to be freed */
    size_t size;
    bool delta; /* chosen by what packs a part of the array better */
} iso_packed;

/* ISO_E_MEMORY. */
iso_status iso_pack(const iso_pack_array *array, iso_packed *packed, iso_error *err);

#endif
