/* SPDX-License-Identifier: MIT */
/* adapted.h - options for adapted transfer functions, shared by all commands that render or export a level.
 *
 * Adapting replaces the view's transfer function, 1D or 2D, so every renderer and exporter can use the result. */
#pragma once

#include "options/cli.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"
#include "tf/adapt.h"

typedef struct iso_cli_adapted {
    int wanted; /* --adapt */
    char *tf_2d;
    int bits, always, extinction_scale;
    const iso_cli *cli; /* reports ghosts; or NULL */
} iso_cli_adapted;
#define ISO_CLI_ADAPTED_DEFAULTS \
    { \
        .bits = ISO_ADAPT_BITS \
    }
extern const iso_option iso_adapted_rows[], iso_adapt_method_rows[]; /* the second: only how to adapt */

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
