/* SPDX-License-Identifier: MIT */
/* command.c - the command line that renders a setting of a chart again. */
#define _GNU_SOURCE
#include "chart/result.h"

#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"
#include "base/words.h"
#include "chart/kept.h"

static void put_option(FILE *f, const char *option, const char *word)
{
    if (!word)
        return;
    fprintf(f, " --%s ", option);
    iso_words_put_quoted(f, word);
}

/* Prints the fewest digits that restore the number. */
static void put_number(FILE *f, const char *option, double value)
{
    char text[32];
    for (int digits = 6; digits <= 17; ++digits) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    fprintf(f, " --%s %s", option, text);
}

static void put_input(FILE *f, const iso_volume_input *in)
{
    FREED char *line = iso_volume_input_line(in);
    fputs(line ? line : "", f);
}

/* Prints the options that differ from the defaults of `render`. */
static void put_directions(FILE *f, const iso_chart_result *r, const iso_chart_case *c)
{
    const iso_pyramid_options usual = r->bench->is_volume ? iso_pyramid_defaults() : r->bench->first.options;
    char palette[64];
    if (c->code != usual.code && (c->source == ISO_FROM_CODES || c->source == ISO_FROM_FLIPPED))
        put_option(f, "code", iso_code_describe(c->code)->name);
    if (c->source != ISO_FROM_ON_THE_FLY && c->estimator != usual.gradient.method)
        put_option(f, "estimator", iso_gradient_name(c->estimator));
    if (c->source != ISO_FROM_ON_THE_FLY && c->level > 0 && c->filter != usual.direction_filter)
        put_option(f, "direction-filter", iso_direction_filter_name(c->filter));
    if (c->source != ISO_FROM_CODES)
        put_option(f, "shading-from", iso_direction_source_name(c->source));
    if (c->source != ISO_FROM_PALETTE)
        return;
    snprintf(palette, sizeof palette, "palette-%zu.csv", iso_chart_palettes[c->palette]);
    FREED char *path = iso_path_join(r->output, palette);
    put_option(f, "palette", path);
}

char *iso_chart_command(const iso_chart_result *r, const iso_chart_case *c)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f)
        return NULL;
    fputs("isoshade render ", f);
    iso_words_put_quoted(f, r->bench->path);
    put_input(f, r->bench->input);
    fputs(r->looks[c->scene], f);
    put_option(f, "with", c->renderer->name); /* always: the default renderer depends on the machine */
    if (c->plan_error > 0) {
        put_number(f, "plan-error", c->plan_error);
        fprintf(f, " --brick %d --brick-levels %d", ISO_CHART_BRICK_VOXELS, ISO_CHART_BRICK_LEVELS);
        if (c->estimator != iso_pyramid_defaults().gradient.method && r->bench->is_volume)
            put_option(f, "estimator", iso_gradient_name(c->estimator));
    } else {
        if (c->level > 0)
            fprintf(f, " --level %zu", c->level);
        put_directions(f, r, c);
        if (c->adapted)
            fputs(" --adapt", f);
        if (c->second != ISO_SECOND_VALUE_NONE)
            put_option(f, "tf-2d", iso_chart_name_tf(c));
    }
    put_number(f, "step", c->step_voxels);
    if (c->preintegrated)
        put_option(f, "quadrature", "preintegrated");
    else if (iso_renderer_has(c->renderer, ISO_READS_QUADRATURE) &&
             c->renderer->defaults.quadrature != ISO_QUADRATURE_MIDPOINT)
        put_option(f, "quadrature", "midpoint");
    fputs(" -o setting.exr", f);
    if (fclose(f) == 0)
        return text;
    free(text);
    return NULL;
}

/* Writes "isoshade compare setting.exr DIR/reference.exr". */
char *iso_chart_compare_command(const iso_chart_result *r, size_t scene)
{
    char name[192];
    iso_chart_reference_name(r->bench, scene, name, sizeof name);
    char *text = NULL, *path = iso_path_join(r->output, name);
    size_t size = 0;
    FILE *f = path ? open_memstream(&text, &size) : NULL;
    if (f) {
        fputs("isoshade compare setting.exr ", f);
        iso_words_put_quoted(f, path);
        fclose(f);
    }
    free(path);
    return text;
}
