/* SPDX-License-Identifier: MIT */
/* cmd_render.c - renders a level of a volume with any of the renderers. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/machine.h"
#include "base/parallel.h"
#include "cli/cycles_options.h"
#include "cli/render.h"
#include "plan/cached.h"
#include "options/cli.h"
#include "options/visible.h"
#include "validate/limits.h"
#include "pyramid/narrow.h"
#include "pyramid/palette_level.h"
#include "renderers/external.h"
#include "render/cpu/caster.h"
#include "renderers/gl.h"
#include "scene/subject_frames.h"
#include "scene/viewpoint.h"
#include "tf/presets.h"
#include "volume/frames_all.h"
#include "cli/renderer_help.h"

/* Sets how the pyramid of a volume is built in memory, as `isoshade build` does. */
static iso_status take_build(const iso_render_arguments *a, const char *path, iso_pyramid_options *build,
                             iso_error *err)
{
    if ((a->direction_filter || a->estimator) && iso_pyramid_is_one(path))
        return iso_fail(err, ISO_E_USAGE,
                        "--direction-filter and --estimator need a volume; %s keeps those of its build", path);
    if (a->estimator)
        NEED(iso_gradient_from_name(a->estimator, &build->gradient.method, err));
    if (a->direction_filter)
        NEED(iso_direction_filter_from_name(a->direction_filter, &build->direction_filter, err));
    if (a->code)
        NEED(iso_code_from_name(a->code, &build->code, err));
    return iso_pyramid_check_options(build, err);
}

/* Encodes the directions of a pyramid on disk by another code; needs its floats. */
static iso_status recode(const iso_render_arguments *a, iso_pyramid *p, iso_error *err)
{
    iso_code code = p->options.code;
    iso_status status = a->code ? iso_code_from_name(a->code, &code, err) : ISO_OK;
    if (status != ISO_OK || code == p->options.code || (size_t)a->level >= p->level_count)
        return status;
    iso_level *level = &p->levels[a->level];
    if (!level->directions || !iso_code_describe(code)->is_textured)
        return iso_fail(err, ISO_E_USAGE,
                        "--code %s: the pyramid has %s and no floats to encode; build it with --keep-float", a->code,
                        iso_code_describe(p->options.code)->name);
    iso_code_encode(code, level->directions, level->codes, iso_geometry_voxel_count(&level->geometry));
    p->options.code = code;
    return ISO_OK;
}

static bool is_from_palette(iso_direction_source source)
{
    return source == ISO_FROM_PALETTE || source == ISO_FROM_PALETTE_NEAREST;
}

/* Loads the palette; --palette and --shading-from palette need each other. */
static iso_status attach_palette(const iso_render_arguments *a, const iso_render_options *opt, iso_pyramid *p,
                                 iso_palette *palette, iso_error *err)
{
    if (!a->palette && !a->shade_table && !is_from_palette(opt->source))
        return ISO_OK;
    if (a->shade_table && !a->palette)
        return iso_fail(err, ISO_E_USAGE, "--shade-table needs a --palette FILE.csv");
    if (!a->palette || !is_from_palette(opt->source))
        return iso_fail(err, ISO_E_USAGE,
                        "--palette FILE.csv and --shading-from palette or palette-nearest need each other");
    NEED(iso_palette_load_csv(a->palette, palette, err));
    return (size_t)a->level < p->level_count
               ? iso_level_attach_palette(&p->levels[a->level], p->options.code, palette, err)
               : ISO_OK;
}

/* Renders by bricks, in a cache of --cache-bytes. */
static iso_status render_cached(const iso_render_arguments *a, const iso_cli *cli, const iso_render_request *q,
                                iso_image *image, double *seconds, iso_error *err)
{
    iso_cached_report r = {0};
    const iso_cached_options o = {.cache_bytes = a->plan_error > 0 ? 0 : a->cache_bytes,
                                  .plan_error = a->plan_error,
                                  .brick_voxels = (size_t)a->brick,
                                  .level_count = (size_t)a->brick_levels,
                                  .page_side = (size_t)a->page_side,
                                  .step_voxels = a->step == ISO_STEP_OF_SCENE ? 0 : a->step,
                                  .threads = cli->threads,
                                  .report = &r};
    iso_gl *gl = NULL;
    if (q->options->renderer != &iso_renderer_cpu)
        NEED(iso_renderers_need_gl(q->renderers, &gl, err));
    NEED(iso_cached_render(gl, &q->pyramid->levels[0], q->view, &o, image, q->progress, err));
    *seconds = r.seconds;
    iso_render_report_cache(&r, cli);
    return ISO_OK;
}

