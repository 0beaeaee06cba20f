/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "blender/blender_scene.h"

#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/embed.h"
#include "base/file.h"
#include "base/parallel.h"
#include "base/process.h"
#include "base/stamp.h"
#include "vdb/vdb.h"

ISO_EMBED(iso_blender_scene_nodes_py, "exporters/blender/scene_nodes.py");
ISO_EMBED(iso_blender_scene_device_py, "exporters/blender/scene_device.py");
ISO_EMBED(iso_blender_scene_transfer_py, "exporters/blender/scene_transfer.py");
ISO_EMBED(iso_blender_scene_objects_py, "exporters/blender/scene_objects.py");
ISO_EMBED(iso_blender_scene_handles_py, "exporters/blender/scene_handles.py");
ISO_EMBED(iso_blender_scene_window_py, "exporters/blender/scene_window.py");
ISO_EMBED(iso_blender_scene_physical_py, "exporters/blender/scene_physical.py");
ISO_EMBED(iso_blender_build_scene_py, "exporters/blender/build_scene.py");

#define CALIBRATION_SIZE 4 /* voxels along an axis of the calibration volume */

static iso_status save_calibration_volume(const char *path, iso_error *err)
{
    enum { voxels = CALIBRATION_SIZE * CALIBRATION_SIZE * CALIBRATION_SIZE };
    float scalar[voxels];
    uint8_t codes[3 * voxels] = {0};
    for (int i = 0; i < voxels; ++i)
        scalar[i] = 1;
    iso_level level = {.geometry = iso_geometry_axis_aligned((size_t[]){CALIBRATION_SIZE, CALIBRATION_SIZE,
                                                                        CALIBRATION_SIZE},
                                                             (double[]){1, 1, 1}),
                       .scalar = scalar,
                       .codes = codes,
                       .min = 1,
                       .max = 1};
    iso_pyramid p = {.level_count = 1, .levels = &level};
    iso_vdb_options vdb = iso_vdb_defaults();
    vdb.gradient = false;
    return iso_vdb_save(&p, 0, 1, path, &vdb, NULL, err);
}

typedef struct listener {
    const iso_progress *progress;
    char refusal[256]; /* reason why calibration failed */
    char lack[400];    /* feature that this Blender lacks */
    char failure[256]; /* reason why the script failed */
    iso_cycles_stats *stats;
} listener;

/* Parses "Fra:1 Mem:91.94M (Peak 92.20M) | Time:00:01.34 | Mem:82.00M, Peak:82.00M | scene, ViewLayer | Sample 0/1" for
 * the start of the first picture's pixels and its end. */
static void take_stats(iso_cycles_stats *stats, const char *line)
{
    int minutes;
    double seconds, megabytes;
    const char *time = strstr(line, "| Time:");
    sscanf(line, "isoshade: peak %lf", &stats->peak_rss_bytes);
    sscanf(line, "isoshade: device %127[^\n]", stats->device);
    if (strcmp(line, "isoshade: pictures begin") == 0) /* after the calibration pictures */
        stats->load_seconds = stats->render_seconds = 0;
    if (!time || stats->render_seconds > 0 ||
        sscanf(time, "| Time:%d:%lf | Mem:%lfM", &minutes, &seconds, &megabytes) != 3)
        return;
    seconds += 60 * minutes;
    if (strstr(line, "| Sample 0/")) {
        stats->load_seconds = seconds;
        stats->device_bytes = 1048576 * megabytes;
    } else if (strstr(line, "| Finished")) {
        stats->render_seconds = seconds;
    }
}

static void take_line(void *user, const char *line)
{
    listener *l = user;
    double fraction;
    char stage[64];
    if (sscanf(line, "isoshade: progress %lf %63[^\n]", &fraction, stage) == 2)
        iso_progress_report(l->progress, stage, fraction);
    if (l->stats)
        take_stats(l->stats, line);
    sscanf(line, "isoshade: calibration failed: %255[^\n]", l->refusal);
    sscanf(line, "isoshade: shows no volumes: %399[^\n]", l->lack);
    sscanf(line, "isoshade: has no such device: %399[^\n]", l->lack);
    sscanf(line, "isoshade: is too old: %399[^\n]", l->lack);
    sscanf(line, "isoshade: failed: %255[^\n]", l->failure);
}

