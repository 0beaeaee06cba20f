/* SPDX-License-Identifier: MIT */
#include "chart/bench.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/parallel.h"
#include "base/provenance.h"
#include "chart/picture.h"
#include "compare/metrics.h"
#include "options/adapted.h"
#include "plan/cached.h"
#include "pyramid/palette_level.h"
#include "renderers/gl.h"
#include "plan/planner.h"
#include "scene/subject.h"

/* A frame is drawn up to MOST_FRAMES times while that takes less than FRAMES_SECONDS. */
enum { MOST_FRAMES = 5, HASTY_FRAMES = 2 };
static const double FRAMES_SECONDS = 0.15;

static size_t most_frames(const iso_chart_bench *b)
{
    return b->hasty ? HASTY_FRAMES : MOST_FRAMES;
}

/* Limits of memory for objects that settings share. */
static const double MOST_KEPT_BYTES = 600e6, MOST_OTHERS_BYTES = 1500e6;

/* ---- scenes and pyramids ---------------------------------------------------------- */

/* How a pyramid of the chart is built. */
typedef struct chart_build {
    iso_gradient_method estimator;
    iso_direction_filter filter;
    size_t level_count;
    iso_code code;
} chart_build;

static iso_status load(const iso_chart_bench *b, const chart_build *build, const iso_progress *progress, iso_pyramid *p,
                       iso_error *err)
{
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.gradient.method = build->estimator;
    opt.direction_filter = build->filter;
    opt.level_count = build->level_count;
    opt.code = build->code;
    opt.keep_float = true;
    opt.threads = opt.gradient.threads = b->threads;
    return iso_subject_load_pyramid(b->path, b->input, &opt, progress, p, err);
}

/* Names a scene: "brain" of brain.scene.json, with a number if the name is taken. */
static void name_scene(iso_chart_bench *b, iso_chart_scene *scene)
{
    const char *named = iso_provenance_name(scene->path);
    const char *base = !scene->path ? "first-picture" : *named ? iso_path_base(named) : "scene";
    const size_t length = strcspn(base, ".");
    snprintf(scene->name, sizeof scene->name, "%.*s", (int)(length < 100 ? length : 100), base);
    for (const iso_chart_scene *o = b->scenes; o < scene; ++o)
        if (strcmp(o->name, scene->name) == 0) {
            const size_t used = strlen(scene->name);
            snprintf(scene->name + used, sizeof scene->name - used, "-%zu", (size_t)(scene - b->scenes) + 1);
            break;
        }
}

static iso_status add_scene(iso_chart_bench *b, const iso_subject_look *look, iso_error *err)
{
    iso_chart_scene *scene = &b->scenes[b->scene_count++];
    scene->path = look->scene;
    name_scene(b, scene);
    if (!(scene->looks = calloc(ISO_CHART_MAX_LEVELS * ISO_CHART_TFS, sizeof *scene->looks)))
        return iso_fail(err, ISO_E_MEMORY, "chart: no memory for views");
    NEED(iso_subject_make_scene(look, &b->first, &scene->scene, err));
    return iso_scene_resolve(&scene->scene, &b->first.levels[0].geometry, iso_pyramid_lo(&b->first),
                             iso_pyramid_hi(&b->first), &scene->view, err);
}

iso_status iso_chart_bench_open(iso_chart_bench *b, const iso_chart_subject *s, const iso_chart_grid *grid, int threads,
                                const iso_progress *progress, iso_error *err)
{
    *b = (iso_chart_bench){.path = s->path,
                           .input = s->input,
                           .threads = threads,
                           .progress = *progress,
                           .is_volume = !iso_pyramid_is_one(s->path)};
    NEED(load(b, &(chart_build){grid->first_estimator, grid->first_filter, s->level_count, grid->first_code}, progress,
              &b->first, err));
    for (size_t i = 0; i < s->look_count; ++i)
        NEED(add_scene(b, &s->looks[i], err));
    return ISO_OK;
}

