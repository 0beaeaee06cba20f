/* SPDX-License-Identifier: MIT */
#include "render/reference.h"

#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "render/cell_ray.h"
#include "render/reference_ray.h"
#include "render/sampler.h"
#include "scene/roi.h"
#include "tf/integral.h"

iso_reference_options iso_reference_defaults(void)
{
    return (iso_reference_options){.quadrature = ISO_QUADRATURE_CONVERGED,
                                   .source = ISO_FROM_CODES,
                                   .intervals = 100,
                                   .tolerance = 1e-6,
                                   .most_error = 1e-9};
}

/* Sets bends[i + 1] where a component's slope changes at entry i by more than a thousandth of its largest value. */
static void mark_bends(const iso_tf_table *tf, size_t *bends)
{
    double largest[4] = {0};
    for (size_t i = 0; i < 4 * tf->count; ++i)
        largest[i % 4] = fmax(largest[i % 4], (double)tf->entries[i]);
    for (size_t i = 0; i < tf->count; ++i) {
        const float *before = tf->entries + 4 * (i > 0 ? i - 1 : 0), *here = tf->entries + 4 * i;
        const float *after = i + 1 < tf->count ? here + 4 : here;
        for (size_t c = 0; c < 4; ++c)
            if (fabs((double)after[c] - 2 * (double)here[c] + (double)before[c]) > 1e-3 * largest[c])
                bends[i + 1] = 1;
    }
}

/* Counts bends: bends[i] is their number below entry i, in any row of a 2D transfer function. The caller frees it;
 * NULL: out of memory. */
static size_t *bends_create(const iso_tf_table *tf, const iso_tf_2d *tf_2d)
{
    size_t *bends = calloc(tf->count + 1, sizeof *bends);
    for (int c = 0; bends && c < (tf_2d ? ISO_TF_2D_ROWS : 1); ++c)
        mark_bends(tf_2d ? &tf_2d->rows[c] : tf, bends);
    for (size_t i = 0; bends && i < tf->count; ++i)
        bends[i + 1] += bends[i];
    return bends;
}

/* Data shared by all pixels of an image. */
typedef struct picture {
    layer layers[2];
    const iso_view *view;
    const iso_reference_options *opt;
    iso_tf_integral integral;
    iso_shown shown;
    iso_empty_space empty;
    iso_cell_scene cells;
    bool by_cells;
    iso_image *image;
} picture;

/* Renders a pixel. Returns its error if the quadrature is the converged one. */
static double render_pixel(const picture *p, size_t column, size_t row)
{
    const iso_view *view = p->view;
    const iso_reference_options *opt = p->opt;
    const iso_geometry *g = &p->layers[0].sampler->level->geometry;
    iso_ray ray = iso_camera_ray(&view->camera, view->width, view->height, column, row);
    iso_mat3 to_index = iso_mat3_inverse(g->index_to_world);
    ray_state state = {.layer = &p->layers[0],
                       .roi = view->roi ? &p->layers[1] : NULL,
                       .view = view,
                       .emitter = opt->emitter,
                       .integral = &p->integral,
                       .empty = &p->empty,
                       .plain = opt->plain,
                       .to_viewer = iso_scale(ray.direction, -1),
                       .origin = iso_mul(to_index, iso_sub(ray.origin, g->origin_mm)),
                       .direction = iso_mul(to_index, ray.direction)};
    double t0, t1, error = 0;
    stretch s = {{0}, 0};
    if (iso_view_ray(view, &ray, g, &t0, &t1) && t1 > t0) {
        const iso_cell_ray r = {state.origin, state.direction, state.to_viewer, t0, t1, opt->most_error};
        s = p->by_cells ? iso_cell_ray_integrate(&p->cells, &r, &error)
                        : iso_reference_integrate(&state, opt, t0, t1, &error);
    }
    double t_end = exp(-s.depth);
    const bool color = opt->quadrature != ISO_QUADRATURE_FIRST_HIT || opt->output == ISO_SURFACE_COLOR;
    const size_t pixel = row * view->width + column;
    double rgba[4];
    for (int c = 0; c < 3; ++c)
        rgba[c] = s.color[c] + (color ? t_end * view->background[c] : 0);
    rgba[3] = 1 - t_end;
    for (size_t c = 0; c < 4; ++c)
        p->image->rgba[4 * pixel + c] = (float)rgba[c];
    for (size_t c = 0; c < 4 && opt->result && opt->result->rgba; ++c)
        opt->result->rgba[4 * pixel + c] = rgba[c];
    return error;
}

