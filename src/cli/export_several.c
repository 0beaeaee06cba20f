/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/export.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/provenance.h"
#include "tf/presets.h"

enum { MOST_VOLUMES = 32, NAME_BYTES = 64 };

/* One of the volumes, as requested. */
typedef struct one_volume {
    char *path, *tf, *channel; /* tf, channel: or NULL */
    char name[NAME_BYTES];
} one_volume;

typedef struct several_job {
    const iso_export_arguments *asked;
    const iso_export_target *target;
    const iso_subject_look *look;
    iso_progress progress;
    one_volume volumes[MOST_VOLUMES];
    size_t count;
    iso_view first; /* its camera, lights and background are used for all volumes */
} several_job;

/* Green, magenta, cyan, yellow, red, blue: usual for fluorescence, and the first two work for color-blind people. */
static const double channel_colors[][3] = {{0, 1, 0}, {1, 0, 1}, {0, 1, 1}, {1, 1, 0}, {1, 0.05, 0.05}, {0.1, 0.2, 1}};
static const char *const color_names[] = {"green", "magenta", "cyan", "yellow", "red", "blue"};
enum { COLORS = sizeof channel_colors / sizeof *channel_colors };

/* Sets a volume's name: letters, digits, "-" and "_", with a number if the name is taken. */
static void set_name(several_job *job, one_volume *v, const char *text)
{
    char base[NAME_BYTES - 8];
    size_t n = 0;
    for (; text[n] && text[n] != '.' && n + 1 < sizeof base; ++n)
        base[n] = isalnum((unsigned char)text[n]) || text[n] == '-' ? text[n] : '_';
    base[n] = 0;
    snprintf(v->name, sizeof v->name, "%s", n > 0 ? base : "volume");
    for (size_t i = 0, number = 2; i < job->count; ++i)
        if (strcmp(job->volumes[i].name, v->name) == 0) {
            snprintf(v->name, sizeof v->name, "%s_%zu", base, number++);
            i = (size_t)-1;
        }
}

/* Returns the name for objects and files; "volume" if outputs omit names. */
static const char *name_of_volume(const char *path)
{
    const char *name = iso_provenance_name(path);
    return *name ? iso_path_base(name) : "volume";
}

static iso_status add(several_job *job, const char *path, const char *tf, const char *channel, const char *name,
                      iso_error *err)
{
    if (job->count == MOST_VOLUMES)
        return iso_fail(err, ISO_E_USAGE, "too many volumes, at most %d", MOST_VOLUMES);
    one_volume *v = &job->volumes[job->count];
    *v = (one_volume){.path = strdup(path), .tf = tf ? strdup(tf) : NULL, .channel = channel ? strdup(channel) : NULL};
    set_name(job, v, name);
    ++job->count;
    return v->path && (v->tf || !tf) && (v->channel || !channel) ? ISO_OK
                                                                 : iso_fail(err, ISO_E_MEMORY, "out of memory");
}

static iso_status add_channel(several_job *job, const char *channel, iso_error *err)
{
    const iso_export_arguments *a = job->asked;
    iso_volume_input input = a->input;
    iso_volume_source *source = NULL;
    char name[NAME_BYTES];
    input.channel = (char *)channel;
    NEED(iso_volume_input_open(a->cli->arguments[0], &input, &source, err));
    const iso_volume_notes *notes = &iso_source_volume(source)->notes;
    snprintf(name, sizeof name, "channel_%zu%s%.32s", notes->channel, notes->channel_name[0] ? "_" : "",
             notes->channel_name);
    iso_source_close(source);
    return add(job, a->cli->arguments[0], NULL, channel, name, err);
}

/* Counts the channels of the file by opening the first one. */
static iso_status count_channels(const iso_export_arguments *a, size_t *count, iso_error *err)
{
    iso_volume_input input = a->input;
    ENDED_BY(iso_source_close_owned) iso_volume_source *source = NULL;
    char first[] = "0";
    input.channel = first;
    NEED(iso_volume_input_open(a->cli->arguments[0], &input, &source, err));
    *count = iso_source_volume(source)->notes.channel_count;
    return *count < 2
               ? iso_fail(err, ISO_E_USAGE, "%s: has one channel; --channels needs several", a->cli->arguments[0])
               : ISO_OK;
}

static iso_status add_channels(several_job *job, iso_error *err)
{
    const char *list = job->asked->channels;
    size_t count = 0;
    NEED(count_channels(job->asked, &count, err));
    const bool all = strcmp(list, "all") == 0;
    for (size_t c = 0; all && c < count; ++c) {
        char number[24];
        snprintf(number, sizeof number, "%zu", c);
        NEED(add_channel(job, number, err));
    }
    FREED char *copy = strdup(all ? "" : list);
    for (char *word, *rest = copy; !all && (word = strsep(&rest, ","));)
        NEED(add_channel(job, word, err));
    return ISO_OK;
}