static void close_scene(iso_chart_scene *scene)
{
    for (size_t i = 0; i < ISO_CHART_MAX_LEVELS * ISO_CHART_TFS && scene->looks; ++i)
        iso_view_destroy(&scene->looks[i]);
    free(scene->looks);
    iso_plan_errors_destroy(&scene->plan);
    iso_image_destroy(&scene->reference);
    iso_view_destroy(&scene->view);
    iso_scene_destroy(&scene->scene);
}

void iso_chart_bench_close(iso_chart_bench *b)
{
    for (size_t i = 0; i < b->scene_count; ++i)
        close_scene(&b->scenes[i]);
    for (size_t i = 0; i < ISO_CHART_PALETTES; ++i)
        iso_palette_destroy(&b->palettes[i]);
    for (size_t i = 0; i < b->kept_count; ++i)
        free(b->kept[i].bytes);
    iso_node_levels_destroy(&b->nodes);
    iso_pyramid_destroy(&b->first);
    for (size_t i = 0; i < b->other_count; ++i)
        iso_pyramid_destroy(&b->others[i]);
    iso_renderers_end(&b->renderers);
    *b = (iso_chart_bench){.threads = 0};
}

iso_status iso_chart_bench_reference(iso_chart_bench *b, size_t scene, double tolerance, iso_error *err)
{
    iso_chart_scene *s = &b->scenes[scene];
    const iso_pyramid *p = &b->first;
    iso_reference_options opt = iso_reference_defaults();
    opt.source = p->levels[0].directions ? ISO_FROM_FLOAT : ISO_FROM_CODES;
    opt.tolerance = s->reference_tolerance = tolerance;
    opt.most_error = fmin(1e-3 * tolerance, 1e-5); /* proved bounds need no more than 1e-5 */
    opt.threads = b->threads;
    const double start = iso_clock_seconds();
    iso_status status = iso_reference_render(&p->levels[0], p->options.code, &s->view, &opt, &s->reference,
                                             &b->progress, err);
    s->reference_seconds = iso_clock_seconds() - start;
    return status;
}

/* ---- objects that settings need ---------------------------------------------------- */

static bool is_of(const iso_pyramid *p, const iso_chart_case *c)
{
    return p->levels && p->options.gradient.method == c->estimator && p->options.direction_filter == c->filter;
}

/* NULL: not built yet. */
static const iso_pyramid *pyramid_of(const iso_chart_bench *b, const iso_chart_case *c)
{
    for (size_t i = 0; i < b->other_count; ++i)
        if (is_of(&b->others[i], c))
            return &b->others[i];
    return is_of(&b->first, c) ? &b->first : NULL;
}

static iso_status need_pyramid(iso_chart_bench *b, const iso_chart_case *c, iso_error *err)
{
    const double bytes = 8.0 / 7 * (sizeof(float) + 3 + 3 * sizeof(float)) *
                         (double)iso_geometry_voxel_count(&b->first.levels[0].geometry);
    const size_t most = bytes < MOST_OTHERS_BYTES / ISO_CHART_MAX_OTHERS ? ISO_CHART_MAX_OTHERS
                                                                         : (size_t)fmax(MOST_OTHERS_BYTES / bytes, 1);
    const iso_progress silent = {0};
    if (pyramid_of(b, c))
        return ISO_OK;
    iso_pyramid *p = &b->others[b->other_count < most ? b->other_count : b->replaced++ % most];
    iso_pyramid_destroy(p);
    *p = (iso_pyramid){0};
    iso_status status = load(b, &(chart_build){c->estimator, c->filter, b->first.level_count, b->first.options.code},
                             &silent, p, err);
    b->other_count += status == ISO_OK && p == &b->others[b->other_count];
    return status;
}

static iso_view *look_of(const iso_chart_bench *b, const iso_chart_case *c)
{
    const size_t tf = c->second != ISO_SECOND_VALUE_NONE ? 2 + (size_t)(c->second - ISO_SECOND_VALUE_DEVIATION)
                                                         : c->adapted;
    return &b->scenes[c->scene].looks[c->level * ISO_CHART_TFS + tf];
}

