/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "volume/child.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/pidfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/helper.h"
#include "base/parallel.h"
#include "base/process.h"
#include "base/warnings.h"
#include "base/words.h"
#include "volume/child_start.h"
#include "volume/child_stream.h"
#include "volume/segments.h"

/* ---- checks of what the program sends ---- */

/* Checks of the output of the programs that read volumes (child_stream.h). It is untrusted input: a
 * damaged file may make its library write anything. Private to src/volume. */

#define END_TEXT(text) ((text)[sizeof(text) - 1] = 0)

static void child_end_text(iso_child_answer *answer)
{
    END_TEXT(answer->error.text);
}

/* Ends each text where its field ends, for any content. */
static void child_end_texts(iso_child_header *h)
{
    END_TEXT(h->version);
    child_end_text(&h->answer);
    for (int r = 0; r < 3; ++r)
        END_TEXT(h->unit[r]);
    for (int c = 0; c < ISO_CHILD_CHANNELS; ++c)
        END_TEXT(h->channel_name[c]);
    for (int s = 0; s < ISO_CHILD_SEGMENTS; ++s)
        END_TEXT(h->segment[s].name);
    END_TEXT(h->value_unit);
    END_TEXT(h->frame_unit);
    END_TEXT(h->unspaced);
    END_TEXT(h->warning);
}

/* True for a status that a reader may have: not of a comparison or a renderer. */
static bool is_known(iso_status status)
{
    return status >= ISO_E_USAGE && status <= ISO_E_PROGRAM;
}

/* Returns the program's error, or ISO_OK. `path` and `library` are for the message if the answer's status is
 * unknown: ISO_E_FORMAT. Its text is ended. */
static iso_status child_check_answer(const iso_child_answer *answer, const char *path, const char *library,
                                     iso_error *err)
{
    if (answer->status == ISO_OK)
        return ISO_OK;
    if (is_known(answer->status) && answer->error.text[0])
        return iso_fail(err, answer->status, "%s", answer->error.text);
    return iso_fail(err, ISO_E_FORMAT, "%s: damaged: %s fails with status %d and reports \"%s\"", path, library,
                    (int)answer->status, answer->error.text);
}

static bool is_type(iso_type type)
{
    switch (type) {
#define ISO_TYPE_CASE(name, text, ctype) case name:
        ISO_TYPE_LIST(ISO_TYPE_CASE)
#undef ISO_TYPE_CASE
        return true;
    }
    return false;
}

static bool is_world(iso_child_world world)
{
    return world == ISO_CHILD_LPS || world == ISO_CHILD_RAS || world == ISO_CHILD_OWN || world == ISO_CHILD_CENTERED;
}

/* True if the box lies in the grid; 0 stands for the grid's size. */
static bool has_box(const iso_child_header *h)
{
    bool good = true;
    for (int a = 0; a < 3; ++a)
        good = good && h->box[a] >= 0 && h->box[a] <= (double)h->size[a];
    return good;
}

/* Checks all but the size, which iso_geometry_check() checks. ISO_E_FORMAT: an unknown type or world, a number that is
 * not finite, a box beyond the grid, or too many frames and channels to count. */
static iso_status child_check_header(const iso_child_header *h, const char *path, const char *library, iso_error *err)
{
    size_t volumes;
    if (!is_type(h->type))
        return iso_fail(err, ISO_E_FORMAT, "%s: damaged: %s names samples of type %d, which there is not", path,
                        library, (int)h->type);
    if (!is_world(h->world))
        return iso_fail(err, ISO_E_FORMAT, "%s: damaged: %s names axes of kind %d, which there is not", path, library,
                        (int)h->world);
    if (!isfinite(h->slope) || !isfinite(h->intercept))
        return iso_fail(err, ISO_E_FORMAT, "%s: damaged: slope %g and intercept %g, which have to be finite", path,
                        h->slope, h->intercept);
    if (!has_box(h))
        return iso_fail(err, ISO_E_FORMAT, "%s: damaged: a box of %g x %g x %g voxels in a grid of %zu x %zu x %zu",
                        path, h->box[0], h->box[1], h->box[2], h->size[0], h->size[1], h->size[2]);
    if (__builtin_mul_overflow(h->frames, h->channels, &volumes))
        return iso_fail(err, ISO_E_FORMAT, "%s: damaged: %zu frames of %zu channels cannot be counted", path, h->frames,
                        h->channels);
    return ISO_OK;
}

/* ---- the source ---- */

typedef struct child {
    iso_child_process process;
    const iso_child_program *program;
} child;

/* Waits for a program that is about to end, and ends it after some seconds. Its exit code is of interest, and a
 * watching tool, such as valgrind, has a report to write. */