static iso_status check_options(const iso_view *view, const iso_reference_options *opt, iso_error *err)
{
    if (!(opt->tolerance > 0 && opt->most_error > 0) || opt->intervals < 1)
        return iso_fail(err, ISO_E_RANGE, "reference: tolerance %g, error %g and intervals %zu must be above 0",
                        opt->tolerance, opt->most_error, opt->intervals);
    if (view->tf_2d && opt->quadrature == ISO_QUADRATURE_PREINTEGRATED)
        return iso_fail(err, ISO_E_USAGE, "reference: a TF over two values is not pre-integrated");
    const bool integrates = opt->quadrature == ISO_QUADRATURE_MIDPOINT || opt->quadrature == ISO_QUADRATURE_CONVERGED;
    if (opt->emitter && (view->roi || !integrates))
        return iso_fail(err, ISO_E_USAGE,
                        "reference: an emitter is rendered converged or by midpoints, without a region of interest");
    if (view->roi && (opt->quadrature == ISO_QUADRATURE_PREINTEGRATED || opt->quadrature == ISO_QUADRATURE_FIRST_HIT))
        return iso_fail(err, ISO_E_USAGE, "reference: a region of interest is neither pre-integrated nor a surface");
    return ISO_OK;
}

/* Tiles are small compared with the image, so that the last ones leave no thread waiting for long. */
enum { TILE = 8 };

static void render_tiles(const picture *p, const iso_progress *progress)
{
    const size_t across = (p->view->width + TILE - 1) / TILE, count = across * ((p->view->height + TILE - 1) / TILE);
    size_t done = 0;
    double worst = 0;
#pragma omp parallel for schedule(dynamic) num_threads(iso_threads(p->opt->threads)) reduction(max : worst)
    for (size_t tile = 0; tile < count; ++tile) {
        const size_t x = tile % across * TILE, y = tile / across * TILE;
        for (size_t row = y; row < y + TILE && row < p->view->height; ++row)
            for (size_t column = x; column < x + TILE && column < p->view->width && !iso_progress_poll(progress);
                 ++column)
                worst = fmax(worst, render_pixel(p, column, row));
        if (iso_progress_poll(progress))
            continue;
#pragma omp critical(iso_reference_progress)
        iso_progress_report(progress, "reference", (double)++done / (double)count);
    }
    if (p->opt->result) {
        p->opt->result->error = p->opt->quadrature == ISO_QUADRATURE_CONVERGED ? worst : NAN;
        p->opt->result->is_proved = p->by_cells;
    }
}

/* True if building the tree saves time. Small pictures of large volumes meet few voxels, and reading all of them takes
 * longer than it saves: some 25 ns per cell met, half a nanosecond per voxel. */
static bool is_worth_a_tree(const picture *p)
{
    const iso_geometry *g = &p->layers[0].sampler->level->geometry;
    const double met = 0.5 * (double)(p->view->width * p->view->height) *
                       (double)(g->size[0] + g->size[1] + g->size[2]);
    return 50 * met > (double)iso_geometry_voxel_count(g);
}

/* Finds the empty space, and decides whether rays go by cells. Bricks and emitters have no tree: rays skip no part of
 * them. */