/* Joins all scripts into one: the last one, which runs, uses the definitions of the others. */
static iso_status write_script(const char *path, iso_error *err)
{
    const char *const parts[] = {iso_blender_scene_nodes_py,    iso_blender_scene_device_py,
                                 iso_blender_scene_transfer_py, iso_blender_scene_objects_py,
                                 iso_blender_scene_handles_py,  iso_blender_scene_window_py,
                                 iso_blender_scene_physical_py, iso_blender_build_scene_py};
    FREED char *text = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size);
    for (size_t i = 0; memory && i < sizeof parts / sizeof *parts; ++i)
        fprintf(memory, "%s\n\n", parts[i]);
    const bool whole = memory && fclose(memory) == 0;
    return whole ? iso_file_write(path, text, size, err) : iso_fail(err, ISO_E_MEMORY, "blender: out of memory");
}

/* ---- a Blender process, for one scene or for several ---- */

struct iso_blender_session {
    iso_process *process; /* NULL: not started */
    bool calibrates;      /* without a scene; nobody has listened yet */
    char *blender;        /* path of the program */
    int threads;
    char *folder;  /* parent of all scenes' folders, as the program may write only there; NULL: for a single scene */
    size_t scenes; /* scenes that got a folder */
};

static void stop(iso_blender_session *s)
{
    iso_process_end(s->process);
    s->process = NULL;
    free(s->blender);
    s->blender = NULL;
}

void iso_blender_session_end(iso_blender_session *session)
{
    if (!session)
        return;
    stop(session);
    if (session->folder)
        iso_remove_tree(session->folder);
    free(session->folder);
    free(session);
}

char *iso_blender_folder(const iso_blender_options *opt)
{
    char *path = NULL;
    if (!opt->session)
        return iso_make_temp_dir();
    if (!*opt->session && !(*opt->session = calloc(1, sizeof **opt->session)))
        return NULL;
    iso_blender_session *s = *opt->session;
    if (!s->folder && !(s->folder = iso_make_temp_dir()))
        return NULL;
    if (asprintf(&path, "%s/%zu", s->folder, ++s->scenes) < 0)
        return NULL;
    if (mkdir(path, 0700) == 0)
        return path;
    free(path);
    return NULL;
}

/* Inputs of a run of Blender. */
typedef struct blender_run {
    char *blender, *script, *description, *calibration;
    const char *folder;
    int threads;
} blender_run;

/* Returns the sandbox of the device: drivers of graphics devices need more rights than the processor. */
static iso_sandbox_kind sandbox_kind(void)
{
    const char *device = NULL;
    return iso_cycles_device(&device, NULL) == ISO_OK && strcmp(device, "cpu") == 0 ? ISO_SANDBOX_CLOSED
                                                                                    : ISO_SANDBOX_DEVICE;
}

static iso_status start(const blender_run *run, iso_blender_session *s, iso_error *err)
{
    char threads[16];
    snprintf(threads, sizeof threads, "%d", run->threads);
    const char *argv[] = {run->blender, "-b", "--factory-startup", "-noaudio", "--python-exit-code", "9", "-t",
                          threads,      "-P", run->script,         "--",       run->description,     NULL};
    iso_status status = write_script(run->script, err);
    TRY(status, save_calibration_volume(run->calibration, err));
    /* Debian's Blender uses the first Python in PATH and that of PYTHONHOME as its own, and loads modules of PYTHONPATH
     * first. Those of another Python do not work. */
    FREED char *folder = iso_path_dir(run->blender);
    const iso_sandbox_wish sandbox = {.kind = sandbox_kind(),
                                      .first_in_path = folder && folder[0] == '/' ? folder : NULL,
                                      .without = "PYTHON"};
    if (status == ISO_OK && !(s->blender = strdup(run->blender)))
        status = iso_fail(err, ISO_E_MEMORY, "blender: out of memory");
    s->threads = run->threads;
    TRY(status, iso_process_start(argv, s->folder ? s->folder : run->folder, &sandbox, &s->process, err));
    return status;
}

