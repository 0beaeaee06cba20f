/* SPDX-License-Identifier: MIT */
#include "lab/frame_cache.h"

#include <stdlib.h>
#include <string.h>

void iso_frame_cache_clear(iso_frame_cache *cache)
{
    for (size_t i = 0; i < cache->count; ++i)
        iso_image_destroy(&cache->images[i]);
    free(cache->frames);
    free(cache->images);
    *cache = (iso_frame_cache){0};
}

static bool is_same_frame(const iso_render_options *a, const iso_render_options *b)
{
    bool same = true;
#define ISO_FRAME_FIELD(type, name) same = same && a->name == b->name;
    ISO_FRAME_FIELDS(ISO_FRAME_FIELD)
#undef ISO_FRAME_FIELD
    return same;
}

static const iso_image *find_frame(const iso_frame_cache *cache, const iso_render_options *frame)
{
    for (size_t i = 0; i < cache->count; ++i)
        if (is_same_frame(&cache->frames[i], frame))
            return &cache->images[i];
    return NULL;
}

/* Reserves memory for `more` images. */
static iso_status grow_cache(iso_frame_cache *cache, size_t more, iso_error *err)
{
    iso_render_options *frames = realloc(cache->frames, (cache->count + more) * sizeof *frames);
    cache->frames = frames ? frames : cache->frames;
    iso_image *images = realloc(cache->images, (cache->count + more) * sizeof *images);
    cache->images = images ? images : cache->images;
    return frames && images ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for %zu images", more);
}

/* Renders the images that the cache lacks, and copies all. */
static iso_status render_cached(const iso_render_request *q, size_t count, iso_image *images, iso_error *err)
{
    const iso_render_options *frames = q->options;
    iso_frame_cache *cache = q->renderers->several_user;
    size_t lacking = 0;
    iso_status status = grow_cache(cache, count, err);
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        if (!find_frame(cache, &frames[i]))
            cache->frames[cache->count + lacking++] = frames[i];
    if (status == ISO_OK && lacking > 0) {
        iso_render_request rest = *q;
        rest.options = cache->frames + cache->count;
        iso_frame_cache_use(q->renderers, NULL);
        status = iso_render_several(&rest, lacking, cache->images + cache->count, err);
        iso_frame_cache_use(q->renderers, cache);
    }
    cache->count += status == ISO_OK ? lacking : 0;
    for (size_t i = 0; i < count && status == ISO_OK; ++i) {
        const iso_image *there = find_frame(cache, &frames[i]);
        status = iso_image_create(&images[i], there->width, there->height, err);
        if (status == ISO_OK)
            memcpy(images[i].rgba, there->rgba, 4 * there->width * there->height * sizeof(float));
    }
    for (size_t i = 0; i < count && status != ISO_OK; ++i)
        iso_image_destroy(&images[i]);
    return status;
}

void iso_frame_cache_use(iso_renderers *r, iso_frame_cache *cache)
{
    r->several = cache ? render_cached : NULL;
    r->several_user = cache;
}
