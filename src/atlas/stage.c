/* SPDX-License-Identifier: MIT */
/* stage.c - a scene of the atlas as volume, view and scene file; a way as a picture. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/random.h"
#include "options/adapted.h"
#include "atlas/atlas.h"
#include "options/cli.h"
#include "render/reference.h"

static const double color[3] = {0.95, 0.72, 0.5};
static const iso_shading shading = {.ambient = 0.1, .diffuse = 0.65, .specular = 0.25, .power = 20};
static const double step_voxels = 0.25, unit_distance_mm = 1e-3;

/* ---- the volume ---- */

iso_status iso_atlas_volume(const iso_atlas_scene *scene, iso_volume *v, iso_error *err)
{
    const double *n = (const double[3]){(double)scene->size[0], (double)scene->size[1], (double)scene->size[2]};
    const double spacing[3] = {2 / n[0], 2 / n[1], 2 / n[2]}, steps = (double)scene->values - 1;
    const iso_geometry g = iso_geometry_axis_aligned(scene->size, spacing);
    iso_random random = {.state = 1};
    NEED(iso_volume_create(v, &g, ISO_F32, "atlas", err));
    float *out = v->data;
    for (size_t z = 0; z < g.size[2]; ++z)
        for (size_t y = 0; y < g.size[1]; ++y)
            for (size_t x = 0; x < g.size[0]; ++x) {
                iso_vec3 normal, index = {(double)x + 0.5, (double)y + 0.5, (double)z + 0.5};
                double value = scene->field(iso_geometry_to_world(&g, index), &normal) +
                               scene->noise * (2 * iso_random_unit(&random) - 1);
                *out++ = (float)(scene->values ? round(value * steps) / steps : value);
            }
    return ISO_OK;
}

/* ---- the view, and the same as a file ---- */

static iso_vec3 forward_of(const iso_atlas_scene *s)
{
    return iso_normalize(iso_norm(s->forward) > 0 ? s->forward : iso_v3(1, 2, -1.2));
}

static iso_vec3 light_of(const iso_atlas_scene *s)
{
    return iso_normalize(iso_norm(s->light) > 0 ? s->light : iso_v3(-0.55, -0.25, 0.8));
}

double iso_atlas_picture_mm(const iso_atlas_scene *s)
{
    return s->height_mm > 0 ? s->height_mm : 1.7;
}

/* Converts the scene's TF; it refers to `points`, of which at most 5 are used. */
static iso_tf tf_of(const iso_atlas_scene *s, iso_tf_point points[5])
{
    const double opacity = 1 - exp(-s->extinction_per_mm * unit_distance_mm);
    const double values[2][5] = {{0, s->lo, s->hi, 1, 1}, {0, s->lo, 0.5 * (s->lo + s->hi), s->hi, 1}};
    const double shown[2][5] = {{0, 0, 1, 1, 1}, {0, 0, 1, 0, 0}};
    for (size_t i = 0; i < 5; ++i) {
        points[i] = (iso_tf_point){.value = values[s->band][i], .opacity = opacity * shown[s->band][i]};
        memcpy(points[i].rgb_linear, color, sizeof color);
    }
    return (iso_tf){.point_count = s->band ? 5 : 4,
                    .points = points,
                    .range = {0, 1},
                    .unit_distance = unit_distance_mm,
                    .table_size = 512};
}

iso_status iso_atlas_tf(const iso_atlas_scene *s, const iso_geometry *g, iso_tf_table *tf, iso_error *err)
{
    iso_tf_point points[5];
    const iso_tf of_scene = tf_of(s, points);
    return iso_tf_tabulate(&of_scene, 0, 1, g, tf, err);
}

static iso_status make_view(const iso_atlas_scene *s, const iso_geometry *g, iso_view *view, iso_error *err)
{
    const size_t pixels = s->pixels ? s->pixels : ISO_ATLAS_PIXELS;
    *view =
        (iso_view){.width = pixels, .height = pixels, .light_count = 1, .step_voxels = step_voxels, .shading = shading};
    view->lights[0] = (iso_light){.direction = light_of(s), .intensity = 1};
    iso_camera *c = &view->camera;
    *c = (iso_camera){.orthographic = true, .forward = forward_of(s), .half_height = 0.5 * iso_atlas_picture_mm(s)};
    c->right = iso_normalize(iso_cross(c->forward, iso_v3(0, 0, 1)));
    c->up = iso_cross(c->right, c->forward);
    c->position = iso_scale(c->forward, -10);
    return iso_atlas_tf(s, g, &view->tf, err);
}

static json_t *vector(iso_vec3 v)
{
    return json_pack("[f, f, f]", v.x, v.y, v.z);
}

json_t *iso_atlas_scene_to_json(const iso_atlas_scene *s, const char *comment)
{
    iso_tf_point points[5];
    const iso_tf tf = tf_of(s, points);
    return json_pack("{s:s, s:s, s:{s:i, s:i}, s:{s:s, s:o, s:[f, f, f], s:[i, i, i], s:f}, s:[{s:o, s:s}], "
                     "s:{s:f, s:f, s:f, s:f}, s:[i, i, i], s:f, s:o}",
                     "schema", "isoshade.scene/1", "comment", comment, "image", "width", ISO_ATLAS_PIXELS, "height",
                     ISO_ATLAS_PIXELS, "camera", "projection", "orthographic", "position",
                     vector(iso_scale(forward_of(s), -10)), "look_at", 0., 0., 0., "up", 0, 0, 1, "height_mm",
                     iso_atlas_picture_mm(s), "lights", "direction", vector(light_of(s)), "space", "world", "shading",
                     "ambient", shading.ambient, "diffuse", shading.diffuse, "specular", shading.specular, "power",
                     shading.power, "background", 0, 0, 0, "step_voxels", step_voxels, "tf", iso_tf_to_json(&tf));
}

