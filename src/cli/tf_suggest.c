/* SPDX-License-Identifier: MIT */
#include "cli/tf.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/json.h"
#include "scene/subject.h"
#include "tf/color_space.h"
#include "tf/presets.h"
#include "tf/suggest.h"
#include "volume/unit.h"

/* Rounds x for editing, to `digits` digits after the first one of x, or of `span` if that is smaller. */
static double rounded(double x, double span, int digits)
{
    const double size = span > 0 ? fmin(fabs(x), span) : fabs(x);
    const double digit = size > 0 ? pow(10, floor(log10(size)) - digits) : 0;
    return digit > 0 && isfinite(x / digit) ? round(x / digit) * digit : x;
}

/* Returns the TF as JSON with display colors, which are easier to edit. */
static json_t *editable(const iso_tf *tf, const char *comment)
{
    json_t *root = iso_tf_to_json(tf), *points = json_object_get(root, "points");
    const double span = tf->fit_range ? 1 : tf->range[1] - tf->range[0];
    for (size_t i = 0; i < tf->point_count; ++i) {
        static const char *const keys[3] = {"r", "g", "b"};
        json_t *point = json_array_get(points, i);
        json_object_set_new(point, "value", json_real(rounded(tf->points[i].value, span, 5)));
        json_object_set_new(point, "opacity", json_real(rounded(tf->points[i].opacity, 0, 2)));
        for (int c = 0; c < 3; ++c)
            json_object_set_new(point, keys[c],
                                json_real(rounded(iso_linear_to_srgb(tf->points[i].rgb_linear[c]), 0, 2)));
    }
    json_object_set_new(root, "color_space", json_string("srgb"));
    json_object_set_new(root, "comment", json_string(comment));
    return root;
}

/* Returns the materials for --json. */
static json_t *materials_of(const iso_suggestion *s)
{
    json_t *list = json_array();
    for (size_t i = 0; i < s->material_count; ++i)
        json_array_append_new(list, json_pack("{s:f, s:f, s:f, s:f}", "begins", s->materials[i].begins, "peak",
                                              s->materials[i].peak, "part", s->materials[i].part, "opacity",
                                              s->materials[i].opacity));
    return list;
}

static void print_survey(const iso_survey *s, const iso_suggestion *found)
{
    printf("values      %.5g to %.5g%s\n", s->min, s->max, s->is_hounsfield ? ", Hounsfield units" : "");
    if (s->has_padding)
        printf("padding     %.5g\n", s->padding);
    if (s->has_background)
        printf("background  %.5g, from %.5g to %.5g\n", s->background, s->background_lo, s->background_hi);
    printf("shown       %s\n", iso_suggest_kind_text(found->kind));
    for (size_t i = 0; i < found->material_count; ++i)
        printf("material    from %.5g, most of it at %.5g, %.3g %% of the voxels, opacity %.2g\n",
               found->materials[i].begins, found->materials[i].peak, 100 * found->materials[i].part,
               found->materials[i].opacity);
}

static void print_points(const iso_tf *tf)
{
    char length[32];
    printf("points      opacity for %s\n", iso_unit_text(tf->unit_distance, 3, length, sizeof length));
    for (size_t i = 0; i < tf->point_count; ++i) {
        const iso_tf_point *p = &tf->points[i];
        printf("  %10.5g  opacity %.2g, color %.2f %.2f %.2f\n", p->value, p->opacity,
               iso_linear_to_srgb(p->rgb_linear[0]), iso_linear_to_srgb(p->rgb_linear[1]),
               iso_linear_to_srgb(p->rgb_linear[2]));
    }
}

static iso_status report(const iso_tf_arguments *a, const iso_survey *survey, const iso_suggestion *found,
                         const iso_tf *tf, const char *preset, iso_error *err)
{
    char comment[256];
    snprintf(comment, sizeof comment, "Made by isoshade tf suggest, preset %s: %s. Values are the volume's own.",
             preset, iso_suggest_kind_text(found->kind));
    json_auto_t *file = editable(tf, comment);
    if (a->output)
        NEED(iso_tf_save_json(file, a->output, err));
    if (a->cli->json) {
        iso_cli_print_results(a->cli,
                              json_pack("{s:s, s:s, s:b, s:o, s:O, s:o, s:o}", "preset", preset, "kind",
                                        iso_suggest_kind_text(found->kind), "hounsfield", survey->is_hounsfield,
                                        "materials", materials_of(found), "tf", file, "padding",
                                        survey->has_padding ? json_real(survey->padding) : json_null(), "background",
                                        survey->has_background ? json_real(survey->background) : json_null()));
        return ISO_OK;
    }
    print_survey(survey, found);
    print_points(tf);
    if (a->output)
        printf("%s: %zu points to edit\n", a->output, tf->point_count);
    return ISO_OK;
}

iso_status iso_cli_tf_suggest(const iso_tf_arguments *a, iso_error *err)
{
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_progress progress = iso_cli_progress(a->cli);
    OWNED(iso_pyramid) p = {0};
    FREED iso_survey *survey = NULL;
    OWNED(iso_suggestion) found = {0};
    OWNED(iso_tf) tf = {0};
    const char *preset = a->look.tf ? a->look.tf : "auto";
    size_t row = 0;
    if (a->cli->argument_count != 2)
        return iso_fail(err, ISO_E_USAGE,
                        "usage: isoshade tf suggest VOLUME|PYRAMID.iso [--tf PRESET] [-o FILE.tf.json]");
    if (a->look.scene)
        return iso_fail(err, ISO_E_USAGE, "--scene %s has no effect: suggestions depend only on the volume",
                        a->look.scene);
    build.threads = a->cli->threads;
    build.level_count = 1;
    NEED(iso_names_find(&iso_tf_preset_names, preset, &row, err));
    NEED(iso_subject_begin_pyramid(a->cli->arguments[1], &a->input, &build, &progress, &p, err));
    NEED(iso_survey_make(&p.levels[0], a->cli->threads, &survey, err));
    NEED(iso_suggest(survey, &p.levels[0].geometry, &found, err));
    NEED(iso_tf_preset_apply(row, survey, &p.levels[0].geometry, &tf, err));
    return report(a, survey, &found, &tf, preset, err);
}
