/* SPDX-License-Identifier: MIT */
/* animation.h - pictures one after the other in one file: a PNG with the chunks acTL, fcTL and fdAT (PNG, third edition),
 * which browsers and viewers play and other programs show as the first frame. All colors are kept, as in the pictures. */
#ifndef ISO_FIGURE_ANIMATION_H
#define ISO_FIGURE_ANIMATION_H

#include <stddef.h>

#include "image/image.h"

typedef struct iso_animation iso_animation;

/* For so many frames of so many seconds each, shown again and again. */
iso_status iso_animation_create(iso_animation **a, const char *path, size_t frames, double seconds, iso_error *err);
/* Frames of one size. */
iso_status iso_animation_add(iso_animation *a, const iso_image *image, iso_error *err);
/* ISO_E_IO; ISO_E_RANGE: other than `frames` were added. */
iso_status iso_animation_finish(iso_animation *a, iso_error *err);
void iso_animation_destroy(iso_animation *a); /* accepts NULL */

#endif
