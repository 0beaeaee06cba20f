/* SPDX-License-Identifier: MIT */
/* roi.h - the options by which a command puts full resolution into a box of a
 * coarse level (scene/roi.h), and the one call that does it. */
#ifndef ISO_OPTIONS_ROI_H
#define ISO_OPTIONS_ROI_H

#include <popt.h>

#include "options/adapted.h"
#include "scene/roi.h"

typedef struct iso_cli_roi {
    char *box; /* by popt; lives until the process ends */
    int level;
    double band;
} iso_cli_roi;

/* clang-format off */
#define ISO_CLI_ROI_OPTIONS(r)                                                                                              \
    {"roi", 0, POPT_ARG_STRING, &(r)->box, 0, "a finer level inside this box of level-0 voxels", "X0,Y0,Z0,X1,Y1,Z1"},        \
    {"roi-level", 0, POPT_ARG_INT, &(r)->level, 0, "the level inside the box (0)", "J"},                                      \
    {"roi-band", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &(r)->band, 0, "around the box, in voxels of the level: where the two are blended; 0: a hard edge", "VOXELS"}
/* clang-format on */

void iso_cli_roi_defaults(iso_cli_roi *r);

/* The level around a region of interest. */
typedef struct iso_cli_roi_place {
    const iso_cli_adapted *adapted;
    const char *path; /* of the pyramid, or of its volume */
    const iso_pyramid *pyramid;
    size_t level;
    int threads;
} iso_cli_roi_place;

/* Sets view->roi when a box is given. To be called while view->tf is still the scene's: the
 * level inside gets a 1D transfer function of its own, adapted as `adapted` says. ISO_E_USAGE. */
iso_status iso_cli_roi_view(const iso_cli_roi *r, const iso_cli_roi_place *at, iso_view *view, iso_error *err);

#endif
