/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "figure/kinds.h"

#include <stdio.h>
#include <string.h>

#include "figure/columns.h"
#include "figure/picture.h"
#include "plan/scene_levels.h"

enum { USUAL_LEVELS = 4 };

typedef struct shown {
    iso_figure_subject subject, optimized; /* optimized: its levels are; empty if no column shows them */
    const iso_renderer_info *with[ISO_FIGURE_MOST_COLUMNS];
    size_t level[ISO_FIGURE_MOST_COLUMNS];
    bool is_optimized[ISO_FIGURE_MOST_COLUMNS];
} shown;

static void shown_destroy(shown *s)
{
    iso_figure_subject_end(&s->subject);
    iso_figure_subject_end(&s->optimized);
}

/* Does the same as build --for with the scene, for levels from `first` on. */
static iso_status optimize_levels(iso_figure_subject *s, size_t first, iso_error *err)
{
    const iso_optimize_options opt = {.effort = ISO_EFFORT_NORMAL, .seed = 1};
    const iso_progress progress = iso_cli_progress(s->job->cli);
    return iso_scene_levels_make(&s->pyramid, first, &s->scene, 1, &opt, s->job->cli->threads, NULL, &progress, err);
}

static iso_status render(void *user, size_t column, size_t width, size_t height, iso_image *image, double *mm_per_pixel,
                         iso_error *err)
{
    shown *s = user;
    const iso_figure_picture what = {.with = s->with[column],
                                     .level = s->level[column],
                                     .width = width,
                                     .height = height};
    return iso_figure_render(s->is_optimized[column] ? &s->optimized : &s->subject, &what, image, mm_per_pixel, err);
}

/* Chooses level 0, and of each other level the default, the optimized one, or both by --methods. */
static iso_status choose_levels(const iso_figure_job *job, shown *s, iso_figure_columns *c, iso_error *err)
{
    const iso_renderer_info *with = NULL;
    const iso_status status = iso_figure_renderer(job, &with, err);
    const char *const methods = job->methods ? job->methods : "default";
    const bool both = !strcmp(methods, "default,optimized"), plain = both || !strcmp(methods, "default");
    const size_t count = job->levels ? (size_t)job->levels : USUAL_LEVELS;
    if (!plain && strcmp(methods, "optimized") != 0)
        return iso_fail(err, ISO_E_USAGE,
                        "--methods is \"%s\", levels of a volume are default, optimized or "
                        "default,optimized",
                        methods);
    for (size_t i = 0; i < 2 * count; ++i) {
        const bool is_optimized = i % 2 == 1;
        if (is_optimized ? i == 1 || (plain && !both) : i > 0 && !plain)
            continue;
        s->with[c->count] = with;
        s->level[c->count] = i / 2;
        s->is_optimized[c->count] = is_optimized;
        snprintf(c->titles[c->count++], sizeof *c->titles, "level %zu%s", i / 2, is_optimized ? ", optimized" : "");
    }
    return status;
}

static iso_status choose_renderers(const iso_figure_job *job, shown *s, iso_figure_columns *c, iso_error *err)
{
    bool wanted[ISO_MAX_RENDERERS];
    NEED(iso_renderers_from_list(job->with, wanted, err));
    NEED(iso_renderers_find_missing(job->with, wanted, err));
    for (size_t i = 0; i < iso_renderer_count(); ++i)
        if (wanted[i]) {
            s->with[c->count] = iso_renderer_at(i);
            s->level[c->count] = (size_t)job->level;
            snprintf(c->titles[c->count++], sizeof *c->titles, "%.90s", iso_renderer_at(i)->title);
        }
    return ISO_OK;
}

static iso_status load_levels(const iso_figure_job *job, shown *s, size_t last, iso_error *err)
{
    NEED(iso_figure_subject_load(&s->subject, job, s->level[last] + 1, NULL, err));
    if (!s->is_optimized[last])
        return ISO_OK;
    if (iso_pyramid_is_one(job->input))
        return iso_fail(err, ISO_E_USAGE, "--methods optimized builds a pyramid: give the volume, not %s", job->input);
    NEED(iso_figure_subject_load(&s->optimized, job, s->level[last] + 1, NULL, err));
    return optimize_levels(&s->optimized, 1, err);
}

