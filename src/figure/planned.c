/* SPDX-License-Identifier: MIT */
/* A plan: its picture, and cuts through the bricks, each in the color of its level. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "figure/columns.h"
#include "figure/kinds.h"
#include "figure/picture.h"
#include "plan/planner.h"
#include "tf/color_space.h"

enum { BRICK_VOXELS = 16, USUAL_LEVELS = 4, WAYS = 4 };
static const double usual_error = 1.0 / 255, foot_mm = 5;
static const unsigned char left_out[3] = {225, 225, 225};

typedef struct shown {
    const iso_figure_job *job;
    iso_figure_subject subject;
    iso_node_levels nodes;
    iso_planner planner;
    iso_view view;
    size_t level_count;
} shown;

static void shown_destroy(shown *s)
{
    iso_planner_destroy(&s->planner);
    iso_node_levels_destroy(&s->nodes);
    iso_view_destroy(&s->view);
    iso_figure_subject_end(&s->subject);
}

/* Returns the color of a level; the finest one is the darkest. */
static void color_of(const shown *s, size_t level, unsigned char rgb[3])
{
    iso_colormap_lookup(s->job->map, 0.35 + 0.6 * (double)level / fmax((double)s->level_count - 1, 1), rgb);
}

/* Computes a pixel: darker for high values; bricks have thin edges. axis: normal of the cut. */
static void paint(const shown *s, const double index[3], size_t axis, double edge, float rgba[4])
{
    const iso_node_levels *n = &s->nodes;
    const iso_level *level0 = &s->subject.pyramid.levels[0];
    size_t brick[3], voxel[3];
    bool on_edge = false;
    unsigned char rgb[3];
    for (int a = 0; a < 3; ++a) {
        const double at = fmax(index[a], 0), size = (double)n->brick_voxels;
        brick[a] = (size_t)fmin(at / size, (double)n->count[a] - 1);
        voxel[a] = (size_t)fmin(at, (double)level0->geometry.size[a] - 1);
        on_edge |= (size_t)a != axis && fmod(at, size) < edge;
    }
    const size_t i = iso_brick_index(n, brick);
    const size_t *size = level0->geometry.size;
    const double value = ((double)level0->scalar[voxel[0] + size[0] * (voxel[1] + size[1] * voxel[2])] - level0->min) /
                         fmax(level0->max - level0->min, 1e-300);
    if (s->planner.best.drawn[i])
        color_of(s, s->planner.best.levels[i], rgb);
    else
        memcpy(rgb, left_out, sizeof left_out);
    for (size_t c = 0; c < 4; ++c)
        rgba[c] = c == 3 ? 1 : (float)iso_srgb_to_linear((on_edge ? 0.55 : 1 - 0.35 * value) * (double)rgb[c] / 255.0);
}

/* Renders a cut across axis 2, 1 or 0 through the middle, with the volume as large as possible. */
static iso_status render_cut(const shown *s, size_t axis, size_t width, size_t height, iso_image *image, iso_error *err)
{
    const iso_geometry *g = &s->subject.pyramid.levels[0].geometry;
    const size_t across = axis == 0 ? 1 : 0, up = axis == 2 ? 1 : 2;
    double mm[3];
    for (int a = 0; a < 3; ++a)
        mm[a] = iso_norm(iso_column(g->index_to_world, a));
    /* One scale for all cuts: the first size goes across, or upward in the cut along it. */
    const double mm_per_pixel = fmax(fmax(mm[0] * (double)g->size[0], mm[1] * (double)g->size[1]) / (double)width,
                                     fmax(mm[1] * (double)g->size[1], mm[2] * (double)g->size[2]) / (double)height);
    const iso_status status = iso_image_create(image, width, height, err);
    for (size_t i = 0; i < width * height && status == ISO_OK; ++i) {
        double index[3] = {0};
        index[axis] = 0.5 * (double)g->size[axis];
        index[across] = 0.5 * (double)g->size[across] +
                        ((double)(i % width) + 0.5 - 0.5 * (double)width) * mm_per_pixel / mm[across];
        index[up] = 0.5 * (double)g->size[up] -
                    ((double)(i / width) + 0.5 - 0.5 * (double)height) * mm_per_pixel / mm[up];
        float *rgba = image->rgba + 4 * i;
        if (index[across] >= 0 && index[across] < (double)g->size[across] && index[up] >= 0 &&
            index[up] < (double)g->size[up])
            paint(s, index, axis, mm_per_pixel / fmin(mm[across], mm[up]), rgba);
        else
            for (size_t c = 0; c < 4; ++c)
                rgba[c] = 1;
    }
    return status;
}

static iso_status render(void *user, size_t column, size_t width, size_t height, iso_image *image, double *mm_per_pixel,
                         iso_error *err)
{
    shown *s = user;
    if (column > 0)
        return render_cut(s, 3 - column, width, height, image, err);
    iso_view view = s->view; /* borrows its contents */
    view.width = width, view.height = height;
    *mm_per_pixel = iso_view_mm_per_pixel(&view, &s->subject.pyramid.levels[0].geometry);
    return iso_planner_draw(&s->planner, s->planner.best.levels, s->planner.best.drawn, &view, image, err);
}

