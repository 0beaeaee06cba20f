/* SPDX-License-Identifier: MIT */
/* paper_palette.c - an isosurface shaded by its own directions, by a palette fitted to them by annealing, and by the
 * largest regular subdivision of the sphere with as many directions, from two sides. The paper shows an airplane's
 * wing. */
#include <math.h>

#include "compare/metrics.h"
#include "lab/figure/paper_own.h"
#include "lab/figure/paper_kinds.h"
#include "lab/figure/paper_wing.h"
#include "lab/rivals/palettes.h"
#include "pyramid/palette_level.h"
#include "render/gl/raycaster.h"
#include "scene/viewpoint.h"

enum { VIEWS = 2, METHODS = 3, OWN_ENTRIES = 254 };

static const iso_paper_own own_wing = {"a wing by a formula", iso_paper_make_wing};

/* ---- the stage ---- */

typedef struct method {
    const char *title;
    char words[64];
    iso_palette palette; /* empty: all directions */
    iso_palette_error error;
} method;

typedef struct stage {
    iso_pyramid pyramid;
    iso_scene scene;
    iso_gl *gl;
    double surface;
    iso_direction_set set;
    method methods[METHODS];
} stage;

static void end(stage *s)
{
    for (int i = 0; i < METHODS; ++i)
        iso_palette_destroy(&s->methods[i].palette);
    iso_direction_set_destroy(&s->set);
    iso_gl_destroy(s->gl);
    iso_scene_destroy(&s->scene);
    iso_pyramid_destroy(&s->pyramid);
}

/* Samples the directions around the surface, with larger weights near it and on steep slopes. */
static iso_status sample(const iso_figure_job *job, stage *s, iso_error *err)
{
    enum { TABLE = 257 };
    const iso_level *l = &s->pyramid.levels[0];
    const double span = l->max - l->min;
    float near[TABLE];
    for (int i = 0; i < TABLE; ++i)
        near[i] = (float)fmax(0, 1 - fabs(l->min + span * i / (TABLE - 1.0) - s->surface) / (0.25 * span));
    const iso_palette_weighting w = {.by_magnitude = true,
                                     .value_span = span,
                                     .by_value = near,
                                     .by_value_count = TABLE,
                                     .by_value_lo = l->min,
                                     .by_value_hi = l->max};
    iso_direction_pool *pool;
    iso_status status = iso_direction_pool_create(&pool, job->cli->threads, err);
    TRY(status, iso_palette_sample_field(pool, l->directions, l->scalar, l->magnitude,
                                         iso_geometry_voxel_count(&l->geometry), &w, err));
    TRY(status, iso_direction_pool_finish(pool, &s->set, err));
    iso_direction_pool_destroy(pool);
    return status;
}

static iso_status fit(stage *s, size_t entries, iso_error *err)
{
    enum { FEW = 24 }; /* cells: enough for annealing */
    iso_rival_options opt = iso_rival_defaults();
    iso_direction_set few = {0};
    opt.fit.directions = entries;
    opt.method = ISO_RIVAL_ANNEAL;
    iso_status status = iso_direction_set_coarsen(&s->set, FEW, &few, err);
    TRY(status, iso_rival_palette_fit(&few, &opt, &s->methods[1].palette, err));
    opt.method = ISO_RIVAL_FACES;
    TRY(status, iso_rival_palette_fit(&s->set, &opt, &s->methods[2].palette, err));
    for (int i = 1; i < METHODS && status == ISO_OK; ++i) {
        method *m = &s->methods[i];
        status = iso_palette_measure(&s->set, &m->palette, &m->error, err);
        snprintf(m->words, sizeof m->words, i == 1 ? "%zu fitted" : "%zu evenly spread", m->palette.count - 1);
    }
    iso_direction_set_destroy(&few);
    s->methods[0].title = "all directions";
    s->methods[1].title = s->methods[1].words;
    s->methods[2].title = s->methods[2].words;
    return status;
}

