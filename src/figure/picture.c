/* SPDX-License-Identifier: MIT */
#include "figure/picture.h"

#include <math.h>
#include <string.h>

#include "base/provenance.h"
#include "renderers/picture_store.h"
#include "scene/subject.h"

iso_status iso_figure_scene_tf(const iso_scene *scene, const iso_pyramid *p, iso_tf_table *tf, iso_error *err)
{
    OWNED(iso_view) view = {0};
    NEED(iso_scene_resolve(scene, &p->levels[0].geometry, iso_pyramid_lo(p), iso_pyramid_hi(p), &view, err));
    return iso_tf_table_copy(&view.tf, tf, err);
}

iso_status iso_figure_subject_load(iso_figure_subject *s, const iso_figure_job *job, size_t level_count,
                                   const iso_pyramid_options *build, iso_error *err)
{
    iso_subject_look look;
    iso_pyramid_options options = build ? *build : iso_pyramid_defaults();
    const iso_progress progress = iso_cli_progress(job->cli);
    s->job = job;
    s->renderers.store = job->store;
    options.threads = job->cli->threads;
    options.level_count = level_count;
    NEED(iso_cli_look_check(&job->look, job->cli->threads, &look, err));
    NEED(iso_subject_load_pyramid(job->input, &job->volume, &options, &progress, &s->pyramid, err));
    if (level_count > s->pyramid.level_count)
        return iso_fail(err, ISO_E_RANGE, "%s has levels 0 to %zu, the figure would show level %zu", job->input,
                        s->pyramid.level_count - 1, level_count - 1);
    NEED(iso_subject_make_scene(&look, &s->pyramid, &s->scene, err));
    if (job->has_background)
        memcpy(s->scene.background, job->background, sizeof s->scene.background);
    return iso_figure_scene_tf(&s->scene, &s->pyramid, &s->tf, err);
}

void iso_figure_subject_end(iso_figure_subject *s)
{
    iso_tf_table_destroy(&s->tf);
    iso_scene_destroy(&s->scene);
    iso_pyramid_destroy(&s->pyramid);
    iso_renderers_end(&s->renderers);
}

iso_status iso_figure_renderer(const iso_figure_job *job, const iso_renderer_info **with, iso_error *err)
{
    return iso_renderer_from_name(job->with ? job->with : iso_renderers_usual()->name, with, err);
}

/* Rotates by Rodrigues' formula; the axis is a unit vector. */
static iso_vec3 rotate(iso_vec3 v, iso_vec3 axis, double angle)
{
    return iso_madd(iso_madd(iso_scale(v, cos(angle)), iso_cross(axis, v), sin(angle)), axis,
                    iso_dot(axis, v) * (1 - cos(angle)));
}

/* Turns the camera around the scene's up axis through the center of the box, together with the lights that are
 * relative to the camera. */
static void turn_camera(iso_view *view, const iso_scene *scene, iso_vec3 center, double degrees)
{
    iso_camera *c = &view->camera;
    const double angle = degrees * acos(-1.0) / 180;
    const iso_vec3 axis = iso_normalize(scene->camera_up);
    c->position = iso_add(center, rotate(iso_sub(c->position, center), axis, angle));
    c->forward = rotate(c->forward, axis, angle);
    c->right = rotate(c->right, axis, angle);
    c->up = rotate(c->up, axis, angle);
    for (size_t i = 0; i < view->light_count; ++i)
        if (scene->lights[i].in_camera_space)
            view->lights[i].direction = rotate(view->lights[i].direction, axis, angle);
}

/* Returns the extent of the box relative to the picture: 1 if a corner lies on an edge. */
static double reach(const iso_view *view, const iso_geometry *g)
{
    const iso_camera *c = &view->camera;
    const double aspect = (double)view->width / (double)view->height;
    double most = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const iso_vec3 index = iso_v3((corner & 1) * (double)g->size[0], (corner >> 1 & 1) * (double)g->size[1],
                                      (corner >> 2) * (double)g->size[2]);
        const iso_vec3 at = iso_sub(iso_geometry_to_world(g, index), c->position);
        const double half = c->half_height * (c->orthographic ? 1 : iso_dot(at, c->forward));
        most = fmax(most, fmax(fabs(iso_dot(at, c->up)), fabs(iso_dot(at, c->right)) / aspect) / half);
    }
    return most;
}

