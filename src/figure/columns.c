/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "figure/columns.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "figure/sheet.h"

typedef struct drawn {
    const iso_figure_columns *c;
    iso_page *page;
    size_t width, height; /* of a picture, in pixels */
    iso_figure_panel panels[3 * ISO_FIGURE_MOST_COLUMNS];
    size_t count;
    iso_image pictures[ISO_FIGURE_MOST_COLUMNS], insets[ISO_FIGURE_MOST_COLUMNS];
} drawn;

static bool has_insets(const drawn *w)
{
    return w->c->job->inset[2] > 0;
}

static size_t per_row(const drawn *w)
{
    return w->c->per_row ? w->c->per_row : w->c->count;
}

static void write_note(iso_figure_panel *map, const iso_metrics *m)
{
    snprintf(map->note, sizeof map->note, "RMSE %.3g|1−SSIM %.3g|FLIP %.3g", m->rmse, 1 - m->ssim, m->flip_mean);
}

/* ---- layout ---- */

/* Lays out all panels without pictures, to find their width in print. Notes have their final length. */
static void lay_out(drawn *w)
{
    const iso_figure_columns *c = w->c;
    /* any size with the right aspect */
    const iso_image blank = {.width = 1000, .height = (size_t)fmax(1, rint(1000 / c->aspect))};
    const size_t insets_row = 1, maps_row = has_insets(w) ? 2 : 1;
    for (size_t i = 0; i < c->count; ++i) {
        iso_figure_panel *p = &w->panels[w->count++];
        *p = (iso_figure_panel){
            .row = i / per_row(w), .column = i % per_row(w), .image = "", .scale_bar = i == 0, .a = blank};
        snprintf(p->title, sizeof p->title, "%s", c->titles[i]);
        if (has_insets(w)) {
            memcpy(p->mark, c->job->inset, sizeof p->mark);
            w->panels[w->count++] =
                (iso_figure_panel){.row = insets_row, .column = i, .image = "", .framed = true, .a = blank};
        }
        if (i == 0 || !c->compared)
            continue; /* the first has no differences; the color legend is below it */
        iso_figure_panel *map = &w->panels[w->count++];
        *map = (iso_figure_panel){.row = maps_row, .column = i, .image = "", .against = "", .a = blank};
        write_note(map, &(iso_metrics){.rmse = 0.0123, .ssim = 1 - 0.0123, .flip_mean = 0.0123});
    }
}

static iso_figure_sheet sheet_of(const drawn *w)
{
    const iso_figure_columns *c = w->c;
    const double foot_mm = c->foot_mm + iso_figure_tf_foot_mm(&c->tf);
    iso_figure_sheet s = {.panels = w->panels,
                          .count = w->count,
                          .columns = per_row(w) < c->count ? per_row(w) : c->count,
                          .rows_per_side = 1,
                          .in_logs = c->in_logs,
                          .low = c->in_logs ? -8 : 0,
                          .width_mm = c->job->width_mm,
                          .height_mm = c->job->height_mm - foot_mm,
                          .is_pixel_per_dot = true,
                          .map = c->job->map,
                          .foot_mm = foot_mm,
                          .legend = c->color_text};
    for (size_t i = 0; i < w->count; ++i) {
        s.rows = w->panels[i].row + 1 > s.rows ? w->panels[i].row + 1 : s.rows;
        if (w->panels[i].against && !c->in_logs)
            s.high = fmax(s.high, w->panels[i].metrics.p99_abs);
    }
    if (!c->in_logs)
        s.high = iso_figure_round_up(s.high);
    if (c->color_text)
        s.low = c->color_range[0], s.high = c->color_range[1];
    return s;
}

/* Chooses one pixel per dot of the panel. */
static iso_status choose_pixels(drawn *w, iso_error *err)
{
    const iso_figure_sheet sheet = sheet_of(w);
    double width_mm = 0;
    NEED(iso_figure_panel_width(&sheet, &width_mm, err));
    w->width = iso_page_dots(w->page, width_mm);
    w->height = (size_t)fmax(1, rint((double)w->width / w->c->aspect));
    return ISO_OK;
}

/* ---- rendering ---- */

/* Renders the whole picture so large that the inset's part fills a panel, and cuts out this part: every renderer has
 * the same projection, with pixels of its own. */
