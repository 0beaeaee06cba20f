/* SPDX-License-Identifier: MIT */
/* The volume from all sides: frames on a page, as an animation, and as files. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "figure/animation.h"
#include "figure/columns.h"
#include "figure/kinds_of_volume.h"
#include "figure/picture.h"
#include "renderers/picture_store.h"

enum { USUAL_FRAMES = 8, SHOWN_OF_MANY = 32 };

typedef struct turned {
    iso_figure_subject subject;
    const iso_renderer_info *with;
    size_t frames, level, shown; /* total frames; number of frames on the page */
    const char *dir;             /* of the frames' files */
    iso_animation *animation;
} turned;

static iso_status save_frame(const turned *t, size_t frame, const iso_image *image, iso_error *err)
{
    char name[32];
    snprintf(name, sizeof name, "%03zu.png", frame);
    char *path = iso_path_join(t->dir, name);
    const iso_status status = path ? iso_image_save_png(image, path, 1, err)
                                   : iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
    free(path);
    return status;
}

static iso_status draw_frame(turned *t, size_t frame, size_t width, size_t height, iso_image *image,
                             double *mm_per_pixel, iso_error *err)
{
    const iso_figure_picture what = {.with = t->with,
                                     .level = t->level,
                                     .width = width,
                                     .height = height,
                                     .turn_deg = 360.0 * (double)frame / (double)t->frames,
                                     .turns = t->frames};
    return iso_figure_render(&t->subject, &what, image, mm_per_pixel, err);
}

static iso_status render_frame(turned *t, size_t frame, size_t width, size_t height, iso_image *image,
                               double *mm_per_pixel, iso_error *err)
{
    iso_status status = draw_frame(t, frame, width, height, image, mm_per_pixel, err);
    TRY(status, iso_animation_add(t->animation, image, err));
    return status == ISO_OK ? save_frame(t, frame, image, err) : status;
}

/* Draws the frames for rank 0, from the end of this rank's share backwards: so it meets the rank before it. */
static iso_status draw_as_other_rank(turned *t, size_t width, size_t height, iso_error *err)
{
    const size_t end = iso_picture_store_share(t->subject.renderers.store, t->frames).end;
    iso_status status = ISO_OK;
    for (size_t i = t->frames; i > 0 && status == ISO_OK; --i) {
        iso_image image = {0};
        status = draw_frame(t, (end + i - 1) % t->frames, width, height, &image, NULL, err);
        iso_image_destroy(&image);
    }
    if (status == ISO_OK)
        t->subject.job->end_rank();
    return status;
}

static size_t frame_of(const turned *t, size_t column)
{
    return column * t->frames / t->shown;
}

/* Renders a frame of the page, and the following ones up to the next on the page. */
static iso_status render(void *user, size_t column, size_t width, size_t height, iso_image *image, double *mm_per_pixel,
                         iso_error *err)
{
    turned *t = user;
    const size_t first = frame_of(t, column), end = frame_of(t, column + 1);
    if (t->subject.job->end_rank)
        return draw_as_other_rank(t, width, height, err);
    iso_status status = render_frame(t, first, width, height, image, mm_per_pixel, err);
    for (size_t i = first + 1; i < end && status == ISO_OK; ++i) {
        iso_image between = {0};
        double unused;
        status = render_frame(t, i, width, height, &between, &unused, err);
        iso_image_destroy(&between);
    }
    return status;
}

/* Chooses 2 to 8 frames per row, few enough for a scale bar and its text in each, with full rows if possible. */
static size_t choose_row(size_t frames, double width_mm)
{
    const double least_mm = 24;
    size_t best = frames > 32 ? 8 : frames < 4 ? frames : width_mm < 2 * least_mm ? 2 : 4;
    for (size_t n = 3; n <= 8 && n <= frames; ++n)
        if (frames % n == 0 && (n == 3 || width_mm / (double)n >= least_mm))
            best = n;
    return best;
}

static iso_status make_folder(const char *dir, iso_error *err)
{
    return mkdir(dir, 0777) == 0 ? ISO_OK : iso_fail(err, ISO_E_IO, "%s: %s", dir, strerror(errno));
}

static void write_caption(const turned *t, FILE *f)
{
    fputs("Turns", f);
    iso_figure_put_subject(&t->subject, f);
    fprintf(f, " around the camera's up axis, level %zu", t->level);
    if (t->shown < t->frames)
        fprintf(f, ", %zu of %zu frames", t->shown, t->frames);
}

static iso_status draw_frames(turned *t, const iso_figure_job *job, iso_page *page, iso_error *err)
{
    iso_figure_columns c = {.job = job, .count = t->shown, .render = render, .user = t};
    c.per_row = choose_row(c.count, job->width_mm);
    for (size_t i = 0; i < c.count; ++i)
        snprintf(c.titles[i], sizeof c.titles[i], "%.4g°", 360.0 * (double)frame_of(t, i) / (double)t->frames);
    NEED(iso_figure_subject_load(&t->subject, job, t->level + 1, NULL, err));
    write_caption(t, iso_page_caption(page));
    c.drawn_by = &t->subject.drawn_by;
    c.tf = iso_figure_tf_foot_of(&t->subject);
    c.aspect = iso_figure_aspect(&t->subject);
    iso_status status = iso_figure_draw_columns(&c, page, err);
    if (status == ISO_OK)
        fputs(" turntable.png is an animation of all, 10 per second; frames/ has each as a file.",
              iso_page_caption(page));
    return status;
}

static iso_status draw_turntable(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    char *path = iso_page_file(page, "turntable.png"), *dir = iso_page_file(page, "frames");
    turned t = {.frames = job->frames ? (size_t)job->frames : USUAL_FRAMES, .level = (size_t)job->level, .dir = dir};
    t.shown = t.frames > ISO_FIGURE_MOST_COLUMNS ? (size_t)SHOWN_OF_MANY : t.frames;
    iso_status status = path && dir ? iso_figure_renderer(job, &t.with, err)
                                    : iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
    TRY(status, make_folder(dir, err));
    TRY(status, iso_animation_create(&t.animation, path, t.frames, 0.1, err));
    TRY(status, draw_frames(&t, job, page, err));
    TRY(status, iso_animation_finish(t.animation, err));
    if (job->store)
        json_object_set_new(job->facts, "frames_of_other_ranks",
                            json_integer((json_int_t)iso_picture_store_taken(job->store)));
    iso_animation_destroy(t.animation);
    iso_figure_subject_end(&t.subject);
    free(path);
    free(dir);
    return status;
}

const iso_figure_info iso_figure_turntable = {
    .name = "turntable",
    .summary = "the volume from all sides: frames side by side, as animation turntable.png, and as files",
    .takes = ISO_FIGURE_OF_VOLUME | ISO_FIGURE_HAS_LOOK | ISO_FIGURE_HAS_WITH | ISO_FIGURE_HAS_LEVEL |
             ISO_FIGURE_HAS_ADAPT | ISO_FIGURE_HAS_FRAMES | ISO_FIGURE_HAS_RANKS,
    .draw = draw_turntable,
};
