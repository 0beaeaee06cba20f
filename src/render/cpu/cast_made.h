/* SPDX-License-Identifier: MIT */
/* cast_made.h - bricks that are made when a ray looks into them; private to src/render/cpu.
 *
 *     samples of the file's type, or a level  --bricks that rays look into-->  pool  -->  rays
 *
 * For one picture: bricks that the transfer function or an opaque part hides have neither directions nor memory. The
 * bricks have the same bits as those of a whole level, and so has the picture. */
#pragma once

#include "render/cpu/cast_bricks.h"

typedef struct iso_cast_maker iso_cast_maker;

typedef struct iso_cast_made {
    const iso_level *level; /* it must outlive the maker */
    iso_code code;
    iso_cast_scalars scalars;
    const iso_cast_blocks *blocks; /* rays look only into the visible ones; NULL: into all */
    int threads;
} iso_cast_made;

/* Creates a maker and sets the bricks of c, whose normals are known. ISO_E_MEMORY; destroy the maker then, too. */
iso_status iso_cast_make_on_demand(iso_cast_maker **maker, iso_cast *c, const iso_cast_made *of, iso_error *err);
void iso_cast_maker_destroy(iso_cast_maker *m); /* accepts NULL */
/* Returns the bytes of the bricks that were made. */
double iso_cast_maker_bytes(const iso_cast_maker *m);