static iso_status find_empty_space(picture *p, iso_error *err)
{
    const iso_sampler *s = p->layers[0].sampler;
    const iso_roi *roi = p->view->roi;
    if (s->bricks || p->opt->emitter || p->opt->plain || p->opt->quadrature == ISO_QUADRATURE_FIRST_HIT ||
        p->opt->quadrature == ISO_QUADRATURE_PREINTEGRATED)
        return ISO_OK;
    double lo[3], hi[3];
    for (int a = 0; a < 3 && roi; ++a) {
        lo[a] = roi->lo[a] - roi->band;
        hi[a] = roi->hi[a] + roi->band;
    }
    iso_status status = iso_shown_create(&p->shown, p->layers[0].tf, p->view->tf_2d, err);
    if (status == ISO_OK && is_worth_a_tree(p))
        status = iso_empty_space_create(&p->empty, s->level, &p->shown, roi ? lo : NULL, hi, p->opt->threads, err);
    if (status != ISO_OK || p->opt->quadrature != ISO_QUADRATURE_CONVERGED || !iso_cell_scene_is_for(s, p->view))
        return status;
    p->by_cells = true;
    return iso_cell_scene_create(&p->cells, s, p->view, &p->shown, &p->empty, err);
}

/* Renders all pixels. roi: sampler of the region of interest, or NULL. */
static iso_status render_all(const iso_sampler *sampler, const iso_sampler *roi, const iso_view *view,
                             const iso_reference_options *opt, iso_image *image, const iso_progress *progress,
                             iso_error *err)
{
    const iso_roi *f = view->roi;
    /* The rows of a 2D transfer function have one range and count, so the first serves for them where entries are
     * counted. */
    const iso_tf_table *tf = view->tf_2d ? &view->tf_2d->rows[0] : &view->tf;
    size_t *bends = bends_create(tf, view->tf_2d), *roi_bends = f ? bends_create(&f->tf, NULL) : NULL;
    picture p = {.view = view, .opt = opt, .image = image};
    p.layers[0] = (layer){.sampler = sampler,
                          .tf = tf,
                          .tf_2d = view->tf_2d,
                          .extinction_scale = view->extinction_scale,
                          .bends = bends,
                          .scale = 1};
    if (f)
        p.layers[1] = (layer){.sampler = roi,
                              .tf = &f->tf,
                              .bends = roi_bends,
                              .scale = f->scale,
                              .offset = {f->offset[0], f->offset[1], f->offset[2]}};
    iso_status status = iso_image_create(image, view->width, view->height, err);
    if (status == ISO_OK && (!bends || (f && !roi_bends)))
        status = iso_fail(err, ISO_E_MEMORY, "reference: out of memory");
    if (status == ISO_OK && opt->quadrature == ISO_QUADRATURE_PREINTEGRATED)
        status = iso_tf_integral_create(&p.integral, &view->tf, err);
    TRY(status, find_empty_space(&p, err));
    if (status == ISO_OK)
        render_tiles(&p, progress);
    iso_cell_scene_destroy(&p.cells);
    iso_empty_space_destroy(&p.empty);
    iso_shown_destroy(&p.shown);
    iso_tf_integral_destroy(&p.integral);
    free(bends);
    free(roi_bends);
    if (status != ISO_OK)
        iso_image_destroy(image);
    return status;
}

iso_status iso_reference_render(const iso_level *level, iso_code code, const iso_view *view,
                                const iso_reference_options *opt, iso_image *image, const iso_progress *progress,
                                iso_error *err)
{
    OWNED(iso_sampler) sampler = {0}, roi = {0};
    *image = (iso_image){0};
    NEED(check_options(view, opt, err));
    NEED(iso_sampler_create(&sampler, level, code, opt->source, err));
    if (view->roi)
        NEED(iso_sampler_create(&roi, &view->roi->level, code, opt->source, err));
    return render_all(&sampler, &roi, view, opt, image, progress, err);
}

iso_status iso_reference_render_bricks(const iso_brick_field *bricks, const iso_view *view,
                                       const iso_reference_options *opt, iso_image *image, const iso_progress *progress,
                                       iso_error *err)
{
    iso_sampler sampler;
    iso_level level;
    *image = (iso_image){0};
    NEED(check_options(view, opt, err));
    if (view->tf_2d || view->extinction_scale || view->roi)
        return iso_fail(err, ISO_E_RANGE,
                        "reference: bricks have no 2D transfer function, extinction scale or region of interest");
    iso_sampler_of_bricks(&sampler, bricks, &level);
    return render_all(&sampler, NULL, view, opt, image, progress, err);
}