/* Returns the step of the picture; of a limit, the finer of its first two. */
static double taken_step(const iso_render_arguments *a, const iso_render_request *q)
{
    if (iso_render_is_in_bricks(a))
        return a->step > 0 ? a->step : q->view->step_voxels;
    if (a->limit && !(a->step > 0) && !a->intervals)
        return iso_limit_defaults().step_voxels;
    return iso_render_taken_step_voxels(q, q->options);
}

/* Renders the limit of small steps, extrapolated from the step and its double; for Cycles, the mean over seeds. */
static iso_status render_limit(const iso_render_arguments *a, const iso_cli *cli, const iso_render_request *q,
                               iso_image *image, double *seconds, iso_error *err)
{
    iso_limit_options o = iso_limit_defaults();
    const double start = iso_clock_seconds();
    o.step_voxels = a->step > 0 ? a->step : o.step_voxels;
    o.seeds = a->seeds ? (size_t)a->seeds : o.seeds;
    o.first_seed = a->seed;
    o.planes = (size_t)a->planes;
    o.intervals = (size_t)a->intervals;
    o.threads = cli->threads;
    NEED(iso_pyramid_check_level(q->pyramid, NULL, q->level, err));
    NEED(iso_limit_render(q, q->options->renderer, &o, image, err));
    *seconds = iso_clock_seconds() - start;
    return ISO_OK;
}

/* Checks the options before the volume is read, and sets how its pyramid is built. */
static iso_status prepare(const iso_render_arguments *a, const iso_cli *cli, iso_render_options *opt,
                          iso_pyramid_options *build, iso_subject_look *look, iso_error *err)
{
    NEED(iso_render_take_options(a, cli->threads, opt, err));
    *build = iso_pyramid_defaults();
    build->threads = cli->threads;
    build->level_count = (size_t)a->level + 1;
    build->keep_float = opt->source == ISO_FROM_FLOAT || is_from_palette(opt->source);
    NEED(take_build(a, cli->arguments[0], build, err));
    NEED(iso_render_check_output(a, err));
    return iso_cli_look_check(&a->look, cli->threads, look, err);
}

/* A pyramid, and the level whose palette is borrowed. */
typedef struct shown_pyramid {
    iso_pyramid pyramid;
    size_t level;
} shown_pyramid;

static void shown_pyramid_destroy(shown_pyramid *s)
{
    if (s->level < s->pyramid.level_count)
        iso_level_detach_palette(&s->pyramid.levels[s->level]);
    iso_pyramid_destroy(&s->pyramid);
}

/* A frame of a series; series is NULL for a single volume. */
typedef struct frame_of_series {
    const iso_subject_frames *series;
    size_t frame;
    json_t *results;
} frame_of_series;

/* True if the picture may need only a part of a volume, as far as the options decide. */
static bool may_need_a_part(const iso_render_arguments *a, const char *path, const iso_render_options *opt)
{
    return a->level == 0 && !iso_pyramid_is_one(path) && opt->source == ISO_FROM_CODES && !a->palette &&
           !a->estimator && !a->limit && !a->roi.box && !a->adapted.wanted && !a->adapted.extinction_scale &&
           !a->adapted.tf_2d && !iso_render_is_in_bricks(a);
}

/* True if the picture needs no level finer than its own, as far as the options decide. */
static bool needs_its_level_alone(const iso_render_arguments *a)
{
    return a->level > 0 && !a->roi.box && !a->adapted.wanted && !a->adapted.extinction_scale && !a->adapted.tf_2d;
}

/* Bytes per voxel of level 0 while a pyramid is built: floats, codes, samples and coarser levels. */
#define BUILT_BYTES 12.0

