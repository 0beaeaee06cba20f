/* SPDX-License-Identifier: MIT */
/* frame_cache.h - images of one scene by their options, for work that requests the same ones again. */
#pragma once

#include "renderers/renderers.h"

/* Zeroed: empty. Valid while pyramid, level, view and hook stay. */
typedef struct iso_frame_cache {
    size_t count;
    iso_render_options *frames;
    iso_image *images;
} iso_frame_cache;
void iso_frame_cache_clear(iso_frame_cache *cache);

/* Makes iso_render_several() take images from the cache; NULL: it renders all again. */
void iso_frame_cache_use(iso_renderers *r, iso_frame_cache *cache);