/* As in the paper: gray, one light, a highlight. The transfer function sets only the surface's color. */
static const iso_tf_point gray[] = {{0, {0.72, 0.74, 0.78}, 0}, {1, {0.72, 0.74, 0.78}, 0.9}};
static const iso_paper_look own_look = {.view = "-28,30",
                                        .points = gray,
                                        .point_count = sizeof gray / sizeof *gray,
                                        .zoom = 1.45,
                                        .width = 360,
                                        .height = 216,
                                        .shading = {.ambient = 0.1, .diffuse = 0.65, .specular = 0.6, .power = 30}};

static iso_status begin(const iso_figure_job *job, stage *s, iso_error *err)
{
    const int entries = iso_lab_figure_of(job)->entries ? iso_lab_figure_of(job)->entries : OWN_ENTRIES;
    iso_pyramid_options build = iso_pyramid_defaults();
    build.level_count = 1;
    build.keep_float = build.keep_magnitude = true;
    *s = (stage){.surface = NAN};
    if (entries < 60 || entries > 4094 || entries % 2 == 1)
        return iso_fail(err, ISO_E_RANGE, "--entries is %d, must be even, 60 to 4094, as in a tessellation", entries);
    NEED(iso_paper_load(job, &own_wing, &build, &s->pyramid, err));
    const iso_level *l = &s->pyramid.levels[0];
    iso_status status = iso_paper_surface(job, l, &s->surface, err);
    if (status == ISO_OK && (!l->directions || !l->magnitude))
        status = iso_fail(err, ISO_E_RANGE,
                          "%s stores only codes; this figure needs the volume, or a pyramid with floats and "
                          "magnitudes",
                          job->input);
    TRY(status, iso_paper_scene(job, &own_look, &s->pyramid, &s->scene, err));
    TRY(status, sample(job, s, err));
    if (status == ISO_OK && s->set.count == 0)
        status = iso_fail(err, ISO_E_RANGE, "%s has no gradient at the value %.4g; set another one with --surface",
                          iso_paper_volume_name(job, &own_wing), s->surface);
    TRY(status, fit(s, (size_t)entries, err));
    return status == ISO_OK ? iso_gl_create(&s->gl, NULL, err) : status;
}

/* ---- pictures ---- */

static iso_status render(stage *s, const iso_view *view, method *m, iso_image *image, iso_error *err)
{
    iso_level level = s->pyramid.levels[0];
    const iso_surface surface = {.iso = s->surface};
    const iso_code code = s->pyramid.options.code;
    iso_gl_options o = iso_gl_defaults();
    iso_status status = ISO_OK;
    o.surface = &surface;
    o.source = ISO_FROM_FLOAT;
    if (m->palette.count) {
        o.source = ISO_FROM_PALETTE;
        status = iso_level_attach_palette(&level, code, &m->palette, err);
    }
    TRY(status, iso_gl_render(s->gl, &level, code, view, &o, image, err));
    if (m->palette.count)
        iso_level_detach_palette(&level);
    return status;
}

/* Moves the second view to the other side and below. */
static void look_from_behind(iso_scene *scene, const iso_geometry *g)
{
    const iso_viewpoint behind = {{-scene->camera_direction.x, -scene->camera_direction.y, -scene->camera_direction.z},
                                  scene->camera_up};
    iso_scene_look_from(scene, g, &behind);
}

