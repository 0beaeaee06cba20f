/* SPDX-License-Identifier: MIT */
/* paper_mixed.c - bricks of two levels next to each other: as they are, and with their shared faces made equal
 * (brick/bricks.h). The pictures are by the OpenGL ray caster, one pixel per dot. */
#include <math.h>
#include <stdlib.h>

#include "lab/figure/paper_own.h"
#include "lab/figure/paper_bricks.h"
#include "lab/figure/paper_kinds.h"
#include "figure/sheet.h"
#include "figure/tf_bar.h"
#include "render/gl/bricks_gl.h"
#include "volume/synthetic.h"

enum { OWN_SIDE = 40, OWN_BRICK = 16, OWN_COARSE = 1, SEEN_WIDTH = 160 };

/* Makes ripples so fine that a coarser level loses part of them. */
static iso_status make_ripples(iso_volume *v, iso_error *err)
{
    const size_t size[3] = {OWN_SIDE, OWN_SIDE, OWN_SIDE};
    const iso_field field = {.kind = ISO_FIELD_MARSCHNER_LOBB,
                             .geometry = iso_geometry_axis_aligned(size, (const double[3]){1, 1, 1})};
    return iso_field_sample(&field, ISO_F32, v, err);
}
static const iso_paper_own ripples = {"the signal of Marschner and Lobb", make_ripples};

/* A ramp around the middle of the range, paler in denser parts. */
static const iso_tf_point flank[] = {{0, {0.42, 0.24, 0.12}, 0},
                                     {0.46, {0.42, 0.24, 0.12}, 0},
                                     {0.5, {0.80, 0.45, 0.20}, 0.7},
                                     {0.54, {1, 0.88, 0.66}, 0.97},
                                     {1, {1, 0.97, 0.92}, 0.99}};
static const iso_paper_look own_look = {.view = "35,38",
                                        .points = flank,
                                        .point_count = sizeof flank / sizeof *flank,
                                        .zoom = 1,
                                        .width = 256,
                                        .height = 256,
                                        .shading = {.ambient = 0.2, .diffuse = 0.7, .specular = 0.3, .power = 30}};

typedef struct stage {
    iso_pyramid pyramid;
    iso_scene scene;
    iso_view view;   /* the whole volume, at the size of a panel */
    iso_view near;   /* the border, magnified; borrows from view */
    double frame[4]; /* of `near` within `view` */
    iso_mixed mixed;
    iso_mixed_seen seen;
    iso_gl *gl;
    iso_tf_table tf;
    double surface, magnification;
} stage;

static void end(stage *s)
{
    iso_gl_destroy(s->gl);
    free(s->seen.index);
    iso_mixed_destroy(&s->mixed);
    iso_tf_table_destroy(&s->tf);
    iso_view_destroy(&s->view);
    iso_scene_destroy(&s->scene);
    iso_pyramid_destroy(&s->pyramid);
}

/* Loads volume and scene and splits into bricks. Panels set the pictures' size. */
static iso_status begin(const iso_figure_job *job, stage *s, bool of_surface, iso_error *err)
{
    const size_t brick = iso_lab_figure_of(job)->bricks > 0 ? (size_t)iso_lab_figure_of(job)->bricks : OWN_BRICK;
    const size_t coarse = job->level ? (size_t)job->level : OWN_COARSE;
    iso_pyramid_options build = iso_pyramid_defaults();
    build.level_count = 1;
    build.keep_float = build.keep_magnitude = true;
    *s = (stage){.surface = NAN};
    if (iso_lab_figure_of(job)->bricks < 0)
        return iso_fail(err, ISO_E_RANGE, "--bricks is %d, must be a power of two, 2 to 64",
                        iso_lab_figure_of(job)->bricks);
    NEED(iso_paper_load(job, &ripples, &build, &s->pyramid, err));
    const iso_level *level = &s->pyramid.levels[0];
    if (of_surface)
        NEED(iso_paper_surface(job, level, &s->surface, err));
    NEED(iso_paper_scene(job, &own_look, &s->pyramid, &s->scene, err));
    NEED(iso_figure_scene_tf(&s->scene, &s->pyramid, &s->tf, err));
    NEED(iso_mixed_create(&s->mixed, level, brick, coarse, job->cli->threads, err));
    return iso_gl_create(&s->gl, NULL, err);
}