/* ---- a way ---- */

/* Options of a way, parsed as by the two commands. */
typedef struct taken_options {
    iso_pyramid_options build;
    iso_reference_options render;
    iso_cli_adapted adapted;
    size_t level;
} taken_options;

typedef struct option_words {
    char *estimator, *direction_filter, *shading_from;
    int level, radius, exponent;
    double sigma, step;
} option_words;

static iso_status parse(const char *text, const struct poptOption *options, iso_error *err)
{
    int count = 0;
    FREED const char **words = NULL;
    if (!text)
        return ISO_OK;
    if (poptParseArgvString(text, &count, &words) != 0)
        return iso_fail(err, ISO_E_USAGE, "atlas: \"%s\" is not a list of options", text);
    poptContext context = poptGetContext("atlas", count, words, options, POPT_CONTEXT_KEEP_FIRST);
    int rc = poptGetNextOpt(context);
    bool left = poptPeekArg(context) != NULL;
    poptFreeContext(context);
    return rc == -1 && !left ? ISO_OK : iso_fail(err, ISO_E_USAGE, "atlas: unknown option in \"%s\"", text);
}

static iso_status take_words(const option_words *w, taken_options *o, iso_error *err)
{
    if (w->estimator)
        NEED(iso_gradient_from_name(w->estimator, &o->build.gradient.method, err));
    if (w->direction_filter)
        NEED(iso_direction_filter_from_name(w->direction_filter, &o->build.direction_filter, err));
    if (w->shading_from)
        NEED(iso_direction_source_from_name(w->shading_from, &o->render.source, err));
    o->level = (size_t)w->level;
    o->build.level_count = o->level + 1;
    o->build.keep_float = true;
    o->build.gauss_radius = (size_t)w->radius;
    o->build.gauss_sigma_voxels = w->sigma;
    o->build.eq1_exponent = (size_t)w->exponent;
    o->render.step_voxels = w->step;
    o->render.quadrature = ISO_QUADRATURE_MIDPOINT;
    return ISO_OK;
}

/* Parses the options of a way. Free o->adapted.tf_2d. */
static iso_status take_options(const iso_atlas_way *way, taken_options *o, iso_error *err)
{
    *o = (taken_options){.build = iso_pyramid_defaults(), .render = iso_reference_defaults()};
    o->adapted = (iso_cli_adapted)ISO_CLI_ADAPTED_DEFAULTS;
    option_words w = {.radius = (int)o->build.gauss_radius,
                      .exponent = (int)o->build.eq1_exponent,
                      .sigma = o->build.gauss_sigma_voxels};
    const struct poptOption build[] = {{"estimator", 0, POPT_ARG_STRING, &w.estimator, 0, NULL, NULL},
                                       {"direction-filter", 0, POPT_ARG_STRING, &w.direction_filter, 0, NULL, NULL},
                                       {"gauss-radius", 0, POPT_ARG_INT, &w.radius, 0, NULL, NULL},
                                       {"gauss-sigma", 0, POPT_ARG_DOUBLE, &w.sigma, 0, NULL, NULL},
                                       {"eq1-exponent", 0, POPT_ARG_INT, &w.exponent, 0, NULL, NULL},
                                       POPT_TABLEEND};
    const struct poptOption render[] = {{"level", 0, POPT_ARG_INT, &w.level, 0, NULL, NULL},
                                        {"shading-from", 0, POPT_ARG_STRING, &w.shading_from, 0, NULL, NULL},
                                        {"step", 0, POPT_ARG_DOUBLE, &w.step, 0, NULL, NULL},
                                        {"adapt", 0, POPT_ARG_NONE, &o->adapted.wanted, 0, NULL, NULL},
                                        {"tf-2d", 0, POPT_ARG_STRING, &o->adapted.tf_2d, 0, NULL, NULL},
                                        {"always", 0, POPT_ARG_NONE, &o->adapted.always, 0, NULL, NULL},
                                        POPT_TABLEEND};
    iso_status status = parse(way->build, build, err);
    TRY(status, parse(way->render, render, err));
    TRY(status, take_words(&w, o, err));
    free(w.estimator);
    free(w.direction_filter);
    free(w.shading_from);
    return status;
}

static iso_status draw(const iso_atlas_scene *scene, const iso_pyramid *p, const taken_options *o, iso_image *image,
                       iso_error *err)
{
    OWNED(iso_view) view = {0};
    NEED(make_view(scene, &p->levels[0].geometry, &view, err));
    NEED(iso_cli_adapt_view(&o->adapted, "", p, o->level, &view, 0, err));
    return iso_reference_render(&p->levels[o->level], p->options.code, &view, &o->render, image, NULL, err);
}

iso_status iso_atlas_show(const iso_atlas_case *c, iso_atlas_which which, const iso_volume *v, iso_image *image,
                          double *value, iso_error *err)
{
    const iso_atlas_way *way = &c->ways[which];
    taken_options o;
    iso_pyramid p = {0};
    *value = NAN;
    if (c->draw)
        return c->draw(v, which, image, value, err);
    iso_status status = take_options(way, &o, err);
    TRY(status, iso_pyramid_build(v, "atlas", &o.build, &p, NULL, err));
    if (status == ISO_OK && way->fault)
        status = way->fault(&c->scene, &p, o.level, err);
    TRY(status, draw(&c->scene, &p, &o, image, err));
    iso_pyramid_destroy(&p);
    free(o.adapted.tf_2d);
    return status;
}
