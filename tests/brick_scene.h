/* SPDX-License-Identifier: MIT */
/* brick_scene.h - bricks of random levels, and what the double-precision reference shows of them. */
#pragma once

#include "test.h"

#include <math.h>
#include <stdlib.h>

#include "base/random.h"
#include "brick/bricks.h"
#include "render/reference.h"
#include "scene/scene.h"
#include "volume/synthetic.h"

typedef struct brick_scene {
    iso_level level;
    iso_node_levels nodes;
    iso_view view;
    uint8_t levels[5 * 7 * 4];
} brick_scene;

static void make_brick_scene(brick_scene *s, iso_field_kind kind)
{
    const double c = cos(0.4), d = sin(0.4);
    iso_geometry g = {.size = {40, 56, 33},
                      .origin_mm = {-17, 5, 40},
                      .box_index = {40, 56, 33},
                      .index_to_world = {{{c, -0.8 * d, 0}, {d, 0.8 * c, 0}, {0, 0, 1.7}}}};
    iso_field f = {.kind = kind, .geometry = g, .seed = 3};
    iso_volume v;
    OWNED(iso_scene) file;
    assert_ok(iso_field_sample(&f, ISO_F32, &v, &err));
    iso_volume_stats stats = iso_volume_measure(&v);
    *s = (brick_scene){
        .level = {.geometry = g, .stored_type = ISO_F32, .scalar = v.data, .min = stats.min, .max = stats.max}};
    assert_ok(iso_node_levels_create(&s->nodes, &s->level, 8, 4, true, 0, &err));
    assert_ok(iso_scene_load("refscenes/marschner-lobb.scene.json", &file, &err));
    file.width = 64, file.height = 56;
    assert_ok(iso_scene_resolve(&file, &g, stats.min, stats.max, &s->view, &err));
    iso_random random = {3};
    assert_int_equal(iso_brick_count(&s->nodes), sizeof s->levels);
    for (size_t i = 0; i < sizeof s->levels; ++i)
        s->levels[i] = (uint8_t)iso_random_below(&random, 4);
}

static void destroy_brick_scene(brick_scene *s)
{
    iso_view_destroy(&s->view);
    iso_node_levels_destroy(&s->nodes);
    free(s->level.scalar);
}

static double max_difference(const iso_image *a, const iso_image *b, double *rmse)
{
    double max = 0, sum = 0;
    size_t count = 4 * a->width * a->height;
    for (size_t i = 0; i < count; ++i) {
        double e = fabs((double)a->rgba[i] - (double)b->rgba[i]);
        if (!(e <= max))
            max = e;
        sum += e * e;
    }
    *rmse = sqrt(sum / (double)count);
    return max;
}

static iso_image brick_reference(const iso_brick_field *f, const iso_view *view)
{
    iso_reference_options opt = iso_reference_defaults();
    opt.quadrature = ISO_QUADRATURE_MIDPOINT;
    iso_image image;
    assert_ok(iso_reference_render_bricks(f, view, &opt, &image, NULL, &err));
    return image;
}
