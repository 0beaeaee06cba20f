/* SPDX-License-Identifier: MIT */
/* figure_drawn.h - a figure of a volume whose pictures are rendered for their places in print: as many pixels as the
 * places have dots, in the scene's own view and aspect. */
#ifndef ISO_CLI_FIGURE_DRAWN_H
#define ISO_CLI_FIGURE_DRAWN_H

#include "options/adapted.h"
#include "options/look.h"
#include "report/figure.h"
#include "volume/input.h"

typedef struct iso_figure_drawn {
    const iso_cli *cli;
    const char *output;
    iso_figure_options figure; /* kind, sizes, sources; levels: the rest is not looked at; renderers: the level */
    iso_volume_input input;
    iso_cli_look look;
    iso_cli_adapted adapted; /* levels: each under the transfer function adapted to it */
    const char *with;        /* levels: the renderer; renderers: a list of them; NULL: the usual one, all */
    int levels;              /* how many, with level 0 */
} iso_figure_drawn;

/* ISO_E_USAGE, ISO_E_RANGE as the options are; what reading, rendering and drawing give. */
iso_status iso_figure_draw_volume(const iso_figure_drawn *d, iso_error *err);

#endif
