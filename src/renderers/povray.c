/* SPDX-License-Identifier: MIT */
/* povray.c - POV-Ray, another program. Its rays have intervals instead of steps, and its images 16 bits per channel. */
#include "povray/povray.h"

#include <math.h>
#include <stdio.h>

#include "renderers/renderers.h"

static iso_status version(const iso_renderer_info *self, iso_renderers *r, char *text, size_t size, iso_error *err)
{
    (void)self;
    (void)r;
    char found[128] = "";
    NEED(iso_povray_version(found, sizeof found, err));
    snprintf(text, size, "POV-Ray %s", found);
    return ISO_OK;
}

static iso_povray_options take_options(const iso_render_request *q)
{
    const iso_render_options *opt = q->options;
    iso_povray_options o = iso_povray_defaults();
    if (opt->intervals) {
        o.intervals = opt->intervals;
        o.planes = opt->planes;
        o.extrapolate = opt->extrapolate;
    } else if (opt->step_voxels > 0) {
        iso_povray_set_step(&q->pyramid->levels[q->level].geometry, q->view, opt->step_voxels, &o);
    }
    o.float_directions = opt->source == ISO_FROM_FLOAT;
    o.isosurface = opt->isosurface;
    o.iso = opt->iso;
    o.threads = opt->threads;
    return o;
}

/* Returns the finer step of the two that it extrapolates from. */
static double own_step(const iso_level *level)
{
    const iso_povray_options o = iso_povray_defaults();
    return iso_level_chord_voxels(level) / (double)(o.intervals * (o.planes + 1));
}

static iso_status render(const iso_render_request *q, iso_image *image, iso_render_stats *stats, iso_error *err)
{
    const iso_render_options *opt = q->options;
    iso_povray_options o = take_options(q);
    iso_povray_stats inside = {0};
    o.stats = &inside;
    const iso_status status = iso_povray_render(q->pyramid, q->level, q->view, &o, image, q->progress, err);
    iso_render_stats_sum_up(stats, opt->processor_time ? &inside.processor_seconds : &inside.trace_seconds, 1);
    stats->bytes = inside.df3_bytes;
    return status;
}

/* True if one export serves both frames: the same planes, surface and source of directions. */
static bool shares_export(const iso_render_options *a, const iso_render_options *b)
{
    return a->intervals > 0 && b->intervals > 0 && a->planes == b->planes && a->source == b->source &&
           a->isosurface == b->isosurface && a->iso == b->iso && !a->extrapolate && !b->extrapolate;
}

/* Draws `count` frames in one start. */
static iso_status render_together(const iso_render_request *q, size_t count, iso_image *images, iso_error *err)
{
    size_t intervals[ISO_RENDER_MAX_FRAMES];
    const iso_povray_options o = take_options(q);
    for (size_t i = 0; i < count; ++i)
        intervals[i] = q->options[i].intervals;
    return iso_povray_render_several(q->pyramid, q->level, q->view, &o,
                                     &(iso_povray_pictures){intervals, count, images}, q->progress, err);
}

static iso_status render_several(const iso_render_request *q, size_t count, iso_image *images, iso_error *err)
{
    iso_render_request rest = *q;
    iso_render_stats unused;
    for (size_t done = 0, n; done < count; done += n) {
        rest.options = q->options + done;
        n = 1;
        while (n < ISO_RENDER_MAX_FRAMES && done + n < count && shares_export(rest.options, rest.options + n))
            ++n;
        NEED(n > 1 ? render_together(&rest, n, images + done, err) : render(&rest, images + done, &unused, err));
    }
    return ISO_OK;
}

static iso_status render_scenes(const iso_render_request *scenes, size_t count, iso_image *images, iso_error *err)
{
    iso_povray_options options[ISO_RENDER_MAX_SCENES];
    iso_povray_wanted wanted[ISO_RENDER_MAX_SCENES];
    for (size_t i = 0; i < count; ++i) {
        options[i] = take_options(&scenes[i]);
        wanted[i] = (iso_povray_wanted){scenes[i].pyramid, scenes[i].level, scenes[i].view, &options[i]};
    }
    return iso_povray_render_scenes(wanted, count, images, scenes->progress, err);
}

/* Keeps the planes and doubles the intervals from frame to frame, so that each interval is halved. The number of
 * planes leaves room to double the intervals of a piece `spare` times more. */
static void ask_steps(const iso_level *level, double finest_voxels, size_t count, double spare,
                      iso_render_options *frames)
{
    const int halvings = (int)count - 1;
    const size_t most_coarse = (size_t)ISO_POVRAY_MAX_INTERVALS >> halvings, most = most_coarse << halvings;
    const double total = ceil(iso_level_chord_voxels(level) / finest_voxels);
    const double pieces = fmin(fmax(ceil(spare * total / (double)most), 1), ISO_POVRAY_MAX_PLANES + 1);
    const double coarse = fmin(fmax(ceil(ldexp(total / pieces, -halvings)), 2), (double)most_coarse);
    for (size_t i = 0; i < count; ++i) {
        frames[i].planes = (size_t)pieces - 1;
        frames[i].intervals = (size_t)coarse << i;
    }
}

/* Returns the largest possible color with the background. An image is made of two pictures, emission and transmittance.
 * Integers of the first are parts of the brightest possible color; those of the second weight the background. */
static double peak_with_background(const iso_view *view)
{
    return iso_povray_peak(view) + fmax(view->background[0], fmax(view->background[1], view->background[2]));
}

/* Both are rounded by half a step of 16 bits, 7.6e-6 of the peak. Over an image this is 4.4e-6 (a step over the root
 * of 12) if pixels differ, and up to 7.6e-6 if they are equal: a flat image is rounded to one side everywhere. */
static const iso_lock_step lock_step = {
    .quadrature = ISO_QUADRATURE_POVRAY,
    .intervals = 128, /* enough to resemble the volume, and still fast */
    .smooth = {.max_abs = 2e-5},
    .sharp = {.max_abs = 2e-4},
    .why = "the same samples; POV-Ray writes 16 bits per channel (7.6e-6 of the brightest possible color)",
};

static const char *const programs[] = {"povray", "~/.povray/3.7/povray.ini", "/etc/povray/3.7/povray.ini", NULL};

const iso_renderer_info iso_renderer_povray = {
    .name = "povray",
    .title = "POV-Ray",
    .programs = programs,
    .stages = {"povray: writing DF3", "povray: rendering"},
    .color = "#009e73",
    .traits = ISO_IS_PROGRAM | ISO_HAS_ALL_SCENES | ISO_HAS_LABELS | ISO_HAS_LIMIT | ISO_HAS_ISOSURFACES |
              ISO_HAS_PROCESSOR_TIME | ISO_READS_INTERVALS | ISO_READS_PLANES | ISO_WAITS_BETWEEN,
    .defaults = {.source = ISO_FROM_CODES},
    .sample_seconds = 5e-7,
    .max_intervals = ISO_POVRAY_MAX_INTERVALS,
    .lock_step = &lock_step,
    .output = {.bits = 16, .peak = peak_with_background, .rounding = 1e-5, .rounding_rmse = 8e-6},
    .version = version,
    .render = render,
    .render_several = render_several,
    .render_scenes = render_scenes,
    .ask_steps = ask_steps,
    .own_step = own_step,
};
