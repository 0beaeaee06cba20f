/* SPDX-License-Identifier: MIT */
/* brick_scene.h - bricks of random levels, and what the double-precision reference shows of them. */
#pragma once

#include "difference.h"
#include "sampled.h"

#include "base/random.h"
#include "brick/bricks.h"
#include "render/reference.h"
#include "scene/scene.h"

typedef struct brick_scene {
    iso_pyramid pyramid;
    iso_level level; /* level 0; lent */
    iso_node_levels nodes;
    iso_view view;
    uint8_t levels[5 * 7 * 4];
} brick_scene;

/* Of the scene of refscenes/, after change(), which may be NULL. */
static void make_changed_brick_scene(brick_scene *s, iso_field_kind kind, size_t level_count,
                                     void (*change)(iso_scene *))
{
    const double c = cos(0.4), d = sin(0.4);
    iso_geometry g = {.size = {40, 56, 33},
                      .origin_mm = {-17, 5, 40},
                      .box_index = {40, 56, 33},
                      .index_to_world = {{{c, -0.8 * d, 0}, {d, 0.8 * c, 0}, {0, 0, 1.7}}}};
    iso_field f = {.kind = kind, .geometry = g, .seed = 3};
    iso_pyramid_options build = iso_pyramid_defaults();
    OWNED(iso_scene) file;
    build.level_count = level_count;
    *s = (brick_scene){.pyramid = sampled_pyramid(&f, ISO_F32, &build)};
    s->level = s->pyramid.levels[0];
    assert_ok(iso_node_levels_create(&s->nodes, &s->level, 8, 4, true, 0, &err));
    assert_ok(iso_scene_load("refscenes/marschner-lobb.scene.json", &file, &err));
    file.width = 64, file.height = 56;
    if (change)
        change(&file);
    assert_ok(iso_scene_resolve(&file, &g, s->level.min, s->level.max, &s->view, &err));
    iso_random random = {3};
    assert_int_equal(iso_brick_count(&s->nodes), sizeof s->levels);
    for (size_t i = 0; i < sizeof s->levels; ++i)
        s->levels[i] = (uint8_t)iso_random_below(&random, 4);
}

static inline void make_brick_scene(brick_scene *s, iso_field_kind kind)
{
    make_changed_brick_scene(s, kind, 1, NULL);
}

static void destroy_brick_scene(brick_scene *s)
{
    iso_view_destroy(&s->view);
    iso_node_levels_destroy(&s->nodes);
    iso_pyramid_destroy(&s->pyramid);
}

static inline iso_image brick_reference(const iso_brick_field *f, const iso_view *view)
{
    iso_reference_options opt = iso_reference_defaults();
    opt.quadrature = ISO_QUADRATURE_MIDPOINT;
    iso_image image;
    assert_ok(iso_reference_render_bricks(f, view, &opt, &image, NULL, &err));
    return image;
}