/* Makes the view of a level as `isoshade render` does, so that the command of a setting gives its error again. */
static iso_status need_look(iso_chart_bench *b, const iso_chart_case *c, iso_error *err)
{
    iso_chart_scene *s = &b->scenes[c->scene];
    iso_view *look = look_of(b, c);
    OWNED(iso_view) made = {0};
    iso_cli_adapted adapted = ISO_CLI_ADAPTED_DEFAULTS;
    char second[16];
    snprintf(second, sizeof second, "%s", iso_chart_name_tf(c));
    adapted.wanted = c->adapted;
    adapted.tf_2d = c->second != ISO_SECOND_VALUE_NONE ? second : NULL;
    if (c->plan_error > 0 || look->tf.entries)
        return ISO_OK;
    NEED(iso_scene_resolve(&s->scene, &b->first.levels[0].geometry, iso_pyramid_lo(&b->first),
                           iso_pyramid_hi(&b->first), &made, err));
    NEED(iso_cli_adapt_view(&adapted, "", &b->first, c->level, &made, b->threads, err));
    *look = made;
    made = (iso_view){0};
    return ISO_OK;
}

/* Allows two swaps only: a chart has no time for the last percent. */
static iso_status need_palette(iso_chart_bench *b, const iso_chart_case *c, iso_error *err)
{
    iso_palette *palette = &b->palettes[c->palette];
    if (c->source != ISO_FROM_PALETTE || palette->xyz)
        return ISO_OK;
    return iso_level_fit_palette(&b->first.levels[0], b->first.options.code, iso_chart_palettes[c->palette], 2,
                                 b->threads, palette, err);
}

static iso_status need_plan(iso_chart_bench *b, const iso_chart_case *c, iso_error *err)
{
    iso_chart_scene *s = &b->scenes[c->scene];
    if (!(c->plan_error > 0) || s->plan.levels)
        return ISO_OK;
    if (!b->nodes.nodes[0]) {
        NEED(iso_node_levels_create(&b->nodes, &b->first.levels[0], ISO_CHART_BRICK_VOXELS, ISO_CHART_BRICK_LEVELS,
                                    true, b->threads, err));
        NEED(iso_node_levels_round(&b->nodes, b->threads, err));
    }
    const iso_progress silent = {0};
    return iso_plan_errors_create(&s->plan, &b->nodes, &s->view, 1, b->threads, &silent, err);
}

/* ---- estimates -------------------------------------------------------------------- */

/* Estimates seconds for objects that the setting still needs, from the seconds per million voxels of level 0 on a slow
 * machine. Decides only whether to start the setting. */
static double estimate_needs(const iso_chart_bench *b, const iso_chart_case *c)
{
    const double millions = 1e-6 * (double)iso_geometry_voxel_count(&b->first.levels[0].geometry);
    const iso_chart_scene *s = &b->scenes[c->scene];
    double a_million = 0;
    if (!pyramid_of(b, c))
        a_million += 0.4;
    if (c->adapted && !look_of(b, c)->tf.entries)
        a_million += 0.2;
    if (c->source == ISO_FROM_PALETTE && !b->palettes[c->palette].xyz)
        a_million += 1;
    if (c->plan_error > 0 && !s->plan.levels)
        a_million += 0.8;
    return a_million * millions;
}

double iso_chart_bench_estimate(const iso_chart_bench *b, const iso_chart_case *c)
{
    const iso_chart_pace *pace = &b->pace[iso_renderer_index(c->renderer)];
    const bool other_program = iso_renderer_has(c->renderer, ISO_IS_PROGRAM);
    const double needs = estimate_needs(b, c) + b->metrics_seconds;
    if (!pace->is_known)
        return needs + (other_program ? 4 + 1e-6 * (double)c->voxel_count : 0);
    const double frame = pace->frame_seconds_per_cost * c->relative_cost;
    const double frames = other_program ? frame : fmin((double)most_frames(b) * frame, FRAMES_SECONDS + frame);
    return needs + pace->setup_seconds * (other_program ? 1 : (double)c->voxel_count) + frames;
}

