/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <ctype.h>
#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/parallel.h"
#include "base/process.h"
#include "povray/povray_files.h"

typedef struct version_search {
    char *version;
    size_t size;
} version_search;

/* Parses "POV-Ray 3.7.0.10.unofficial", "POV-Ray 3.8.0-alpha.unofficial". */
static void take_version(void *user, const char *line)
{
    version_search *search = user;
    static const char prefix[] = "POV-Ray ";
    if (search->version[0] || strncmp(line, prefix, sizeof prefix - 1) != 0 ||
        !isdigit((unsigned char)line[sizeof prefix - 1]))
        return;
    static const char unofficial[] = ".unofficial"; /* all builds except the POV-Ray team's */
    const char *number = line + sizeof prefix - 1;
    size_t length = strcspn(number, " \r");
    if (length > strlen(unofficial) &&
        strncmp(number + length - strlen(unofficial), unofficial, strlen(unofficial)) == 0)
        length -= strlen(unofficial);
    snprintf(search->version, search->size, "%.*s", (int)length, number);
}

iso_status iso_povray_version(char *version, size_t size, iso_error *err)
{
    FREED char *program = NULL;
    version[0] = 0;
    NEED(iso_process_find("povray", "povray", &program, err));
    version_search search = {version, size};
    const char *argv[] = {program, "--version", NULL};
    const iso_process_options options = {.line = take_version, .user = &search, .timeout_seconds = 600};
    NEED(iso_process_run(argv, &options, err));
    return !version[0] ? iso_fail(err, ISO_E_PROGRAM, "%s: --version names no version of POV-Ray", program) : ISO_OK;
}

/* ---- starting it ---- */

typedef struct patient_start {
    const iso_process_options *options;
    bool did_not_start;
} patient_start;

static void watch_start(void *user, const char *line)
{
    patient_start *start = user;
    if (strstr(line, "Timed out waiting for worker thread startup"))
        start->did_not_start = true;
    if (start->options->line)
        start->options->line(start->options->user, line);
}

/* True unless a signal or the time limit ended it. */
static bool may_start_again(const iso_process_outcome *outcome)
{
    return !outcome->timed_out && !iso_process_was_stopped();
}

iso_status iso_povray_run_program(const char *const argv[], const iso_process_options *options, iso_error *err)
{
    enum { TRIES = 5 };
    patient_start start = {.options = options};
    iso_process_options own = *options;
    iso_process_outcome outcome = {0};
    iso_status status = ISO_E_PROGRAM;
    bool again = true;
    own.line = watch_start;
    own.user = &start;
    own.outcome = options->outcome ? options->outcome : &outcome;
    for (int i = 0; i < TRIES && again; ++i) {
        start.did_not_start = false;
        status = iso_process_run(argv, &own, err);
        again = status == ISO_E_PROGRAM && start.did_not_start && may_start_again(own.outcome);
    }
    return status;
}

/* A picture of a scene in the folder. */
typedef struct wanted_picture {
    const iso_povray_scene *scene;
    size_t intervals;
} wanted_picture;

/* Pictures of one size, the folder of their scenes, and the program. */
typedef struct render_job {
    const char *program, *dir;
    const wanted_picture *pictures;
    size_t count;
    int threads;
    iso_povray_stats *stats; /* or NULL */
} render_job;

/* One start of POV-Ray renders pictures as frames of an animation, two passes per picture. */
enum { PASSES = 2 };
static const iso_povray_pass passes[PASSES] = {ISO_POVRAY_TRANSMITTANCE, ISO_POVRAY_EMISSION};

/* Progress of a start. */
typedef struct run_progress {
    const iso_progress *progress;
    const double *parts; /* done part of the whole when each frame starts, and at the end */
    size_t frame, frame_count;
    iso_povray_stats *stats; /* or NULL */
    bool after_trace;        /* True if the next line has the time of all threads */
} run_progress;

/* Parses "Rendering frame 2 of 4", "Rendered 1234 of 2304 pixels (53%)", and "  Trace Time:       0 hours  0 minutes  1
 * seconds (1.234 seconds)" followed by "              using 2 thread(s) with 2.345 CPU-seconds total". */
