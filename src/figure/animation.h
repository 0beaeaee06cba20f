/* SPDX-License-Identifier: MIT */
/* animation.h - an animated PNG with the chunks acTL, fcTL and fdAT (PNG, third edition). Browsers and viewers play
 * it; other programs show the first frame. Colors are exactly those of the pictures. */
#pragma once

#include <stddef.h>

#include "image/image.h"

typedef struct iso_animation iso_animation;

/* Creates an animation of `frames` frames, each shown for the given seconds, repeated endlessly. */
iso_status iso_animation_create(iso_animation **a, const char *path, size_t frames, double seconds, iso_error *err);
/* Adds a frame. All frames have one size. */
iso_status iso_animation_add(iso_animation *a, const iso_image *image, iso_error *err);
/* Finishes the file. ISO_E_IO; ISO_E_RANGE: the number of added frames is not `frames`. */
iso_status iso_animation_finish(iso_animation *a, iso_error *err);
void iso_animation_destroy(iso_animation *a); /* accepts NULL */