static iso_status draw_volume(const iso_figure_job *job, bool of_levels, iso_page *page, iso_error *err)
{
    OWNED(shown) s = {0};
    iso_figure_columns c = {.job = job, .compared = true, .in_logs = !of_levels, .render = render, .user = &s};
    FILE *f = iso_page_caption(page);
    NEED(of_levels ? choose_levels(job, &s, &c, err) : choose_renderers(job, &s, &c, err));
    NEED(load_levels(job, &s, c.count - 1, err));
    fputs(of_levels ? "Levels" : "Renderers", f);
    iso_figure_put_subject(&s.subject, f);
    if (!of_levels)
        fprintf(f, ", level %zu", s.level[0]);
    else if (job->adapted.wanted)
        fputs(", each under the transfer function adapted to it", f);
    c.drawn_by = of_levels ? &s.subject.drawn_by : NULL;
    c.tf = iso_figure_tf_foot_of(&s.subject);
    c.aspect = iso_figure_aspect(&s.subject);
    return iso_figure_draw_columns(&c, page, err);
}

static iso_status draw_levels(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    return iso_figure_is_of_report(job) ? iso_figure_draw_report(job, true, page, err)
                                        : draw_volume(job, true, page, err);
}

static iso_status draw_renderers(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    return iso_figure_is_of_report(job) ? iso_figure_draw_report(job, false, page, err)
                                        : draw_volume(job, false, page, err);
}

const iso_figure_info iso_figure_levels = {
    .name = "levels",
    .summary = "the levels of a volume side by side, with maps of differences from level 0",
    .takes = ISO_FIGURE_OF_VOLUME | ISO_FIGURE_OF_REPORT | ISO_FIGURE_HAS_LOOK | ISO_FIGURE_HAS_WITH |
             ISO_FIGURE_HAS_LEVELS | ISO_FIGURE_HAS_ADAPT | ISO_FIGURE_HAS_METHODS | ISO_FIGURE_HAS_INSET,
    .draw = draw_levels,
};

const iso_figure_info iso_figure_renderers = {
    .name = "renderers",
    .summary = "one level by several renderers, with maps of differences from the reference",
    .takes = ISO_FIGURE_OF_VOLUME | ISO_FIGURE_OF_REPORT | ISO_FIGURE_HAS_LOOK | ISO_FIGURE_HAS_WITH |
             ISO_FIGURE_HAS_LEVEL | ISO_FIGURE_HAS_VARIANT | ISO_FIGURE_HAS_INSET,
    .draw = draw_renderers,
};

/* ---- methods ---- */

typedef enum shown_as { AS_BUILT, ADAPTED, FOR_SCENE } shown_as; /* the last as build --for */

typedef struct method {
    const char *name, *title;
    iso_direction_filter filter;
    iso_direction_source source;
    shown_as as;
} method;

static const method methods[] = {
    {"on-the-fly", "directions on the fly", ISO_DIRECTION_NAIVE, ISO_FROM_ON_THE_FLY, AS_BUILT},
    {"naive", "means of directions", ISO_DIRECTION_NAIVE, ISO_FROM_CODES, AS_BUILT},
    {"eq1", "weighted means (Eq. 1)", ISO_DIRECTION_EQ1, ISO_FROM_CODES, AS_BUILT},
    {"moments", "moments", ISO_DIRECTION_MOMENTS, ISO_FROM_CODES, AS_BUILT},
    {"on-the-fly+adapted", "on the fly, adapted TF", ISO_DIRECTION_NAIVE, ISO_FROM_ON_THE_FLY, ADAPTED},
    {"naive+adapted", "means of directions, adapted TF", ISO_DIRECTION_NAIVE, ISO_FROM_CODES, ADAPTED},
    {"eq1+adapted", "weighted means (Eq. 1), adapted TF", ISO_DIRECTION_EQ1, ISO_FROM_CODES, ADAPTED},
    {"moments+adapted", "moments, adapted TF", ISO_DIRECTION_MOMENTS, ISO_FROM_CODES, ADAPTED},
    {"optimized", "optimized for the scene", ISO_DIRECTION_MOMENTS, ISO_FROM_CODES, FOR_SCENE},
};
static const iso_names method_names = {"method",
                                       "methods",
                                       methods,
                                       ISO_NAMES_COUNT(methods),
                                       sizeof methods[0],
                                       offsetof(method, name),
                                       offsetof(method, title),
                                       false};
