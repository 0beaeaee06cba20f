/* SPDX-License-Identifier: MIT */
/* narrow.h - a pyramid without level 0; scalars and codes of level 0 are read from the volume itself. Takes an eighth
 * of the memory if samples are bytes. For users such as exports, which read scalars a few at a time and codes box by
 * box. */
#pragma once

#include "pyramid/pyramid.h"

/* Builds as iso_pyramid_build() does, but levels[0] has neither scalars nor codes. */
iso_status iso_pyramid_build_narrow(const iso_volume *v, const char *source, const iso_pyramid_options *opt,
                                    iso_pyramid *out, const iso_progress *progress, iso_error *err);

/* Makes a pyramid of level 0 alone for pictures that read a part of it: the pyramid takes the volume, and codes are
 * made where they are needed (iso_box_codes). iso_pyramid_complete() makes the level that iso_pyramid_build() makes. v is
 * empty afterwards, also after a failure. */
iso_status iso_pyramid_begin(iso_volume *v, const char *source, const iso_pyramid_options *opt, iso_pyramid *out,
                             iso_error *err);
iso_status iso_pyramid_complete(iso_pyramid *p, const iso_progress *progress, iso_error *err);

/* Returns the value that voxels without data have where a format or a device has to interpolate them: `ranges` of the
 * level's range below its least value, where transfer functions show nothing. In the cells next to these voxels the
 * interpolated value leaves the range within 1 / ranges of a cell. */
static inline float iso_level_stand_in(const iso_level *level, double ranges)
{
    const double range = level->max - level->min, size = level->max < 0 ? -level->max : level->max;
    return (float)(level->min - ranges * (range > 1e-6 * size ? range : size > 0 ? size : 1));
}
/* For devices, and for files of programs that may keep 16 bits of a value. */
#define ISO_STAND_IN_DEVICE 0x1p20
#define ISO_STAND_IN_FILE 16
/* Copies scalars like iso_level_scalars(), those without data as iso_level_stand_in(). */
void iso_level_file_scalars(const iso_level *level, const iso_volume *volume, size_t first, size_t count,
                            float *restrict out);

/* Copies the scalars of `count` voxels from number `first` on, from the level or, if it has none, from the volume. */
void iso_level_scalars(const iso_level *level, const iso_volume *volume, size_t first, size_t count,
                       float *restrict out);

/* Scalars of a level that has its own or `samples`: in place, or converted into the caller's buffer of `count`
 * floats. */
static inline const float *iso_level_floats(const iso_level *level, size_t first, size_t count, float *room)
{
    if (level->scalar)
        return level->scalar + first;
    iso_level_scalars(level, level->samples, first, count, room);
    return room;
}

static inline double iso_level_value(const iso_level *level, size_t voxel)
{
    float room;
    return (double)*iso_level_floats(level, voxel, 1, &room);
}

/* Codes of a box of level 0, made from the volume: the same bytes as those of a whole level. */
typedef struct iso_narrow_codes {
    const iso_volume *volume;
    iso_pyramid_options options;
    double scale;             /* of gradients, as the whole volume has it (cascade.h) */
    size_t first[3], size[3]; /* the boxes that `codes` covers: the valid one, and the larger one, whose outer codes may
                               * be wrong */
    uint8_t *codes;           /* owned */
    size_t codes_bytes;       /* allocated bytes of `codes` */
} iso_narrow_codes;

/* Begins without codes. p: made from v by iso_pyramid_build_narrow(). */
iso_status iso_narrow_codes_begin(iso_narrow_codes *c, const iso_pyramid *p, const iso_volume *v, iso_error *err);
/* Makes the codes from voxel `first` to `end` (not included); earlier ones are gone. Uses several threads; only one
 * thread may call it at a time. ISO_E_MEMORY. */
iso_status iso_narrow_codes_make(iso_narrow_codes *c, const size_t first[3], const size_t end[3], iso_error *err);
void iso_narrow_codes_destroy(iso_narrow_codes *c); /* accepts empty */

/* Codes of small boxes of a level that has `samples`, by one thread and without allocating. */
typedef struct iso_box_codes iso_box_codes;

/* Creates them for boxes of at most `side` voxels along each axis. scale: iso_level_gradient_scale(). ISO_E_MEMORY. */
iso_status iso_box_codes_create(const iso_level *level, iso_code code, double scale, size_t side, iso_box_codes **out,
                                iso_error *err);
void iso_box_codes_destroy(iso_box_codes *b); /* accepts NULL */
/* Fills the codes of a box, 3 bytes per voxel: the same bytes as those of a whole level. */
void iso_box_codes_make(iso_box_codes *b, const size_t first[3], const size_t count[3], uint8_t *codes);
/* Returns the scale of gradients of the whole level. */
iso_status iso_level_gradient_scale(const iso_level *level, double *scale, iso_error *err);

/* Returns the code of a voxel within the box, counted in level 0; the rest of its row follows. */
static inline const uint8_t *iso_narrow_codes_at(const iso_narrow_codes *c, size_t x, size_t y, size_t z)
{
    return c->codes + 3 * (x - c->first[0] + c->size[0] * (y - c->first[1] + c->size[1] * (z - c->first[2])));
}
