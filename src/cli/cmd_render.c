/* SPDX-License-Identifier: MIT */
/* cmd_render.c - one level of a volume as an image, by any of the four renderers. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/parallel.h"
#include "plan/cached.h"
#include "options/cli.h"
#include "options/input.h"
#include "validate/limits.h"
#include "pyramid/palette_level.h"
#include "renderers/renderers.h"
#include "options/roi.h"
#include "scene/subject.h"

typedef struct render_arguments {
    iso_volume_input input;
    iso_cli_adapted adapted;
    iso_cli_roi roi;
    char *scene, *with, *output, *png, *size, *source, *quadrature, *isosurface, *palette;
    int level, intervals, planes, samples, seed, seeds, limit, shade_table, exact_lookups, brick, brick_levels, page_side;
    double step, cache_bytes;
    char *plan_error_text, *code, *direction_filter, *estimator;
    double plan_error; /* 0: none */
    const char *shader_dir;
} render_arguments;

/* An option that the renderer would pass over is an error: its user would believe it. */
static iso_status check_for_renderer(const render_arguments *a, iso_renderer renderer, iso_error *err)
{
    const unsigned reference = 1u << ISO_WITH_REFERENCE, gl = 1u << ISO_WITH_GL, cycles = 1u << ISO_WITH_CYCLES,
                   povray = 1u << ISO_WITH_POVRAY;
    const struct {
        const char *option, *where;
        bool given;
        unsigned renderers;
    } rules[] = {
        {"--quadrature", "reference and gl", a->quadrature != NULL, reference | gl},
        {"--shading-from", "reference and gl", a->source != NULL, reference | gl},
        {"--intervals", "povray and reference", a->intervals != 0, povray | reference},
        {"--planes", "povray", a->planes != 0, povray},
        {"--samples", "cycles", a->samples != 0, cycles},
        {"--seed", "cycles", a->seed != 0, cycles},
        {"--shader-dir", "gl", a->shader_dir != NULL, gl},
        {"--shade-table", "gl", a->shade_table != 0, gl},
        {"--exact-lookups", "gl", a->exact_lookups != 0, gl},
    };
    for (size_t i = 0; i < sizeof rules / sizeof *rules; ++i)
        if (rules[i].given && !(rules[i].renderers & 1u << renderer))
            return iso_fail(err, ISO_E_USAGE, "%s is for --with %s alone", rules[i].option, rules[i].where);
    return ISO_OK;
}

/* The ray caster has no end of its refinement and no other program's sums. */
static iso_status take_quadrature(const char *word, iso_renderer renderer, iso_quadrature *quadrature, iso_error *err)
{
    static const struct {
        const char *name;
        iso_quadrature value;
        bool in_gl;
    } quadratures[] = {{"converged", ISO_QUADRATURE_CONVERGED, false},
                       {"midpoint", ISO_QUADRATURE_MIDPOINT, true},
                       {"preintegrated", ISO_QUADRATURE_PREINTEGRATED, true},
                       {"povray", ISO_QUADRATURE_POVRAY, false}};
    for (size_t i = 0; i < sizeof quadratures / sizeof *quadratures; ++i)
        if (strcmp(quadratures[i].name, word) == 0 && (quadratures[i].in_gl || renderer == ISO_WITH_REFERENCE)) {
            *quadrature = quadratures[i].value;
            return ISO_OK;
        }
    return iso_fail(err, ISO_E_USAGE, "--quadrature is \"%s\", wanted %s", word,
                    renderer == ISO_WITH_REFERENCE ? "converged, midpoint, preintegrated or povray" : "midpoint or preintegrated");
}

static bool is_in_bricks(const render_arguments *a) { return a->cache_bytes != 0 || a->plan_error > 0; }

