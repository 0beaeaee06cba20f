/* SPDX-License-Identifier: MIT */
/* region.c - full resolution in a box, a coarse level around it: with a hard edge under the transfer function of level
 * 0, with a hard edge under that of the coarse level, and blended. */
#include <stdio.h>

#include "figure/columns.h"
#include "lab/figure/paper_kinds.h"
#include "figure/picture.h"

enum { USUAL_LEVEL = 2, BOX_BYTES = 160 };

typedef struct way {
    const char *title;
    bool has_region, is_hard, is_adapted;
} way;

static const way ways[] = {{"level 0 everywhere", false, false, false},
                           {"hard edge, TF of level 0", true, true, false},
                           {"hard edge, adapted TF", true, true, true},
                           {"blended, adapted TF", true, false, true}};
enum { WAYS = sizeof ways / sizeof *ways };

typedef struct shown {
    iso_figure_subject subject;
    const iso_renderer_info *with;
    size_t level;
    char middle[BOX_BYTES]; /* the box if none is given */
    iso_cli_roi region;
} shown;

static iso_status render(void *user, size_t column, size_t width, size_t height, iso_image *image, double *mm_per_pixel,
                         iso_error *err)
{
    shown *s = user;
    const way *w = &ways[column];
    iso_cli_roi region = s->region;
    if (w->is_hard)
        region.band = 0;
    const iso_figure_picture what = {.with = s->with,
                                     .level = w->has_region ? s->level : 0,
                                     .width = width,
                                     .height = height,
                                     .adapted = w->is_adapted,
                                     .region = w->has_region ? &region : NULL};
    return iso_figure_render(&s->subject, &what, image, mm_per_pixel, err);
}

/* Chooses the middle half along each axis. */
static void choose_middle(shown *s)
{
    const size_t *n = s->subject.pyramid.levels[0].geometry.size;
    snprintf(s->middle, sizeof s->middle, "%zu,%zu,%zu,%zu,%zu,%zu", n[0] / 4, n[1] / 4, n[2] / 4, n[0] - n[0] / 4,
             n[1] - n[1] / 4, n[2] - n[2] / 4);
    s->region.box = s->middle;
}

static iso_status draw_region(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    shown s = {.level = job->level ? (size_t)job->level : USUAL_LEVEL};
    iso_figure_columns c = {.job = job, .count = WAYS, .compared = true, .render = render, .user = &s};
    s.region = (iso_cli_roi)ISO_CLI_ROI_DEFAULTS;
    s.region.box = iso_lab_figure_of(job)->region;
    for (size_t i = 0; i < WAYS; ++i)
        snprintf(c.titles[i], sizeof c.titles[i], "%s", ways[i].title);
    iso_status status = iso_figure_renderer(job, &s.with, err);
    TRY(status, iso_figure_subject_load(&s.subject, job, s.level + 1, NULL, err));
    TRY(status, iso_subject_refuse_labels(&s.subject.pyramid, job->input, "--kind roi", err));
    if (status == ISO_OK) {
        FILE *f = iso_page_caption(page);
        if (!s.region.box)
            choose_middle(&s);
        fputs("A region of interest", f);
        iso_figure_put_subject(&s.subject, f);
        fprintf(
            f,
            ": level 0 in the box %s of its voxels, level %zu around it, under the transfer function of level 0 and "
            "under the one adapted to level %zu, with a hard edge and blended over a band of %g voxels of level %zu",
            s.region.box, s.level, s.level, s.region.band, s.level);
        c.drawn_by = &s.subject.drawn_by;
        c.tf = iso_figure_tf_foot_of(&s.subject);
        c.tf.of_level0 = true;
        c.aspect = iso_figure_aspect(&s.subject);
        status = iso_figure_draw_columns(&c, page, err);
    }
    iso_figure_subject_end(&s.subject);
    return status;
}

const iso_figure_info iso_figure_region = {
    .name = "roi",
    .summary = "full resolution in a box of a coarse level: edges and transfer functions [diaz-garcia-2016], Figure 11",
    .takes = ISO_FIGURE_OF_VOLUME | ISO_FIGURE_HAS_LOOK | ISO_FIGURE_HAS_WITH | ISO_FIGURE_HAS_LEVEL |
             ISO_LAB_FIGURE_HAS_REGION | ISO_FIGURE_HAS_INSET,
    .draw = draw_region,
};