/* Loads the pyramid; of one that the free memory does not hold, only the level of the picture and coarser ones. */
static iso_status load_level(const iso_render_arguments *a, const char *path, const iso_pyramid_options *build,
                             const iso_progress *progress, iso_pyramid *p, iso_error *err)
{
    OWNED(iso_pyramid) outline = {0};
    OWNED(iso_subject_coarse) coarse = {0};
    NEED(iso_subject_load_coarse(path, &a->input, build, iso_machine_free_bytes("") / BUILT_BYTES, progress, p, &coarse,
                                 err));
    if (!coarse.folder)
        return ISO_OK;
    outline = *p;
    *p = (iso_pyramid){0};
    NEED(iso_pyramid_check_level(&outline, NULL, (size_t)a->level, err));
    return iso_pyramid_load_from(coarse.folder, (size_t)a->level, p, err);
}

static iso_status load_subject(const iso_render_arguments *a, const iso_cli *cli, const frame_of_series *of,
                               const iso_pyramid_options *build, bool part, iso_pyramid *p, iso_error *err)
{
    const iso_progress progress = iso_cli_progress(cli);
    if (of->series)
        return iso_subject_frames_load(of->series, of->frame, p, err);
    if (needs_its_level_alone(a))
        return load_level(a, cli->arguments[0], build, &progress, p, err);
    return (part ? iso_subject_begin_pyramid : iso_subject_load_pyramid)(cli->arguments[0], &a->input, build, &progress,
                                                                         p, err);
}

/* Completes level 0 of a pyramid with samples alone, if the free memory holds it: 7 bytes per voxel, and 8 of textures
 * in software. */
static iso_status complete(const char *path, const iso_renderer_info *renderer, iso_pyramid *p,
                           const iso_progress *progress, iso_error *err)
{
    const bool cpu_takes_it = iso_cpu_takes(&p->levels[0].geometry);
    const bool has_textures = renderer == iso_renderers_usual() && iso_gl_is_software();
    const double needs = (has_textures ? 15 : 7) * (double)iso_geometry_voxel_count(&p->levels[0].geometry),
                 is_free = iso_machine_free_bytes("");
    if (p->volume && needs > is_free)
        return iso_fail(err, ISO_E_MEMORY,
                        "%s: level 0 needs %.3g GB for --with %s, %.3g GB of memory are free; take %sa coarser "
                        "--level, or a pyramid (isoshade build) and --memory",
                        path, needs / 1e9, renderer->name, is_free / 1e9, cpu_takes_it ? "--with cpu, " : "");
    return iso_pyramid_complete(p, progress, err);
}

/* ---- coarse pictures first ---- */

/* Enlarges a picture 2^shift times, without interpolation, and cuts it to the size. */
static iso_status enlarge(const iso_image *small, size_t shift, size_t width, size_t height, iso_image *large,
                          iso_error *err)
{
    NEED(iso_image_create(large, width, height, err));
    for (size_t i = 0; i < width * height; ++i) {
        const size_t x = i % width >> shift, y = i / width >> shift;
        memcpy(large->rgba + 4 * i, small->rgba + 4 * (x + small->width * y), 4 * sizeof *large->rgba);
    }
    return ISO_OK;
}

/* True if the scene is the same at every level. */
static bool may_coarsen(const iso_render_request *q)
{
    return q->options->source == ISO_FROM_CODES && !q->view->tf_2d && !q->view->extinction_scale && !q->view->roi &&
           !q->pyramid->levels[0].geometry.has_no_data;
}

/* Draws a part of the pixels, from a coarser level if there is one, and saves them as the whole picture. */
static iso_status save_coarse(const iso_render_arguments *a, const iso_cli *cli, const iso_render_request *q,
                              size_t shift, const char *version, iso_error *err)
{
    const size_t last = q->pyramid->level_count - 1, side = (size_t)1 << shift;
    iso_render_request part = *q;
    iso_render_options opt = *q->options;
    iso_view view = *q->view;
    OWNED(iso_image) small = {0}, large = {0};
    view.width = (view.width + side - 1) / side;
    view.height = (view.height + side - 1) / side;
    part.view = &view;
    part.options = &opt;
    part.level = may_coarsen(q) ? (q->level + shift < last ? q->level + shift : last) : q->level;
    opt.stats = NULL;
    NEED(iso_render_with(&part, &small, NULL, err));
    NEED(enlarge(&small, shift, q->view->width, q->view->height, &large, err));
    return iso_render_save(a, cli, &large, version, taken_step(a, &part), err);
}

