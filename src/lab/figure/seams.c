/* SPDX-License-Identifier: MIT */
/* seams.c - bricks of alternating levels: with their own nodes, whose faces jump, and with shared ones. */
#include <stdlib.h>

#include "figure/columns.h"
#include "lab/figure/paper_kinds.h"
#include "figure/picture.h"
#include "render/gl/bricks_gl.h"

enum { BRICK_VOXELS = 16, USUAL_LEVELS = 3, WAYS = 3 };

typedef struct bricks {
    iso_figure_subject subject;
    iso_node_levels nodes;
    uint8_t *levels[2]; /* all 0; alternating */
    iso_gl *gl;
} bricks;

static iso_status render(void *user, size_t column, size_t width, size_t height, iso_image *image, double *mm_per_pixel,
                         iso_error *err)
{
    bricks *b = user;
    iso_scene scene = b->subject.scene; /* borrows what it owns */
    const iso_geometry *geometry = &b->subject.pyramid.levels[0].geometry;
    const iso_brick_field field = {&b->nodes, b->levels[column > 0], column == 1 ? ISO_FACES_OWN : ISO_FACES_BAKED};
    const iso_gl_brick_options opt = iso_gl_brick_defaults();
    OWNED(iso_view) view = {0};
    scene.width = width, scene.height = height;
    NEED(iso_scene_resolve(&scene, geometry, iso_pyramid_lo(&b->subject.pyramid), iso_pyramid_hi(&b->subject.pyramid),
                           &view, err));
    NEED(iso_gl_render_bricks(b->gl, &field, &view, &opt, image, NULL, err));
    *mm_per_pixel = iso_view_mm_per_pixel(&view, geometry);
    return ISO_OK;
}

/* Alternates levels, so that neighbors across every face differ by one level. */
static iso_status alternate(bricks *b, size_t level_count, iso_error *err)
{
    const iso_node_levels *n = &b->nodes;
    for (int i = 0; i < 2; ++i)
        if (!(b->levels[i] = calloc(iso_brick_count(n), 1)))
            return iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
    for (size_t z = 0; z < n->count[2]; ++z)
        for (size_t y = 0; y < n->count[1]; ++y)
            for (size_t x = 0; x < n->count[0]; ++x)
                b->levels[1][iso_brick_index(n, (size_t[3]){x, y, z})] = (uint8_t)((x + y + z) % level_count);
    return ISO_OK;
}

static iso_status draw_seams(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    bricks b = {0};
    const size_t level_count = job->levels ? (size_t)job->levels : USUAL_LEVELS;
    iso_figure_columns c = {.job = job,
                            .count = WAYS,
                            .titles = {"level 0 everywhere", "mixed, own faces", "mixed, shared faces"},
                            .compared = true,
                            .render = render,
                            .user = &b};
    iso_status status = iso_figure_subject_load(&b.subject, job, 1, NULL, err);
    TRY(status, iso_subject_refuse_labels(&b.subject.pyramid, job->input, "--kind seams", err));
    TRY(status, iso_node_levels_create(&b.nodes, &b.subject.pyramid.levels[0], BRICK_VOXELS, level_count, true,
                                       job->cli->threads, err));
    TRY(status, iso_node_levels_round(&b.nodes, job->cli->threads, err));
    TRY(status, alternate(&b, level_count, err));
    TRY(status, iso_gl_create(&b.gl, NULL, err));
    if (status == ISO_OK) {
        FILE *f = iso_page_caption(page);
        fprintf(f, "Bricks of %d voxels per side at alternating levels 0 to %zu", BRICK_VOXELS, level_count - 1);
        iso_figure_put_subject(&b.subject, f);
        fputs(", each with the nodes of its own level, whose faces jump, and with shared ones", f);
        c.aspect = iso_figure_aspect(&b.subject);
        c.tf = iso_figure_tf_foot_of(&b.subject);
        status = iso_figure_draw_columns(&c, page, err);
    }
    iso_gl_destroy(b.gl);
    free(b.levels[0]);
    free(b.levels[1]);
    iso_node_levels_destroy(&b.nodes);
    iso_figure_subject_end(&b.subject);
    return status;
}

const iso_figure_info iso_figure_seams = {
    .name = "seams",
    .summary = "bricks of alternating levels, with seams and without, and maps of both",
    .takes = ISO_FIGURE_OF_VOLUME | ISO_FIGURE_HAS_LOOK | ISO_FIGURE_HAS_LEVELS | ISO_FIGURE_HAS_INSET,
    .draw = draw_seams,
};
