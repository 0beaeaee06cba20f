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

static iso_status find_povray(char **path, iso_error *err)
{
    return iso_process_find("povray", "povray", path, err);
}

typedef struct version_search {
    char *version;
    size_t size;
} version_search;

/* "POV-Ray 3.7.0.10.unofficial", "POV-Ray 3.8.0-alpha.unofficial" */
static void take_version(void *user, const char *line)
{
    version_search *search = user;
    static const char prefix[] = "POV-Ray ";
    if (search->version[0] || strncmp(line, prefix, sizeof prefix - 1) != 0 ||
        !isdigit((unsigned char)line[sizeof prefix - 1]))
        return;
    static const char unofficial[] = ".unofficial"; /* all builds but the team's own */
    const char *number = line + sizeof prefix - 1;
    size_t length = strcspn(number, " \r");
    if (length > strlen(unofficial) && strncmp(number + length - strlen(unofficial), unofficial, strlen(unofficial)) == 0)
        length -= strlen(unofficial);
    snprintf(search->version, search->size, "%.*s", (int)length, number);
}

iso_status iso_povray_version(char *version, size_t size, iso_error *err)
{
    char *program = NULL;
    version[0] = 0;
    iso_status status = find_povray(&program, err);
    if (status != ISO_OK)
        return status;
    version_search search = {version, size};
    const char *argv[] = {program, "--version", NULL};
    const iso_process_options options = {.line = take_version, .user = &search, .timeout_seconds = 600};
    status = iso_process_run(argv, &options, err);
    if (status == ISO_OK && !version[0])
        status = iso_fail(err, ISO_E_PROGRAM, "%s: --version names no version of POV-Ray", program);
    free(program);
    return status;
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

iso_status iso_povray_run_program(const char *const argv[], const iso_process_options *options, iso_error *err)
{
    enum { TRIES = 5 };
    patient_start start = {.options = options};
    iso_process_options own = *options;
    iso_status status = ISO_E_PROGRAM;
    own.line = watch_start;
    own.user = &start;
    for (int i = 0; i < TRIES && status == ISO_E_PROGRAM && (i == 0 || start.did_not_start); ++i) {
        start.did_not_start = false;
        status = iso_process_run(argv, &own, err);
    }
    return status;
}

/* A scene that stands in a folder, and the program. */
typedef struct render_job {
    const char *program, *dir;
    const iso_povray_scene *scene;
} render_job;

/* One start of POV-Ray draws pictures as the frames of an animation: two passes for each number of intervals. */
enum { PASSES = 2 };
static const iso_povray_pass passes[PASSES] = {ISO_POVRAY_TRANSMITTANCE, ISO_POVRAY_EMISSION};

/* The progress of a start. */
typedef struct run_progress {
    const iso_progress *progress;
    const double *parts; /* of the whole that are done when a frame begins; one more at the end */
    size_t frame, frame_count;
    iso_povray_stats *stats; /* or NULL */
    bool after_trace;        /* the next line says how long all threads took */
} run_progress;

/* "Rendering frame 2 of 4", "Rendered 1234 of 2304 pixels (53%)", and "  Trace Time:       0 hours  0 minutes  1 seconds
 * (1.234 seconds)" followed by "              using 2 thread(s) with 2.345 CPU-seconds total" */
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

/* frames.pov: the scene with the pass and the intervals of each frame. */
static iso_status write_frames(const render_job *job, const size_t *intervals, size_t count, iso_error *err)
{
    char *path = iso_path_join(job->dir, "frames.pov"), *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (f) {
        fprintf(f, "#version 3.7;\n#declare Iso_Frames = array[%zu][2] {\n", PASSES * count);
        for (size_t i = 0; i < PASSES * count; ++i)
            fprintf(f, "    { %d, %zu }%s\n", (int)passes[i % PASSES], intervals[i / PASSES],
                    i + 1 < PASSES * count ? "," : "");
        fprintf(f, "}\n"
                   "#declare Iso_Pass = Iso_Frames[frame_number - 1][0];\n"
                   "#declare Iso_Intervals = Iso_Frames[frame_number - 1][1];\n"
                   "#include \"scene.pov\"\n");
    }
    const bool whole = f && fclose(f) == 0 && path;
    iso_status status = whole ? iso_file_write(path, text, size, err) : iso_povray_no_memory(err);
    free(text);
    free(path);
    return status;
}

/* POV-Ray writes as many digits as the last frame's number has. */
static char *pass_path(const render_job *job, size_t frame, size_t frame_count)
{
    char name[64];
    int digits = 1;
    for (size_t n = frame_count; n >= 10; n /= 10)
        ++digits;
    snprintf(name, sizeof name, "pass%0*zu.ppm", digits, frame + 1);
    return iso_path_join(job->dir, name);
}

/* The picture that a frame has left. Without one, or with a broken one, it is the program that failed. */
static iso_status load_pass(const render_job *job, size_t frame, size_t frame_count, iso_image *image, iso_error *err)
{
    const iso_view *view = job->scene->view;
    iso_error why = {""};
    char *path = pass_path(job, frame, frame_count);
    if (!path)
        return iso_povray_no_memory(err);
    const iso_status status = iso_path_exists(path) ? iso_image_load_ppm(path, image, &why)
                                                    : iso_fail(&why, ISO_E_IO, "it left no picture");
    free(path);
    if (status == ISO_E_MEMORY)
        return iso_fail(err, status, "%s", why.text);
    if (status != ISO_OK)
        return iso_fail(err, ISO_E_PROGRAM, "povray: %s", why.text);
    if (image->width == view->width && image->height == view->height)
        return ISO_OK;
    iso_fail(err, ISO_E_PROGRAM, "povray: the image has %zu x %zu pixels, wanted %zu x %zu", image->width,
             image->height, view->width, view->height);
    iso_image_destroy(image);
    return ISO_E_PROGRAM;
}

/* Frames [first, first + count) of them. */
static iso_status run_povray(const render_job *job, size_t first, size_t count, run_progress *run, iso_error *err)
{
    const iso_view *view = job->scene->view;
    char width[32], height[32], threads[48], last[48], begin[48], end[48];
    snprintf(width, sizeof width, "Width=%zu", view->width);
    snprintf(height, sizeof height, "Height=%zu", view->height);
    snprintf(threads, sizeof threads, "Work_Threads=%d", iso_threads(job->scene->options->threads));
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
    const iso_process_options options = {.directory = job->dir, .line = take_progress, .user = run};
    return iso_povray_run_program(argv, &options, err);
}

/* Emission and transmittance to premultiplied colour over the background, and alpha. */
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

/* What both passes of a number of intervals have left. */
static iso_status load_picture(const render_job *job, size_t i, size_t count, iso_image *image, iso_error *err)
{
    iso_image transmittance = {0};
    iso_status status = load_pass(job, PASSES * i, PASSES * count, &transmittance, err);
    if (status == ISO_OK)
        status = load_pass(job, PASSES * i + 1, PASSES * count, image, err);
    if (status == ISO_OK)
        compose(image, &transmittance, job->scene->view, job->scene->peak);
    iso_image_destroy(&transmittance);
    return status;
}

enum { MOST_PICTURES = 16 }; /* of a start */

/* A picture for each number of intervals, by one start; all or none. */
static iso_status render_pictures(const render_job *job, const size_t *intervals, size_t count,
                                  const iso_progress *progress, iso_image *images, iso_error *err)
{
    double parts[PASSES * MOST_PICTURES + 1] = {0};
    const double part_of_pass[PASSES] = {0.3, 0.7};
    double all = 0;
    for (size_t i = 0; i < count; ++i)
        all += (double)intervals[i];
    for (size_t i = 0; i < PASSES * count; ++i)
        parts[i + 1] = parts[i] + part_of_pass[i % PASSES] * (double)intervals[i / PASSES] / all;
    run_progress run = {.progress = progress,
                        .parts = parts,
                        .frame_count = PASSES * count,
                        .stats = job->scene->options->stats};
    iso_progress_report(progress, "povray: rendering", 0);
    iso_status status = write_frames(job, intervals, count, err);
    const size_t step = getenv(ISO_POVRAY_APART) ? 1 : PASSES * count;
    for (size_t first = 0; first < PASSES * count && status == ISO_OK; first += step)
        status = run_povray(job, first, step, &run, err);
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        status = load_picture(job, i, count, &images[i], err);
    for (size_t i = 0; i < count && status != ISO_OK; ++i)
        iso_image_destroy(&images[i]);
    if (status == ISO_OK)
        iso_progress_report(progress, "povray: rendering", 1);
    return status;
}

/* The error of n intervals is of order 1 / n^2: image += (image - coarse) / ((n / m)^2 - 1). */
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
        char *path = iso_path_join(folder, e->d_name);
        struct stat about;
        if (path && iso_path_ends_with(path, ".df3") && stat(path, &about) == 0)
            sum += (double)about.st_size;
        free(path);
    }
    if (dir)
        closedir(dir);
    return sum;
}