static iso_status render(const iso_render_arguments *a, const iso_cli *cli, const frame_of_series *of, iso_error *err)
{
    const char *path = cli->arguments[0];
    const size_t level = (size_t)a->level;
    iso_progress progress = iso_cli_progress(cli);
    iso_pyramid_options build = iso_pyramid_defaults();
    ENDED_BY(iso_renderers_end) iso_renderers renderers = {.shader_dir = a->shader_dir};
    OWNED(iso_palette) palette = {0};
    OWNED(shown_pyramid) shown = {.level = level};
    iso_pyramid *pyramid = &shown.pyramid;
    OWNED(iso_view) view = {0};
    OWNED(iso_image) image = {0};
    iso_render_options opt;
    iso_render_stats stats = {0};
    char version[320] = "";
    double seconds = 0;
    bool warned = false;
    iso_subject_look look;
    const iso_render_request request = {&renderers, pyramid, level, &view, &opt, &progress};
    NEED(prepare(a, cli, &opt, &build, &look, err));
    iso_cli_expect_names(cli, !iso_pyramid_is_one(path), opt.renderer->stages, opt.renderer->name);
    NEED(load_subject(a, cli, of, &build, may_need_a_part(a, path, &opt), pyramid, err));
    NEED(recode(a, pyramid, err));
    NEED(attach_palette(a, &opt, pyramid, &palette, err));
    NEED(of->series ? iso_subject_frames_view(of->series, pyramid, &view, err)
                    : iso_subject_make_view(&look, pyramid, &view, err));
    iso_visible visible = iso_cli_warn_view(cli, pyramid, &view, opt.isosurface ? &opt.iso : NULL, &warned);
    NEED(iso_cli_roi_view(&a->roi, &(iso_cli_roi_place){&a->adapted, path, pyramid, level, cli->threads}, &view, err));
    NEED(iso_cli_adapt_view(&a->adapted, path, pyramid, level, &view, cli->threads, err));
    if (!a->with && !a->limit && !a->page_side)
        iso_renderers_choose(pyramid, &view, &opt);
    if (!iso_renderer_has(opt.renderer, ISO_TAKES_A_PART))
        NEED(complete(path, opt.renderer, pyramid, &progress, err));
    NEED(opt.renderer->version(opt.renderer, &renderers, version, sizeof version, err));
    for (size_t shift = 3; shift > 0 && a->progressive; --shift) /* an eighth of rows and columns, a quarter, a half */
        NEED(save_coarse(a, cli, &request, shift, version, err));
    opt.stats = &stats;
    if (iso_render_is_in_bricks(a))
        NEED(render_cached(a, cli, &request, &image, &seconds, err));
    else if (a->limit)
        NEED(render_limit(a, cli, &request, &image, &seconds, err));
    else
        NEED(iso_render_with(&request, &image, &seconds, err));
    NEED(iso_render_check_finite(opt.renderer, &image, err));
    NEED(iso_render_save(a, cli, &image, version, taken_step(a, &request), err));
    iso_visible_take_image(&visible, &image, view.background);
    if (!warned)
        iso_cli_warn_visible(cli, &visible);
    iso_render_report(a, cli, pyramid, &view, &visible,
                      &(iso_rendered){opt.renderer->name, version, seconds, iso_render_device_seconds(&opt, &renderers),
                                      taken_step(a, &request), &stats, of->results});
    return ISO_OK;
}

/* Returns "out_0003.png" for "out.png". */
static char *numbered(const char *path, size_t frame)
{
    const char *end = path ? strrchr(iso_path_base(path), '.') : NULL;
    return path ? iso_frames_name(path, end ? end : "", frame) : NULL;
}

