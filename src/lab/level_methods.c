/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "lab/level_methods.h"

#include <stdlib.h>
#include <string.h>

#include "lab/level_scene.h"
#include "fit/extinction_scale.h"

/* Creates the extinction scale for the level's transfer function. */
static iso_status scale_extinction(const iso_level_subject *s, iso_level_shown *shown, iso_error *err)
{
    return iso_extinction_scale_level(s->pyramid, s->level, s->tf, &shown->tf, s->threads, &shown->extinction_scale,
                                      err);
}

/* The first is the default of `build` with an adapted transfer function. */
static const iso_level_method methods[] = {
    {.name = "default",
     .summary = "means, directions by moments, adapted TF if small views favor it",
     .treatment = ISO_LEVEL_TF_ADAPTED,
     .bytes = 3,
     .fetches = 2},
    {.name = "original", .summary = "as default, with the original TF", .bytes = 3, .fetches = 2},
    {.name = "on-the-fly",
     .summary = "means and the original TF, gradients from them",
     .source = ISO_FROM_ON_THE_FLY,
     .fetches = 7},
    {.name = "always",
     .summary = "as default, always adapted",
     .treatment = ISO_LEVEL_TF_ALWAYS,
     .bytes = 3,
     .fetches = 2},
    {.name = "tf-2d",
     .summary = "2D TF of value and deviation",
     .treatment = ISO_LEVEL_TF_2D,
     .bytes = 4,
     .fetches = 3},
    {.name = "gauss", .summary = "Gaussian scalar, original TF", .scalar = ISO_SCALAR_GAUSS, .bytes = 3, .fetches = 2},
    {.name = "least-squares",
     .summary = "original, the scalar nearest to level 0 by least squares",
     .scalar = ISO_SCALAR_LEAST_SQUARES,
     .bytes = 3,
     .fetches = 2},
    {.name = "lsq-adapted",
     .summary = "the same, adapted TF if small views favor it",
     .scalar = ISO_SCALAR_LEAST_SQUARES,
     .treatment = ISO_LEVEL_TF_ADAPTED,
     .bytes = 3,
     .fetches = 2},
    {.name = "damped",
     .summary = "original, scalar .6 of the way from means to least squares",
     .scalar = ISO_SCALAR_DAMPED,
     .bytes = 3,
     .fetches = 2},
    {.name = "damped-adapted",
     .summary = "the same, adapted TF if small views favor it",
     .scalar = ISO_SCALAR_DAMPED,
     .treatment = ISO_LEVEL_TF_ADAPTED,
     .bytes = 3,
     .fetches = 2},
    {.name = "fitted",
     .summary = "a scalar fitted to the TF, adapted TF if small views favor it",
     .make = iso_level_make_fitted,
     .bytes = 3,
     .fetches = 2},
    {.name = "for-scene",
     .summary = "as build --for --effort none: the nearest of several ways by pictures",
     .make = iso_level_make_for_scene,
     .bytes = 4,
     .fetches = 2},
    {.name = "optimized-fast",
     .summary = "as build --for --effort fast: the same, or optimized by rendering",
     .make = iso_level_make_optimized_fast,
     .bytes = 4,
     .fetches = 2},
    {.name = "optimized",
     .summary = "as build --for --effort normal",
     .make = iso_level_make_optimized,
     .bytes = 4,
     .fetches = 2},
    {.name = "optimized-best",
     .summary = "as build --for --effort best",
     .make = iso_level_make_optimized_best,
     .bytes = 4,
     .fetches = 2},
    {.name = "optimized-others",
     .summary = "as build --for --effort fast, of the other TFs: this one was not given",
     .make = iso_level_make_for_others,
     .bytes = 4,
     .fetches = 2},
    {.name = "optimized-tf",
     .summary = "default, its TF optimized by rendering: tf adapt --optimize",
     .treatment = ISO_LEVEL_TF_ADAPTED,
     .make = iso_level_optimize_tf,
     .bytes = 3,
     .fetches = 2},
    {.name = "naive",
     .summary = "original, mean gradients",
     .directions = ISO_DIRECTION_NAIVE,
     .bytes = 3,
     .fetches = 2},
    {.name = "eq1",
     .summary = "original, directions by Eq. 1 of [diaz-garcia-2017]",
     .directions = ISO_DIRECTION_EQ1,
     .bytes = 3,
     .fetches = 2},
    {.name = "lsq-directions",
     .summary = "original, directions nearest to level 0's by weighted least squares",
     .directions = ISO_DIRECTION_LEAST_SQUARES,
     .bytes = 3,
     .fetches = 2},
    {.name = "lsq-both",
     .summary = "the same, and the least-squares scalar",
     .scalar = ISO_SCALAR_LEAST_SQUARES,
     .directions = ISO_DIRECTION_LEAST_SQUARES,
     .bytes = 3,
     .fetches = 2},
    {.name = "tensor",
     .summary = "original, main axes of the gradients' tensors",
     .directions = ISO_DIRECTION_TENSOR,
     .source = ISO_FROM_FLIPPED,
     .bytes = 3,
     .fetches = 9},
    /* Rivals replace the scalar (2 bytes, not counted) by 16-bit values; a deviation takes one byte. */
    {.name = "rgba-opacity",
     .summary = "classified first: means of color and opacity; the limit of [sicat-2014]",
     .rival = iso_rival_opacity,
     .bytes = 9,
     .fetches = 2},
    {.name = "rgba-extinction",
     .summary = "classified first: means of color and extinction [kraus-2008]",
     .rival = iso_rival_extinction,
     .bytes = 9,
     .fetches = 2},
    {.name = "rgba-transmittance",
     .summary = "classified first: mean transmittances kept [loubet-2017]",
     .rival = iso_rival_transmittance,
     .bytes = 9,
     .fetches = 2},
    {.name = "two-gaussians",
     .summary = "two Gaussians per voxel under the TF: a sparse pdf [sicat-2014]",
     .rival = iso_rival_two_gaussians,
     .bytes = 8,
     .fetches = 16},
    {.name = "mean-deviation",
     .summary = "the TF under the Gaussian of mean and deviation [younesy-2006]",
     .rival = iso_rival_deviation,
     .bytes = 4,
     .fetches = 3},
    {.name = "brick-tables",
     .summary = "original, a TF adapted to each brick of 16^3",
     .rival = iso_rival_bricks,
     .bytes = 4,
     .fetches = 10},
    {.name = "sggx",
     .summary = "original, directions as microflakes [heitz-2015]",
     .rival = iso_rival_sggx,
     .bytes = 6,
     .fetches = 3},
    {.name = "scaled",
     .summary = "always adapted, and an extinction scale: --adapt --extinction-scale",
     .treatment = ISO_LEVEL_TF_ALWAYS,
     .make = scale_extinction,
     .bytes = 4,
     .fetches = 2},
    {.name = "scaled-judged",
     .summary = "default, and an extinction scale",
     .treatment = ISO_LEVEL_TF_ADAPTED,
     .make = scale_extinction,
     .bytes = 4,
     .fetches = 2},
    {.name = "scaled-original",
     .summary = "the original TF, and an extinction scale",
     .make = scale_extinction,
     .bytes = 4,
     .fetches = 2},
    {.name = "scaled-damped",
     .summary = "scaled, of the damped scalar",
     .scalar = ISO_SCALAR_DAMPED,
     .treatment = ISO_LEVEL_TF_ALWAYS,
     .make = scale_extinction,
     .bytes = 4,
     .fetches = 2},
    {.name = "scaled-least-squares",
     .summary = "scaled, of the least-squares scalar",
     .scalar = ISO_SCALAR_LEAST_SQUARES,
     .treatment = ISO_LEVEL_TF_ALWAYS,
     .make = scale_extinction,
     .bytes = 4,
     .fetches = 2},
};
_Static_assert(sizeof methods / sizeof *methods <= ISO_LEVEL_MAX_METHODS, "arrays by method have this length");

