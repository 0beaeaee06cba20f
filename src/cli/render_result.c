/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/render.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "renderers/gl.h"

iso_status iso_render_check_output(const iso_render_arguments *a, iso_error *err)
{
    return a->output ? iso_image_check_name("-o", a->output, err)
                     : iso_fail(err, ISO_E_USAGE, "-o is missing: image to write, .exr or .png");
}

iso_status iso_render_save(const iso_render_arguments *a, const iso_cli *cli, const iso_image *image,
                           const char *version, double step_voxels, iso_error *err)
{
    char step[32];
    snprintf(step, sizeof step, isfinite(step_voxels) ? "%g" : "none", step_voxels);
    FREED char *line = iso_cli_command_line(cli);
    const iso_image_note notes[] = {{"isoshade:command", line ? line : ""},
                                    {"isoshade:renderer", version},
                                    {"isoshade:stepVoxels", step},
                                    {NULL, NULL}};
    NEED(iso_image_save(image, a->output, notes, err));
    return a->png ? iso_image_save_png(image, a->png, 1, err) : ISO_OK;
}

double iso_render_device_seconds(const iso_render_options *opt, iso_renderers *renderers)
{
    iso_gl *gl;
    const bool is_gl = strcmp(opt->renderer->name, "gl") == 0;
    return is_gl && iso_renderers_need_gl(renderers, &gl, NULL) == ISO_OK ? iso_gl_device_seconds(gl) : NAN;
}

void iso_render_report(const iso_render_arguments *a, const iso_cli *cli, const iso_pyramid *p, const iso_view *view,
                       const iso_visible *visible, const iso_rendered *done)
{
    const char *version = done->version;
    const double seconds = done->seconds;
    if (!cli->json) {
        printf("%s: level %d, %zu x %zu pixels, %s, %.3g s\n", a->output, a->level, view->width, view->height, version,
               seconds);
        return;
    }
    json_t *root = iso_cli_json(cli);
    const iso_geometry *g = &p->levels[a->level].geometry;
    json_object_update_new(json_object_get(root, "options"),
                           json_pack("{s:s, s:i, s:s, s:s}", "with", done->with, "level", a->level, "shading_from",
                                     a->source ? a->source : "codes", "code",
                                     iso_code_describe(p->options.code)->name));
    json_object_update_new(root,
                           json_pack("{s:s, s:s, s:[I,I], s:[I,I,I], s:o, s:f}", "image", a->output, "renderer",
                                     version, "size", (json_int_t)view->width, (json_int_t)view->height, "level_size",
                                     (json_int_t)g->size[0], (json_int_t)g->size[1], (json_int_t)g->size[2],
                                     "step_voxels", iso_json_number(done->step_voxels), "seconds", seconds));
    if (isfinite(done->device_seconds))
        json_object_set_new(root, "device_seconds", iso_json_number(done->device_seconds));
    if (done->stats->error > 0) {
        json_object_set_new(root, "error_bound", iso_json_number(done->stats->error));
        json_object_set_new(root, "error_bound_is_proved", json_boolean(done->stats->is_proved));
    }
    json_object_set_new(root, "visible", iso_cli_visible_json(visible));
    if (done->frames)
        json_array_append_new(done->frames, root);
    else
        iso_cli_print_json(root);
}

void iso_render_report_cache(const iso_cached_report *r, const iso_cli *cli)
{
    if (cli->json || cli->quiet)
        return;
    printf("cache: %.4g bytes on %zu page%s; %zu bricks,", r->cache_bytes, r->page_count,
           iso_words_plural(r->page_count), r->brick_count);
    for (size_t l = 0; l < ISO_BRICK_MAX_LEVELS; ++l)
        if (r->bricks_by_level[l] > 0)
            printf(" %zu at level %zu", r->bricks_by_level[l], l);
    printf("; RMSE %.3g predicted\n", r->predicted_rmse);
}