static void take_progress(void *user, const char *line)
{
    run_progress *run = user;
    size_t done, total, threads;
    if (sscanf(line, "Rendering frame %zu of %zu", &done, &total) == 2 && done >= 1 && done <= run->frame_count)
        run->frame = done - 1;
    const char *at = strstr(line, "Rendered ");
    const double from = run->parts[run->frame], to = run->parts[run->frame + 1];
    if (at && sscanf(at, "Rendered %zu of %zu pixels", &done, &total) == 2 && total > 0)
        iso_progress_report(run->progress, "povray: rendering", from + (to - from) * (double)done / (double)total);
    double seconds;
    if (!run->stats)
        return;
    if (run->after_trace && sscanf(line, " using %zu thread(s) with %lf CPU-seconds", &threads, &seconds) == 2)
        run->stats->processor_seconds += seconds;
    run->after_trace = strstr(line, "Trace Time:") != NULL;
    at = run->after_trace ? strchr(line, '(') : NULL;
    if (at && sscanf(at, "(%lf seconds)", &seconds) == 1)
        run->stats->trace_seconds += seconds;
}

/* Writes frames.pov: scene, pass and intervals of each frame. */
static iso_status write_frames(const render_job *job, iso_error *err)
{
    FREED char *path = iso_path_join(job->dir, "frames.pov"), *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (f) {
        fprintf(f, "#version 3.7;\n#switch (frame_number - 1)\n");
        for (size_t i = 0; i < PASSES * job->count; ++i)
            fprintf(
                f, "    #case (%zu) #declare Iso_Pass = %d; #declare Iso_Intervals = %zu; #include \"%s.pov\" #break\n",
                i, (int)passes[i % PASSES], job->pictures[i / PASSES].intervals, job->pictures[i / PASSES].scene->name);
        fprintf(f, "#end\n");
    }
    const bool whole = f && fclose(f) == 0 && path;
    return whole ? iso_file_write(path, text, size, err) : iso_povray_no_memory(err);
}

/* Returns the path of a pass's picture, to be freed. POV-Ray pads frame numbers to the width of the last one. */
static char *pass_path(const render_job *job, size_t frame)
{
    char name[64];
    int digits = 1;
    for (size_t n = PASSES * job->count; n >= 10; n /= 10)
        ++digits;
    snprintf(name, sizeof name, "pass%0*zu.ppm", digits, frame + 1);
    return iso_path_join(job->dir, name);
}

/* Loads the picture of a frame. ISO_E_PROGRAM: it is missing or broken; ISO_E_IO: it cannot be read. */
static iso_status load_pass(const render_job *job, size_t frame, iso_image *image, iso_error *err)
{
    const iso_view *view = job->pictures[frame / PASSES].scene->view;
    iso_error why = {""};
    FREED char *path = pass_path(job, frame);
    if (!path)
        return iso_povray_no_memory(err);
    const iso_status status = iso_path_is_file(path) ? iso_image_load_ppm(path, image, &why)
                                                     : iso_fail(&why, ISO_E_PROGRAM, "it wrote no picture");
    if (status == ISO_E_MEMORY || status == ISO_E_IO)
        return iso_fail(err, status, "%s", why.text);
    if (status != ISO_OK)
        return iso_fail(err, ISO_E_PROGRAM, "povray: %s", why.text);
    if (image->width == view->width && image->height == view->height)
        return ISO_OK;
    iso_fail(err, ISO_E_PROGRAM, "povray: the image has %zu x %zu pixels instead of %zu x %zu", image->width,
             image->height, view->width, view->height);
    iso_image_destroy(image);
    return ISO_E_PROGRAM;
}

/* Renders frames [first, first + count). */
static iso_status run_povray(const render_job *job, size_t first, size_t count, run_progress *run, iso_error *err)
{
    const iso_view *view = job->pictures[0].scene->view;
    char width[32], height[32], threads[48], last[48], begin[48], end[48];
    snprintf(width, sizeof width, "Width=%zu", view->width);
    snprintf(height, sizeof height, "Height=%zu", view->height);
    snprintf(threads, sizeof threads, "Work_Threads=%d", iso_threads(job->threads));
    snprintf(last, sizeof last, "Final_Frame=%zu", run->frame_count);
    snprintf(begin, sizeof begin, "Subset_Start_Frame=%zu", first + 1);
    snprintf(end, sizeof end, "Subset_End_Frame=%zu", first + count);
    const char *argv[] = {job->program,
                          "Input_File_Name=frames.pov",
                          "Output_File_Name=pass.ppm",
                          "Output_File_Type=P",
                          "Bits_Per_Color=16",
                          "File_Gamma=1.0",
                          "Dither=Off",
                          "Antialias=Off",
                          "Display=Off",
                          "Pause_When_Done=Off",
                          "Verbose=On",
                          width,
                          height,
                          threads,
                          "Initial_Frame=1",
                          last,
                          begin,
                          end,
                          NULL};
    const iso_process_options options = {.directory = job->dir,
                                         .sandbox = {.private_home = true},
                                         .line = take_progress,
                                         .user = run};
    return iso_povray_run_program(argv, &options, err);
}

