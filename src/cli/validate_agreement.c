/* validate_agreement.c - every renderer against the reference, level by level. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/validate.h"

/* POV-Ray's lock-step: enough intervals to look like the volume, few enough to be quick. */
enum { lock_step_intervals = 128 };

/* One comparison: what is rendered, against which image of the reference, and what is asked of it. */
typedef struct match {
    const char *id, *a, *b, *tier;
    iso_render_options reference, other;
    bool has_coarser; /* a second render at twice the step gives the error bar */
    iso_render_options coarser;
    iso_limits limits;
    const char *why;
    bool informative;
} match;

enum { match_count = 5 };

/* What "converged" means for the two programs whose step stays in the image. */
static const double converged_step = 1.0 / 16;

/* The exports carry decoded directions, so the reference takes the same; for linear codes nothing changes. */
static iso_direction_source exported_source(const iso_validation *v)
{
    return iso_code_describe(v->pyramid->options.code)->is_linear ? ISO_FROM_CODES : ISO_FROM_DECODED;
}

static void describe_matches(const iso_validation *v, match m[match_count])
{
    const iso_scene_agreement *asked = &v->scene->agreement;
    iso_direction_source exported = exported_source(v);
    for (int i = 0; i < match_count; ++i) {
        m[i] = (match){.reference = iso_render_defaults(ISO_WITH_REFERENCE), .other = iso_render_defaults(ISO_WITH_GL)};
        m[i].reference.threads = m[i].other.threads = v->threads;
    }
    m[0].id = "gl-lockstep", m[0].a = "reference, same samples", m[0].b = "gl", m[0].tier = "lock-step";
    m[0].reference.quadrature = ISO_QUADRATURE_MIDPOINT;
    m[0].limits = (iso_limits){.rmse = 1e-6, .max_abs = 2e-5};
    m[0].why = "the same samples in float instead of double";

    m[1].id = "gl-converged", m[1].a = "reference", m[1].b = "gl", m[1].tier = "convergence";
    m[1].has_coarser = true;
    m[1].informative = true;
    m[1].why = "what the scene's own ray step costs; reported, not asked for";

    m[2].id = "povray-lockstep", m[2].a = "reference, same samples", m[2].b = "povray", m[2].tier = "lock-step";
    m[2].reference.quadrature = ISO_QUADRATURE_POVRAY;
    m[2].reference.intervals = m[2].other.intervals = lock_step_intervals;
    m[2].limits = (iso_limits){.max_abs = 2e-5};
    m[2].why = "the same samples; POV-Ray writes 16 bits a channel (7.6e-6)";

    m[3].id = "povray-converged", m[3].a = "reference", m[3].b = "povray", m[3].tier = "convergence";
    m[3].has_coarser = !v->quick; /* half of POV-Ray's time again */
    m[3].limits = (iso_limits){.rmse = asked->povray_rmse};
    m[3].why = asked->why;

    m[4].id = "cycles", m[4].a = "reference", m[4].b = "cycles", m[4].tier = "convergence";
    m[4].has_coarser = true;
    m[4].limits = (iso_limits){.rmse = asked->cycles_rmse};
    m[4].why = asked->why;

    m[2].other.renderer = m[3].other.renderer = ISO_WITH_POVRAY;
    m[4].other.renderer = ISO_WITH_CYCLES;
    m[2].reference.source = m[3].reference.source = m[4].reference.source = exported;
    m[3].other.step_voxels = m[4].other.step_voxels = converged_step;
    for (int i = 0; i < match_count; ++i)
        m[i].coarser = m[i].other;
    m[1].coarser.step_voxels = 2 * v->view->step_voxels;
    m[3].coarser.step_voxels = m[4].coarser.step_voxels = 2 * converged_step;
}

/* The converged image of a level serves several matches. */
typedef struct kept_image {
    bool there;
    char name[64];
    iso_image image;
} kept_image;

static iso_status render(iso_validation *v, size_t level, const iso_render_options *opt, const char *name,
                         const char *caption, iso_image *image, iso_error *err)
{
    iso_status status = iso_render_with(&v->renderers, v->pyramid, level, v->view, opt, image, NULL, v->progress, err);
    if (status == ISO_OK && name)
        status = iso_report_add_image(v->report, name, image, caption, NULL, err);
    if (status == ISO_OK && name)
        iso_report_set_scale(v->report, name, iso_view_mm_per_pixel(v->view, &v->pyramid->levels[0].geometry));
    return status;
}

