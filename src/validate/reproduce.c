/* SPDX-License-Identifier: MIT */
/* reproduce.c - the line that repeats one row of a report: makes image b again, and compares it with image a. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>

#include "base/provenance.h"
#include "base/words.h"
#include "validate/validate.h"

static void put_tolerances(FILE *f, const iso_tolerances *l)
{
    const struct {
        const char *option;
        double value;
    } all[] = {
        {"--max-rmse", l->rmse},      {"--max-abs", l->max_abs},
        {"--max-p99", l->p99_abs},    {"--max-dissimilarity", l->ssim_dissimilarity},
        {"--max-flip", l->flip_mean},
    };
    for (size_t i = 0; i < sizeof all / sizeof all[0]; ++i)
        if (all[i].value > 0)
            fprintf(f, " %s %.6g", all[i].option, all[i].value);
}

static void put_render(FILE *f, const iso_validation *v, size_t level, const iso_renderer_info *renderer,
                       const char *options, const char *image)
{
    const bool is_volume = !iso_pyramid_is_one(v->volume_path); /* a pyramid keeps its build options */
    if (v->make) {
        fprintf(f, "isoshade make %s -o ", v->make);
        iso_provenance_put_word(f, v->volume_path);
        fputs(" && ", f);
    }
    fputs("isoshade render ", f);
    iso_provenance_put_word(f, v->volume_path);
    fputs(v->input_options, f);
    if (is_volume && v->pyramid->options.code != iso_pyramid_defaults().code)
        fprintf(f, " --code %s", iso_code_describe(v->pyramid->options.code)->name);
    fprintf(f, "%s%s --scene ", v->build_options[0] ? " " : "", v->build_options);
    iso_provenance_put_word(f, v->scene_path);
    fprintf(f, " --with %s", renderer->asked_by ? renderer->asked_by(renderer) : renderer->name);
    if (renderer->found_in) {
        fputs(" --renderers ", f);
        iso_provenance_put_word(f, renderer->found_in);
    }
    fprintf(f, " --level %zu --size %zux%zu%s%s -o %s", level, v->view->width, v->view->height, v->render_options,
            options, image);
}

char *iso_validate_reproduce(const iso_validation *v, size_t level, const iso_renderer_info *renderer,
                             const char *options, const char *image_a, const iso_tolerances *tolerances)
{
    /* Directions other than those of a pyramid on disk are made from its level 0, which no command does. */
    if (v->build_options[0] && iso_pyramid_is_one(v->volume_path))
        return NULL;
    if (iso_provenance_kept() == ISO_PROVENANCE_NONE)
        return NULL;
    if (iso_renderer_has(renderer, ISO_IS_OF_PICTURES)) /* that no command makes */
        return NULL;
    char image[64], *text = NULL, *path = NULL;
    size_t size = 0;
    snprintf(image, sizeof image, "%s-level-%zu.exr", renderer->name, level);
    FILE *f = open_memstream(&text, &size);
    if (!f || asprintf(&path, "%s/images/%s.exr", iso_provenance_path(iso_report_path(v->report)), image_a) < 0)
        path = NULL;
    if (f) {
        put_render(f, v, level, renderer, options, image);
        fputs(" && isoshade compare ", f);
        iso_words_put_quoted(f, path ? path : "");
        fprintf(f, " %s", image);
        put_tolerances(f, tolerances);
        fclose(f);
    }
    free(path);
    return text;
}
