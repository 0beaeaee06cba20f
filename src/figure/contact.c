/* SPDX-License-Identifier: MIT */
/* contact.c - a sheet for choosing: transfer functions downward, sides to look from across, and below each row the
 * bar of its transfer function. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/file.h"
#include "figure/kinds.h"
#include "figure/paper.h"
#include "figure/picture.h"
#include "figure/tf_bar.h"
#include "scene/subject.h"
#include "volume/unit.h"

enum { MOST_COLUMNS = 8, NAME_BYTES = 64 };
static const double side_mm = 5, bar_room_mm = 6.6, bar_mm = 2, bar_above_mm = 0.8;

typedef struct contact {
    const iso_figure_job *job;
    const char *tfs[ISO_PAPER_MOST_ROWS];
    const char *views[MOST_COLUMNS]; /* NULL: the scene's own */
    size_t rows, columns;
    iso_viewpoint from[MOST_COLUMNS];
    const iso_renderer_info *with;
    iso_figure_subject subject; /* scene and transfer function of the row being drawn */
    iso_paper paper;
} contact;

static void contact_destroy(contact *c)
{
    iso_figure_subject_end(&c->subject);
}

static iso_status take(const char *option, char *const *given, const char **kept, size_t most, size_t *count,
                       iso_error *err)
{
    for (*count = 0; given && given[*count]; ++*count) {
        if (*count == most)
            return iso_fail(err, ISO_E_RANGE, "%s is given too often, at most %zu times fit on a page", option, most);
        kept[*count] = given[*count];
    }
    return ISO_OK;
}

/* Chooses transfer functions and sides. The default is the scene's own; without a scene, one suggested transfer
 * function from four sides. */
static iso_status choose(contact *c, iso_error *err)
{
    static const char *const usual[] = {"front", "left", "top", "iso"};
    NEED(take("--tf", c->job->tfs, c->tfs, ISO_PAPER_MOST_ROWS, &c->rows, err));
    NEED(take("--view", c->job->views, c->views, MOST_COLUMNS, &c->columns, err));
    if (c->rows == 0)
        c->tfs[c->rows++] = NULL;
    for (size_t i = 0; c->columns == 0 && !c->job->look.scene && i < sizeof usual / sizeof *usual; ++i)
        c->views[i] = usual[i];
    if (c->columns == 0)
        c->columns = c->job->look.scene ? 1 : sizeof usual / sizeof *usual;
    for (size_t i = 0; i < c->columns; ++i)
        if (c->views[i])
            NEED(iso_viewpoint_parse(c->views[i], &c->from[i], err));
    return iso_figure_renderer(c->job, &c->with, err);
}

static void name_tf(const contact *c, size_t row, char name[NAME_BYTES])
{
    const char *tf = c->tfs[row];
    snprintf(name, NAME_BYTES, "%.60s", tf ? iso_path_base(tf) : c->job->look.scene ? "of the scene" : "suggested");
}

static const char *name_of_view(const contact *c, size_t column)
{
    return c->views[column] ? c->views[column] : "as in the scene";
}

/* Gives the scene the transfer function of a row. */
static iso_status change_tf(contact *c, size_t row, iso_error *err)
{
    iso_figure_subject *s = &c->subject;
    iso_subject_look look;
    iso_cli_look asked = c->job->look;
    asked.tf = (char *)c->tfs[row];
    asked.view = NULL;
    NEED(iso_cli_look_check(&asked, c->job->cli->threads, &look, err));
    iso_scene_destroy(&s->scene);
    look.frames_box = true;
    NEED(iso_subject_make_scene(&look, &s->pyramid, &s->scene, err));
    if (c->job->has_background)
        memcpy(s->scene.background, c->job->background, sizeof s->scene.background);
    iso_tf_table_destroy(&s->tf);
    return iso_figure_scene_tf(&s->scene, &s->pyramid, &s->tf, err);
}

/* Puts a text upright on the left of a row. If it is too long, all titles become smaller. */
static void put_side(iso_page *page, const iso_page_box *box, const char *name)
{
    const double wide = iso_page_text_mm(page, ISO_PAGE_TITLE, name);
    const iso_page_text at = {box->left - 2.2, box->top + 0.5 * box->height, ISO_PAGE_TITLE, ISO_PAGE_CENTER, 1, NULL};
    if (wide > box->height)
        iso_page_set_text_pt(page, ISO_PAGE_TITLE, iso_page_text_pt(page, ISO_PAGE_TITLE) * box->height / wide);
    iso_page_put_text(page, &at, name);
}

