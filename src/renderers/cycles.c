/* SPDX-License-Identifier: MIT */
/* cycles.c - Blender's Cycles, as a program. It puts its steps at random phases, so that its images have noise; what it
 * needs to start is shared by several images, and Blender itself stays for the next scene. */
#include <stdio.h>
#include <stdlib.h>

#include "blender/blender.h"
#include "renderers/renderers.h"

static iso_status version(const iso_renderer_info *self, iso_renderers *r, char *text, size_t size, iso_error *err)
{
    (void)self;
    (void)r;
    char found[128] = "";
    const iso_status status = iso_cycles_version(found, sizeof found, err);
    if (status == ISO_OK)
        snprintf(text, size, "Blender %s", found);
    return status;
}

static iso_blender_options take_options(const iso_render_options *opt)
{
    iso_blender_options o = iso_blender_defaults();
    if (opt->step_voxels > 0)
        o.step_voxels = opt->step_voxels;
    if (opt->samples)
        o.samples = opt->samples;
    o.seed = opt->seed;
    o.threads = opt->threads;
    return o;
}

static void end(void *kept)
{
    iso_blender_session_end(kept);
}

static iso_status render_frames(const iso_render_request *q, const iso_blender_frames *frames, iso_error *err)
{
    return iso_cycles_render_frames(q->pyramid, q->level, q->view, frames, q->progress, err);
}

/* By the Blender that is kept. */
static iso_status render_kept(const iso_render_request *q, iso_blender_options *o, size_t count, iso_image *images,
                              iso_error *err)
{
    void **kept = iso_renderers_kept(q->renderers, &iso_renderer_cycles);
    iso_blender_session *session = *kept;
    for (size_t i = 0; i < count; ++i)
        o[i].session = &session;
    const iso_status status = render_frames(q, &(iso_blender_frames){o, count, images}, err);
    *kept = session;
    return status;
}

/* Who measures a frame has a Blender started for it. */
static iso_status render(const iso_render_request *q, iso_image *image, iso_render_stats *stats, iso_error *err)
{
    iso_blender_options o = take_options(q->options);
    iso_cycles_stats inside = {0};
    o.stats = &inside;
    const iso_status status = q->options->stats ? render_frames(q, &(iso_blender_frames){&o, 1, image}, err)
                                                : render_kept(q, &o, 1, image, err);
    inside.render_seconds -= inside.load_seconds;
    iso_render_stats_sum_up(stats, &inside.render_seconds, 1);
    stats->bytes = inside.device_bytes;
    return status;
}

static iso_status render_several(const iso_render_request *q, size_t count, iso_image *images, iso_error *err)
{
    iso_blender_options *o = malloc(count * sizeof *o);
    if (!o)
        return iso_fail(err, ISO_E_MEMORY, "no memory for %zu images", count);
    for (size_t i = 0; i < count; ++i)
        o[i] = take_options(&q->options[i]);
    const iso_status status = render_kept(q, o, count, images, err);
    free(o);
    return status;
}

const iso_renderer_info iso_renderer_cycles = {
    .name = "cycles",
    .title = "Blender Cycles",
    .stages = {"OpenVDB grids", "Blender"},
    .color = "#d55e00",
    .traits = ISO_IS_PROGRAM | ISO_IS_RANDOM | ISO_HAS_ALL_SCENES | ISO_HAS_LABELS | ISO_HAS_LIMIT | ISO_READS_SAMPLES |
              ISO_READS_SEED,
    .defaults = {.source = ISO_FROM_CODES},
    .relative_cost = 100,
    .version = version,
    .render = render,
    .render_several = render_several,
    .end = end,
};
