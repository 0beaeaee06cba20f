/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/figure_drawn.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/provenance.h"
#include "renderers/renderers.h"
#include "report/figure_draw.h"
#include "scene/scene.h"

enum { MOST_COLUMNS = 16 };

/* Columns are levels or renderers: a picture each, and below it how far it is from the first one. */
typedef struct drawn {
    const iso_figure_drawn *d;
    iso_pyramid pyramid;
    iso_scene scene;
    iso_renderers renderers;
    const iso_renderer_info *with[MOST_COLUMNS]; /* of a column */
    size_t level[MOST_COLUMNS], columns;
    size_t width, height; /* of a picture, in pixels */
    iso_figure_panel panels[2 * MOST_COLUMNS];
    size_t count;
} drawn;

static bool shows_levels(const drawn *w)
{
    return w->d->figure.kind == ISO_FIGURE_LEVELS;
}

static void write_note(iso_figure_panel *map, const iso_metrics *m)
{
    snprintf(map->note, sizeof map->note, "RMSE %.3g|1−SSIM %.3g|FLIP %.3g", m->rmse, 1 - m->ssim, m->flip_mean);
}

/* ---- layout ---- */

/* All panels, without pictures: they say how wide each is in print. Notes are as long as they will be. */
static void lay_out(drawn *w)
{
    const iso_image blank = {.width = w->scene.width, .height = w->scene.height};
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
    const iso_figure_options *o = &w->d->figure;
    iso_figure_sheet s = {.panels = w->panels,
                          .count = w->count,
                          .rows = w->columns > 1 ? 2 : 1,
                          .columns = w->columns,
                          .rows_a_side = 1,
                          .in_logs = !shows_levels(w),
                          .low = shows_levels(w) ? 0 : -8,
                          .width_mm = o->width_mm,
                          .height_mm = o->height_mm,
                          .dpi = o->dpi,
                          .with_sources = o->with_sources};
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
    w->width = (size_t)ceil(w->d->figure.dpi * width_mm / 25.4);
    w->height = (size_t)fmax(1, rint((double)w->width * (double)w->scene.height / (double)w->scene.width));
    w->scene.width = w->width, w->scene.height = w->height;
    return ISO_OK;
}

/* ---- rendering ---- */

