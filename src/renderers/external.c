/* SPDX-License-Identifier: MIT */
/* external.c - starts an external renderer and loads its pictures. */
#define _GNU_SOURCE
#include "renderers/external.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/json.h"
#include "base/process.h"
#include "base/provenance.h"
#include "base/words.h"
#include "renderers/picture_file.h"
#include "renderers/picture_plain.h"
#include "renderers/request.h"

/* ---- output of the program, for reports ---- */

enum { KEPT_LINES = 8, LINE_BYTES = 240 };

/* The last lines of a program's output, in a ring, and the first one, which may be a version. */
typedef struct tail {
    char line[KEPT_LINES][LINE_BYTES], first[LINE_BYTES];
    size_t count; /* of all lines */
} tail;

static void keep_line(void *user, const char *line)
{
    tail *t = user;
    char *to = t->line[t->count++ % KEPT_LINES];
    snprintf(to, LINE_BYTES, "%.*s", LINE_BYTES - 1, line);
    iso_words_make_printable(to);
    if (t->count == 1)
        memcpy(t->first, to, sizeof t->first);
}

/* Returns the last line, or "". */
static const char *last_line(const tail *t)
{
    return t->count ? t->line[(t->count - 1) % KEPT_LINES] : "";
}

/* Starts of one renderer: their number, and details of the first one that failed, or else of the last one. */
typedef struct record {
    size_t starts;
    double seconds;
    bool failed;
    iso_process_outcome outcome;
    tail output;
    char why[512];
} record;

/* Locked, since several threads may use one renderer. */
static record records[ISO_MAX_RENDERERS];
static pthread_mutex_t records_lock = PTHREAD_MUTEX_INITIALIZER;

static void note_start(const iso_renderer_info *r, const iso_process_outcome *outcome, const tail *output,
                       const char *failure)
{
    record *to = &records[iso_renderer_index(r)];
    pthread_mutex_lock(&records_lock);
    to->starts += 1;
    to->seconds += outcome->seconds;
    if (!to->failed) {
        to->outcome = *outcome;
        to->output = *output;
        to->failed = failure != NULL;
        snprintf(to->why, sizeof to->why, "%.500s", failure ? failure : "");
    }
    pthread_mutex_unlock(&records_lock);
}

static json_t *words_json(const char *const *words)
{
    json_t *list = json_array();
    for (; *words; ++words)
        json_array_append_new(list, json_string(strchr(*words, '/') ? iso_provenance_name(*words) : *words));
    return list;
}

static json_t *output_json(const tail *t)
{
    json_t *list = json_array();
    for (size_t i = t->count > KEPT_LINES ? t->count - KEPT_LINES : 0; i < t->count; ++i) {
        char line[LINE_BYTES];
        memcpy(line, t->line[i % KEPT_LINES], sizeof line);
        json_array_append_new(list, json_string(iso_provenance_shorten(line)));
    }
    return list;
}

/* Describes the limits of its images, and their reason. */
static json_t *limits_json(const iso_lock_step *lock)
{
    return lock ? json_pack("{s:f, s:f, s:f, s:f, s:s}", "rmse", lock->smooth.rmse, "max_abs", lock->smooth.max_abs,
                            "sharp_rmse", lock->sharp.rmse, "sharp_max_abs", lock->sharp.max_abs, "why",
                            lock->why ? lock->why : "")
                : json_null();
}

json_t *iso_external_describe(const iso_renderer_info *self)
{
    const iso_external *e = self->data;
    pthread_mutex_lock(&records_lock);
    const record *r = &records[iso_renderer_index(self)];
    const iso_process_outcome *o = &r->outcome;
    char why[sizeof r->why];
    memcpy(why, r->why, sizeof why);
    json_t *out = json_pack("{s:o, s:s, s:o, s:I, s:f, s:o, s:i, s:b, s:o, s:s}", "command", words_json(e->command),
                            "tier", e->tier, "limits", limits_json(self->lock_step), "starts", (json_int_t)r->starts,
                            "seconds", r->seconds, "exit_code",
                            r->starts && o->exit_code >= 0 ? json_integer(o->exit_code) : json_null(), "signal",
                            o->signal, "timed_out", o->timed_out, "output", output_json(&r->output), "failure",
                            iso_provenance_shorten(why));
    pthread_mutex_unlock(&records_lock);
    return out;
}