/* Sets the pixels of the whole view from the panel, and the view of the visible border. */
static iso_status aim(const iso_paper *p, stage *s, iso_error *err)
{
    const iso_level *level = &s->pyramid.levels[0];
    const size_t dots = iso_paper_dots(p, 0);
    iso_vec3 index;
    s->scene.height = (size_t)fmax(1, rint((double)dots * (double)s->scene.height / (double)s->scene.width));
    s->scene.width = dots;
    NEED(iso_scene_resolve(&s->scene, &level->geometry, iso_pyramid_lo(&s->pyramid), iso_pyramid_hi(&s->pyramid),
                           &s->view, err));
    NEED(iso_mixed_look(&s->mixed, &s->view, s->surface, SEEN_WIDTH, p->job->cli->threads, &s->seen, err));
    if (!iso_mixed_find_border(&s->mixed, &s->seen, &index))
        return iso_fail(err, ISO_E_RANGE,
                        "%s: no border between levels is visible; try other --bricks, --view, --tf or --surface",
                        iso_paper_volume_name(p->job, &ripples));
    const double height_mm = 0.9 * (double)s->mixed.nodes.brick_voxels * iso_geometry_mean_spacing_mm(&level->geometry);
    iso_mixed_magnify(&s->view, iso_geometry_to_world(&level->geometry, index), height_mm, &s->near, s->frame);
    s->magnification = 1 / (s->frame[3] - s->frame[1]);
    return ISO_OK;
}

static iso_status render(stage *s, const iso_view *view, bool smooth, bool lit, iso_image *image, iso_error *err)
{
    const iso_brick_field field = iso_mixed_field(&s->mixed, smooth);
    const iso_surface surface = {.iso = s->surface};
    iso_gl_brick_options o = iso_gl_brick_defaults();
    iso_gl_brick_stats stats;
    iso_view shown = *view;
    o.shaded = lit;
    o.cache_bits = 32;
    o.surface = isnan(s->surface) ? NULL : &surface;
    if (!lit)
        shown.shading = (iso_shading){.ambient = 1, .power = 1};
    return iso_gl_render_bricks(s->gl, &field, &shown, &o, image, &stats, err);
}

/* ---- contents of the panels ---- */

/* Returns the share of fine bricks around a place of the picture. */
static double fine_share(const stage *s, double x, double y)
{
    const double at_x = fmin(fmax(x * (double)s->seen.width - 0.5, 0), (double)s->seen.width - 1.001);
    const double at_y = fmin(fmax(y * (double)s->seen.height - 0.5, 0), (double)s->seen.height - 1.001);
    const size_t column = (size_t)at_x, row = (size_t)at_y;
    double share = 0;
    for (size_t k = 0; k < 4; ++k) {
        const size_t i = (row + k / 2) * s->seen.width + column + k % 2;
        const double wx = at_x - (double)column, wy = at_y - (double)row;
        if (i < s->seen.width * s->seen.height && s->seen.index[i].x >= 0 &&
            iso_mixed_is_fine(&s->mixed, s->seen.index[i]))
            share += (k % 2 ? wx : 1 - wx) * (k / 2 ? wy : 1 - wy);
    }
    return share;
}

/* Tints fine bricks green, with unchanged brightness. */
static void tint(const stage *s, iso_image *image)
{
    static const double green[3] = {0.03, 0.62, 0.36}; /* linear */
    for (size_t i = 0; i < image->width * image->height; ++i) {
        float *p = image->rgba + 4 * i;
        const double share = 0.75 * (double)p[3] *
                             fine_share(s, ((double)(i % image->width) + 0.5) / (double)image->width,
                                        ((double)(i / image->width) + 0.5) / (double)image->height);
        const double bright = 0.2126 * (double)p[0] + 0.7152 * (double)p[1] + 0.0722 * (double)p[2];
        for (int c = 0; c < 3; ++c)
            p[c] = (float)((1 - share) * (double)p[c] + share * 1.9 * bright * green[c]);
    }
}

/* The content of a panel, and its place. */
typedef struct panel {
    enum { NEAR, OVERVIEW, DIFFERENCE } what;
    size_t row, column;
    const char *title, *note;
    bool smooth, lit;
} panel;