static int end_program(child *r)
{
    enum { PATIENCE_MS = 5000 };
    int result = 0;
    struct pollfd end = {.fd = pidfd_open(r->process.pid, 0), .events = POLLIN};
    if (end.fd >= 0) {
        poll(&end, 1, PATIENCE_MS);
        close(end.fd);
    }
    kill(r->process.pid, SIGKILL);
    while (waitpid(r->process.pid, &result, 0) < 0 && errno == EINTR)
        ;
    r->process.pid = 0;
    return result;
}

/* True if the program, whose output has ended, did not start. */
static bool did_not_start(child *r)
{
    const int result = r->process.pid > 0 ? end_program(r) : 0;
    return WIFEXITED(result) && WEXITSTATUS(result) == ISO_CHILD_NOT_STARTED;
}

/* True if there is output to read, its end, or an error; false: the deadline came first. */
static bool wait_for_output(const child *r, double deadline)
{
    struct pollfd output = {.fd = r->process.output, .events = POLLIN};
    for (double left; (left = deadline - iso_clock_seconds()) > 0;) {
        const int ready = poll(&output, 1, (int)fmin(ceil(1e3 * left), 1e6));
        if (ready > 0 || (ready < 0 && errno != EINTR))
            return true;
    }
    return false;
}

static iso_status get(iso_volume_source *source, void *data, size_t bytes, iso_error *err)
{
    child *r = source->reader;
    const double limit = iso_process_limit(0), deadline = iso_clock_seconds() + limit;
    bool in_time = true;
    ssize_t n = 1;
    for (size_t had = 0; n != 0; had += n > 0 ? (size_t)n : 0) {
        if (had == bytes)
            return ISO_OK;
        in_time = wait_for_output(r, deadline);
        n = in_time ? read(r->process.output, (char *)data + had, bytes - had) : 0;
        if (n < 0 && errno != EINTR)
            return iso_fail(err, ISO_E_IO, "%s: the output of %s cannot be read", source->path, r->program->library);
    }
    if (!in_time)
        return iso_fail(err, ISO_E_PROGRAM, "%s: %s: stopped after %g s, the time limit", source->path,
                        r->program->name, limit);
    if (did_not_start(r))
        return iso_fail(err, ISO_E_PROGRAM, "%s: %s cannot be started", source->path, r->program->name);
    return iso_fail(err, ISO_E_FORMAT, "%s: damaged: %s ends before the samples do", source->path, r->program->library);
}

static iso_status get_answer(iso_volume_source *source, iso_error *err)
{
    const child *r = source->reader;
    iso_child_answer answer;
    NEED(get(source, &answer, sizeof answer, err));
    child_end_text(&answer);
    return child_check_answer(&answer, source->path, r->program->library, err);
}

static iso_status read_planes(iso_volume_source *source, size_t plane_count, void *out, iso_error *err)
{
    const size_t plane = iso_source_plane_bytes(source);
    for (size_t i = 0; i < plane_count; ++i) {
        NEED(get_answer(source, err));
        NEED(get(source, (char *)out + i * plane, plane, err));
    }
    return ISO_OK;
}

/* Closes the reader: a healthy one ends on SIGTERM. */
static void close_reader(iso_volume_source *source)
{
    child *r = source->reader;
    if (r && r->process.output >= 0)
        close(r->process.output);
    if (r && r->process.pid > 0) {
        kill(r->process.pid, SIGTERM);
        end_program(r);
    }
    free(r);
    source->reader = NULL;
}

/* Finds the mm per unit of each world axis. If units differ, the notes keep the first one. */
static iso_status take_units(iso_volume_source *source, const iso_child_header *h, double mm[3], iso_error *err)
{
    for (int r = 2; r >= 0; --r)
        NEED(iso_source_unit(source, h->unit[r], "mm", &mm[r], err));
    return ISO_OK;
}

/* Returns the names of a label map's segments; NULL if there are none. */
static json_t *list_segments(const iso_child_header *h)
{
    json_t *list = h->is_labels && h->segment[0].name[0] ? json_array() : NULL;
    for (size_t s = 0; list && s < ISO_CHILD_SEGMENTS && h->segment[s].name[0]; ++s)
        json_array_append_new(list, json_pack("{s:i, s:o}", "label", (int)h->segment[s].label, "name",
                                              iso_segments_text(h->segment[s].name)));
    return list;
}

static void take_geometry(const iso_child_header *h, const double mm[3], iso_volume *header)
{
    iso_geometry *g = &header->geometry;
    const double turned = h->world == ISO_CHILD_LPS ? -1 : 1, sign[3] = {turned * mm[0], turned * mm[1], mm[2]};
    *g = iso_geometry_axis_aligned(h->size, (double[]){1, 1, 1});
    for (int a = 0; a < 3; ++a) {
        for (int r = 0; r < 3; ++r)
            g->index_to_world.m[r][a] = sign[r] * h->step[a][r];
        if (h->box[a] > 0)
            g->box_index[a] = h->box[a];
    }
    const iso_vec3 half = iso_mul(g->index_to_world, iso_v3(0.5, 0.5, 0.5));
    const iso_vec3 first = iso_v3(sign[0] * h->first[0], sign[1] * h->first[1], sign[2] * h->first[2]);
    g->origin_mm = iso_v3(0, 0, 0);
    g->origin_mm = h->world == ISO_CHILD_CENTERED ? iso_scale(iso_geometry_box_center_mm(g), -1) : iso_sub(first, half);
    header->type = h->type;
    header->notes.world_is_ras = h->world == ISO_CHILD_LPS || h->world == ISO_CHILD_RAS;
    header->notes.says_labels = h->is_labels;
    header->segments = list_segments(h);
    header->notes.scale_slope = h->slope;
    header->notes.scale_intercept = h->intercept;
    iso_words_copy_line(h->value_unit, header->notes.value_unit, sizeof header->notes.value_unit);
}

