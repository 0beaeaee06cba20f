/* SPDX-License-Identifier: MIT */
/* adapted.h - the options for adapted transfer functions, alike in every command that renders or
 * exports a level, and the one call that applies them.
 *
 *     iso_cli_adapted adapted;
 *     struct poptOption options[] = {ISO_CLI_ADAPTED_OPTIONS(&adapted), ..., POPT_TABLEEND};
 *     iso_cli_adapted_defaults(&adapted);
 *     ... iso_cli_parse(...), iso_subject_load_view(...) ...
 *     iso_cli_adapt_view(&adapted, path, &pyramid, level, &view, threads, err);
 *
 * An adapted view is the same view with another transfer function, 1D or 2D, so
 * every renderer and exporter takes it. */
#ifndef ISO_OPTIONS_ADAPTED_H
#define ISO_OPTIONS_ADAPTED_H

#include <popt.h>

#include "options/cli.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"
#include "tf/adapt.h"

typedef struct iso_cli_adapted {
    int wanted;                     /* --adapt */
    char *tf_2d;                    /* by popt; lives until the process ends */
    int bits, always, extinction_scale;
    const iso_cli *cli;             /* where ghosts are told of, or NULL */
} iso_cli_adapted;

/* How to adapt, without the switch that asks for it. */
/* clang-format off */
#define ISO_CLI_ADAPT_METHOD_OPTIONS(a)                                                                                        \
    {"bits", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &(a)->bits, 0, "bits of the joint histogram, 8 to 16", "N"},               \
    {"always", 0, POPT_ARG_NONE, &(a)->always, 0, "adapt also where small views say that it does not help", NULL}

#define ISO_CLI_ADAPTED_OPTIONS(a)                                                                                             \
    {"adapt", 0, POPT_ARG_NONE, &(a)->wanted, 0, "with the transfer function adapted to the level", NULL},                      \
    {"extinction-scale", 0, POPT_ARG_NONE, &(a)->extinction_scale, 0, "scale the extinction of each voxel of a coarse level, so that it is as opaque as the fine voxels are", NULL}, \
    {"tf-2d", 0, POPT_ARG_STRING, &(a)->tf_2d, 0, "a 2D transfer function, whose second value is the deviation or the gradient magnitude", "deviation|gradient"}, \
    ISO_CLI_ADAPT_METHOD_OPTIONS(a)
/* clang-format on */

void iso_cli_adapted_defaults(iso_cli_adapted *a);
/* ISO_E_USAGE with option and value. */
iso_status iso_cli_adapt_options(const iso_cli_adapted *a, int threads, iso_adapt_options *opt, iso_error *err);

/* Replaces view->tf by the transfer function adapted to `level` when it is wanted; with --tf-2d and a coarse level
 * sets view->tf_2d too, whether adapting pays or not; with --extinction-scale and a coarse level view->extinction_scale, made
 * for the transfer function that the view has then; that one is adapted whatever small views say, which see no scale. A level
 * that draws a ghost (tf/ghost.h), or would, is told of in a line of a->cli. path: what p was loaded from; a pyramid on disk keeps its
 * histograms. */
iso_status iso_cli_adapt_view(const iso_cli_adapted *a, const char *path, const iso_pyramid *p, size_t level,
                              iso_view *view, int threads, iso_error *err);

/* What --tf-2d says: ISO_SECOND_VALUE_NONE without it. */
iso_status iso_cli_adapt_second_value(const iso_cli_adapted *a, iso_second_value *second, iso_error *err);

#endif
