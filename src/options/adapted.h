/* SPDX-License-Identifier: MIT */
/* adapted.h - options for adapted transfer functions, shared by all commands that render or export a level.
 *
 *     iso_cli_adapted adapted;
 *     struct poptOption options[] = {ISO_CLI_ADAPTED_OPTIONS(&adapted), ..., POPT_TABLEEND};
 *     iso_cli_adapted_defaults(&adapted);
 *     ... iso_cli_parse(...), iso_subject_load_view(...) ...
 *     iso_cli_adapt_view(&adapted, path, &pyramid, level, &view, threads, err);
 *
 * Adapting replaces the view's transfer function, 1D or 2D, so every renderer and exporter can use the result. */
#ifndef ISO_OPTIONS_ADAPTED_H
#define ISO_OPTIONS_ADAPTED_H

#include <popt.h>

#include "options/cli.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"
#include "tf/adapt.h"

typedef struct iso_cli_adapted {
    int wanted;                     /* --adapt */
    char *tf_2d;                    /* set by popt, lives until the process ends */
    int bits, always, extinction_scale;
    const iso_cli *cli; /* reports ghosts; or NULL */
} iso_cli_adapted;

/* Options that say how to adapt, without --adapt. */
/* clang-format off */
#define ISO_CLI_ADAPT_METHOD_OPTIONS(a)                                                                                        \
    {"bits", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &(a)->bits, 0, "bits of the joint histogram, 8 to 16", "N"},               \
    {"always", 0, POPT_ARG_NONE, &(a)->always, 0, "adapt even if small views show no gain", NULL}

#define ISO_CLI_ADAPTED_OPTIONS(a)                                                                                             \
    {"adapt", 0, POPT_ARG_NONE, &(a)->wanted, 0, "adapt the transfer function to the level", NULL},                      \
    {"extinction-scale", 0, POPT_ARG_NONE, &(a)->extinction_scale, 0, "scale coarse voxels' extinction to match the opacity of fine ones", NULL}, \
    {"tf-2d", 0, POPT_ARG_STRING, &(a)->tf_2d, 0, "use a 2D transfer function with this second value", "deviation|gradient"}, \
    ISO_CLI_ADAPT_METHOD_OPTIONS(a)
/* clang-format on */

void iso_cli_adapted_defaults(iso_cli_adapted *a);
/* Fills the options of the adaptation. ISO_E_USAGE names the option and its value. */
iso_status iso_cli_adapt_options(const iso_cli_adapted *a, int threads, iso_adapt_options *opt, iso_error *err);

/* Applies the options to a view. A level that was made for the view's transfer function is shown as it was made
 * (scene/level_view.h), whatever the options say; one of another transfer function gets a warning.
 *
 * --adapt: replaces view->tf by the transfer function adapted to `level`. --tf-2d at a coarse level: sets view->tf_2d,
 * too, without the test whether adapting helps. --extinction-scale at a coarse level: sets view->extinction_scale for
 * the final transfer function, which is always adapted: small views ignore extinction scales. Reports a ghost
 * (tf/ghost.h) through a->cli. path: where p was loaded from; a pyramid on disk keeps its histograms. */
iso_status iso_cli_adapt_view(const iso_cli_adapted *a, const char *path, const iso_pyramid *p, size_t level,
                              iso_view *view, int threads, iso_error *err);

/* Reads --tf-2d. ISO_SECOND_VALUE_NONE without it. */
iso_status iso_cli_adapt_second_value(const iso_cli_adapted *a, iso_second_value *second, iso_error *err);

#endif