double iso_chart_bench_estimate_frame(const iso_chart_bench *b, const iso_chart_case *c)
{
    const iso_chart_pace *pace = &b->pace[iso_renderer_index(c->renderer)];
    return pace->is_known ? pace->frame_seconds_per_cost * c->relative_cost : NAN;
}

/* Keeps the slowest measurement, but halves it each time: one slow frame may be due to other load. */
static void learn(iso_chart_bench *b, const iso_chart_case *c, double all_seconds)
{
    iso_chart_pace *pace = &b->pace[iso_renderer_index(c->renderer)];
    const double frames = c->took.median_seconds * (double)c->took.count, setup = fmax(all_seconds - frames, 0);
    const double voxels = iso_renderer_has(c->renderer, ISO_IS_PROGRAM) ? 1 : fmax((double)c->voxel_count, 1e5);
    pace->setup_seconds = fmax(0.5 * pace->setup_seconds, setup / voxels);
    pace->frame_seconds_per_cost = fmax(0.5 * pace->frame_seconds_per_cost, c->took.median_seconds / c->relative_cost);
    pace->is_known = true;
}

void iso_chart_bench_learn(iso_chart_bench *b, const iso_chart_case *c)
{
    learn(b, c, c->took.median_seconds * (double)c->took.count + c->took.setup_seconds);
}

/* ---- one setting ------------------------------------------------------------------- */

/* Makes directions of the level in the case's code, or palette indices; keeps them while memory allows. */
static iso_status need_bytes(iso_chart_bench *b, const iso_pyramid *p, const iso_chart_case *c, void **bytes,
                             bool *is_kept, iso_error *err)
{
    const bool keep = p == &b->first;
    *bytes = NULL;
    *is_kept = false;
    for (size_t i = 0; keep && i < b->kept_count; ++i) {
        const iso_chart_kept *k = &b->kept[i];
        if (k->level == c->level && k->source == c->source && k->code == c->code && k->palette == c->palette) {
            *bytes = k->bytes;
            *is_kept = true;
            return ISO_OK;
        }
    }
    iso_level level = p->levels[c->level];
    const size_t count = iso_geometry_voxel_count(&level.geometry);
    const double size = (double)count * (c->source == ISO_FROM_PALETTE ? sizeof(uint16_t) : 3);
    iso_status status = ISO_OK;
    if (c->source == ISO_FROM_PALETTE) {
        status = iso_level_attach_palette(&level, p->options.code, &b->palettes[c->palette], err);
        *bytes = status == ISO_OK ? (void *)level.palette_index : NULL;
    } else if (!(*bytes = malloc(3 * count))) {
        status = iso_fail(err, ISO_E_MEMORY, "chart: no memory for %zu directions", count);
    } else {
        iso_code_encode(c->code, level.directions, *bytes, count);
    }
    if (status == ISO_OK && keep && b->kept_bytes + size <= MOST_KEPT_BYTES &&
        b->kept_count < sizeof b->kept / sizeof *b->kept) {
        b->kept[b->kept_count++] = (iso_chart_kept){c->source, c->code, c->palette, c->level, *bytes};
        b->kept_bytes += size;
        *is_kept = true;
    }
    return status;
}