enum { MOST_METHODS = ISO_NAMES_COUNT(methods), USUAL_LEVEL = 2 };

const char *iso_figure_method_words(const char *name)
{
    for (size_t i = 0; i < ISO_NAMES_COUNT(methods); ++i)
        if (strcmp(methods[i].name, name) == 0)
            return methods[i].title;
    return name;
}

/* Level 0 in the first column; each other column has a pyramid of its own. */
typedef struct methods_shown {
    const iso_renderer_info *with;
    const method *method[1 + MOST_METHODS];
    iso_figure_subject subject[1 + MOST_METHODS];
    size_t level;
} methods_shown;

static void methods_shown_destroy(methods_shown *s)
{
    for (size_t i = 0; i < sizeof s->subject / sizeof *s->subject; ++i)
        iso_figure_subject_end(&s->subject[i]);
}

static iso_status render_method(void *user, size_t column, size_t width, size_t height, iso_image *image,
                                double *mm_per_pixel, iso_error *err)
{
    methods_shown *s = user;
    const method *m = s->method[column];
    const iso_figure_picture what = {.with = s->with,
                                     .level = column > 0 ? s->level : 0,
                                     .width = width,
                                     .height = height,
                                     .source = m ? &m->source : NULL,
                                     .adapted = m && m->as == ADAPTED};
    return iso_figure_render(&s->subject[column], &what, image, mm_per_pixel, err);
}

static iso_status choose_methods(const char *list, methods_shown *s, iso_figure_columns *c, iso_error *err)
{
    iso_status status = ISO_OK;
    snprintf(c->titles[0], sizeof c->titles[0], "level 0");
    c->count = 1;
    for (const char *at = list; at && status == ISO_OK; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL) {
        char word[64];
        size_t row = 0;
        snprintf(word, sizeof word, "%.*s", (int)strcspn(at, ","), at);
        if (c->count > MOST_METHODS)
            return iso_fail(err, ISO_E_USAGE, "--methods: at most %d methods", MOST_METHODS);
        status = iso_names_find(&method_names, word, &row, err);
        s->method[c->count] = &methods[row];
        snprintf(c->titles[c->count++], sizeof *c->titles, "%s", methods[row].title);
    }
    return status;
}

static iso_status load_methods(const iso_figure_job *job, methods_shown *s, size_t count, iso_error *err)
{
    iso_pyramid_options build = iso_pyramid_defaults();
    if (iso_pyramid_is_one(job->input))
        return iso_fail(err, ISO_E_USAGE, "--kind methods builds a pyramid for each method: give the volume, not %s",
                        job->input);
    for (size_t i = 0; i < count; ++i) {
        if (i > 0)
            build.direction_filter = s->method[i]->filter;
        NEED(iso_figure_subject_load(&s->subject[i], job, i > 0 ? s->level + 1 : 1, &build, err));
        if (i > 0 && s->method[i]->as == FOR_SCENE)
            NEED(optimize_levels(&s->subject[i], s->level, err));
    }
    return ISO_OK;
}

static iso_status draw_methods(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    OWNED(methods_shown) s = {.level = job->level ? (size_t)job->level : USUAL_LEVEL};
    iso_figure_columns c = {.job = job, .compared = true, .render = render_method, .user = &s};
    FILE *f = iso_page_caption(page);
    NEED(iso_figure_renderer(job, &s.with, err));
    NEED(choose_methods(job->methods ? job->methods : "naive,moments,moments+adapted", &s, &c, err));
    NEED(load_methods(job, &s, c.count, err));
    fprintf(f, "Methods for directions, level %zu", s.level);
    iso_figure_put_subject(&s.subject[0], f);
    c.drawn_by = &s.subject[0].drawn_by;
    c.tf = iso_figure_tf_foot_of(&s.subject[0]);
    c.aspect = iso_figure_aspect(&s.subject[0]);
    return iso_figure_draw_columns(&c, page, err);
}

const iso_figure_info iso_figure_methods = {
    .name = "methods",
    .summary = "one coarse level by several methods for its directions, and level 0",
    .takes = ISO_FIGURE_OF_VOLUME | ISO_FIGURE_HAS_LOOK | ISO_FIGURE_HAS_WITH | ISO_FIGURE_HAS_LEVEL |
             ISO_FIGURE_HAS_METHODS | ISO_FIGURE_HAS_INSET,
    .draw = draw_methods,
};
