/* SPDX-License-Identifier: MIT */
/* The volume from all sides: frames on a page, and the same as an animation. */
#include <math.h>
#include <stdlib.h>

#include "figure/animation.h"
#include "figure/columns.h"
#include "figure/kinds_of_volume.h"
#include "figure/picture.h"

enum { USUAL_FRAMES = 8 };

typedef struct turned {
    iso_figure_subject subject;
    const iso_renderer_info *with;
    size_t frames, level;
    iso_animation *animation;
} turned;

static iso_status render(void *user, size_t column, size_t width, size_t height, iso_image *image, double *mm_per_pixel,
                         iso_error *err)
{
    turned *t = user;
    const iso_figure_picture what = {.with = t->with,
                                     .level = t->level,
                                     .width = width,
                                     .height = height,
                                     .turn_deg = 360.0 * (double)column / (double)t->frames,
                                     .turns = t->frames};
    iso_status status = iso_figure_render(&t->subject, &what, image, mm_per_pixel, err);
    if (status == ISO_OK)
        status = iso_animation_add(t->animation, image, err);
    return status;
}

/* The least count of rows whose pictures are hardly smaller than those of fewer columns would be. */
static size_t choose_row(size_t frames)
{
    size_t best = frames < 4 ? frames : 4;
    for (size_t n = best; n <= 8 && n <= frames; ++n)
        if (frames % n == 0)
            best = n;
    return frames > 32 ? 8 : best;
}

static iso_status draw_turntable(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    turned t = {.frames = job->frames ? (size_t)job->frames : USUAL_FRAMES, .level = (size_t)job->level};
    iso_figure_columns c = {.job = job, .count = t.frames, .a_row = choose_row(t.frames), .render = render, .user = &t};
    char *path = iso_page_file(page, "turntable.png");
    iso_status status = path ? iso_figure_renderer(job, &t.with, err) : iso_fail(err, ISO_E_MEMORY, "out of memory");
    if (status == ISO_OK && t.frames > ISO_FIGURE_MOST_COLUMNS)
        status = iso_fail(err, ISO_E_RANGE, "--frames is %zu, a page shows %d at most", t.frames,
                          (int)ISO_FIGURE_MOST_COLUMNS);
    if (status == ISO_OK)
        status = iso_figure_subject_load(&t.subject, job, t.level + 1, NULL, err);
    if (status == ISO_OK)
        status = iso_animation_create(&t.animation, path, t.frames, 0.1, err);
    for (size_t i = 0; i < c.count && status == ISO_OK; ++i)
        snprintf(c.titles[i], sizeof c.titles[i], "%.4g°", 360.0 * (double)i / (double)t.frames);
    if (status == ISO_OK) {
        fputs("Turns", iso_page_caption(page));
        iso_figure_put_subject(&t.subject, iso_page_caption(page));
        fprintf(iso_page_caption(page), " round the camera's up axis, level %zu", t.level);
        c.drawn_by = &t.subject.drawn_by;
        c.aspect = iso_figure_aspect(&t.subject);
        status = iso_figure_draw_columns(&c, page, err);
    }
    if (status == ISO_OK) {
        fputs(" turntable.png shows them one after the other, 10 a second.", iso_page_caption(page));
        status = iso_animation_finish(t.animation, err);
    }
    iso_animation_destroy(t.animation);
    iso_figure_subject_end(&t.subject);
    free(path);
    return status;
}

const iso_figure_info iso_figure_turntable = {
    .name = "turntable",
    .summary = "the volume from all sides: frames side by side, and turntable.png, which moves",
    .takes = ISO_FIGURE_OF_VOLUME | ISO_FIGURE_HAS_LOOK | ISO_FIGURE_HAS_WITH | ISO_FIGURE_HAS_LEVEL |
             ISO_FIGURE_HAS_ADAPT | ISO_FIGURE_HAS_FRAMES,
    .draw = draw_turntable,
};
