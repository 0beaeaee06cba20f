/* SPDX-License-Identifier: MIT */
/* roi.h - options for a region of interest: a finer level in a box of a coarse one (scene/roi.h). */
#ifndef ISO_OPTIONS_ROI_H
#define ISO_OPTIONS_ROI_H

#include <popt.h>

#include "options/adapted.h"
#include "scene/roi.h"

typedef struct iso_cli_roi {
    char *box; /* set by popt, lives until the process ends */
    int level;
    double band;
} iso_cli_roi;

/* clang-format off */
#define ISO_CLI_ROI_OPTIONS(r)                                                                                              \
    {"roi", 0, POPT_ARG_STRING, &(r)->box, 0, "show a finer level in this box of level-0 voxels", "X0,Y0,Z0,X1,Y1,Z1"},        \
    {"roi-level", 0, POPT_ARG_INT, &(r)->level, 0, "level inside the box (0)", "J"},                                      \
    {"roi-band", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &(r)->band, 0, "blended band around the box, in voxels; 0: hard edge", "VOXELS"}
/* clang-format on */

void iso_cli_roi_defaults(iso_cli_roi *r);

/* The level around a region of interest. */
typedef struct iso_cli_roi_place {
    const iso_cli_adapted *adapted;
    const char *path; /* path of the pyramid or of its volume */
    const iso_pyramid *pyramid;
    size_t level;
    int threads;
} iso_cli_roi_place;

/* Sets view->roi if a box is given. Call it while view->tf is still the scene's: the level inside gets its own 1D
 * transfer function, adapted as `adapted` says. ISO_E_USAGE. */
iso_status iso_cli_roi_view(const iso_cli_roi *r, const iso_cli_roi_place *at, iso_view *view, iso_error *err);

#endif
