/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "figure/levels.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "figure/of_report.h"
#include "figure/picture.h"
#include "figure/sheet.h"

enum { MOST_COLUMNS = ISO_FIGURE_MOST_LEVELS, USUAL_LEVELS = 4 };

/* Columns are levels or renderers: a picture each, and below it how far it is from the first one. */
typedef struct drawn {
    const iso_figure_job *d;
    iso_page *page;
    bool of_levels;
    iso_figure_subject subject;
    const iso_renderer_info *with[MOST_COLUMNS]; /* of a column */
    size_t level[MOST_COLUMNS], columns;
    size_t width, height; /* of a picture, in pixels */
    iso_figure_panel panels[2 * MOST_COLUMNS];
    size_t count;
} drawn;

static bool shows_levels(const drawn *w)
{
    return w->of_levels;
}

static void write_note(iso_figure_panel *map, const iso_metrics *m)
{
    snprintf(map->note, sizeof map->note, "RMSE %.3g|1−SSIM %.3g|FLIP %.3g", m->rmse, 1 - m->ssim, m->flip_mean);
}

/* ---- layout ---- */

/* All panels, without pictures: they say how wide each is in print. Notes are as long as they will be. */
static void lay_out(drawn *w)
{
    const iso_image blank = {.width = w->subject.scene.width, .height = w->subject.scene.height};
    for (size_t column = 0; column < w->columns; ++column) {
        iso_figure_panel *p = &w->panels[w->count++];
        *p = (iso_figure_panel){.column = column, .image = "", .scale_bar = column == 0, .a = blank};
        if (shows_levels(w))
            snprintf(p->title, sizeof p->title, "level %zu", w->level[column]);
        else
            snprintf(p->title, sizeof p->title, "%.90s", w->with[column]->title);
        if (column == 0)
            continue; /* it differs from nothing; the color legend stands below it */
        iso_figure_panel *map = &w->panels[w->count++];
        *map = (iso_figure_panel){.row = 1, .column = column, .image = "", .against = "", .a = blank};
        write_note(map, &(iso_metrics){.rmse = 0.0123, .ssim = 1 - 0.0123, .flip_mean = 0.0123});
    }
}

static iso_figure_sheet sheet_of(const drawn *w)
{
    const iso_figure_job *o = w->d;
    iso_figure_sheet s = {.panels = w->panels,
                          .count = w->count,
                          .rows = w->columns > 1 ? 2 : 1,
                          .columns = w->columns,
                          .rows_a_side = 1,
                          .in_logs = !shows_levels(w),
                          .low = shows_levels(w) ? 0 : -8,
                          .width_mm = o->width_mm,
                          .height_mm = o->height_mm,
                          .a_pixel_a_dot = true,
                          .map = o->map};
    for (size_t i = 0; i < w->count && shows_levels(w); ++i)
        if (w->panels[i].against)
            s.high = fmax(s.high, w->panels[i].metrics.p99_abs);
    if (shows_levels(w) && !(s.high > 0))
        s.high = 1;
    return s;
}

/* As many pixels as the panel has dots. */
static iso_status choose_pixels(drawn *w, iso_error *err)
{
    const iso_figure_sheet sheet = sheet_of(w);
    double width_mm;
    const iso_status status = iso_figure_panel_width(&sheet, &width_mm, err);
    if (status != ISO_OK)
        return status;
    w->width = iso_page_dots(w->page, width_mm);
    w->height = (size_t)fmax(1,
                             rint((double)w->width * (double)w->subject.scene.height / (double)w->subject.scene.width));
    w->subject.scene.width = w->width, w->subject.scene.height = w->height;
    return ISO_OK;
}

/* ---- rendering ---- */

static iso_status render_one(drawn *w, size_t column, iso_figure_panel *p, iso_error *err)
{
    const iso_figure_picture what = {.with = w->with[column],
                                     .named = !shows_levels(w),
                                     .level = w->level[column],
                                     .width = w->width,
                                     .height = w->height};
    return iso_figure_render(&w->subject, &what, &p->a, &p->mm_per_pixel, err);
}

/* A map borrows the pixels of the picture above it, and those of the first one. */
static iso_status compare(iso_figure_panel *map, const iso_figure_panel *picture, const iso_figure_panel *first,
                          iso_error *err)
{
    map->a = picture->a;
    map->b = first->a;
    const iso_status status = iso_metrics_measure(&first->a, &picture->a, &map->metrics, err);
    write_note(map, &map->metrics);
    return status;
}

/* Pictures that are not rendered yet have no pixels of their own. */
static void forget_pictures(drawn *w)
{
    for (size_t i = 0; i < w->count; ++i)
        w->panels[i].a = w->panels[i].b = (iso_image){0};
}

static iso_status render_all(drawn *w, iso_error *err)
{
    iso_status status = ISO_OK;
    size_t i = 0;
    forget_pictures(w);
    for (size_t column = 0; column < w->columns && status == ISO_OK; ++column) {
        iso_figure_panel *picture = &w->panels[i++];
        status = render_one(w, column, picture, err);
        if (status == ISO_OK && column > 0)
            status = compare(&w->panels[i++], picture, &w->panels[0], err);
    }
    return status;
}