/* Widens all frames equally, by the excess of the worst frame over the first, with a margin of a twentieth: a camera
 * that frames the box from one side may cut it from another. Parts of the box that the scene itself cuts off stay cut
 * off. */
static void widen_for_turns(iso_view *view, const iso_scene *scene, const iso_geometry *g, size_t turns)
{
    const double first = reach(view, g);
    double most = first;
    for (size_t i = 1; i < turns; ++i) {
        iso_view turned = *view; /* borrows its contents */
        turn_camera(&turned, scene, iso_geometry_box_center_mm(g), 360.0 * (double)i / (double)turns);
        most = fmax(most, reach(&turned, g));
    }
    if (scene->camera_fit && isfinite(most) && most > fmax(1, first))
        view->camera.half_height *= 1.05 * most / fmax(1, first);
}

static iso_status make_view(iso_figure_subject *s, const iso_figure_picture *what, iso_view *view, iso_error *err)
{
    const iso_geometry *geometry = &s->pyramid.levels[0].geometry;
    const int threads = s->job->cli->threads;
    iso_scene scene = s->scene; /* borrows its contents */
    scene.width = what->width, scene.height = what->height;
    if (what->viewpoint)
        iso_scene_look_from(&scene, geometry, what->viewpoint);
    NEED(iso_scene_resolve(&scene, geometry, iso_pyramid_lo(&s->pyramid), iso_pyramid_hi(&s->pyramid), view, err));
    widen_for_turns(view, &scene, geometry, what->turns);
    if (what->turn_deg != 0)
        turn_camera(view, &scene, iso_geometry_box_center_mm(geometry), what->turn_deg);
    iso_cli_adapted adapted = s->job->adapted;
    adapted.wanted = adapted.wanted || what->adapted;
    const iso_cli_roi_place at = {&adapted, s->job->input, &s->pyramid, what->level, threads};
    if (what->region)
        NEED(iso_cli_roi_view(what->region, &at, view, err));
    return iso_cli_adapt_view(&adapted, s->job->input, &s->pyramid, what->level, view, threads, err);
}

/* Lets ranks share the pictures of a renderer that draws from now on. */
static iso_status share_pictures(iso_figure_subject *s, const iso_renderer_info *r, iso_error *err)
{
    char version[320];
    if (!s->renderers.store || s->drawn_by == r)
        return ISO_OK;
    NEED(r->version(r, &s->renderers, version, sizeof version, err));
    iso_picture_store_set_version(s->renderers.store, r, version);
    return ISO_OK;
}

iso_status iso_figure_render(iso_figure_subject *s, const iso_figure_picture *what, iso_image *image,
                             double *mm_per_pixel, iso_error *err)
{
    OWNED(iso_view) view = {0};
    const iso_progress progress = iso_cli_progress(s->job->cli);
    iso_render_options opt = iso_render_defaults(what->with);
    const iso_render_request request = {&s->renderers, &s->pyramid, what->level, &view, &opt, &progress};
    opt.threads = s->job->cli->threads;
    if (what->source)
        opt.source = *what->source;
    *image = (iso_image){0};
    NEED(make_view(s, what, &view, err));
    if (!s->job->with && !what->named)
        iso_renderers_choose(&s->pyramid, &view, &opt);
    NEED(share_pictures(s, opt.renderer, err));
    s->drawn_by = opt.renderer;
    NEED(iso_render_with(&request, image, NULL, err));
    NEED(iso_render_check_finite(opt.renderer, image, err));
    if (mm_per_pixel)
        *mm_per_pixel = iso_view_mm_per_pixel(&view, &s->pyramid.levels[0].geometry);
    return ISO_OK;
}

void iso_figure_put_subject(const iso_figure_subject *s, FILE *caption)
{
    const char *scene = iso_provenance_name(s->job->look.scene);
    fprintf(caption, " of %s%s%s%s", iso_provenance_title(s->job->input), *scene ? " (" : "", scene, *scene ? ")" : "");
}

double iso_figure_aspect(const iso_figure_subject *s)
{
    return (double)s->scene.width / (double)s->scene.height;
}