/* Adds a volume of --add, "VOLUME,TF": the last comma separates them, unless a file of the whole name exists. */
static iso_status add_other(several_job *job, const char *text, iso_error *err)
{
    const char *comma = iso_path_exists(text) ? NULL : strrchr(text, ',');
    FREED char *path = comma ? strndup(text, (size_t)(comma - text)) : strdup(text);
    return path ? add(job, path, comma ? comma + 1 : NULL, NULL, name_of_volume(path), err)
                : iso_fail(err, ISO_E_MEMORY, "out of memory");
}

static void color_points(iso_tf *tf, const double color[3])
{
    for (size_t i = 0; i < tf->point_count; ++i)
        memcpy(tf->points[i].rgb_linear, color, sizeof tf->points[i].rgb_linear);
}

/* Makes the view of a volume. Its transfer function is the one named with it; for channels, a suggested one in the
 * channel's color; for the first volume the scene's; otherwise a suggested one. */
static iso_status make_view(several_job *job, size_t i, const iso_pyramid *p, iso_view *view, iso_error *err)
{
    const one_volume *v = &job->volumes[i];
    iso_subject_look look = *job->look;
    OWNED(iso_scene) scene = {0};
    const bool colored = v->channel && !look.tf && !p->levels[0].labels;
    look.tf = v->tf ? v->tf : i > 0 && !v->channel ? "auto" : colored ? "auto" : look.tf;
    NEED(iso_subject_make_scene(&look, p, &scene, err));
    if (colored)
        color_points(&scene.tf, channel_colors[i % COLORS]);
    NEED(iso_scene_resolve(&scene, &p->levels[0].geometry, iso_pyramid_lo(p), iso_pyramid_hi(p), view, err));
    if (i == 0) {
        job->first = *view;
        return ISO_OK;
    }
    const iso_tf_table own = view->tf;
    *view = job->first;
    view->tf = own;
    return ISO_OK;
}

static iso_status load(void *user, size_t i, iso_pyramid *p, iso_view *view, char name[NAME_BYTES], iso_error *err)
{
    several_job *job = user;
    const iso_export_arguments *a = job->asked;
    const one_volume *v = &job->volumes[i];
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_volume_input input = a->input;
    build.threads = a->cli->threads;
    build.level_count = (size_t)(a->level + a->level_count);
    if (v->channel)
        input.channel = v->channel;
    else if (i > 0)
        input = (iso_volume_input){0};
    snprintf(name, NAME_BYTES, "%s", v->name);
    NEED(iso_subject_load_pyramid(v->path, &input, &build, &job->progress, p, err));
    NEED(iso_pyramid_check_level(p, v->path, build.level_count - 1, err));
    return make_view(job, i, p, view, err);
}

static void print_summary(const several_job *job)
{
    const iso_export_arguments *a = job->asked;
    json_auto_t *names = json_array();
    for (size_t i = 0; i < job->count; ++i) {
        const one_volume *v = &job->volumes[i];
        json_array_append_new(names, json_string(v->name));
        if (!a->cli->json)
            printf("%s%s%s\n", v->name, v->channel && !job->look->tf ? ": " : "",
                   v->channel && !job->look->tf ? color_names[i % COLORS] : "");
    }
    if (a->cli->json)
        iso_cli_print_results(a->cli, json_pack("{s:s, s:s, s:i, s:O}", "to", job->target->name, "output", a->output,
                                                "level", a->level, "volumes", names));
    else
        printf("%s: %zu volumes: %s\n", a->output, job->count, job->target->summary);
}

static iso_status write_volumes(several_job *job, iso_error *err)
{
    const iso_export_arguments *a = job->asked;
    const char *path = a->cli->arguments[0];
    NEED(a->channels ? add_channels(job, err) : add(job, path, NULL, NULL, name_of_volume(path), err));
    for (size_t i = 0; a->added && a->added[i]; ++i)
        NEED(add_other(job, a->added[i], err));
    NEED(job->target->write_volumes(&(iso_export_job){.level = (size_t)a->level,
                                                      .level_count = (size_t)a->level_count,
                                                      .output = a->output,
                                                      .step_voxels = a->step == ISO_STEP_OF_SCENE ? 0 : a->step,
                                                      .threads = a->cli->threads,
                                                      .progress = &job->progress,
                                                      .volume_count = job->count,
                                                      .load_volume = load,
                                                      .volume_user = job},
                                    err));
    print_summary(job);
    return ISO_OK;
}

iso_status iso_export_several_volumes(const iso_export_arguments *a, const iso_export_target *target,
                                      const iso_subject_look *look, iso_error *err)
{
    several_job job = {.asked = a, .target = target, .look = look, .progress = iso_cli_progress(a->cli)};
    if (!target->write_volumes)
        return iso_fail(err, ISO_E_USAGE, "--to %s takes a single volume, without --add and --channels", target->name);
    const iso_status status = write_volumes(&job, err);
    for (size_t i = 0; i < job.count; ++i) {
        free(job.volumes[i].path);
        free(job.volumes[i].tf);
        free(job.volumes[i].channel);
    }
    return status;
}