/* ---- a start ---- */

/* A start: its folder and its result. */
typedef struct start {
    const iso_renderer_info *renderer;
    char *dir;
    tail output;
    iso_process_outcome outcome;
} start;

static iso_status begin(start *s, const iso_renderer_info *r, iso_error *err)
{
    *s = (start){.renderer = r, .dir = iso_make_temp_dir(), .outcome = {.exit_code = -1}};
    return s->dir ? ISO_OK : iso_temp_dir_fail(err);
}

static void end(start *s)
{
    if (s->dir)
        iso_remove_tree(s->dir);
    free(s->dir);
}

static iso_status find_program(const iso_external *e, const char *word, char **path, iso_error *err)
{
    if (!strchr(word, '/'))
        return iso_process_find(word, e->package ? e->package : word, path, err);
    *path = iso_path_exists(word) && !iso_path_is_dir(word) ? strdup(word) : NULL;
    return *path ? ISO_OK : iso_fail(err, ISO_E_MISSING, "%s: no such program", word);
}

/* Runs the command `words`, with `last` as the last argument if it is not NULL. */
static iso_status run(start *s, const char *const *words, const char *last, iso_error *err)
{
    const iso_external *e = s->renderer->data;
    size_t count = 0;
    FREED char *program = NULL;
    while (words[count])
        ++count;
    FREED const char **argv = calloc(count + 2, sizeof *argv);
    NEED(argv ? find_program(e, words[0], &program, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    memcpy(argv, words, count * sizeof *argv);
    argv[0] = program;
    argv[count] = last;
    const iso_process_options options = {.directory = s->dir,
                                         .sandbox = {.kind = e->has_all_rights ? ISO_SANDBOX_NONE : ISO_SANDBOX_DEVICE},
                                         .line = keep_line,
                                         .user = &s->output,
                                         .timeout_seconds = e->timeout_seconds,
                                         .outcome = &s->outcome};
    return iso_process_run(argv, &options, err);
}

iso_status iso_external_version(const iso_renderer_info *self, iso_renderers *r, char *text, size_t size,
                                iso_error *err)
{
    const iso_external *e = self->data;
    start s;
    char *program = NULL;
    (void)r;
    if (!e->version) {
        const iso_status found = find_program(e, e->command[0], &program, err);
        free(program);
        snprintf(text, size, "%s", found == ISO_OK ? iso_path_base(e->command[0]) : "");
        return found;
    }
    iso_error why = {""};
    iso_status status = begin(&s, self, &why);
    TRY(status, run(&s, e->version, NULL, &why));
    if (status == ISO_OK)
        snprintf(text, size, "%.*s", (int)size - 1, s.output.count ? s.output.first : self->title);
    else if (s.outcome.exit_code > 0) /* it reports that something is missing */
        status = ISO_E_MISSING;
    end(&s);
    return status == ISO_OK ? ISO_OK : iso_fail(err, status, "%s: %s", self->name, why.text);
}

/* ---- its pictures ---- */

static iso_status refuse(const char *file, iso_error *err, const char *what)
{
    return iso_fail(err, ISO_E_PROGRAM, "%s %s", file, what);
}

static bool is_older(const struct timespec *a, const struct timespec *b)
{
    return a->tv_sec != b->tv_sec ? a->tv_sec < b->tv_sec : a->tv_nsec < b->tv_nsec;
}

/* Refuses a picture unless it is a regular file written after the request: a pipe never ends, a link leads anywhere. */
static iso_status check_file(const char *path, const char *file, const char *request, iso_error *err)
{
    struct stat picture, asked;
    if (lstat(path, &picture) != 0)
        return refuse(file, err, "was not written");
    if (!S_ISREG(picture.st_mode))
        return refuse(file, err, "is not a regular file");
    if (stat(request, &asked) != 0 || is_older(&picture.st_mtim, &asked.st_mtim))
        return refuse(file, err, "is older than the request for it");
    return ISO_OK;
}

static iso_status take_picture(const start *s, const char *file, const iso_view *view, iso_image *image, iso_error *err)
{
    FREED char *asked = iso_path_join(s->dir, file), *request = iso_path_join(s->dir, "request.json"), *path = NULL;
    NEED(asked && request ? iso_picture_find(asked, file, &path, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    FREED char *alpha = iso_picture_alpha(path);
    NEED(check_file(path, iso_path_base(path), request, err));
    if (alpha)
        NEED(check_file(alpha, iso_path_base(alpha), request, err));
    return iso_picture_load(path, iso_path_base(path), view, image, err);
}

/* Prefixes the renderer's name to an error, and appends its last output line if the error does not quote it yet. */
static iso_status add_context(const start *s, iso_status status, const iso_error *why, iso_error *err)
{
    const char *line = s->outcome.exit_code == 0 ? last_line(&s->output) : "";
    return iso_fail(err, status, "%s: %.700s%s%.200s", s->renderer->name, why->text, line[0] ? "; last output: " : "",
                    line);
}

enum { FILE_NAME_BYTES = 32 };

static void ask_frames(const iso_render_options *options, size_t count, char (*names)[FILE_NAME_BYTES],
                       iso_request_frame *frames)
{
    for (size_t i = 0; i < count; ++i) {
        snprintf(names[i], FILE_NAME_BYTES, "frame%zu.exr", i);
        frames[i] = (iso_request_frame){.step_voxels = options[i].step_voxels,
                                        .samples = options[i].samples,
                                        .seed = options[i].seed,
                                        .file = names[i]};
    }
}

/* Writes the request, runs the program and loads the pictures, all in the folder of `s`. */
static iso_status render_in(start *s, const iso_render_request *q, const iso_request *request, iso_image *images,
                            iso_error *err)
{
    const iso_external *e = s->renderer->data;
    FREED char *path = iso_path_join(s->dir, "request.json");
    iso_status status = path ? iso_request_write(request, s->dir, err) : iso_fail(err, ISO_E_MEMORY, "out of memory");
    iso_progress_report(q->progress, s->renderer->name, 0);
    if (status == ISO_OK) {
        iso_error why = {""};
        status = run(s, e->command, path, &why);
        for (size_t i = 0; i < request->frame_count && status == ISO_OK; ++i)
            status = take_picture(s, request->frames[i].file, q->view, &images[i], &why);
        if (status != ISO_OK)
            status = add_context(s, status, &why, err);
        note_start(s->renderer, &s->outcome, &s->output, status == ISO_OK ? NULL : why.text);
    }
    return status;
}

iso_status iso_external_render_several(const iso_render_request *q, size_t count, iso_image *images, iso_error *err)
{
    FREED iso_request_frame *frames = calloc(count, sizeof *frames);
    char(*names)[FILE_NAME_BYTES] = calloc(count, sizeof *names);
    start s = {.dir = NULL};
    memset(images, 0, count * sizeof *images);
    iso_status status = frames && names ? begin(&s, q->options->renderer, err)
                                        : iso_fail(err, ISO_E_MEMORY, "no memory for %zu frames", count);
    if (status == ISO_OK) {
        ask_frames(q->options, count, names, frames);
        const iso_request request = {.pyramid = q->pyramid,
                                     .level = q->level,
                                     .view = q->view,
                                     .frames = frames,
                                     .frame_count = count,
                                     .threads = q->options->threads};
        status = render_in(&s, q, &request, images, err);
    }
    for (size_t i = 0; i < count && status != ISO_OK; ++i)
        iso_image_destroy(&images[i]);
    end(&s);
    free(names);
    return status;
}

iso_status iso_external_render(const iso_render_request *q, iso_image *image, iso_render_stats *stats, iso_error *err)
{
    (void)stats; /* the caller measures the call, start included */
    return iso_external_render_several(q, 1, image, err);
}