static iso_status draw_row(const iso_paper *p, stage *s, size_t row, json_t *rows, iso_error *err)
{
    const iso_geometry *g = &s->pyramid.levels[0].geometry;
    OWNED(iso_view) view = {0};
    iso_image images[METHODS] = {{0}};
    if (row == 1)
        look_from_behind(&s->scene, g);
    iso_status status = iso_scene_resolve(&s->scene, g, iso_pyramid_lo(&s->pyramid), iso_pyramid_hi(&s->pyramid), &view,
                                          err);
    if (status != ISO_OK)
        return status;
    for (int i = 0; i < METHODS && status == ISO_OK; ++i) {
        iso_metrics metrics = {0};
        char note[64];
        status = render(s, &view, &s->methods[i], &images[i], err);
        if (status == ISO_OK && i > 0)
            status = iso_metrics_measure(&images[0], &images[i], &metrics, err);
        if (i == 0)
            snprintf(note, sizeof note, "view %zu", row + 1);
        else
            snprintf(note, sizeof note, "RMSE %.4f", metrics.rmse);
        if (status == ISO_OK) {
            const iso_page_box box = iso_paper_picture(p, row, (size_t)i, row == 0 ? s->methods[i].title : NULL, note,
                                                       &images[i]);
            if (row == 0 && i == 0)
                iso_page_put_scale_bar(p->page, &box, &images[i], iso_view_mm_per_pixel(&view, g));
        }
        if (i > 0)
            json_array_append_new(rows, json_pack("{s:i, s:i, s:f}", "view", (int)row + 1, "entries",
                                                  (int)s->methods[i].palette.count - 1, "rmse", metrics.rmse));
    }
    for (int i = 0; i < METHODS; ++i)
        iso_image_destroy(&images[i]);
    return status;
}

static iso_status draw_rows(const iso_figure_job *job, iso_page *page, stage *s, json_t *pictures, iso_error *err)
{
    const iso_paper_row row = {.columns = METHODS,
                               .aspect = (double)s->scene.height / (double)s->scene.width,
                               .gap_mm = 1.5,
                               .most_mm = 60,
                               .has_titles = true,
                               .has_notes = true};
    iso_paper_row rows[VIEWS] = {row, row};
    iso_paper p;
    rows[1].has_titles = false;
    NEED(iso_paper_lay_out(&p, job, page, rows, VIEWS, err));
    const size_t dots = iso_paper_dots(&p, 0);
    s->scene.height = (size_t)fmax(1, rint((double)dots * row.aspect));
    s->scene.width = dots;
    for (size_t i = 0; i < VIEWS; ++i)
        NEED(draw_row(&p, s, i, pictures, err));
    return ISO_OK;
}

static iso_status palette_views(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    stage s;
    json_t *pictures = json_array(), *errors = json_array();
    json_object_set_new(job->facts, "palettes", errors);
    json_object_set_new(job->facts, "pictures", pictures);
    iso_status status = begin(job, &s, err);
    if (status == ISO_OK)
        fprintf(
            iso_page_caption(page),
            "The isosurface of %s at the value %.4g from two sides, shaded by all directions, by a palette fitted to "
            "them by annealing, and by one of a regular subdivision of the sphere.",
            iso_paper_volume_name(job, &own_wing), s.surface);
    TRY(status, draw_rows(job, page, &s, pictures, err));
    for (int i = 1; i < METHODS && status == ISO_OK; ++i) {
        const method *m = &s.methods[i];
        fprintf(iso_page_caption(page), " %s: error norm 1 %.4g, rms angle %.3g degrees.", m->title, m->error.norm1,
                m->error.rms_deg);
        json_array_append_new(errors, json_pack("{s:i, s:f, s:f}", "entries", (int)m->palette.count - 1, "norm1",
                                                m->error.norm1, "rms_deg", m->error.rms_deg));
    }
    end(&s);
    return status;
}

const iso_figure_info iso_figure_palette_views = {
    .name = "palette-views",
    .summary = "a surface shaded by all directions and by palettes [bremer-2001], Figures 10 to 15",
    .takes = ISO_FIGURE_OF_NOTHING | ISO_FIGURE_OF_VOLUME | ISO_FIGURE_HAS_LOOK | ISO_LAB_FIGURE_HAS_ENTRIES |
             ISO_LAB_FIGURE_HAS_SURFACE,
    .draw = palette_views,
};