/* Bricks choose their levels themselves, and are what the ray caster has decoded. */
static iso_status check_cache(const render_arguments *a, iso_renderer renderer, iso_error *err)
{
    if (!is_in_bricks(a))
        return a->page_side ? iso_fail(err, ISO_E_USAGE, "--page-side needs --cache-bytes or --plan-error") : ISO_OK;
    if (a->cache_bytes != 0 && a->plan_error > 0)
        return iso_fail(err, ISO_E_USAGE, "--cache-bytes and --plan-error exclude each other: what fits, or what an error allows");
    if (renderer != ISO_WITH_GL || a->level != 0 || a->source || a->palette || a->shade_table || a->exact_lookups ||
        a->isosurface || a->quadrature || a->adapted.wanted || a->roi.box)
        return iso_fail(err, ISO_E_USAGE, "--cache-bytes and --plan-error are for --with gl, without --level, --shading-from, --palette, --shade-table, "
                                          "--exact-lookups, --isosurface, --quadrature, --adapt and --roi");
    iso_status status = a->plan_error > 0 ? ISO_OK : iso_words_check_range("--cache-bytes", a->cache_bytes, 1, 1e15, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--brick-levels", a->brick_levels, 1, ISO_BRICK_MAX_LEVELS, err);
    return status == ISO_OK ? iso_words_check_range("--page-side", a->page_side, 0, 65536, err) : status;
}

/* How the pyramid of a volume is made in memory, as `isoshade build` has it. */
static iso_status take_build(const render_arguments *a, const char *path, iso_pyramid_options *build, iso_error *err)
{
    iso_status status = ISO_OK;
    if ((a->direction_filter || a->estimator) && iso_pyramid_is_one(path))
        return iso_fail(err, ISO_E_USAGE, "--direction-filter and --estimator are for volumes; %s keeps those of its build", path);
    if (a->estimator)
        status = iso_gradient_from_name(a->estimator, &build->gradient.method, err);
    if (status == ISO_OK && a->direction_filter)
        status = iso_direction_filter_from_name(a->direction_filter, &build->direction_filter, err);
    if (status == ISO_OK && a->code)
        status = iso_code_from_name(a->code, &build->code, err);
    return status == ISO_OK ? iso_pyramid_check_options(build, err) : status;
}

/* A pyramid on disk that kept its floats takes another code. */
static iso_status recode(const render_arguments *a, iso_pyramid *p, iso_error *err)
{
    iso_code code = p->options.code;
    iso_status status = a->code ? iso_code_from_name(a->code, &code, err) : ISO_OK;
    if (status != ISO_OK || code == p->options.code || (size_t)a->level >= p->level_count)
        return status;
    iso_level *level = &p->levels[a->level];
    if (!level->directions || !iso_code_describe(code)->is_textured)
        return iso_fail(err, ISO_E_USAGE, "--code %s: the pyramid has %s and no floats to encode (isoshade build --keep-float)", a->code,
                        iso_code_describe(p->options.code)->name);
    iso_code_encode(code, level->directions, level->codes, iso_geometry_voxel_count(&level->geometry));
    p->options.code = code;
    return ISO_OK;
}

/* The limit is made of renders by the step alone. */
static iso_status check_limit(const render_arguments *a, iso_renderer renderer, iso_error *err)
{
    if (!a->limit)
        return a->seeds ? iso_fail(err, ISO_E_USAGE, "--seeds needs --limit") : ISO_OK;
    if (renderer == ISO_WITH_REFERENCE || a->quadrature || a->source || a->isosurface || a->samples || a->shade_table ||
        a->exact_lookups || is_in_bricks(a))
        return iso_fail(err, ISO_E_USAGE, "--limit is for --with gl, cycles and povray, without --quadrature, --shading-from, "
                                          "--isosurface, --samples, --shade-table, --exact-lookups, --cache-bytes and --plan-error");
    if (a->intervals % 2)
        return iso_fail(err, ISO_E_USAGE, "--intervals is %d, must be even with --limit, which halves them", a->intervals);
    if (a->seeds && renderer != ISO_WITH_CYCLES)
        return iso_fail(err, ISO_E_USAGE, "--seeds is for --with cycles alone");
    return a->seeds ? iso_words_check_range("--seeds", a->seeds, 2, 32, err) : ISO_OK;
}

static iso_status take_options(const render_arguments *a, const iso_cli *cli, iso_render_options *opt, iso_error *err)
{
    iso_renderer renderer = ISO_WITH_GL;
    iso_status status = iso_renderer_from_name(a->with, &renderer, err);
    *opt = iso_render_defaults(renderer);
    if (status == ISO_OK && a->source)
        status = iso_direction_source_from_name(a->source, &opt->source, err);
    if (status == ISO_OK && a->step != 0)
        status = iso_words_check_range("--step", a->step, 1e-3, 100, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--intervals", a->intervals, 0, renderer == ISO_WITH_POVRAY ? 255 : 1e6, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--planes", a->planes, 0, 64, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--samples", a->samples, 0, 65536, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--level", a->level, 0, 63, err);
    if (status == ISO_OK)
        status = check_for_renderer(a, renderer, err);
    if (status == ISO_OK)
        status = check_cache(a, renderer, err);
    if (status == ISO_OK)
        status = check_limit(a, renderer, err);
    if (status != ISO_OK)
        return status;
    if (a->quadrature)
        status = take_quadrature(a->quadrature, renderer, &opt->quadrature, err);
    if (status != ISO_OK)
        return status;
    if (a->isosurface) {
        double value[3];
        status = iso_words_parse_numbers(a->isosurface, "--isosurface", value, err);
        opt->isosurface = true;
        opt->iso = value[0];
    }
    opt->step_voxels = a->step;
    opt->intervals = (size_t)a->intervals;
    opt->planes = (size_t)a->planes;
    opt->samples = a->samples;
    opt->seed = a->seed;
    opt->threads = cli->threads;
    opt->shade_table = a->shade_table;
    opt->exact_lookups = a->exact_lookups;
    return status;
}

static bool is_from_palette(iso_direction_source source)
{
    return source == ISO_FROM_PALETTE || source == ISO_FROM_PALETTE_NEAREST;
}

/* --palette and --shading-from palette need each other. */
static iso_status attach_palette(const render_arguments *a, const iso_render_options *opt, iso_pyramid *p,
                                 iso_palette *palette, iso_error *err)
{
    if (!a->palette && !a->shade_table && !is_from_palette(opt->source))
        return ISO_OK;
    if (a->shade_table && !a->palette)
        return iso_fail(err, ISO_E_USAGE, "--shade-table needs a --palette FILE.csv");
    if (!a->palette || !is_from_palette(opt->source))
        return iso_fail(err, ISO_E_USAGE, "--palette FILE.csv and --shading-from palette or palette-nearest go together");
    iso_status status = iso_palette_load_csv(a->palette, palette, err);
    if (status == ISO_OK && (size_t)a->level < p->level_count)
        status = iso_level_attach_palette(&p->levels[a->level], p->options.code, palette, err);
    return status;
}

static iso_status save_image(const render_arguments *a, const iso_cli *cli, const iso_image *image, const char *version,
                             double step_voxels, iso_error *err)
{
    char step[32];
    snprintf(step, sizeof step, "%g", step_voxels);
    char *line = iso_cli_command_line(cli);
    const iso_image_note notes[] = {{"isoshade:command", line ? line : ""},
                                    {"isoshade:renderer", version},
                                    {"isoshade:stepVoxels", step},
                                    {NULL, NULL}};
    iso_status status = iso_path_ends_with(a->output, ".png") ? iso_image_save_png(image, a->output, 1, err)
                                                              : iso_image_save_exr(image, a->output, notes, err);
    if (status == ISO_OK && a->png)
        status = iso_image_save_png(image, a->png, 1, err);
    free(line);
    return status;
}

static void report(const render_arguments *a, const iso_cli *cli, const iso_pyramid *p, const iso_view *view,
                   const char *version, double seconds)
{
    if (!cli->json) {
        printf("%s: level %d, %zu x %zu pixels, %s, %.3g s\n", a->output, a->level, view->width, view->height, version, seconds);
        return;
    }
    json_t *root = iso_cli_json(cli);
    const iso_geometry *g = &p->levels[a->level].geometry;
    json_object_update_new(json_object_get(root, "options"),
                           json_pack("{s:s, s:i, s:s, s:s}", "with", a->with, "level", a->level, "shading_from",
                                     a->source ? a->source : "codes", "code", iso_code_describe(p->options.code)->name));
    json_object_update_new(root, json_pack("{s:s, s:s, s:[I,I], s:[I,I,I], s:f, s:f}", "image", a->output, "renderer", version,
                                           "size", (json_int_t)view->width, (json_int_t)view->height, "level_size",
                                           (json_int_t)g->size[0], (json_int_t)g->size[1], (json_int_t)g->size[2],
                                           "step_voxels", a->step > 0 ? a->step : view->step_voxels, "seconds", seconds));
    iso_cli_print_json(root);
}

static void report_cache(const iso_cached_report *r, const iso_cli *cli)
{
    if (cli->json || cli->quiet)
        return;
    printf("cache: %.4g bytes on %zu page%s; %zu bricks,", r->cache_bytes, r->page_count, r->page_count == 1 ? "" : "s", r->brick_count);
    for (size_t l = 0; l < ISO_BRICK_MAX_LEVELS; ++l)
        if (r->bricks_by_level[l] > 0)
            printf(" %zu at level %zu", r->bricks_by_level[l], l);
    printf("; RMSE %.3g predicted\n", r->predicted_rmse);
}

/* By bricks, in a cache of so many bytes. */
static iso_status render_cached(const render_arguments *a, const iso_cli *cli, iso_renderers *renderers, const iso_pyramid *p,
                                const iso_view *view, iso_image *image, double *seconds, const iso_progress *progress, iso_error *err)
{
    const iso_cached_options o = {.cache_bytes = a->cache_bytes, .plan_error = a->plan_error, .brick_voxels = (size_t)a->brick, .level_count = (size_t)a->brick_levels,
                                  .page_side = (size_t)a->page_side, .step_voxels = a->step, .threads = cli->threads};
    iso_cached_report r;
    iso_status status = iso_renderers_need_gl(renderers, err);
    if (status == ISO_OK)
        status = iso_cached_render(renderers->gl, &p->levels[0], view, &o, image, &r, progress, err);
    *seconds = r.seconds;
    if (status == ISO_OK)
        report_cache(&r, cli);
    return status;
}

/* Extrapolated from the step and its double; of Cycles the mean over seeds. */
static iso_status render_limit(const render_arguments *a, const iso_cli *cli, iso_renderers *renderers, const iso_pyramid *p,
                               const iso_view *view, iso_renderer which, iso_image *image, double *seconds,
                               const iso_progress *progress, iso_error *err)
{
    iso_limit_options o = iso_limit_defaults();
    const double start = iso_clock_seconds();
    o.step_voxels = a->step > 0 ? a->step : o.step_voxels;
    o.seeds = a->seeds ? (size_t)a->seeds : o.seeds;
    o.first_seed = a->seed;
    o.planes = (size_t)a->planes;
    o.intervals = (size_t)a->intervals;
    o.threads = cli->threads;
    if ((size_t)a->level >= p->level_count)
        return iso_fail(err, ISO_E_RANGE, "level %d: the pyramid has levels 0 to %zu", a->level, p->level_count - 1);
    iso_status status = iso_limit_render(renderers, p, (size_t)a->level, view, which, &o, image, progress, err);
    *seconds = iso_clock_seconds() - start;
    return status;
}

static iso_status render(const render_arguments *a, const iso_cli *cli, iso_error *err)
{
    iso_progress progress = iso_cli_progress(cli);
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_renderers renderers = {.shader_dir = a->shader_dir};
    iso_render_options opt;
    iso_pyramid pyramid = {0};
    iso_palette palette = {0};
    iso_view view = {0};
    iso_image image = {0};
    char version[320] = "";
    double seconds = 0;
    iso_status status = take_options(a, cli, &opt, err);
    build.threads = cli->threads;
    build.level_count = (size_t)a->level + 1;
    build.keep_float = opt.source == ISO_FROM_FLOAT || is_from_palette(opt.source);
    if (status == ISO_OK)
        status = take_build(a, cli->arguments[0], &build, err);
    if (status == ISO_OK && !a->output)
        status = iso_fail(err, ISO_E_USAGE, "-o is missing: the image to write, .exr or .png");
    if (status == ISO_OK)
        status = iso_subject_load_pyramid(cli->arguments[0], &a->input, &build, &progress, &pyramid, err);
    if (status == ISO_OK)
        status = recode(a, &pyramid, err);
    if (status == ISO_OK)
        status = attach_palette(a, &opt, &pyramid, &palette, err);
    if (status == ISO_OK)
        status = iso_subject_load_view(a->scene, &pyramid, a->size, &view, err);
    if (status == ISO_OK)
        status = iso_cli_roi_view(&a->roi, &a->adapted, cli->arguments[0], &pyramid, (size_t)a->level, &view, cli->threads, err);
    if (status == ISO_OK)
        status = iso_cli_adapt_view(&a->adapted, cli->arguments[0], &pyramid, (size_t)a->level, &view, cli->threads, err);
    if (status == ISO_OK)
        status = iso_renderer_version(&renderers, opt.renderer, version, sizeof version, err);
    if (status == ISO_OK && is_in_bricks(a))
        status = render_cached(a, cli, &renderers, &pyramid, &view, &image, &seconds, &progress, err);
    else if (status == ISO_OK && a->limit)
        status = render_limit(a, cli, &renderers, &pyramid, &view, opt.renderer, &image, &seconds, &progress, err);
    else if (status == ISO_OK)
        status = iso_render_with(&renderers, &pyramid, (size_t)a->level, &view, &opt, &image, &seconds, &progress, err);
    if (status == ISO_OK)
        status = save_image(a, cli, &image, version, a->step > 0 ? a->step : view.step_voxels, err);
    if (status == ISO_OK)
        report(a, cli, &pyramid, &view, version, seconds);
    iso_image_destroy(&image);
    iso_view_destroy(&view);
    if ((size_t)a->level < pyramid.level_count)
        iso_level_detach_palette(&pyramid.levels[a->level]);
    iso_palette_destroy(&palette);
    iso_pyramid_destroy(&pyramid);
    iso_renderers_end(&renderers);
    return status;
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    render_arguments a = {.with = "gl", .brick = 16, .brick_levels = 4};
    iso_volume_input_defaults(&a.input);
    iso_cli_adapted_defaults(&a.adapted);
    iso_cli_roi_defaults(&a.roi);
    struct poptOption options[] = {
        {"output", 'o', POPT_ARG_STRING, &a.output, 0, "the image: .exr (float, linear) or .png (sRGB)", "FILE"},
        {"scene", 0, POPT_ARG_STRING, &a.scene, 0, "camera, lights, shading and transfer function", "SCENE.scene.json"},
        {"with", 0, POPT_ARG_STRING | POPT_ARGFLAG_SHOW_DEFAULT, &a.with, 0, "reference, gl, cycles or povray", "RENDERER"},
        {"level", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &a.level, 0, "level of the pyramid, 0 is the finest", "K"},
        {"size", 0, POPT_ARG_STRING, &a.size, 0, "image size instead of the scene's", "WxH"},
        {"png", 0, POPT_ARG_STRING, &a.png, 0, "an 8-bit picture as well", "FILE.png"},
        {"shading-from", 0, POPT_ARG_STRING, &a.source, 0, "directions: codes (default), decoded, float, flipped, on-the-fly, palette or palette-nearest; reference and gl", "SOURCE"},
        {"palette", 0, POPT_ARG_STRING, &a.palette, 0, "for --shading-from palette: made by isoshade palette", "FILE.csv"},
        {"exact-lookups", 0, POPT_ARG_NONE, &a.exact_lookups, 0, "gl: filter textures at positions in double precision; slow, for certifying", NULL},
        {"shade-table", 0, POPT_ARG_NONE, &a.shade_table, 0, "gl: shade the palette's entries once instead of each sample", NULL},
        {"step", 0, POPT_ARG_DOUBLE, &a.step, 0, "ray step in voxels of the level instead of the scene's", "VOXELS"},
        {"quadrature", 0, POPT_ARG_STRING, &a.quadrature, 0, "reference: converged (default), midpoint, preintegrated or povray; gl: midpoint (default) or preintegrated", "RULE"},
        {"estimator", 0, POPT_ARG_STRING, &a.estimator, 0, "a volume's estimator of gradients: central (default), sobel, ...", "NAME"},
        {"direction-filter", 0, POPT_ARG_STRING, &a.direction_filter, 0, "of its coarse levels: moments (default), eq1, naive or tensor", "NAME"},
        {"code", 0, POPT_ARG_STRING, &a.code, 0, "of its directions: fit (default), snorm, region48, ...", "NAME"},
        {"isosurface", 0, POPT_ARG_STRING, &a.isosurface, 0, "reference, gl and povray: the first hit of this value, opaque", "VALUE"},
        {"intervals", 0, POPT_ARG_INT, &a.intervals, 0, "povray, and the reference in its quadrature: intervals a ray", "N"},
        {"planes", 0, POPT_ARG_INT, &a.planes, 0, "povray: planes that cut each ray, with --intervals", "N"},
        {"samples", 0, POPT_ARG_INT, &a.samples, 0, "cycles: samples a pixel (1)", "N"},
        {"seed", 0, POPT_ARG_INT, &a.seed, 0, "cycles: seed of its random numbers", "N"},
        {"limit", 0, POPT_ARG_NONE, &a.limit, 0, "gl, cycles and povray: the limit of --step (0.25), or --intervals, and its double, as validate compares it", NULL},
        {"seeds", 0, POPT_ARG_INT, &a.seeds, 0, "cycles with --limit: renders at each step, whose mean counts (4)", "N"},
        {"cache-bytes", 0, POPT_ARG_DOUBLE, &a.cache_bytes, 0, "gl: by bricks of mixed levels, without seams, in textures of so many bytes: the least error that fits", "BYTES"},
        {"plan-error", 0, POPT_ARG_STRING, &a.plan_error_text, 0, "gl: by bricks of mixed levels, as coarse as this predicted RMSE allows", "1/255"},
        {"brick", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &a.brick, 0, "of these two: voxels a side", "N"},
        {"brick-levels", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &a.brick_levels, 0, "of these two: levels of the bricks, with level 0", "N"},
        {"page-side", 0, POPT_ARG_INT, &a.page_side, 0, "of these two: texels a side of a texture at most; more textures are made where one is too small", "TEXELS"},
        {"shader-dir", 0, POPT_ARG_STRING, &a.shader_dir, 0, "gl: shaders from this folder instead of the built-in ones", "DIR"},
        ISO_CLI_ADAPTED_OPTIONS(&a.adapted),
        ISO_CLI_ROI_OPTIONS(&a.roi),
        ISO_CLI_INPUT_OPTIONS(&a.input),
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, 1, 1, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN && a.plan_error_text)
        status = iso_words_parse_error("--plan-error", a.plan_error_text, &a.plan_error, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = render(&a, &cli, err);
    iso_cli_end(&cli);
    return status;
}

const iso_command iso_command_render = {
    .name = "render",
    .summary = "render a level with the reference, OpenGL, Cycles or POV-Ray",
    .usage = "VOLUME|PYRAMID.iso --scene SCENE.scene.json -o IMAGE [options]",
    .details = "All renderers compute the same integral from the same scene. A volume is made a pyramid in memory; a pyramid on\n"
               "disk keeps the options of its build. The image is linear, premultiplied RGBA with the background included.",
    .examples = "  isoshade make marschner-lobb --size 40x56x33 -o ml.nrrd\n"
                "  isoshade render ml.nrrd --scene refscenes/marschner-lobb.scene.json -o ml.exr --png ml.png\n"
                "  isoshade render ml.nrrd --scene refscenes/marschner-lobb.scene.json --with reference --level 1 -o ml1.exr\n"
                "  isoshade render ml.nrrd --scene refscenes/marschner-lobb.scene.json --isosurface 32768 -o surface.exr\n"
                "  isoshade render ml.nrrd --scene refscenes/marschner-lobb.scene.json --with cycles --step 0.0625 --size 64 -o ml-cycles.exr\n"
                "  isoshade render ml.nrrd --scene refscenes/marschner-lobb.scene.json --with povray --limit --step 0.25 --size 32 -o ml-limit.exr\n"
                "  isoshade render ml.nrrd --scene refscenes/marschner-lobb.scene.json --level 1 --adapt --roi 8,8,6,24,32,20 -o roi.exr\n"
                "  isoshade render ml.nrrd --scene refscenes/marschner-lobb.scene.json --cache-bytes 400000 --brick 8 -o cached.exr\n",
    .run = run,
};