static iso_status put_overview(const iso_paper *p, stage *s, const panel *one, iso_error *err)
{
    OWNED(iso_image) image = {0};
    NEED(render(s, &s->view, true, true, &image, err));
    tint(s, &image);
    const iso_page_box box = iso_paper_picture(p, one->row, one->column, one->title, one->note, &image);
    const iso_page_box frame = {box.left + s->frame[0] * box.width, box.top + s->frame[1] * box.height,
                                (s->frame[2] - s->frame[0]) * box.width, (s->frame[3] - s->frame[1]) * box.height};
    iso_page_put_rectangle(p->page, &frame, NULL,
                           &(iso_page_pen){"#000000", 1.7, 0}); /* visible on dark and bright ground */
    iso_page_put_rectangle(p->page, &frame, NULL, &(iso_page_pen){"#ffffff", 0.7, 0});
    iso_page_put_scale_bar(p->page, &box, &image, iso_view_mm_per_pixel(&s->view, &s->pyramid.levels[0].geometry));
    return ISO_OK;
}

static iso_status put_near(const iso_paper *p, stage *s, const panel *one, iso_error *err)
{
    OWNED(iso_image) image = {0};
    NEED(render(s, &s->near, one->smooth, one->lit, &image, err));
    iso_paper_picture(p, one->row, one->column, one->title, one->note, &image);
    return ISO_OK;
}

/* Draws the difference of the lit pictures by the map of --map, with its bar at the right. */
static iso_status put_difference(const iso_paper *p, stage *s, const panel *one, iso_error *err)
{
    OWNED(iso_image) rough = {0}, smooth = {0};
    NEED(render(s, &s->near, false, true, &rough, err));
    NEED(render(s, &s->near, true, true, &smooth, err));
    const size_t count = rough.width * rough.height;
    FREED float *apart = malloc(count * sizeof *apart);
    NEED_MEMORY(apart, err, "figure: out of memory");
    double most = 1e-6;
    for (size_t i = 0; i < count; ++i) {
        apart[i] = 0;
        for (int c = 0; c < 3; ++c)
            apart[i] = fmaxf(apart[i], fabsf(rough.rgba[4 * i + (size_t)c] - smooth.rgba[4 * i + (size_t)c]));
        most = fmax(most, (double)apart[i]);
    }
    most = iso_figure_round_up(most);
    const double range[2] = {0, most};
    const iso_page_box box = iso_paper_panel(p, one->row, one->column, one->title, one->note),
                       corner = iso_paper_corner(box);
    const iso_page_color_bar bar = {.box = {box.left + box.width + 1.2, box.top, 2.2, box.height},
                                    .map = p->job->map,
                                    .range = {0, most}};
    iso_page_put_values(p->page, &corner, apart, rough.width, rough.height, p->job->map, range);
    iso_page_put_color_bar(p->page, &bar);
    return ISO_OK;
}

static void describe(const iso_paper *p, const stage *s)
{
    const double rough = iso_mixed_jump(&s->mixed, false), smooth = iso_mixed_jump(&s->mixed, true);
    fprintf(
        iso_page_caption(p->page),
        " Bricks of %zu voxels along a side, of levels 0 and %zu; magnified %.1f times. Across the faces between the "
        "two levels values jump by at most %.3g of the range if each brick keeps its own samples, and by %.2g if "
        "shared faces are made equal.",
        s->mixed.nodes.brick_voxels, s->mixed.coarse, s->magnification, rough, smooth);
    json_object_set_new(p->job->facts, "jump_discontinuous", json_real(rough));
    json_object_set_new(p->job->facts, "jump_smooth", json_real(smooth));
    json_object_set_new(p->job->facts, "magnification", json_real(s->magnification));
    json_object_set_new(p->job->facts, "brick_voxels", json_integer((json_int_t)s->mixed.nodes.brick_voxels));
}

static iso_paper_row row_of(const stage *s, double right_mm, bool has_titles)
{
    return (iso_paper_row){.columns = 3,
                           .aspect = (double)s->scene.height / (double)s->scene.width,
                           .right_mm = right_mm,
                           .gap_mm = 1.5,
                           .most_mm = 60,
                           .has_titles = has_titles,
                           .has_notes = true};
}

