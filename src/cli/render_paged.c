/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/render.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "base/version.h"
#include "base/words.h"
#include "image/image.h"
#include "render/cpu/paged.h"
#include "scene/subject.h"

static iso_status check(const iso_render_arguments *a, const iso_cli *cli, iso_error *err)
{
    if (!iso_path_exists(cli->arguments[0]))
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", cli->arguments[0], strerror(errno));
    if (!iso_pyramid_is_one(cli->arguments[0]))
        return iso_fail(err, ISO_E_USAGE,
                        "--memory needs a pyramid on disk: make one with isoshade build %s -o NAME.iso",
                        cli->arguments[0]);
    if ((a->with && strcmp(a->with, "cpu") != 0) || a->frames || a->source || a->palette || a->shade_table ||
        a->exact_lookups || a->isosurface || a->quadrature || a->limit || a->code || a->estimator ||
        a->direction_filter || a->adapted.wanted || a->adapted.extinction_scale || a->roi.box ||
        iso_render_is_in_bricks(a))
        return iso_fail(
            err, ISO_E_USAGE,
            "--memory needs --with cpu, without --frames, --shading-from, --palette, --shade-table, "
            "--exact-lookups, --isosurface, --quadrature, --limit, --code, --estimator, --direction-filter, "
            "--adapt, --extinction-scale, --roi, --cache-bytes and --plan-error");
    return iso_render_check_output(a, err);
}

/* Makes the view. A transfer function that depends on all values would need to read them all. */
static iso_status make_view(const iso_render_arguments *a, const iso_cli *cli, const iso_pyramid *p, iso_view *view,
                            iso_error *err)
{
    iso_subject_look look;
    NEED(iso_cli_look_check(&a->look, cli->threads, &look, err));
    if (iso_subject_look_needs_values(&look))
        return iso_fail(err, ISO_E_USAGE,
                        "--memory needs a transfer function from a file, by --scene or --tf; write one "
                        "with isoshade tf suggest");
    return iso_subject_make_view(&look, p, view, err);
}

/* Returns "out_level_2.exr" for "out.exr", or the name itself for the last frame. */
static char *name_of(const char *path, size_t level, bool is_last)
{
    const char *dot = strrchr(iso_path_base(path), '.');
    const int stem = dot ? (int)(dot - path) : (int)strlen(path);
    char *name = NULL;
    if (is_last)
        return strdup(path);
    return asprintf(&name, "%.*s_level_%zu%s", stem, path, level, dot ? dot : "") < 0 ? NULL : name;
}

static iso_status save(const iso_render_arguments *a, const iso_cli *cli, const iso_image *image, size_t level,
                       iso_error *err)
{
    const bool is_last = level == (size_t)a->level;
    FREED char *path = name_of(a->output, level, is_last), *png = a->png ? name_of(a->png, level, is_last) : NULL;
    FREED char *line = iso_cli_command_line(cli);
    const iso_image_note notes[] = {{"isoshade:command", line ? line : ""}, {NULL, NULL}};
    if (!path || !(png || !a->png))
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    NEED(iso_image_save(image, path, notes, err));
    return png ? iso_image_save_png(image, png, 1, err) : ISO_OK;
}

static void report(const iso_cli *cli, const char *path, size_t level, const iso_paged_stats *s, json_t *frames)
{
    if (!cli->json) {
        printf(
            "%s: level %zu, %zu of %zu bricks were loaded in %zu pass%s, %.4g MB read with %.4g MB of memory, %.3g s\n",
            path, level, s->bricks, s->bricks_of_level, s->passes, s->passes == 1 ? "" : "es", s->bytes_read / 1048576,
            s->memory_bytes / 1048576, s->seconds);
        return;
    }
    json_array_append_new(frames,
                          json_pack("{s:I, s:I, s:I, s:I, s:I, s:f, s:f, s:f}", "level", (json_int_t)level, "passes",
                                    (json_int_t)s->passes, "bricks_loaded", (json_int_t)s->bricks, "bricks_of_level",
                                    (json_int_t)s->bricks_of_level, "pages", (json_int_t)s->pool_bricks, "bytes_read",
                                    s->bytes_read, "memory_bytes", s->memory_bytes, "seconds", s->seconds));
}

ISO_ENDING(close_pages, iso_level_pages, iso_level_pages_close)

static iso_status render_level(const iso_render_arguments *a, const iso_cli *cli, const iso_pyramid *p,
                               const iso_view *view, size_t level, json_t *frames, iso_error *err)
{
    const iso_progress progress = iso_cli_progress(cli);
    const iso_paged_options opt = {.memory_bytes = a->memory_mb * 1048576,
                                   .step_voxels = a->step == ISO_STEP_OF_SCENE ? 0 : a->step,
                                   .threads = cli->threads};
    ENDED_BY(close_pages) iso_level_pages *pages = NULL;
    OWNED(iso_image) image = {0};
    iso_paged_stats stats;
    NEED(iso_level_pages_open(cli->arguments[0], p, level, iso_view_is_lit(view), &pages, err));
    NEED(iso_cpu_render_paged(&p->levels[level], p->options.code, pages, view, &opt, &image, &stats, &progress, err));
    NEED(save(a, cli, &image, level, err));
    report(cli, a->output, level, &stats, frames);
    return ISO_OK;
}

iso_status iso_cli_render_paged(const iso_render_arguments *a, const iso_cli *cli, iso_error *err)
{
    OWNED(iso_pyramid) pyramid = {0};
    OWNED(iso_view) view = {0};
    json_auto_t *frames = json_array();
    NEED(check(a, cli, err));
    NEED(iso_pyramid_load_outline(cli->arguments[0], &pyramid, err));
    NEED(iso_pyramid_check_level(&pyramid, cli->arguments[0], (size_t)a->level, err));
    if (pyramid.levels[0].geometry.has_no_data && (a->level > 0 || a->refine))
        return iso_fail(err, ISO_E_RANGE,
                        "%s: some voxels have no data, which --memory renders at level 0 alone; leave it out",
                        cli->arguments[0]);
    NEED(make_view(a, cli, &pyramid, &view, err));
    const size_t last = (size_t)a->level, first = a->refine && pyramid.level_count ? pyramid.level_count - 1 : last;
    for (size_t k = first + 1; k-- > last;)
        NEED(render_level(a, cli, &pyramid, &view, k, frames, err));
    if (cli->json)
        iso_cli_print_results(cli, json_pack("{s:s, s:O}", "image", a->output, "frames", frames));
    return ISO_OK;
}