const iso_names iso_level_method_names = ISO_NAMES_OF_ROWS("method", methods);

size_t iso_level_method_count(void)
{
    return sizeof methods / sizeof *methods;
}

const iso_level_method *iso_level_method_at(size_t index)
{
    return &methods[index];
}

iso_status iso_level_methods_choose(const char *text, bool wanted[ISO_LEVEL_MAX_METHODS], iso_error *err)
{
    for (const char *at = text; *at;) {
        const size_t length = strcspn(at, ",");
        FREED char *name = strndup(at, length);
        size_t row = 0;
        NEED_MEMORY(name, err, "no memory for a name");
        const bool all = strcmp(name, "all") == 0, own = all || strcmp(name, "own") == 0,
                   rivals = all || strcmp(name, "rivals") == 0;
        NEED(own || rivals ? ISO_OK : iso_names_find(&iso_level_method_names, name, &row, err));
        for (size_t m = 0; m < iso_level_method_count(); ++m)
            wanted[m] = wanted[m] || (own || rivals ? (methods[m].rival ? rivals : own) : m == row);
        at += length + (at[length] == ',');
    }
    return ISO_OK;
}

static iso_status treat_tf(const iso_level_method *m, const iso_level_subject *s, iso_level_shown *shown,
                           iso_error *err)
{
    iso_adapt_options opt = iso_adapt_defaults();
    opt.threads = s->threads;
    opt.fall_back = m->treatment == ISO_LEVEL_TF_ADAPTED;
    const bool adapted = m->treatment == ISO_LEVEL_TF_ADAPTED || m->treatment == ISO_LEVEL_TF_ALWAYS;
    iso_status status = iso_adapt_level(s->pyramid, adapted ? s->level : 0, s->tf, &opt, &shown->tf, &shown->judgment,
                                        err);
    if (status == ISO_OK && m->treatment == ISO_LEVEL_TF_2D) {
        status = iso_adapt_tf_2d(s->pyramid, s->level, ISO_SECOND_VALUE_DEVIATION, s->tf, &opt, &shown->tf_2d, err);
        shown->has_tf_2d = status == ISO_OK;
    }
    return status;
}

iso_status iso_level_show(const iso_level_method *m, const iso_level_subject *s, iso_level_shown *shown, iso_error *err)
{
    *shown = (iso_level_shown){.level = s->pyramid->levels[s->level]};
    iso_status status = treat_tf(m, s, shown, err);
    if (status == ISO_OK && m->make)
        status = m->make(s, shown, err);
    if (status == ISO_OK && m->rival)
        status = m->rival(s, &shown->rival, err);
    if (status != ISO_OK)
        iso_level_shown_destroy(shown);
    return status;
}

void iso_level_shown_destroy(iso_level_shown *shown)
{
    iso_tf_table_destroy(&shown->tf);
    iso_tf_2d_destroy(&shown->tf_2d);
    free(shown->scalar);
    free(shown->bytes);
    iso_rival_destroy(&shown->rival);
    free(shown->extinction_scale);
    *shown = (iso_level_shown){0};
}