/* Composes emission and transmittance to premultiplied color over the background, and alpha. */
static void compose(iso_image *emission, const iso_image *transmittance, const iso_view *view, double peak)
{
    for (size_t i = 0; i < emission->width * emission->height; ++i) {
        float *to = emission->rgba + 4 * i;
        const double through = (double)transmittance->rgba[4 * i];
        for (int c = 0; c < 3; ++c)
            to[c] = (float)((double)to[c] * peak + through * view->background[c]);
        to[3] = (float)(1 - through);
    }
}

/* Loads both passes of a picture. */
static iso_status load_picture(const render_job *job, size_t i, iso_image *image, iso_error *err)
{
    const iso_povray_scene *scene = job->pictures[i].scene;
    OWNED(iso_image) transmittance = {0};
    NEED(load_pass(job, PASSES * i, &transmittance, err));
    NEED(load_pass(job, PASSES * i + 1, image, err));
    compose(image, &transmittance, scene->view, scene->peak);
    return ISO_OK;
}

/* Renders pictures with one start; all or none. */
static iso_status render_pictures(const render_job *job, const iso_progress *progress, iso_image *images,
                                  iso_error *err)
{
    double parts[PASSES * ISO_POVRAY_MAX_PICTURES + 1] = {0};
    const double part_of_pass[PASSES] = {0.3, 0.7};
    const size_t frame_count = PASSES * job->count;
    double all = 0;
    for (size_t i = 0; i < job->count; ++i)
        all += (double)job->pictures[i].intervals;
    for (size_t i = 0; i < frame_count; ++i)
        parts[i + 1] = parts[i] + part_of_pass[i % PASSES] * (double)job->pictures[i / PASSES].intervals / all;
    run_progress run = {.progress = progress, .parts = parts, .frame_count = frame_count, .stats = job->stats};
    iso_progress_report(progress, "povray: rendering", 0);
    iso_status status = write_frames(job, err);
    const size_t step = getenv(ISO_POVRAY_APART) ? 1 : frame_count;
    for (size_t first = 0; first < frame_count && status == ISO_OK; first += step)
        status = run_povray(job, first, step, &run, err);
    for (size_t i = 0; i < job->count && status == ISO_OK; ++i)
        status = load_picture(job, i, &images[i], err);
    for (size_t i = 0; i < job->count && status != ISO_OK; ++i)
        iso_image_destroy(&images[i]);
    if (status == ISO_OK)
        iso_progress_report(progress, "povray: rendering", 1);
    return status;
}

/* Extrapolates the error of n intervals, of order 1 / n^2, to 0: image += (image - coarse) / ((n / m)^2 - 1). */
static void extrapolate(iso_image *image, const iso_image *coarse, size_t n, size_t m)
{
    const double ratio = (double)n / (double)m, factor = 1 / (ratio * ratio - 1);
    for (size_t i = 0; i < 4 * image->width * image->height; ++i)
        image->rgba[i] += (float)(((double)image->rgba[i] - (double)coarse->rgba[i]) * factor);
}

double iso_povray_df3_bytes(const char *folder)
{
    double sum = 0;
    DIR *dir = opendir(folder);
    for (struct dirent *e = dir ? readdir(dir) : NULL; e; e = readdir(dir)) {
        FREED char *path = iso_path_join(folder, e->d_name);
        struct stat about;
        if (path && iso_path_ends_with(path, ".df3") && stat(path, &about) == 0)
            sum += (double)about.st_size;
    }
    if (dir)
        closedir(dir);
    return sum;
}

/* Scenes in a folder of their own. */
typedef struct prepared_scenes {
    char *dir;
    iso_povray_prepared *scenes;
    char (*names)[32];
    size_t count;
} prepared_scenes;

static void release_scenes(prepared_scenes *s)
{
    if (s->dir)
        iso_remove_tree(s->dir);
    for (size_t i = 0; i < s->count; ++i)
        iso_povray_release(&s->scenes[i]);
    free(s->scenes);
    free(s->names);
    free(s->dir);
}

