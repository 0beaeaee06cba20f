/* SPDX-License-Identifier: MIT */
/* cycles.c - Blender's Cycles, another program. It places its steps at random phases, so that its images have noise.
 * Several images share a start, and Blender keeps running for the next scene. Several Blenders are several
 * renderers, each with its program as data; "cycles" is the first. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/provenance.h"
#include "blender/blender.h"
#include "renderers/renderers.h"

/* Returns the renderer's own Blender; NULL: the one that all of isoshade finds. */
static const char *program_of(const iso_renderer_info *r)
{
    return r->data;
}

static iso_status version(const iso_renderer_info *self, iso_renderers *r, char *text, size_t size, iso_error *err)
{
    (void)r;
    iso_cycles_about about;
    NEED(iso_cycles_ask(program_of(self), &about, err));
    snprintf(text, size, "Blender %s on %s", about.version, about.device);
    return ISO_OK;
}

static iso_blender_options take_options(const iso_render_options *opt)
{
    iso_blender_options o = iso_blender_defaults();
    o.program = program_of(opt->renderer);
    if (opt->step_voxels > 0)
        o.step_voxels = opt->step_voxels;
    if (opt->samples)
        o.samples = opt->samples;
    o.seed = opt->seed;
    o.threads = opt->threads;
    return o;
}

static double own_step(const iso_level *level)
{
    (void)level;
    return iso_blender_defaults().step_voxels;
}

static void end(void *kept)
{
    iso_blender_session_end(kept);
}

static iso_status render_frames(const iso_render_request *q, const iso_blender_frames *frames, iso_error *err)
{
    return iso_cycles_render_frames(q->pyramid, q->level, q->view, frames, q->progress, err);
}

/* Renders in the Blender that keeps running. */
static iso_status render_kept(const iso_render_request *q, iso_blender_options *o, size_t count, iso_image *images,
                              iso_error *err)
{
    void **kept = iso_renderers_kept(q->renderers, q->options->renderer);
    iso_blender_session *session = *kept;
    for (size_t i = 0; i < count; ++i)
        o[i].session = &session;
    const iso_status status = render_frames(q, &(iso_blender_frames){o, count, images}, err);
    *kept = session;
    return status;
}

/* Starts a new Blender for a frame that is measured. */
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
    FREED iso_blender_options *o = malloc(count * sizeof *o);
    NEED_MEMORY(o, err, "no memory for %zu images", count);
    for (size_t i = 0; i < count; ++i)
        o[i] = take_options(&q->options[i]);
    return render_kept(q, o, count, images, err);
}

static char *first_command; /* of "cycles", if its Blender was named */

static const char *first_asked_by(const iso_renderer_info *self)
{
    return first_command ? first_command : self->name;
}

static const char *const programs[] = {"blender", NULL};

const iso_renderer_info iso_renderer_cycles = {
    .name = "cycles",
    .title = "Blender Cycles",
    .programs = programs,
    .stages = {"OpenVDB grids", "Blender"},
    .color = "#d55e00",
    .traits = ISO_IS_PROGRAM | ISO_IS_RANDOM | ISO_HAS_ALL_SCENES | ISO_HAS_LABELS | ISO_HAS_LIMIT | ISO_READS_SAMPLES |
              ISO_READS_SEED,
    .defaults = {.source = ISO_FROM_CODES},
    .sample_seconds = 7e-8,
    .asked_by = first_asked_by,
    .version = version,
    .own_step = own_step,
    .render = render,
    .render_several = render_several,
    .end = end,
};

/* ---- several Blenders ---- */

enum { MAX_BLENDERS = 4 };
static const char *const colors[MAX_BLENDERS - 1] = {"#cc79a7", "#56b4e9", "#8c510a"};

/* One more Blender as a renderer of this file; its texts last as long as the process. */
typedef struct more_blender {
    iso_renderer_info info;
    char name[48], title[64], *program, *command;
    const char *programs[2];
} more_blender;
static more_blender more[MAX_BLENDERS - 1];
static size_t more_count;

static bool is_taken(const char *name)
{
    bool found = false;
    for (size_t i = 0; i < iso_renderer_count(); ++i)
        found = found || strcmp(iso_renderer_at(i)->name, name) == 0;
    return found;
}

static const char *asked_by(const iso_renderer_info *self)
{
    const char *command = "";
    for (size_t i = 0; i < more_count; ++i)
        if (&more[i].info == self)
            command = more[i].command;
    return command;
}

/* Returns the argument of --with that selects this Blender; NULL: no memory. */
static char *command_with(const char *program)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f)
        return NULL;
    fputs("cycles --blender ", f);
    iso_provenance_put_word(f, program);
    return fclose(f) == 0 ? text : NULL;
}

static iso_status add_blender(const char *program, const char *found_version, iso_error *err)
{
    if (more_count == MAX_BLENDERS - 1)
        return iso_fail(err, ISO_E_USAGE, "--blender: too many Blenders, at most %d", MAX_BLENDERS);
    more_blender *b = &more[more_count];
    char which[40];
    snprintf(which, sizeof which, "%.30s", found_version);
    snprintf(b->name, sizeof b->name, "cycles-%s", which);
    for (unsigned n = 2; is_taken(b->name) && n <= MAX_BLENDERS; ++n) {
        snprintf(which, sizeof which, "%.30s-%u", found_version, n % 10);
        snprintf(b->name, sizeof b->name, "cycles-%s", which);
    }
    snprintf(b->title, sizeof b->title, "Blender Cycles %s", which);
    NEED(iso_blender_find(program, &b->program, err));
    if (!(b->command = command_with(b->program)))
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    b->info = iso_renderer_cycles;
    b->info.name = b->name;
    b->info.title = b->title;
    b->info.color = colors[more_count];
    b->info.data = b->programs[0] = b->program;
    b->info.programs = b->programs;
    b->info.asked_by = asked_by;
    b->info.beside = &iso_renderer_cycles;
    ++more_count;
    return iso_renderers_register(&b->info, err);
}

/* Sets the command of this renderer, and the Blender that exports and viewing commands use. */
static iso_status take_first(const char *program, iso_error *err)
{
    FREED char *path = NULL;
    NEED(iso_blender_find(program, &path, err));
    if (!(first_command = command_with(path)) || setenv("ISOSHADE_BLENDER", path, 1) != 0)
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    return ISO_OK;
}

iso_status iso_renderers_take_blenders(const char *list, iso_error *err)
{
    FREED char *copy = strdup(list ? list : "");
    NEED_MEMORY(copy, err, "out of memory");
    for (char *program, *rest = copy; list && (program = strsep(&rest, ","));) {
        char found[32];
        NEED(*program ? iso_blender_version(program, found, sizeof found, err)
                      : iso_fail(err, ISO_E_USAGE, "--blender \"%s\": a name is empty; separate names by single commas",
                                 list));
        NEED(first_command ? add_blender(program, found, err) : take_first(program, err));
    }
    return ISO_OK;
}