/* The line that repeats the other side of a match. */
static char *reproduce(const iso_validation *v, size_t level, const match *m)
{
    char *text = NULL, extra[96] = "";
    size_t size = 0;
    if (m->other.intervals)
        snprintf(extra, sizeof extra, " --intervals %zu", m->other.intervals);
    else if (m->other.step_voxels > 0)
        snprintf(extra, sizeof extra, " --step %g", m->other.step_voxels);
    FILE *memory = open_memstream(&text, &size);
    if (!memory)
        return NULL;
    fprintf(memory, "isoshade render %s --scene %s --with %s --level %zu --size %zux%zu%s -o %s-level-%zu.exr", v->volume_path,
            v->scene_path, iso_renderer_name(m->other.renderer), level, v->view->width, v->view->height, extra, m->id, level);
    fclose(memory);
    return text;
}

static bool shows_nothing(const iso_image *image)
{
    for (size_t i = 0; i < image->width * image->height; ++i)
        if (image->rgba[4 * i + 3] != 0)
            return false;
    return true;
}

static iso_status add_row(iso_validation *v, size_t level, const match *m, const char *name_a, const char *name_b,
                          const iso_image *a, const iso_image *b, double error_bar, iso_error *err)
{
    iso_report_agreement row = {.level = level, .scene = v->scene_name, .a = m->a, .b = m->b, .image_a = name_a,
                                .image_b = name_b, .tier = m->tier, .error_bar = error_bar, .limits = m->limits,
                                .why = m->why, .informative = m->informative};
    const char *refused = v->refused[m->other.renderer];
    iso_status status = ISO_OK;
    if (refused[0])
        row.refused = refused, row.image_a = row.image_b = NULL;
    else
        status = iso_metrics_measure(a, b, &row.metrics, err);
    if (!refused[0] && shows_nothing(a) && shows_nothing(b)) { /* two empty images prove nothing */
        row.informative = true;
        row.why = "the transfer function shows nothing of this level";
    }
    char *command = reproduce(v, level, m);
    row.command = command;
    if (status == ISO_OK)
        status = iso_report_add_agreement(v->report, &row, err);
    free(command);
    return status;
}

/* RMSE between the step and its double: what the step alone explains. */
static iso_status measure_error_bar(iso_validation *v, size_t level, const match *m, const iso_image *fine, double *bar, iso_error *err)
{
    iso_image coarse = {0};
    iso_metrics metrics = {0};
    iso_status status = render(v, level, &m->coarser, NULL, NULL, &coarse, err);
    if (status == ISO_OK)
        status = iso_metrics_measure(fine, &coarse, &metrics, err);
    iso_image_destroy(&coarse);
    *bar = metrics.rmse;
    return status;
}

static iso_status reference_image(iso_validation *v, size_t level, const match *m, kept_image *converged, kept_image *own,
                                  const kept_image **out, iso_error *err)
{
    bool shared = m->reference.quadrature == ISO_QUADRATURE_CONVERGED && m->reference.source == ISO_FROM_CODES;
    kept_image *keep = shared ? converged : own;
    *out = keep;
    if (keep->there)
        return ISO_OK;
    snprintf(keep->name, sizeof keep->name, "level-%zu-reference%s%s", level, shared ? "" : "-for-", shared ? "" : m->id);
    iso_status status = render(v, level, &m->reference, keep->name, m->a, &keep->image, err);
    keep->there = status == ISO_OK;
    return status;
}

static iso_status run_match(iso_validation *v, size_t level, const match *m, kept_image *converged, iso_error *err)
{
    char name[64];
    kept_image own = {0};
    const kept_image *reference = NULL;
    iso_image image = {0};
    double bar = NAN;
    if (v->refused[m->other.renderer][0])
        return add_row(v, level, m, NULL, NULL, NULL, NULL, bar, err);
    snprintf(name, sizeof name, "level-%zu-%s", level, m->id);
    iso_status status = reference_image(v, level, m, converged, &own, &reference, err);
    if (status == ISO_OK)
        status = render(v, level, &m->other, name, m->b, &image, err);
    if (status == ISO_OK && m->has_coarser)
        status = measure_error_bar(v, level, m, &image, &bar, err);
    if (status == ISO_OK)
        status = add_row(v, level, m, reference->name, name, &reference->image, &image, bar, err);
    iso_image_destroy(&own.image);
    iso_image_destroy(&image);
    return status;
}

iso_status iso_validate_agreement(iso_validation *v, iso_error *err)
{
    match matches[match_count];
    iso_status status = ISO_OK;
    describe_matches(v, matches);
    for (size_t level = 0; level < v->pyramid->level_count && status == ISO_OK; ++level) {
        kept_image converged = {0};
        for (int i = 0; i < match_count && status == ISO_OK; ++i) {
            char stage[64];
            if (!v->wanted[matches[i].other.renderer])
                continue;
            snprintf(stage, sizeof stage, "level %zu: %s", level, matches[i].id);
            iso_progress_report(v->progress, stage, 0);
            status = run_match(v, level, &matches[i], &converged, err);
        }
        iso_image_destroy(&converged.image);
    }
    return status;
}