/* Sends the description to the session's process if its program and threads match; if not, starts a new one with it. */
static iso_status send_description(const blender_run *run, iso_blender_session *s, iso_error *err)
{
    if (s->process && s->threads == run->threads && strcmp(s->blender, run->blender) == 0) {
        iso_process_say(s->process, run->description);
        return ISO_OK;
    }
    stop(s);
    return start(run, s, err);
}

/* Listens until the session's Blender has finished its description. A Blender that fails is ended. */
static iso_status listen_to(iso_blender_session *s, const iso_blender_options *opt, const iso_progress *progress,
                            iso_error *err)
{
    listener l = {.progress = progress, .stats = opt->stats};
    const iso_process_options options = {.line = take_line, .user = &l};
    bool ended = true;
    iso_status status = iso_process_listen(s->process, "isoshade: finished", &options, &ended, err);
    if (status != ISO_OK && l.lack[0])
        status = iso_fail(err, ISO_E_MISSING, "%s", l.lack);
    else if (status != ISO_OK && l.refusal[0])
        status = iso_fail(err, ISO_E_UNTRUSTED, "%s: calibration failed: %s", s->blender, l.refusal);
    else if (status != ISO_OK && l.failure[0])
        status = iso_fail(err, ISO_E_PROGRAM, "%s: %s", s->blender, l.failure);
    if (ended)
        stop(s);
    return status;
}

static iso_status run_blender(const blender_run *run, const iso_blender_options *opt, const iso_progress *progress,
                              iso_error *err)
{
    iso_blender_session own = {0}, *s = opt->session && *opt->session ? *opt->session : &own;
    iso_status status = s->calibrates ? listen_to(s, opt, NULL, err) : ISO_OK;
    s->calibrates = false;
    TRY(status, send_description(run, s, err));
    TRY(status, listen_to(s, opt, progress, err));
    if (status != ISO_OK || s == &own)
        stop(s);
    return status;
}

/* Writes the description; the caller frees the run. */
static iso_status prepare(json_t *about, const char *folder, const iso_blender_options *opt, blender_run *run,
                          iso_error *err)
{
    const char *device = NULL;
    *run = (blender_run){.folder = folder,
                         .script = iso_path_join(folder, "build_scene.py"),
                         .description = iso_path_join(folder, "description.json"),
                         .calibration = iso_path_join(folder, "calibration.vdb"),
                         .threads = iso_threads(opt->threads)};
    NEED(iso_cycles_device(&device, err));
    NEED(iso_blender_find(opt->program, &run->blender, err));
    json_object_set_new(about, "device", json_string(device ? device : ""));
    json_object_set_new(about, "calibration",
                        json_pack("{ss ss si}", "vdb", run->calibration, "folder", folder, "size", CALIBRATION_SIZE));
    return iso_json_save(run->description, about, err);
}

static void free_run(blender_run *run)
{
    free(run->calibration);
    free(run->description);
    free(run->script);
    free(run->blender);
}

iso_status iso_blender_run(json_t *about, const char *folder, const iso_blender_options *opt,
                           const iso_progress *progress, iso_error *err)
{
    blender_run run;
    iso_status status = prepare(about, folder, opt, &run, err);
    TRY(status, run_blender(&run, opt, progress, err));
    /* Blender ignores data after the end of a .blend. */
    const char *saved = json_string_value(json_object_get(about, "save"));
    if (status == ISO_OK && saved)
        status = iso_stamp_append(saved, "", err);
    json_decref(about);
    free_run(&run);
    return status;
}

/* Starts the session's Blender, which calibrates itself. */
static iso_status begin_calibration(const char *folder, const iso_blender_options *opt, iso_error *err)
{
    blender_run run;
    json_auto_t *about = json_pack("{sb}", "probe", true);
    iso_status status = prepare(about, folder, opt, &run, err);
    TRY(status, start(&run, *opt->session, err));
    (*opt->session)->calibrates = status == ISO_OK;
    free_run(&run);
    return status;
}