static iso_status start_reader(iso_volume_source *source, const iso_child_program *p, const char *part, iso_error *err)
{
    char frame[24], channel[24], uneven[24];
    FREED char *program = iso_helper_find(p->name);
    child *r = malloc(sizeof *r);
    source->reader = r;
    source->read_planes = read_planes;
    source->close_reader = close_reader;
    if (r)
        *r = (child){.program = p, .process.output = -1};
    snprintf(frame, sizeof frame, "%zu", source->choice.frame);
    snprintf(channel, sizeof channel, "%zu", source->choice.channel);
    snprintf(uneven, sizeof uneven, "%d", (int)source->hints.uneven);
    const char *const words[] = {program, source->path, part ? part : "", frame, channel, uneven, NULL};
    return !r         ? iso_fail(err, ISO_E_MEMORY, "%s: out of memory", source->path)
           : !program ? iso_fail(err, ISO_E_MISSING,
                                 "%s: files of this kind are read by %s, which is missing; install %s of "
                                 "Debian, and build again",
                                 source->path, p->name, p->package)
                      : iso_child_start(&r->process, words, err);
}

static iso_status read_header(iso_volume_source *source, const iso_child_program *p, const char *part,
                              iso_child_header *h, iso_error *err)
{
    NEED(start_reader(source, p, part, err));
    NEED(get(source, h, sizeof *h, err));
    child_end_texts(h);
    if (strcmp(h->version, ISO_VERSION) != 0)
        return iso_fail(err, ISO_E_MISSING, "%s is of version %s, isoshade of " ISO_VERSION, p->name, h->version);
    NEED(child_check_answer(&h->answer, source->path, p->library, err));
    return child_check_header(h, source->path, p->library, err);
}

/* Chooses frame and channel. The program gives one of each: it is started again unless these are the first ones. */
static iso_status choose(iso_volume_source *source, const iso_child_program *p, const char *part, iso_child_header *h,
                         iso_error *err)
{
    iso_extra_axes axes = {.frame = {h->frames, false, 1}, .channel = {h->channels, false, h->frames ? h->frames : 1}};
    axes.frame_step = isfinite(h->frame_step) ? h->frame_step : 0; /* 0: not given */
    snprintf(axes.frame_unit, sizeof axes.frame_unit, "%s", h->frame_unit);
    axes.is_color = axes.gives_luminance = h->is_color;
    for (size_t c = 0; c < ISO_NAMED_CHANNELS && c < h->channels; ++c)
        snprintf(axes.channel_name[c], sizeof axes.channel_name[c], "%s", h->channel_name[c]);
    iso_status status = iso_source_choose(source, &axes, err);
    source->choice.volume_count = source->choice.inside_count = 1;
    source->choice.volume_at = source->choice.inside_at = 0;
    if (source->choice.luminance)
        source->choice.channel = h->channels;
    source->choice.luminance = false; /* the program weighs the colors */
    if (status != ISO_OK || (source->choice.frame == 0 && source->choice.channel == 0))
        return status;
    close_reader(source);
    return read_header(source, p, part, h, err);
}

/* Prints the header's warning as one line. It may contain any bytes, such as names from the file. */
static void warn(const iso_child_header *h)
{
    char text[sizeof h->warning];
    iso_words_copy_line(h->warning, text, sizeof text);
    if (text[0])
        iso_warn(text);
}

iso_status iso_child_open(iso_volume_source *source, const iso_child_program *program, const char *part, iso_error *err)
{
    iso_child_header h;
    double mm[3];
    NEED(read_header(source, program, part, &h, err));
    NEED(choose(source, program, part, &h, err));
    if (h.unspaced[0])
        NEED(iso_source_need_spacing(source, h.unspaced, err));
    NEED(take_units(source, &h, mm, err));
    take_geometry(&h, mm, &source->header);
    warn(&h);
    if (h.is_whole)
        iso_source_set_form(source, ISO_FORM_WHOLE);
    for (size_t f = 0; f < h.fill_count && f < sizeof h.fill / sizeof *h.fill; ++f)
        iso_source_note_fill(source, h.fill[f]);
    return iso_source_check_geometry(source, err);
}
