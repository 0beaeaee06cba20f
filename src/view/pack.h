/* SPDX-License-Identifier: MIT */
/* pack.h - packs arrays of voxels for a page: bytes are grouped by weight, replaced by differences if that is smaller,
 * and deflated.
 *
 * An array has `count` voxels of `components` numbers of `width` bytes each. The components are written one after
 * another, each with the lowest bytes of all voxels first, then the next ones: high bytes are similar and compress
 * well. With `delta`, each number is the difference to the previous voxel's, modulo 2^(8 width). The format is zlib's,
 * for the page's DecompressionStream("deflate"). */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

typedef struct iso_pack_array {
    size_t count, components, width;
    /* Returns component c of voxel i; the low `width` bytes count. */
    uint32_t (*number)(const void *of, size_t i, size_t c);
    const void *of;
} iso_pack_array;

typedef struct iso_packed {
    unsigned char *bytes; /* owned; free() */
    size_t size;
    bool delta; /* chosen by packing a part of the array both ways */
} iso_packed;

/* Packs an array. ISO_E_MEMORY. */
iso_status iso_pack(const iso_pack_array *array, iso_packed *packed, iso_error *err);