iso_status iso_povray_render_several(const iso_pyramid *p, size_t level, const iso_view *view,
                                     const iso_povray_options *opt, const iso_povray_pictures *wanted,
                                     const iso_progress *progress, iso_error *err)
{
    memset(wanted->images, 0, wanted->count * sizeof *wanted->images);
    char *program = NULL, *dir = NULL;
    iso_status status = iso_povray_check(p, level, view, opt, err);
    if (status == ISO_OK && (wanted->count < 1 || wanted->count > MOST_PICTURES))
        status = iso_fail(err, ISO_E_RANGE, "povray: %zu pictures of one start, must be 1 to %d", wanted->count,
                          MOST_PICTURES);
    if (status == ISO_OK)
        status = find_povray(&program, err);
    if (status == ISO_OK && !(dir = iso_make_temp_dir()))
        status = iso_fail(err, ISO_E_IO, "povray: no temporary folder can be made");
    iso_povray_prepared s = {0};
    if (status == ISO_OK)
        status = iso_povray_prepare(p, level, view, "scene", opt, &s, err);
    if (status == ISO_OK)
        status = iso_povray_write_files(&s, dir, progress, err);
    if (status == ISO_OK && opt->stats)
        *opt->stats = (iso_povray_stats){.df3_bytes = iso_povray_df3_bytes(dir)};
    if (status == ISO_OK)
        status = render_pictures(&(render_job){program, dir, &s.scene}, wanted->intervals, wanted->count, progress,
                                 wanted->images, err);
    if (dir)
        iso_remove_tree(dir);
    iso_povray_release(&s);
    free(dir);
    free(program);
    return status;
}

iso_status iso_povray_render(const iso_pyramid *p, size_t level, const iso_view *view, const iso_povray_options *opt,
                             iso_image *image, const iso_progress *progress, iso_error *err)
{
    const size_t n = opt->intervals, both[2] = {n, n / 2}, count = opt->extrapolate && !opt->isosurface ? 2 : 1;
    iso_image images[2] = {{0}, {0}};
    *image = (iso_image){0};
    iso_status status = iso_povray_render_several(p, level, view, opt, &(iso_povray_pictures){both, count, images},
                                                  progress, err);
    if (status == ISO_OK && count == 2)
        extrapolate(&images[0], &images[1], n, n / 2);
    *image = images[0];
    iso_image_destroy(&images[1]);
    return status;
}