static const panel of_volume[] = {
    {NEAR, 0, 0, "without light", "discontinuous", false, false},
    {NEAR, 0, 1, "lit", "discontinuous", false, true},
    {OVERVIEW, 0, 2, "whole volume", "level 0 green", true, true},
    {NEAR, 1, 0, NULL, "smooth", true, false},
    {NEAR, 1, 1, NULL, "smooth", true, true},
    {DIFFERENCE, 1, 2, NULL, "difference, lit", false, true},
};
static const panel of_surface[] = {
    {OVERVIEW, 0, 0, "surface", "level 0 green", true, true},
    {NEAR, 0, 1, "discontinuous", "magnified", false, true},
    {NEAR, 0, 2, "smooth", "magnified", true, true},
};

static iso_status put_panels(const iso_paper *p, stage *s, const panel *panels, size_t count, iso_error *err)
{
    for (size_t i = 0; i < count; ++i)
        NEED(panels[i].what == NEAR       ? put_near(p, s, &panels[i], err)
             : panels[i].what == OVERVIEW ? put_overview(p, s, &panels[i], err)
                                          : put_difference(p, s, &panels[i], err));
    return ISO_OK;
}

/* Describes a surface in its single color, which needs no bar. */
static iso_figure_tf_foot tf_foot(const stage *s)
{
    iso_figure_tf_foot foot = {.tf = isnan(s->surface) ? &s->tf : NULL};
    iso_figure_tf_range(&s->tf, &s->pyramid.levels[0], foot.range);
    return foot;
}

/* Draws a figure; its caption begins with the kind's own text. */
static iso_status draw_mixed(const iso_figure_job *job, iso_page *page, bool surface, const panel *panels, size_t count,
                             iso_error *err)
{
    stage s;
    iso_paper p;
    iso_figure_tf_foot foot = {.tf = NULL};
    iso_status status = begin(job, &s, surface, err);
    if (status == ISO_OK) {
        foot = tf_foot(&s);
        iso_paper_row rows[] = {row_of(&s, surface ? 0 : 11.5, true), row_of(&s, surface ? 0 : 11.5, false)};
        rows[surface ? 0 : 1].below_mm = iso_figure_tf_foot_mm(&foot);
        status = iso_paper_lay_out(&p, job, page, rows, surface ? 1 : 2, err);
    }
    TRY(status, aim(&p, &s, err));
    if (status == ISO_OK) {
        FILE *f = iso_page_caption(page);
        const char *name = iso_paper_volume_name(job, &ripples);
        if (surface)
            fprintf(
                f,
                "The isosurface of %s at the value %.4g, first hit: on the left the whole volume, bricks of level 0 "
                "green, with the magnified frame; then discontinuous and smooth.",
                name, s.surface);
        else
            fprintf(f,
                    "Where bricks of two levels of %s meet: discontinuous above, smooth below; without light and lit; "
                    "on the right the whole volume, bricks of level 0 green, with the magnified frame, and below "
                    "it the largest channel difference of the lit pictures, in linear light (1 is white).",
                    name);
        describe(&p, &s);
        status = put_panels(&p, &s, panels, count, err);
        if (status == ISO_OK)
            iso_figure_put_tf_foot(&foot, page, 0);
    }
    end(&s);
    return status;
}

static iso_status mixed_volume(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    return draw_mixed(job, page, false, of_volume, sizeof of_volume / sizeof *of_volume, err);
}

static iso_status mixed_surface(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    return draw_mixed(job, page, true, of_surface, sizeof of_surface / sizeof *of_surface, err);
}

enum {
    OF_MIXED = ISO_FIGURE_OF_NOTHING | ISO_FIGURE_OF_VOLUME | ISO_FIGURE_HAS_LOOK | ISO_FIGURE_HAS_LEVEL |
               ISO_LAB_FIGURE_HAS_BRICKS
};

const iso_figure_info iso_figure_mixed_volume = {
    .name = "mixed-volume",
    .summary = "two levels that meet, discontinuous and smooth [beyer-2008], Figure 8",
    .takes = OF_MIXED,
    .draw = mixed_volume,
};
const iso_figure_info iso_figure_mixed_surface = {
    .name = "mixed-surface",
    .summary = "two levels that meet on an isosurface [beyer-2008], Figure 9",
    .takes = OF_MIXED | ISO_LAB_FIGURE_HAS_SURFACE,
    .draw = mixed_surface,
};