/* ---- caption and legend ---- */

static void count_bricks(const shown *s, size_t of_level[ISO_BRICK_MAX_LEVELS + 1])
{
    const iso_plan_trial *t = &s->planner.best;
    for (size_t i = 0; i < s->planner.plan.brick_count; ++i)
        ++of_level[t->drawn[i] ? t->levels[i] : s->level_count];
}

/* Puts a square and a text per level below the pictures, and one for omitted bricks. */
static void put_legend(const shown *s, iso_page *page)
{
    size_t bricks[ISO_BRICK_MAX_LEVELS + 1] = {0};
    double x = 1;
    const double y = iso_page_height(page) - 0.5 * foot_mm;
    count_bricks(s, bricks);
    for (size_t level = 0; level <= s->level_count; ++level) {
        unsigned char rgb[3];
        char color[16], text[64];
        color_of(s, level, rgb);
        if (level == s->level_count)
            memcpy(rgb, left_out, sizeof left_out);
        snprintf(color, sizeof color, "#%02x%02x%02x", rgb[0], rgb[1], rgb[2]);
        if (level < s->level_count)
            snprintf(text, sizeof text, "%zu %s level %zu", bricks[level], level == 0 ? "bricks of" : "of", level);
        else
            snprintf(text, sizeof text, "%zu left out", bricks[level]);
        iso_page_put_rectangle(page, &(iso_page_box){x, y - 0.9, 1.8, 1.8}, color, &(iso_page_pen){"#888888", 0.3, 0});
        iso_page_put_text(page, &(iso_page_text){.x = x + 2.5, .y = y, .role = ISO_PAGE_NOTE}, text);
        x += 5 + iso_page_text_mm(page, ISO_PAGE_NOTE, text);
    }
}

static void write_caption(const shown *s, double error, FILE *f)
{
    const iso_plan_trial *t = &s->planner.best;
    fputs("Plan", f);
    iso_figure_put_subject(&s->subject, f);
    fprintf(
        f,
        " for an RMSE of %.3g: %.3g of %.3g bytes, measured RMSE %.3g; %zu of %zu bricks of %d voxels per side. Its "
        "picture, and cuts through the middle in the colors of the bricks' levels, darker for high values",
        error, iso_plan_trial_bytes(t), (double)ISO_BYTES_A_NODE * (double)s->planner.full_node_count, t->measured.rmse,
        t->drawn_count, s->planner.plan.brick_count, BRICK_VOXELS);
}

/* ---- the figure ---- */

static iso_status make_plan(shown *s, double error, iso_error *err)
{
    const iso_figure_job *job = s->job;
    const iso_progress progress = iso_cli_progress(job->cli);
    NEED(iso_figure_subject_load(&s->subject, job, 1, NULL, err));
    NEED(iso_subject_refuse_labels(&s->subject.pyramid, job->input, "--kind plan", err));
    NEED(iso_scene_resolve(&s->subject.scene, &s->subject.pyramid.levels[0].geometry,
                           iso_pyramid_lo(&s->subject.pyramid), iso_pyramid_hi(&s->subject.pyramid), &s->view, err));
    NEED(iso_node_levels_begin(&s->nodes, &s->subject.pyramid.levels[0], BRICK_VOXELS, s->level_count,
                               job->cli->threads, err));
    NEED(iso_planner_create(&s->planner, &s->nodes,
                            &(iso_planner_options){&s->view, 1, ISO_FACES_BAKED, job->cli->threads}, &progress, err));
    return iso_planner_search(&s->planner, error, 0, &progress, err);
}

static iso_status draw_plan(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    OWNED(shown) s = {.job = job, .level_count = job->levels ? (size_t)job->levels : USUAL_LEVELS};
    const double error = job->error > 0 ? job->error : usual_error;
    iso_figure_columns c = {.job = job,
                            .count = WAYS,
                            .per_row = job->width_mm < 120 ? 2 : WAYS,
                            .titles = {"picture", "cut across z", "cut across y", "cut across x"},
                            .foot_mm = foot_mm,
                            .render = render,
                            .user = &s};
    NEED(make_plan(&s, error, err));
    write_caption(&s, error, iso_page_caption(page));
    c.aspect = iso_figure_aspect(&s.subject);
    c.tf = iso_figure_tf_foot_of(&s.subject);
    NEED(iso_figure_draw_columns(&c, page, err));
    put_legend(&s, page);
    return ISO_OK;
}

const iso_figure_info iso_figure_plan = {
    .name = "plan",
    .summary = "levels of bricks: the picture of a plan, and cuts through its bricks",
    .takes = ISO_FIGURE_OF_VOLUME | ISO_FIGURE_HAS_LOOK | ISO_FIGURE_HAS_LEVELS | ISO_FIGURE_HAS_ERROR,
    .draw = draw_plan,
};