static iso_status render_inset(drawn *w, size_t column, iso_image *image, iso_error *err)
{
    const double *z = w->c->job->inset;
    const double enlarged = fmin(1 / z[2], 1 / z[3]);
    const size_t width = (size_t)lrint((double)w->width * enlarged),
                 height = (size_t)lrint((double)w->height * enlarged);
    const size_t x = (size_t)lrint(fmin(z[0] * (double)width, (double)(width - w->width))),
                 y = (size_t)lrint(fmin(z[1] * (double)height, (double)(height - w->height)));
    OWNED(iso_image) whole = {0};
    double unused;
    if (width * height > ISO_FIGURE_MOST_PIXELS)
        return iso_fail(err, ISO_E_RANGE,
                        "--zoom: the picture would have %zu x %zu pixels, at most %d million; choose a larger part, "
                        "or a lower --dpi",
                        width, height, (int)ISO_FIGURE_MOST_PIXELS >> 20);
    NEED(w->c->render(w->c->user, column, width, height, &whole, &unused, err));
    NEED(iso_image_create(image, w->width, w->height, err));
    for (size_t row = 0; row < w->height; ++row)
        memcpy(image->rgba + 4 * row * w->width, whole.rgba + 4 * ((y + row) * width + x),
               4 * w->width * sizeof *whole.rgba);
    return ISO_OK;
}

/* Compares a picture with the first one. The map borrows the pixels of both. */
static iso_status compare(drawn *w, iso_figure_panel *map, size_t column, iso_error *err)
{
    map->a = w->pictures[column];
    map->b = w->pictures[0];
    const iso_status status = iso_metrics_measure(&w->pictures[0], &w->pictures[column], &map->metrics, err);
    write_note(map, &map->metrics);
    return status;
}

static iso_status render_all(drawn *w, iso_error *err)
{
    size_t at = 0;
    for (size_t i = 0; i < w->c->count; ++i) {
        iso_figure_panel *p = &w->panels[at++];
        const iso_status status = w->c->render(w->c->user, i, w->width, w->height, &w->pictures[i], &p->mm_per_pixel,
                                               err);
        p->a = w->pictures[i];
        NEED(status);
        if (has_insets(w)) {
            NEED(render_inset(w, i, &w->insets[i], err));
            w->panels[at++].a = w->insets[i];
        }
        if (i > 0 && w->c->compared)
            NEED(compare(w, &w->panels[at++], i, err));
    }
    return ISO_OK;
}

/* ---- caption ---- */

static void write_caption(const drawn *w)
{
    const iso_figure_sheet sheet = sheet_of(w);
    const double *z = w->c->job->inset;
    FILE *f = iso_page_caption(w->page);
    if (w->c->drawn_by && *w->c->drawn_by)
        fprintf(f, ", drawn by the %s", (*w->c->drawn_by)->title);
    fprintf(f, ", %zu x %zu pixels each", w->width, w->height);
    if (w->c->compared)
        fprintf(
            f,
            ": pictures, and below them their largest difference from the first one over the channels, on a %s scale",
            w->c->in_logs ? "log" : "linear");
    fputc('.', f);
    if (has_insets(w))
        fprintf(f, " Insets: the framed part, rendered again with %.3g times as many pixels along each side.",
                fmin(1 / z[2], 1 / z[3]));
    for (size_t i = 0; i < w->count; ++i) {
        const iso_figure_panel *p = &w->panels[i];
        if (p->against)
            fprintf(f, " %s: RMSE %.3g, largest difference %.3g, 1 - SSIM %.3g, FLIP %.3g.", w->c->titles[p->column],
                    p->metrics.rmse, p->metrics.max_abs, 1 - p->metrics.ssim, p->metrics.flip_mean);
    }
    iso_figure_describe(&sheet, f);
}

/* ---- the figure ---- */

static iso_status draw(drawn *w, iso_error *err)
{
    lay_out(w);
    NEED(choose_pixels(w, err));
    NEED(render_all(w, err));
    write_caption(w);
    const iso_figure_sheet sheet = sheet_of(w);
    NEED(iso_figure_draw(&sheet, w->page, err));
    iso_figure_put_tf_foot(&w->c->tf, w->page, w->c->foot_mm);
    return ISO_OK;
}

iso_status iso_figure_draw_columns(const iso_figure_columns *columns, iso_page *page, iso_error *err)
{
    drawn *w = calloc(1, sizeof *w);
    NEED_MEMORY(w, err, "figure: out of memory");
    w->c = columns;
    w->page = page;
    const iso_status status = draw(w, err);
    for (size_t i = 0; i < columns->count; ++i) {
        iso_image_destroy(&w->pictures[i]);
        iso_image_destroy(&w->insets[i]);
    }
    free(w);
    return status;
}