static iso_status prepare_scenes(const iso_povray_wanted *wanted, size_t count, const iso_progress *progress,
                                 prepared_scenes *s, iso_error *err)
{
    *s = (prepared_scenes){.scenes = calloc(count, sizeof *s->scenes), .names = calloc(count, sizeof *s->names)};
    if (!s->scenes || !s->names)
        return iso_povray_no_memory(err);
    if (!(s->dir = iso_make_temp_dir()))
        return iso_temp_dir_fail(err);
    for (size_t i = 0; i < count; ++i) {
        const iso_povray_wanted *w = &wanted[i];
        snprintf(s->names[i], sizeof s->names[i], "scene%zu", i);
        NEED(iso_povray_check(w->pyramid, w->level, w->view, w->options, err));
        NEED(iso_povray_prepare(w->pyramid, w->level, w->view, s->names[i], w->options, &s->scenes[i], err));
        ++s->count;
        NEED(iso_povray_write_files(&s->scenes[i], s->dir, progress, err));
    }
    return ISO_OK;
}

/* Renders pictures of prepared scenes. */
static iso_status render_prepared(const prepared_scenes *s, const wanted_picture *pictures, size_t count,
                                  const iso_progress *progress, iso_image *images, iso_error *err)
{
    const iso_povray_options *opt = pictures[0].scene->options;
    FREED char *program = NULL;
    NEED(iso_process_find("povray", "povray", &program, err));
    if (opt->stats)
        *opt->stats = (iso_povray_stats){.df3_bytes = iso_povray_df3_bytes(s->dir)};
    return render_pictures(&(render_job){program, s->dir, pictures, count, opt->threads, opt->stats}, progress, images,
                           err);
}

iso_status iso_povray_render_several(const iso_pyramid *p, size_t level, const iso_view *view,
                                     const iso_povray_options *opt, const iso_povray_pictures *wanted,
                                     const iso_progress *progress, iso_error *err)
{
    wanted_picture pictures[ISO_POVRAY_MAX_PICTURES];
    prepared_scenes s = {0};
    memset(wanted->images, 0, wanted->count * sizeof *wanted->images);
    if (wanted->count < 1 || wanted->count > ISO_POVRAY_MAX_PICTURES)
        return iso_fail(err, ISO_E_RANGE, "povray: %zu pictures of one start, must be 1 to %d", wanted->count,
                        ISO_POVRAY_MAX_PICTURES);
    iso_status status = prepare_scenes(&(iso_povray_wanted){p, level, view, opt}, 1, progress, &s, err);
    for (size_t i = 0; i < wanted->count && status == ISO_OK; ++i)
        pictures[i] = (wanted_picture){&s.scenes[0].scene, wanted->intervals[i]};
    TRY(status, render_prepared(&s, pictures, wanted->count, progress, wanted->images, err));
    release_scenes(&s);
    return status;
}

static bool is_of_two(const iso_povray_options *opt)
{
    return opt->extrapolate && !opt->isosurface;
}

iso_status iso_povray_render_scenes(const iso_povray_wanted *wanted, size_t count, iso_image *images,
                                    const iso_progress *progress, iso_error *err)
{
    wanted_picture pictures[ISO_POVRAY_MAX_PICTURES];
    iso_image drawn[ISO_POVRAY_MAX_PICTURES] = {{0}};
    prepared_scenes s = {0};
    size_t n = 0, next = 0;
    memset(images, 0, count * sizeof *images);
    if (count < 1 || count > ISO_POVRAY_MAX_PICTURES / 2)
        return iso_fail(err, ISO_E_RANGE, "povray: %zu scenes of one start, must be 1 to %d", count,
                        ISO_POVRAY_MAX_PICTURES / 2);
    iso_status status = prepare_scenes(wanted, count, progress, &s, err);
    for (size_t i = 0; i < count && status == ISO_OK; ++i) {
        const iso_povray_scene *scene = &s.scenes[i].scene;
        if (scene->view->width != wanted[0].view->width || scene->view->height != wanted[0].view->height)
            status = iso_fail(err, ISO_E_RANGE, "povray: pictures of one start have one size");
        pictures[n++] = (wanted_picture){scene, scene->options->intervals};
        if (is_of_two(scene->options))
            pictures[n++] = (wanted_picture){scene, scene->options->intervals / 2};
    }
    TRY(status, render_prepared(&s, pictures, n, progress, drawn, err));
    for (size_t i = 0; i < count && status == ISO_OK; ++i) {
        const iso_povray_options *opt = wanted[i].options;
        images[i] = drawn[next++];
        if (is_of_two(opt)) {
            extrapolate(&images[i], &drawn[next], opt->intervals, opt->intervals / 2);
            iso_image_destroy(&drawn[next++]);
        }
    }
    release_scenes(&s);
    return status;
}

iso_status iso_povray_render(const iso_pyramid *p, size_t level, const iso_view *view, const iso_povray_options *opt,
                             iso_image *image, const iso_progress *progress, iso_error *err)
{
    return iso_povray_render_scenes(&(iso_povray_wanted){p, level, view, opt}, 1, image, progress, err);
}