static iso_status render_level(iso_chart_bench *b, iso_chart_case *c, iso_image *image, iso_error *err)
{
    const iso_pyramid *base = pyramid_of(b, c);
    const bool palette = c->source == ISO_FROM_PALETTE,
               recoded = c->source == ISO_FROM_CODES && c->code != base->options.code;
    iso_render_options opt = iso_render_defaults(c->renderer);
    iso_level levels[ISO_CHART_MAX_LEVELS];
    iso_pyramid p = *base;
    void *bytes = NULL;
    bool is_kept = true;
    iso_status status = palette || recoded ? need_bytes(b, base, c, &bytes, &is_kept, err) : ISO_OK;
    memcpy(levels, base->levels, base->level_count * sizeof *levels);
    p.levels = levels;
    if (recoded) {
        levels[c->level].codes = bytes;
        p.options.code = c->code;
    }
    if (palette) {
        levels[c->level].palette = &b->palettes[c->palette];
        levels[c->level].palette_index = bytes;
    }
    opt.source = c->source;
    opt.quadrature = c->preintegrated ? ISO_QUADRATURE_PREINTEGRATED : ISO_QUADRATURE_MIDPOINT;
    opt.step_voxels = c->step_voxels;
    opt.threads = b->threads;
    opt.repeats = most_frames(b);
    opt.repeat_seconds = FRAMES_SECONDS;
    opt.processor_time = b->processor_time;
    opt.stats = &c->took;
    const iso_render_request request = {&b->renderers, &p, c->level, look_of(b, c), &opt, NULL};
    if (status == ISO_OK)
        status = iso_render_with(&request, image, NULL, err);
    if (!is_kept)
        free(bytes);
    return status;
}

static iso_status render_plan(iso_chart_bench *b, iso_chart_case *c, iso_image *image, iso_error *err)
{
    iso_chart_scene *s = &b->scenes[c->scene];
    iso_cached_report report = {0};
    const iso_cached_options opt = {.plan_error = c->plan_error,
                                    .step_voxels = c->step_voxels,
                                    .repeats = most_frames(b),
                                    .repeat_seconds = FRAMES_SECONDS,
                                    .processor_time = b->processor_time,
                                    .threads = b->threads,
                                    .report = &report};
    iso_gl *gl = NULL;
    if (c->renderer != &iso_renderer_cpu)
        NEED(iso_renderers_need_gl(&b->renderers, &gl, err));
    if (gl && b->processor_time)
        iso_gl_time_processor(gl, true);
    NEED(iso_cached_render_nodes(gl, &b->nodes, &s->plan, &s->view, &opt, image, err));
    iso_render_stats_of_gl(&report.draws, &c->took);
    c->stored_bytes = ISO_BYTES_A_NODE * (double)report.node_count;
    return ISO_OK;
}

/* Makes the objects that the setting needs, and renders it. */
static iso_status render(iso_chart_bench *b, iso_chart_case *c, iso_image *image, iso_error *err)
{
    *image = (iso_image){0};
    NEED(need_pyramid(b, c, err));
    NEED(need_look(b, c, err));
    NEED(need_palette(b, c, err));
    NEED(need_plan(b, c, err));
    const double start = iso_clock_seconds();
    NEED(c->plan_error > 0 ? render_plan(b, c, image, err) : render_level(b, c, image, err));
    learn(b, c, iso_clock_seconds() - start);
    return ISO_OK;
}

/* Compares with the reference. Skips FLIP and SSIM, which take longer than a frame, unless `visual`. */
static iso_status compare(iso_chart_bench *b, iso_chart_case *c, const iso_image *image, bool visual, iso_error *err)
{
    const iso_image *reference = &b->scenes[c->scene].reference;
    const double start = iso_clock_seconds();
    const iso_status status = visual ? iso_metrics_measure(reference, image, &c->metrics, err)
                                     : iso_metrics_measure_differences(reference, image, &c->metrics, err);
    b->metrics_seconds = iso_clock_seconds() - start;
    return status;
}

iso_status iso_chart_bench_measure(iso_chart_bench *b, iso_chart_case *c, iso_error *err)
{
    OWNED(iso_image) image = {0};
    c->done = false;
    NEED(render(b, c, &image, err));
    NEED(compare(b, c, &image, !b->hasty || b->needs_visual, err));
    c->picture = iso_chart_picture(&image);
    c->done = true;
    return ISO_OK;
}

iso_status iso_chart_bench_time_again(iso_chart_bench *b, iso_chart_case *c, iso_error *err)
{
    iso_chart_case again = *c;
    OWNED(iso_image) image = {0};
    NEED(render(b, &again, &image, err));
    if (!isfinite(c->metrics.ssim) && c->metrics.nonfinite_count == 0)
        NEED(compare(b, c, &image, true, err));
    iso_render_stats_add(&c->took, &again.took);
    return ISO_OK;
}