/* Renders all frames of a series, one picture each, with one scene and one transfer function. */
static iso_status render_series(const iso_render_arguments *a, const iso_cli *cli, iso_error *err)
{
    iso_render_options opt;
    iso_pyramid_options build;
    OWNED(iso_subject_frames) series = {0};
    const iso_progress progress = iso_cli_progress(cli);
    iso_subject_look look;
    if (strcmp(a->frames, "all") != 0)
        return iso_fail(err, ISO_E_USAGE, "--frames is \"%s\", must be all; render one with --frame K", a->frames);
    if (a->adapted.wanted || a->adapted.extinction_scale || a->roi.box)
        return iso_fail(err, ISO_E_USAGE, "--frames all excludes %s: a series has one scene and one transfer function",
                        a->roi.box          ? "--roi"
                        : a->adapted.wanted ? "--adapt"
                                            : "--extinction-scale");
    NEED(prepare(a, cli, &opt, &build, &look, err));
    NEED(iso_subject_frames_create(cli->arguments[0], &a->input, &build, &look, &progress, &series, err));
    json_auto_t *all = cli->json ? json_array() : NULL;
    for (size_t k = 0; k < series.count; ++k) {
        FREED char *output = numbered(a->output, k), *png = numbered(a->png, k);
        iso_render_arguments one = *a;
        one.output = output;
        one.png = png;
        NEED(output && (png || !a->png) ? render(&one, cli, &(frame_of_series){&series, k, all}, err)
                                        : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    }
    if (all)
        iso_cli_print_results(cli, json_pack("{s:o, s:O}", "value_range", iso_json_numbers(series.build.value_range, 2),
                                             "frames", all));
    return ISO_OK;
}

/* Returns "reference: converged (default) or midpoint; gl: ...", to be freed. */
static char *describe_quadratures(const iso_option *option)
{
    char list[160], *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    (void)option;
    for (size_t i = 0, count = 0; f && i < iso_renderer_count(); ++i)
        if (iso_renderer_has(iso_renderer_at(i), ISO_READS_QUADRATURE))
            fprintf(f, "%s%s: %s", count++ ? "; " : "", iso_renderer_at(i)->name,
                    iso_render_list_quadratures(iso_renderer_at(i), true, list));
    return f && fclose(f) == 0 ? text : NULL;
}

/* Renders one picture, those of a series, or one within a memory limit. */
static iso_status draw(const iso_render_arguments *a, const iso_cli *cli, iso_error *err)
{
    const bool paged = a->memory_mb != ISO_ALL_IN_MEMORY;
    if (a->refine && !paged)
        return iso_fail(err, ISO_E_USAGE, "--refine needs --memory");
    if (a->progressive && (paged || a->limit || a->frames || iso_render_is_in_bricks(a)))
        return iso_fail(err, ISO_E_USAGE,
                        "--progressive is for single pictures, without --memory, --limit, --frames, --cache-bytes and "
                        "--plan-error");
    if (paged)
        return iso_cli_render_paged(a, cli, err);
    return a->frames ? render_series(a, cli, err) : render(a, cli, &(frame_of_series){NULL, 0, NULL}, err);
}

static const iso_option options[] = {
    {"output", 'o', "image to write: .exr (float, linear) or .png (sRGB)", "FILE",
     ISO_IN(iso_render_arguments, output)},
    ISO_OPTIONS_OF(iso_render_arguments, look, iso_look_rows),
    {"with", 0, "%s (gl, or cpu without hardware OpenGL)", "RENDERER", ISO_IN(iso_render_arguments, with),
     ISO_NAMES_CHOICE(0)},
    ISO_CLI_RENDERERS_OPTION(iso_render_arguments, renderers),
    ISO_CLI_CYCLES_OPTIONS(iso_render_arguments, cycles, "Blender for --with cycles, a path or a name in PATH",
                           "PROGRAM"),
    ISO_CLI_GL_DEVICE_OPTION(iso_render_arguments, gl_device),
    {"level", 0, "level of the pyramid; 0 is the finest", "K", ISO_IN(iso_render_arguments, level), .flags = ISO_SHOWN,
     .most = 63},
    {"frames", 0, "render all frames of a series, as IMAGE_0000.png and so on", "all",
     ISO_IN(iso_render_arguments, frames)},
    {"png", 0, "also write an 8-bit picture", "FILE.png", ISO_IN(iso_render_arguments, png)},
    {"shading-from", 0, "%s: direction source of the list below (codes)", "SOURCE",
     ISO_IN(iso_render_arguments, source), ISO_NAMES_RENDERERS(ISO_READS_SOURCE)},
    {"palette", 0, "palette for --shading-from palette, made by isoshade palette", "FILE.csv",
     ISO_IN(iso_render_arguments, palette)},
    {"exact-lookups", 0, "%s: filter textures in double precision; slow, for validation", NULL,
     ISO_IN(iso_render_arguments, exact_lookups), ISO_NAMES_RENDERERS(ISO_READS_EXACT_LOOKUPS)},
    {"shade-table", 0, "%s: shade the palette's entries once, instead of each sample", NULL,
     ISO_IN(iso_render_arguments, shade_table), ISO_NAMES_RENDERERS(ISO_READS_SHADE_TABLE)},
    {"step", 0, "ray step in voxels of the level (the scene's; cycles 1/16; povray extrapolates)", "VOXELS",
     ISO_IN(iso_render_arguments, step), .least = 1e-3, .most = 100},
    {"quadrature", 0, NULL, "RULE", ISO_IN(iso_render_arguments, quadrature), .describe = describe_quadratures},
    {"estimator", 0, "volumes: gradient estimator of the list below (central)", "NAME",
     ISO_IN(iso_render_arguments, estimator)},
    {"direction-filter", 0, "volumes: direction filter of the list below (moments)", "NAME",
     ISO_IN(iso_render_arguments, direction_filter)},
    {"code", 0, "direction code of the list below (fit)", "NAME", ISO_IN(iso_render_arguments, code)},
    {"isosurface", 0, "%s: show the first hit of this value, opaque", "VALUE", ISO_IN(iso_render_arguments, isosurface),
     ISO_NAMES_RENDERERS(ISO_HAS_ISOSURFACES)},
    {"intervals", 0, "%s: intervals per ray; reference: in POV-Ray's quadrature", "N",
     ISO_IN(iso_render_arguments, intervals), .flags = ISO_NOT_ZERO, ISO_NAMES_RENDERERS(ISO_READS_INTERVALS)},
    {"planes", 0, "%s: planes that divide each ray, with --intervals", "N", ISO_IN(iso_render_arguments, planes),
     .flags = ISO_NOT_ZERO, ISO_NAMES_RENDERERS(ISO_READS_PLANES), .most = 64},
    {"samples", 0, "%s: samples per pixel (1)", "N", ISO_IN(iso_render_arguments, samples), .flags = ISO_NOT_ZERO,
     ISO_NAMES_RENDERERS(ISO_READS_SAMPLES), .most = 65536},
    {"seed", 0, "%s: seed of the random numbers", "N", ISO_IN(iso_render_arguments, seed),
     ISO_NAMES_RENDERERS(ISO_READS_SEED)},
    {"limit", 0, "%s: extrapolate to step 0 from --step (0.25) or --intervals, and twice the step", NULL,
     ISO_IN(iso_render_arguments, limit), ISO_NAMES_RENDERERS(ISO_HAS_LIMIT)},
    {"seeds", 0, "%s: with --limit: renders at each step to average (4)", "N", ISO_IN(iso_render_arguments, seeds),
     .flags = ISO_NOT_ZERO, ISO_NAMES_RENDERERS(ISO_IS_RANDOM), .least = 2, .most = 32},
    {"cache-bytes", 0, "%s: render bricks of mixed levels, with the least error in this many bytes", "BYTES",
     ISO_IN(iso_render_arguments, cache_bytes), ISO_NAMES_RENDERERS(ISO_HAS_BRICKS), .least = 1, .most = 1e15},
    {"plan-error", 0, "%s: render bricks of mixed levels, as coarse as this predicted RMSE allows", "1/255",
     ISO_IN(iso_render_arguments, plan_error_text), ISO_NAMES_RENDERERS(ISO_HAS_BRICKS)},
    {"brick", 0, "with --cache-bytes or --plan-error: voxels per side of a brick", "N",
     ISO_IN(iso_render_arguments, brick), .flags = ISO_SHOWN, .least = 2, .most = ISO_BRICK_MOST_VOXELS},
    {"brick-levels", 0, "with these two: number of levels, including level 0", "N",
     ISO_IN(iso_render_arguments, brick_levels), .flags = ISO_SHOWN, .least = 1, .most = ISO_BRICK_MAX_LEVELS},
    {"page-side", 0, "with these two: largest side of a texture in texels", "TEXELS",
     ISO_IN(iso_render_arguments, page_side), .flags = ISO_NOT_ZERO, .most = 65536},
    {"memory", 0, "cpu, pyramids on disk: limit of memory; bricks are read when needed", "MB",
     ISO_IN(iso_render_arguments, memory_mb), .least = 1, .most = 1e9},
    {"refine", 0, "with --memory: render coarse levels first, as IMAGE_level_K", NULL,
     ISO_IN(iso_render_arguments, refine)},
    {"progressive", 0, "write coarse pictures first, each whole, under the same name", NULL,
     ISO_IN(iso_render_arguments, progressive)},
    {"shader-dir", 0, "%s: use shaders of this folder instead of the built-in ones", "DIR",
     ISO_IN(iso_render_arguments, shader_dir), ISO_NAMES_RENDERERS(ISO_READS_SHADERS)},
    ISO_OPTIONS_OF(iso_render_arguments, adapted, iso_adapted_rows),
    ISO_OPTIONS_OF(iso_render_arguments, roi, iso_roi_rows),
    ISO_OPTIONS_OF(iso_render_arguments, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    iso_render_arguments *a = values;
    a->adapted.cli = cli;
    if (a->gl_device)
        setenv(ISO_GL_DEVICE_VARIABLE, a->gl_device, 1);
    NEED(iso_renderers_load(a->renderers, err));
    if (a->plan_error_text)
        NEED(iso_words_parse_error("--plan-error", a->plan_error_text, &a->plan_error, err));
    NEED(iso_cli_take_cycles(&a->cycles, a->with ? a->with : iso_renderers_usual()->name, err));
    return draw(a, cli, err);
}

const iso_command iso_command_render = {
    .name = "render",
    .summary = "render a level with any of the renderers",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "VOLUME|PYRAMID.iso -o IMAGE [options]",
    .details =
        "Without --scene you get a first picture: a suggested transfer function (tf suggest), and a camera that frames the box,\n"
        "or the visible part if that is much smaller. A scene file keeps one camera for several volumes or transfer\n"
        "functions. All renderers compute the same integral from the same scene. From a volume a pyramid is built in memory; a\n"
        "pyramid on disk keeps the options of its build. The image is linear, premultiplied RGBA with the background included.",
    .common = "output png scene tf view zoom size with level step adapt isosurface quadrature spacing frame threads",
    .examples =
        "  isoshade make marschner-lobb --size 40x56x33 -o ml.nrrd\n"
        "  isoshade render ml.nrrd -o first.png\n"
        "  isoshade render ml.nrrd --tf simulation --view 30,20 --zoom 1.5 -o zoomed.png\n"
        "  isoshade render ml.nrrd --scene refscenes/marschner-lobb.scene.json -o ml.exr --png ml.png\n"
        "  isoshade render ml.nrrd --scene refscenes/marschner-lobb.scene.json --with reference --level 1 --size 96 -o ml1.exr\n"
        "  isoshade render ml.nrrd --scene refscenes/marschner-lobb.scene.json --isosurface 32768 -o surface.exr\n"
        "  isoshade render ml.nrrd --scene refscenes/marschner-lobb.scene.json --with cycles --step 0.0625 --size 64 -o ml-cycles.exr\n"
        "  isoshade render ml.nrrd --scene refscenes/marschner-lobb.scene.json --with povray --limit --step 0.25 --size 32 -o ml-limit.exr\n"
        "  isoshade render ml.nrrd --scene refscenes/marschner-lobb.scene.json --level 1 --adapt --roi 8,8,6,24,32,20 -o roi.exr\n"
        "  isoshade render ml.nrrd --scene refscenes/marschner-lobb.scene.json --cache-bytes 400000 --brick 8 -o cached.exr\n"
        "  isoshade build ml.nrrd -o ml.iso --levels 3\n"
        "  isoshade render ml.iso --scene refscenes/marschner-lobb.scene.json --memory 20 --refine -o paged.exr\n",
    .lists = (const iso_names *const[]){&iso_direction_source_names, &iso_gradient_names, &iso_direction_filter_names,
                                        &iso_code_names, &iso_tf_preset_names, &iso_viewpoint_names, NULL},
    ISO_COMMAND_OPTIONS(iso_render_arguments, options, .step = ISO_STEP_OF_SCENE, .memory_mb = ISO_ALL_IN_MEMORY,
                        .cache_bytes = ISO_NO_CACHE, .brick = 16, .brick_levels = 4,
                        .adapted = ISO_CLI_ADAPTED_DEFAULTS, .roi = ISO_CLI_ROI_DEFAULTS),
    .run = run,
};