/* ---- words ---- */

static void write_caption(const drawn *w)
{
    FILE *f = iso_page_caption(w->page);
    fputs(shows_levels(w) ? "Levels" : "Renderers", f);
    iso_figure_put_subject(&w->subject, f);
    fputs(", ", f);
    if (shows_levels(w))
        fprintf(f, "drawn by the %s%s", w->subject.drawn_by->title,
                w->d->adapted.wanted ? ", each under the transfer function adapted to it" : "");
    else
        fprintf(f, "level %zu", w->level[0]);
    fprintf(f,
            ", %zu x %zu pixels each: pictures, and below them their largest difference from the first one over the "
            "channels, on a %s scale.",
            w->width, w->height, shows_levels(w) ? "linear" : "log");
    for (size_t i = 0; i < w->count; ++i) {
        const iso_figure_panel *p = &w->panels[i];
        if (p->against)
            fprintf(f, " %s: RMSE %.3g, largest difference %.3g, 1 - SSIM %.3g, FLIP %.3g.", w->panels[i - 1].title,
                    p->metrics.rmse, p->metrics.max_abs, 1 - p->metrics.ssim, p->metrics.flip_mean);
    }
    const iso_figure_sheet sheet = sheet_of(w);
    iso_figure_describe(&sheet, f);
}

/* ---- the whole ---- */

static iso_status choose_columns(drawn *w, iso_error *err)
{
    const iso_figure_job *d = w->d;
    bool wanted[ISO_MAX_RENDERERS];
    if (shows_levels(w)) {
        const iso_renderer_info *with;
        const iso_status status = iso_renderer_from_name(d->with ? d->with : iso_renderers_usual()->name, &with, err);
        w->columns = d->levels ? (size_t)d->levels : USUAL_LEVELS;
        for (size_t i = 0; i < w->columns; ++i)
            w->with[i] = with, w->level[i] = i;
        return status;
    }
    const iso_status status = iso_renderers_from_list(d->with, wanted, err);
    for (size_t i = 0; i < iso_renderer_count() && status == ISO_OK; ++i)
        if (wanted[i] && w->columns < MOST_COLUMNS) {
            w->with[w->columns] = iso_renderer_at(i);
            w->level[w->columns++] = (size_t)d->level;
        }
    return status;
}

static iso_status draw(drawn *w, iso_error *err)
{
    lay_out(w);
    iso_status status = choose_pixels(w, err);
    if (status == ISO_OK)
        status = render_all(w, err);
    if (status == ISO_OK) {
        write_caption(w);
        const iso_figure_sheet sheet = sheet_of(w);
        status = iso_figure_draw(&sheet, w->page, err);
    }
    for (size_t i = 0; i < w->count; ++i)
        if (!w->panels[i].against && w->panels[i].a.rgba)
            iso_image_destroy(&w->panels[i].a);
    return status;
}

static iso_status draw_volume(const iso_figure_job *job, bool of_levels, iso_page *page, iso_error *err)
{
    drawn *w = calloc(1, sizeof *w);
    if (!w)
        return iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
    w->d = job;
    w->page = page;
    w->of_levels = of_levels;
    iso_status status = choose_columns(w, err);
    if (status == ISO_OK)
        status = iso_figure_subject_load(&w->subject, job, w->level[w->columns - 1] + 1, NULL, err);
    if (status == ISO_OK)
        status = draw(w, err);
    iso_figure_subject_end(&w->subject);
    free(w);
    return status;
}

static iso_status draw_levels(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    return iso_figure_is_of_report(job) ? iso_figure_levels_of_report(job, page, err)
                                        : draw_volume(job, true, page, err);
}

static iso_status draw_renderers(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    return iso_figure_is_of_report(job) ? iso_figure_renderers_of_report(job, page, err)
                                        : draw_volume(job, false, page, err);
}

const iso_figure_info iso_figure_levels = {
    .name = "levels",
    .summary = "the levels of a volume side by side, with maps of how far each is from level 0",
    .takes = ISO_FIGURE_OF_VOLUME | ISO_FIGURE_OF_REPORT | ISO_FIGURE_HAS_LOOK | ISO_FIGURE_HAS_WITH |
             ISO_FIGURE_HAS_LEVELS | ISO_FIGURE_HAS_ADAPT | ISO_FIGURE_HAS_METHODS | ISO_FIGURE_HAS_INSET,
    .draw = draw_levels,
};

const iso_figure_info iso_figure_renderers = {
    .name = "renderers",
    .summary = "one level by several renderers, with maps of how far each is from the reference",
    .takes = ISO_FIGURE_OF_VOLUME | ISO_FIGURE_OF_REPORT | ISO_FIGURE_HAS_LOOK | ISO_FIGURE_HAS_WITH |
             ISO_FIGURE_HAS_LEVEL | ISO_FIGURE_HAS_VARIANT | ISO_FIGURE_HAS_INSET,
    .draw = draw_renderers,
};
