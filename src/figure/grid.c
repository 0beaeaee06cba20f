/* SPDX-License-Identifier: MIT */
/* grid.c - levels downward and renderers across: pictures, and differences from the first renderer at each level. */
#include <math.h>
#include <stdio.h>

#include "compare/metrics.h"
#include "figure/kinds.h"
#include "figure/paper.h"
#include "figure/picture.h"
#include "figure/tf_bar.h"

enum { MOST_COLUMNS = 8, OWN_LEVELS = 3, MOST_LEVELS = 4 };
static const double side_mm = 8;

typedef struct grid {
    const iso_renderer_info *with[MOST_COLUMNS];
    size_t columns, levels;
    iso_figure_subject subject;
    iso_figure_tf_foot tf;
    iso_paper paper;
} grid;

static void grid_destroy(grid *g)
{
    iso_figure_subject_end(&g->subject);
}

static iso_status choose(grid *g, const iso_figure_job *job, iso_error *err)
{
    bool wanted[ISO_MAX_RENDERERS];
    NEED(iso_renderers_from_list(job->with, wanted, err));
    NEED(iso_renderers_find_missing(job->with, wanted, err));
    for (size_t i = 0; i < iso_renderer_count(); ++i) {
        if (wanted[i] && g->columns == MOST_COLUMNS)
            return iso_fail(err, ISO_E_RANGE, "--with names too many renderers, at most %d fit side by side",
                            (int)MOST_COLUMNS);
        if (wanted[i])
            g->with[g->columns++] = iso_renderer_at(i);
    }
    g->levels = job->levels ? (size_t)job->levels : OWN_LEVELS;
    return iso_words_check_range("--levels", (double)g->levels, 1, MOST_LEVELS, err);
}

/* Puts a text upright on the left of a row: the level, and its part of the voxels. */
static void put_side(const grid *g, iso_page *page, size_t level, const iso_page_box *box)
{
    iso_page_text at = {.x = box->left - 5.2,
                        .y = box->top + 0.5 * box->height,
                        .role = ISO_PAGE_TITLE,
                        .align = ISO_PAGE_CENTER,
                        .upright = 1};
    char text[64];
    const double part = (double)iso_geometry_voxel_count(&g->subject.pyramid.levels[0].geometry) /
                        (double)iso_geometry_voxel_count(&g->subject.pyramid.levels[level].geometry);
    snprintf(text, sizeof text, "level %zu", level);
    iso_page_put_text(page, &at, text);
    at.role = ISO_PAGE_NOTE;
    at.x = box->left - 1.9;
    if (level == 0)
        snprintf(text, sizeof text, "full resolution");
    else
        snprintf(text, sizeof text, "1/%.0f of the voxels", part);
    iso_page_put_text(page, &at, text);
}

static iso_status draw_level(grid *g, const iso_figure_job *job, iso_page *page, size_t level, iso_error *err)
{
    iso_image images[MOST_COLUMNS] = {{0}};
    const size_t width = iso_paper_dots(&g->paper, level);
    iso_status status = ISO_OK;
    for (size_t i = 0; i < g->columns && status == ISO_OK; ++i) {
        const iso_figure_picture what = {.with = g->with[i],
                                         .level = level,
                                         .width = width,
                                         .height = (size_t)fmax(1, rint((double)width * g->paper.rows[level].aspect)),
                                         .adapted = level > 0 && job->adapted.wanted};
        iso_metrics m = {0};
        char note[64] = "";
        double mm_per_pixel = 0;
        status = iso_figure_render(&g->subject, &what, &images[i], &mm_per_pixel, err);
        TRY(status, iso_metrics_measure(&images[0], &images[i], &m, err));
        if (status != ISO_OK)
            break;
        if (i > 0) {
            snprintf(note, sizeof note, "RMSE %.2g", m.rmse);
            fprintf(iso_page_caption(page), " Level %zu, %s: RMSE %.3g, 1 - SSIM %.3g.", level, g->with[i]->title,
                    m.rmse, 1 - m.ssim);
        } else if (level == 0) {
            snprintf(note, sizeof note, "reference of RMSE");
        }
        const iso_page_box box = iso_paper_picture(&g->paper, level, i, level == 0 ? g->with[i]->title : NULL, note,
                                                   &images[i]);
        if (i == 0)
            put_side(g, page, level, &box);
        if (i == 0 && level == 0)
            iso_page_put_scale_bar(page, &box, &images[i], mm_per_pixel);
    }
    for (size_t i = 0; i < g->columns; ++i)
        iso_image_destroy(&images[i]);
    return status;
}

static iso_status draw(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    OWNED(grid) g = {.columns = 0};
    iso_paper_row rows[ISO_PAPER_MOST_ROWS];
    NEED(choose(&g, job, err));
    NEED(iso_figure_subject_load(&g.subject, job, g.levels, NULL, err));
    g.tf = iso_figure_tf_foot_of(&g.subject);
    for (size_t i = 0; i < g.levels; ++i)
        rows[i] = (iso_paper_row){.columns = g.columns,
                                  .aspect = (double)g.subject.scene.height / (double)g.subject.scene.width,
                                  .left_mm = side_mm,
                                  .gap_mm = 1,
                                  .most_mm = 60,
                                  .below_mm = i + 1 == g.levels ? iso_figure_tf_foot_mm(&g.tf) : 0,
                                  .has_titles = i == 0,
                                  .has_notes = g.columns > 1};
    NEED(iso_paper_lay_out(&g.paper, job, page, rows, g.levels, err));
    fprintf(iso_page_caption(page), "Levels and renderers");
    iso_figure_put_subject(&g.subject, iso_page_caption(page));
    fprintf(iso_page_caption(page), "%s; figures compare with the first renderer's picture of the same level.",
            job->adapted.wanted ? ", coarse levels under the transfer functions adapted to them" : "");
    for (size_t i = 0; i < g.levels; ++i)
        NEED(draw_level(&g, job, page, i, err));
    iso_figure_put_tf_foot(&g.tf, page, 0);
    return ISO_OK;
}

const iso_figure_info iso_figure_grid = {
    .name = "grid",
    .summary = "levels downward, renderers across, and differences from the first",
    .takes = ISO_FIGURE_OF_VOLUME | ISO_FIGURE_HAS_LOOK | ISO_FIGURE_HAS_WITH | ISO_FIGURE_HAS_LEVELS |
             ISO_FIGURE_HAS_ADAPT,
    .draw = draw,
};