static iso_status render_one(drawn *w, size_t column, iso_figure_panel *p, iso_error *err)
{
    iso_view view = {0};
    const iso_progress progress = iso_cli_progress(w->d->cli);
    iso_render_options opt = iso_render_defaults(w->with[column]);
    const iso_render_request request = {&w->renderers, &w->pyramid, w->level[column], &view, &opt, &progress};
    opt.threads = w->d->cli->threads;
    p->a = (iso_image){0};
    iso_status status = iso_scene_resolve(&w->scene, &w->pyramid.levels[0].geometry, iso_pyramid_lo(&w->pyramid),
                                          iso_pyramid_hi(&w->pyramid), &view, err);
    if (status == ISO_OK)
        status = iso_cli_adapt_view(&w->d->adapted, w->d->cli->arguments[0], &w->pyramid, w->level[column], &view,
                                    w->d->cli->threads, err);
    if (status == ISO_OK)
        status = iso_render_with(&request, &p->a, NULL, err);
    if (status == ISO_OK)
        status = iso_render_check_finite(w->with[column], &p->a, err);
    if (status == ISO_OK)
        p->mm_per_pixel = iso_view_mm_per_pixel(&view, &w->pyramid.levels[0].geometry);
    iso_view_destroy(&view);
    return status;
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

static iso_status write_caption(const drawn *w, const char *dir, iso_error *err)
{
    char *text = NULL, *path = iso_path_join(dir, "caption.txt");
    size_t size = 0;
    FILE *f = path ? open_memstream(&text, &size) : NULL;
    if (!f) {
        free(path);
        return iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
    }
    const char *scene = iso_provenance_name(w->d->look.scene);
    fprintf(f, "%s of %s%s%s%s, ", shows_levels(w) ? "Levels" : "Renderers",
            iso_provenance_title(w->d->cli->arguments[0]), *scene ? " (" : "", scene, *scene ? ")" : "");
    if (shows_levels(w))
        fprintf(f, "drawn by the %s%s", w->with[0]->title,
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
    fclose(f);
    const iso_status status = iso_file_write(path, text, size, err);
    free(text);
    free(path);
    return status;
}

/* ---- the whole ---- */

static iso_status choose_columns(drawn *w, iso_error *err)
{
    const iso_figure_drawn *d = w->d;
    bool wanted[ISO_MAX_RENDERERS];
    if (shows_levels(w)) {
        const iso_renderer_info *with;
        const iso_status status = iso_renderer_from_name(d->with ? d->with : iso_renderers_usual()->name, &with, err);
        w->columns = (size_t)d->levels;
        for (size_t i = 0; i < w->columns; ++i)
            w->with[i] = with, w->level[i] = i;
        return status;
    }
    const iso_status status = iso_renderers_from_list(d->with, wanted, err);
    for (size_t i = 0; i < iso_renderer_count() && status == ISO_OK; ++i)
        if (wanted[i] && w->columns < MOST_COLUMNS) {
            w->with[w->columns] = iso_renderer_at(i);
            w->level[w->columns++] = d->figure.level;
        }
    return status;
}

static iso_status load(drawn *w, iso_error *err)
{
    const iso_figure_drawn *d = w->d;
    iso_subject_look look;
    iso_pyramid_options build = iso_pyramid_defaults();
    const iso_progress progress = iso_cli_progress(d->cli);
    const size_t coarsest = w->level[w->columns - 1];
    build.threads = d->cli->threads;
    build.level_count = coarsest + 1;
    iso_status status = iso_cli_look_check(&d->look, d->cli->threads, &look, err);
    if (status == ISO_OK)
        status = iso_subject_load_pyramid(d->cli->arguments[0], &d->input, &build, &progress, &w->pyramid, err);
    if (status == ISO_OK && coarsest >= w->pyramid.level_count)
        status = iso_fail(err, ISO_E_RANGE, "%s has levels 0 to %zu, the figure would show level %zu",
                          d->cli->arguments[0], w->pyramid.level_count - 1, coarsest);
    return status == ISO_OK ? iso_subject_make_scene(&look, &w->pyramid, &w->scene, err) : status;
}

static iso_status draw(drawn *w, const char *dir, iso_error *err)
{
    lay_out(w);
    iso_status status = choose_pixels(w, err);
    if (status == ISO_OK)
        status = render_all(w, err);
    if (status == ISO_OK) {
        const iso_figure_sheet sheet = sheet_of(w);
        status = iso_figure_draw(&sheet, dir, err);
    }
    if (status == ISO_OK)
        status = write_caption(w, dir, err);
    for (size_t i = 0; i < w->count; ++i)
        if (!w->panels[i].against && w->panels[i].a.rgba)
            iso_image_destroy(&w->panels[i].a);
    return status;
}

iso_status iso_figure_draw_volume(const iso_figure_drawn *d, iso_error *err)
{
    drawn *w = calloc(1, sizeof *w);
    iso_output out = {0};
    if (!w)
        return iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
    w->d = d;
    iso_status status = iso_words_check_range("--levels", d->levels, 1, MOST_COLUMNS, err);
    if (status == ISO_OK)
        status = iso_figure_check(&d->figure, err);
    if (status == ISO_OK)
        status = choose_columns(w, err);
    if (status == ISO_OK)
        status = load(w, err);
    if (status == ISO_OK)
        status = iso_output_begin_dir(&out, d->output, "figure.pdf", err);
    if (status == ISO_OK)
        status = draw(w, out.temp_path, err);
    if (status == ISO_OK)
        status = iso_output_commit(&out, err);
    iso_output_abandon(&out);
    iso_scene_destroy(&w->scene);
    iso_pyramid_destroy(&w->pyramid);
    iso_renderers_end(&w->renderers);
    free(w);
    return status;
}