iso_status iso_blender_begin(const iso_blender_options *opt, iso_blender_started *e, iso_error *err)
{
    *e = (iso_blender_started){.options = *opt};
    e->options.session = &e->session;
    FREED char *own = iso_blender_folder(&e->options);
    e->folder = own ? iso_blender_folder(&e->options) : NULL;
    return e->folder ? begin_calibration(own, &e->options, err) : iso_temp_dir_fail(err);
}

void iso_blender_end(iso_blender_started *e)
{
    iso_blender_session_end(e->session);
    free(e->folder);
}

int iso_blender_seed(int seed)
{
    return (int)((uint32_t)seed * 2654435761u & INT32_MAX);
}

json_t *iso_blender_describe_frames(double voxel, const char *folder, const iso_blender_options *frames, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; ++i) {
        char path[PATH_MAX];
        snprintf(path, sizeof path, "%s/picture-%zu.exr", folder, i);
        json_array_append_new(list,
                              json_pack("{sf si si ss}", "step", frames[i].step_voxels * voxel, "samples",
                                        frames[i].samples, "seed", iso_blender_seed(frames[i].seed), "path", path));
    }
    return list;
}

/* Loads Blender's picture. ISO_E_PROGRAM: it is missing or broken; ISO_E_IO: it cannot be read. */
static iso_status load_picture(const char *path, const iso_view *view, iso_image *picture, iso_error *err)
{
    iso_error why = {""};
    const iso_status status = iso_path_is_file(path) ? iso_image_load_exr(path, picture, &why)
                                                     : iso_fail(&why, ISO_E_PROGRAM, "it wrote no picture");
    if (status == ISO_E_MEMORY || status == ISO_E_IO)
        return iso_fail(err, status, "%s", why.text);
    if (status != ISO_OK)
        return iso_fail(err, ISO_E_PROGRAM, "blender: %s", why.text);
    if (picture->width == view->width && picture->height == view->height)
        return ISO_OK;
    return iso_fail(err, ISO_E_PROGRAM, "blender: the picture is %zu x %zu instead of %zu x %zu", picture->width,
                    picture->height, view->width, view->height);
}

iso_status iso_blender_load_pictures(const char *folder, const iso_view *view, size_t count, iso_image *pictures,
                                     iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t i = 0; i < count && status == ISO_OK; ++i) {
        char path[PATH_MAX];
        iso_image *picture = &pictures[i];
        snprintf(path, sizeof path, "%s/picture-%zu.exr", folder, i);
        status = load_picture(path, view, picture, err);
        if (status == ISO_OK)
            iso_image_add_background(picture, view->background);
    }
    for (size_t i = 0; i < count && status != ISO_OK; ++i)
        iso_image_destroy(&pictures[i]);
    return status;
}

iso_status iso_blender_check_path(const char *blend_path, iso_error *err)
{
    json_t *text = json_string(blend_path);
    json_decref(text);
    if (!iso_path_ends_with(blend_path, ".blend"))
        return iso_fail(err, ISO_E_USAGE, "%s: the name of a Blender file must end in .blend", blend_path);
    return text ? ISO_OK : iso_fail(err, ISO_E_USAGE, "%s: the path is not UTF-8, which Blender needs", blend_path);
}

iso_status iso_blender_save(json_t *about, const char *blend_path, iso_output *out, const char *folder,
                            const iso_blender_options *opt, const iso_progress *progress, iso_error *err)
{
    FREED char *data = NULL, *saved = iso_path_join(folder, "saved.blend");
    size_t size = 0;
    iso_status status = iso_output_begin(out, blend_path, err);
    if (status == ISO_OK && !saved)
        status = iso_fail(err, ISO_E_MEMORY, "blender: out of memory");
    if (status == ISO_OK) {
        json_object_set_new(about, "save", json_string(saved));
        status = iso_blender_run(about, folder, opt, progress, err);
    } else {
        json_decref(about);
    }
    /* Blender may only write to its own folder. */
    TRY(status, iso_file_read(saved, &data, &size, err));
    TRY(status, iso_file_write(out->temp_path, data, size, err));
    return status;
}