/* Puts a bar below the pictures of a row, with their total width. */
static void put_bar(const contact *c, iso_page *page, const iso_page_box *first, size_t row)
{
    const iso_figure_subject *s = &c->subject;
    const double columns = (double)c->columns,
                 wide = columns * first->width + (columns - 1) * c->paper.rows[row].gap_mm;
    const iso_page_box bar = {first->left, first->top + first->height + bar_above_mm, wide, bar_mm};
    double range[2];
    iso_figure_tf_range(&s->tf, &s->pyramid.levels[0], range);
    iso_figure_put_tf_bar(page, &bar, &s->tf, range);
}

static iso_status draw_row(contact *c, iso_page *page, size_t row, iso_error *err)
{
    const size_t width = iso_paper_dots(&c->paper, row);
    char name[NAME_BYTES], length[32];
    NEED(change_tf(c, row, err));
    name_tf(c, row, name);
    for (size_t i = 0; i < c->columns; ++i) {
        OWNED(iso_image) image = {0};
        double mm_per_pixel = 0;
        const iso_figure_picture what = {.with = c->with,
                                         .level = (size_t)c->job->level,
                                         .width = width,
                                         .height = (size_t)fmax(1, rint((double)width * c->paper.rows[row].aspect)),
                                         .viewpoint = c->views[i] ? &c->from[i] : NULL};
        NEED(iso_figure_render(&c->subject, &what, &image, &mm_per_pixel, err));
        const iso_page_box box = iso_paper_picture(&c->paper, row, i, row == 0 ? name_of_view(c, i) : NULL, NULL,
                                                   &image);
        if (i == 0)
            put_side(page, &box, name);
        if (i == 0 && !c->subject.pyramid.levels[0].labels)
            put_bar(c, page, &box, row);
        if (row == 0)
            iso_page_draw_scale_bar(page, &box, &image, mm_per_pixel);
    }
    fprintf(iso_page_caption(page), " %s, %s%s", name,
            iso_unit_text(iso_figure_tf_unit_mm(&c->subject.tf), 3, length, sizeof length),
            row + 1 < c->rows ? ";" : ".");
    return ISO_OK;
}

static iso_status lay_out(contact *c, iso_page *page, iso_error *err)
{
    iso_paper_row rows[ISO_PAPER_MOST_ROWS];
    for (size_t i = 0; i < c->rows; ++i)
        rows[i] = (iso_paper_row){.columns = c->columns,
                                  .aspect = 1 / iso_figure_aspect(&c->subject),
                                  .left_mm = side_mm,
                                  .gap_mm = 1,
                                  .most_mm = 60,
                                  .foot_mm = c->subject.pyramid.levels[0].labels ? 0 : bar_room_mm,
                                  .has_titles = i == 0};
    return iso_paper_lay_out(&c->paper, c->job, page, rows, c->rows, err);
}

static iso_status draw(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    OWNED(contact) c = {.job = job};
    NEED(choose(&c, err));
    NEED(iso_figure_subject_load(&c.subject, job, (size_t)job->level + 1, NULL, err));
    NEED(lay_out(&c, page, err));
    FILE *f = iso_page_caption(page);
    fputs("A sheet", f);
    iso_figure_put_subject(&c.subject, f);
    fprintf(
        f,
        ": transfer functions downward, sides across, level %d. Scale bars apply to the plane through the center of "
        "the volume. Below each row its transfer function: colors over value with the opacity of a length, over gray "
        "squares:",
        job->level);
    for (size_t i = 0; i < c.rows; ++i)
        NEED(draw_row(&c, page, i, err));
    return ISO_OK;
}

const iso_figure_info iso_figure_contact = {
    .name = "sheet",
    .summary = "a sheet for choosing: transfer functions downward, sides across; --tf and --view may be repeated",
    .takes = ISO_FIGURE_OF_VOLUME | ISO_FIGURE_HAS_LOOK | ISO_FIGURE_HAS_LOOKS | ISO_FIGURE_HAS_WITH |
             ISO_FIGURE_HAS_LEVEL,
    .draw = draw,
};
